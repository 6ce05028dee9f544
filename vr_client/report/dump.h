/// Dump: writes one frame in common formats, with everything that another program needs to check it.
///
/// Files in the folder `frame_NNNN`, where EYE is left or right:
///   EYE_mask_traced.png  16-bit grey: low 16 bits of the newest mask; no file without a mask
///   EYE_mask_shown.png   16-bit grey: low 16 bits of the shown visibility
///   EYE_source.png       16-bit grey: source of each pixel, a value of ShownReport::sources
///   EYE_lookup_x.pfm, EYE_lookup_y.pfm   position of the pixel's surface point in the view of its source,
///                        pixels; 0: no source
///   EYE_distance.pfm     metres along -z in the shown view, 0 without geometry
///   EYE_shown.png, EYE_reference.png   8-bit sRGB
///   views.json           poses, fov, sizes, frame ids and times of both views; lights in bit order
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "stereo/scene/scene_state.h"
#include "vr_client/frame/frame_loop.h"
#include "vr_client/report/measure.h"

namespace farshade {

/// What a dump needs of a frame beside its measurement, so that it can be written later.
struct Dump {
  FrameId frame;
  std::optional<PerEye<EyeMask>> traced;  ///< the newest mask
  PerEye<Image<float>> distance;
  std::string views_json;

  [[nodiscard]] std::uint64_t bytes() const;
};

/// `distance` is the result of Renderer::read_distance for this frame.
[[nodiscard]] Dump dump_of(const FrameView& view, PerEye<Image<float>> distance);

/// Writes frame_NNNN below `folder`. `dump` and `measured` must belong to the same frame.
[[nodiscard]] Expected<void> write_dump(const std::filesystem::path& folder, const Dump& dump,
                                        const MeasuredFrame& measured);

}  // namespace farshade
