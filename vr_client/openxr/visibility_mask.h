/// What the lenses hide, as the runtime states it (XR_KHR_visibility_mask).
#pragma once

#include <span>

#include "stereo/frame/hidden_area.h"
#include "vr_client/openxr/instance.h"

namespace farshade::openxr {

/// No runtime needs more; one that states more is not believed.
inline constexpr std::size_t kMostMaskVertices = 1 << 16, kMostMaskIndices = 3 << 16;
/// Of a coordinate; those of the widest field of view are smaller. So no later product is infinite.
inline constexpr float kMostMaskTangent = 128;

/// The triangles of a mesh that hides. Unsupported, with a sentence, if it is no mesh of triangles: a vertex
/// is not finite or beyond kMostMaskTangent, an index is out of range, or the number of indices is not a
/// multiple of three or too large.
[[nodiscard]] Expected<HiddenArea> hidden_area_of(std::span<const XrVector2f> vertices,
                                                  std::span<const std::uint32_t> indices);

/// Asks the runtime for the meshes of both views. The area of a view whose mesh cannot be had or used is
/// empty, and a warning says why. Empty without the extension, too.
[[nodiscard]] PerEye<HiddenArea> read_hidden(const Instance& instance, XrSession session);

}  // namespace farshade::openxr
