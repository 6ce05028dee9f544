/// The picture of Overlay::GuardBand.
#pragma once

#include "vr_client/report/overlays.h"

namespace farshade {

/// The whole traced view, with the part that is shown marked in it. The picture has the size of the shown
/// one.
[[nodiscard]] Image<Rgb8> guard_band_picture(const OverlayInput& input);

}  // namespace farshade
