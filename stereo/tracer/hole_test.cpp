#include "stereo/tracer/hole_test.h"

#include <cmath>
#include <limits>

namespace farshade {
namespace {

/// The two texels next to a coordinate (the same one twice at a clamped edge), and the weight of the second.
struct Taps {
  std::uint32_t first, second;
  float weight;
};

/// Reduces the coordinate to one period before it becomes an integer, so that no finite value overflows.
Taps taps_of(float coordinate, Wrap wrap, std::uint32_t size) {
  const auto n = static_cast<std::int64_t>(size);
  float in_period = coordinate - std::floor(coordinate);
  if (wrap == Wrap::MirroredRepeat) in_period = coordinate - 2.0f * std::floor(coordinate * 0.5f);
  if (wrap == Wrap::ClampToEdge) in_period = std::fmin(std::fmax(coordinate, 0.0f), 1.0f);
  const float texel = in_period * static_cast<float>(n) - 0.5f;
  const float below = std::floor(texel);
  const auto index = [&](std::int64_t i) {
    if (wrap == Wrap::Repeat) i = (i + n) % n;
    if (wrap == Wrap::MirroredRepeat) {
      i = (i + 2 * n) % (2 * n);
      i = i < n ? i : 2 * n - 1 - i;
    }
    return static_cast<std::uint32_t>(i < 0 ? 0 : i >= n ? n - 1 : i);
  };
  const auto i = static_cast<std::int64_t>(below);
  return {index(i), index(i + 1), texel - below};
}

float texture_alpha(const Texture& texture, const glm::vec2& uv) {
  const Taps x = taps_of(uv.x, texture.wrap_u, texture.image.size.width);
  const Taps y = taps_of(uv.y, texture.wrap_v, texture.image.size.height);
  const auto row = [&](std::uint32_t at_y) {
    const float a = texture.image.at(x.first, at_y).a, b = texture.image.at(x.second, at_y).a;
    return a + (b - a) * x.weight;
  };
  const float top = row(y.first), bottom = row(y.second);
  return (top + (bottom - top) * y.weight) / 255.0f;
}

}  // namespace

HoleTest::HoleTest(const Scene& scene, const Mesh& mesh) : mesh_(&mesh) {
  const Material& material = scene.materials[mesh.material];
  if (material.texture && !mesh.uvs.empty()) texture_ = &scene.textures[*material.texture];
  factor_ = material.base_color.a;
  cutoff_ = material.alpha_cutoff.value_or(-std::numeric_limits<float>::infinity());
}

bool HoleTest::is_hole(const glm::uvec3& triangle, float u, float v) const {
  const auto [a, b, c] = std::array{triangle.x, triangle.y, triangle.z};
  const float w = 1.0f - u - v;
  float alpha = factor_;
  if (texture_ != nullptr)
    alpha *= texture_alpha(*texture_, mesh_->uvs[a] * w + mesh_->uvs[b] * u + mesh_->uvs[c] * v);
  if (!mesh_->colors.empty()) {
    const auto a_of = [&](std::uint32_t vertex) { return static_cast<float>(mesh_->colors[vertex].a); };
    alpha *= (a_of(a) * w + a_of(b) * u + a_of(c) * v) / 255.0f;
  }
  return alpha < cutoff_;
}

}  // namespace farshade
