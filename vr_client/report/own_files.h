/// The files that a run writes to its output folder.
#pragma once

#include <filesystem>

#include "stereo/base/expected.h"

namespace farshade {

/// Removes what an earlier run has written to `folder`, so that no file of it is taken for one of the next
/// run. Everything else stays, files of the preview included.
[[nodiscard]] Expected<void> remove_own_files(const std::filesystem::path& folder);

}  // namespace farshade
