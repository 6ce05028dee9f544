/// The smooth reference: a full trace with several samples a pixel, whose edges are not steps. A picture with
/// one sample a pixel differs from it at every edge, because it is jagged there.
#pragma once

#include "stereo/draw/renderer.h"
#include "stereo/image/image.h"
#include "vr_client/frame/reference.h"

namespace farshade {

/// The mean, in linear light, of `side` x `side` pictures of the views of `shown` in full detail, each
/// shifted by a part of a pixel: sample (i, j) of a pixel lies at ((i + 0.5) / side, (j + 0.5) / side).
/// Textures are read as in a picture with one sample. Afterwards the renderer holds the last of these
/// pictures.
[[nodiscard]] PerEye<Image<Rgb8>> smooth_reference(const FrameMoment& shown, const SceneState& state,
                                                   std::uint32_t side, Renderer& renderer,
                                                   Reference& reference);

/// `view`, seen through the same window moved by `offset_px` pixels, to the right and downwards.
[[nodiscard]] View shifted(const View& view, glm::dvec2 offset_px);

}  // namespace farshade
