/// CasterTexels: CasterTriangles as shaders/edge_rays.comp fetches them. Pure; no device needed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "stereo/edge_rays/caster_triangles.h"

namespace farshade {

/// As indices are floats, and these are exact up to here.
inline constexpr std::size_t kMostAlphas = std::size_t{1} << 24;

struct CasterTexels {
  /// First the corners, three texels a triangle. w of a triangle's first corner: 0 if it has no holes;
  /// FARSHADE_UNKNOWN_HOLES; or the index of its TriangleAlpha, which is three texels: alpha at the corners,
  /// and the cutoff; uv of the first and the second corner; uv of the third one, the index of its texture,
  /// and 0. A texture is one texel: the index of its first alpha, width, height, and wrap_u + 4 wrap_v.
  std::vector<glm::vec4> triangles;
  /// Of the textures in use, each row by row. The first is one opaque texel, for triangles without texture.
  std::vector<std::uint8_t> alphas;

  [[nodiscard]] std::size_t bytes() const { return triangles.size() * sizeof(glm::vec4) + alphas.size(); }
};

/// Neither of the two is empty. Holes are unknown if this would have more than `most_bytes`, or one of the
/// two more than `most_texels`, or if there are too many alphas. Without them, too, it can have more.
[[nodiscard]] CasterTexels caster_texels(const Scene& scene, const CasterTriangles& casters,
                                         std::size_t most_bytes, std::size_t most_texels);

}  // namespace farshade
