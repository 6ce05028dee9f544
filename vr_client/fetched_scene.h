/// The scene of a client that was started without --scene.
#pragma once

#include <optional>

#include "stereo/base/expected.h"
#include "stereo/base/stop_signal.h"
#include "vr_client/options.h"

namespace farshade {

/// If the options need a scene and name none: fetches it from the server (fetch/fetch_scene.h), shows the
/// progress, and puts file, lighting and hash into the options. Creates `stop` for that, and returns
/// Interrupted soon after SIGINT or SIGTERM.
[[nodiscard]] Expected<void> fetch_if_missing(Options& options, std::optional<StopSignal>& stop);

}  // namespace farshade
