/// Dump: for one frame, what another program needs to check us, in formats that any program reads.
///
/// For each eye EYE in left, right, in the folder `frame_NNNN`:
///   EYE_mask_traced.png  16-bit grey: low 16 bits of the newest mask in hand (absent if there is none)
///   EYE_mask_shown.png   16-bit grey: low 16 bits of what was shown (an unknown pixel: the rule's bits)
///   EYE_source.png       16-bit grey: what each pixel was shown with, as ShownReport::sources has it
///   EYE_lookup_x.pfm, EYE_lookup_y.pfm   where its point lies in that source's view, pixels; 0: in none
///   EYE_distance.pfm     metres along -z in the shown view, 0 where nothing is covered
///   EYE_shown.png, EYE_reference.png   8-bit sRGB
///   views.json           poses, fov, sizes, frame ids and times of shown and traced views; lights in bit
///   order
#pragma once

#include "stereo/scene/scene_state.h"
#include "vr_client/frame/frame_loop.h"
#include "vr_client/report/pictures.h"

namespace farshade {

/// `view` and `frame` speak of the same frame; `distance` as Renderer::read_distance.
[[nodiscard]] Expected<void> write_dump(const std::filesystem::path& folder, const FrameView& view,
                                        const MeasuredFrame& frame, const PerEye<Image<float>>& distance);

}  // namespace farshade
