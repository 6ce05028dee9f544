/// Reads a dumped frame, as vr_client/report/dump.h writes it.
#pragma once

#include <filesystem>

#include "stereo/base/clock.h"
#include "stereo/base/expected.h"
#include "stereo/frame/view.h"
#include "stereo/image/image.h"

namespace farshade::stability {

struct DumpedEye {
  Image<std::uint16_t> mask_traced, mask_shown, source;
  Image<float> distance_m, lookup_x, lookup_y;
  Image<Rgb8> shown;
};

struct Dump {
  StereoView shown, traced;
  Time scene_time{}, traced_scene_time{};
  PerEye<DumpedEye> eyes;
};

/// Fault::Missing if a file is missing or the frame was shown without a mask.
[[nodiscard]] Expected<Dump> read_dump(const std::filesystem::path& frame_folder);

/// Counts the values in the float pictures of the dump that are not finite.
[[nodiscard]] std::size_t count_not_finite(const Dump& dump);

}  // namespace farshade::stability
