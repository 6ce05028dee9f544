#include "stereo/edge_rays/caster_texels.h"

#include <algorithm>
#include <map>

#include "shaders/edge_rays_data.h"

namespace farshade {
namespace {

static_assert(static_cast<int>(Wrap::Repeat) == FARSHADE_WRAP_REPEATED);
static_assert(static_cast<int>(Wrap::MirroredRepeat) == FARSHADE_WRAP_MIRRORED);
static_assert(static_cast<int>(Wrap::ClampToEdge) == FARSHADE_WRAP_CLAMPED);

/// Textures, and the index of the texel of each. Triangles without a texture have an opaque one.
using Textures = std::map<std::optional<std::uint32_t>, float>;

const Texture kOpaque{.image = Image<Rgba8>({1, 1}, Rgba8(255))};

const Texture& texture_of(const Scene& scene, const std::optional<std::uint32_t>& texture) {
  return texture ? scene.textures[*texture] : kOpaque;
}

Textures textures_of(const CasterTriangles& casters) {
  Textures textures{{std::nullopt, 0.0f}};
  for (const TriangleAlpha& alpha : casters.alphas) textures.emplace(alpha.texture, 0.0f);
  return textures;
}

/// Whether the holes of all triangles fit.
bool fit(const Scene& scene, const CasterTriangles& casters, const Textures& textures, std::size_t most_bytes,
         std::size_t most_texels) {
  const std::size_t triangles = 3 * (casters.corners.size() + casters.alphas.size()) + textures.size();
  std::size_t alphas = 0;
  for (const auto& [texture, index] : textures) alphas += texture_of(scene, texture).image.size.pixels();
  return triangles <= most_texels && alphas <= std::min(most_texels, kMostAlphas) &&
         triangles * sizeof(glm::vec4) + alphas <= most_bytes;
}

float next_index(const std::vector<glm::vec4>& texels) {
  return static_cast<float>(texels.size());
}

void append(const Texture& texture, CasterTexels& texels) {
  const int wraps = static_cast<int>(texture.wrap_u) + 4 * static_cast<int>(texture.wrap_v);
  const glm::vec2 size(texture.image.size.width, texture.image.size.height);
  texels.triangles.emplace_back(static_cast<float>(texels.alphas.size()), size, static_cast<float>(wraps));
  for (const Rgba8& pixel : texture.image.pixels) texels.alphas.push_back(pixel.a);
}

void append(const TriangleAlpha& alpha, const Textures& textures, std::vector<glm::vec4>& texels) {
  const auto& [a, b, c] = alpha.at_corners;
  texels.emplace_back(a, b, c, alpha.cutoff);
  texels.emplace_back(alpha.uvs[0], alpha.uvs[1]);
  texels.emplace_back(alpha.uvs[2], textures.at(alpha.texture), 0.0f);
}

}  // namespace

CasterTexels caster_texels(const Scene& scene, const CasterTriangles& casters, std::size_t most_bytes,
                           std::size_t most_texels) {
  CasterTexels result;
  for (std::size_t t = 0; t < casters.corners.size(); ++t)
    for (const glm::vec3& corner : casters.corners[t])
      result.triangles.emplace_back(corner, casters.has_holes[t] ? FARSHADE_UNKNOWN_HOLES : 0.0f);
  Textures textures = textures_of(casters);
  const bool all = fit(scene, casters, textures, most_bytes, most_texels);
  for (auto& [texture, index] : textures) {
    if (texture && !all) break;
    index = next_index(result.triangles);
    append(texture_of(scene, texture), result);
  }
  auto alpha = casters.alphas.begin();
  for (std::size_t t = 0; t < casters.corners.size() && all; ++t) {
    if (!casters.has_holes[t]) continue;
    result.triangles[3 * t].w = next_index(result.triangles);
    append(*alpha++, textures, result.triangles);
  }
  return result;
}

}  // namespace farshade
