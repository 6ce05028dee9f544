/// Meshes for the tests of levels of detail.
#pragma once

#include <cmath>
#include <numbers>
#include <random>

#include "stereo/scene/scene.h"

namespace farshade {

/// A grid of columns x rows quads; `shape(u, v)`, both from 0 to 1, has the positions. Smooth normals.
template <class Shape>
Mesh grid_mesh(std::uint32_t columns, std::uint32_t rows, const Shape& shape) {
  Mesh mesh;
  for (std::uint32_t y = 0; y <= rows; ++y)
    for (std::uint32_t x = 0; x <= columns; ++x) {
      const float u = static_cast<float>(x) / static_cast<float>(columns),
                  v = static_cast<float>(y) / static_cast<float>(rows), step = 1e-3f;
      mesh.positions.push_back(shape(u, v));
      const glm::vec3 across =
          glm::cross(shape(u + step, v) - shape(u - step, v), shape(u, v + step) - shape(u, v - step));
      const float length = glm::length(across);
      mesh.normals.push_back(length > 0 ? across / length : glm::vec3(0, 1, 0));
      mesh.uvs.emplace_back(u, v);
    }
  const std::uint32_t stride = columns + 1;
  for (std::uint32_t y = 0; y < rows; ++y)
    for (std::uint32_t x = 0; x < columns; ++x) {
      const std::uint32_t corner = y * stride + x;
      mesh.triangles.emplace_back(corner, corner + 1, corner + stride + 1);
      mesh.triangles.emplace_back(corner, corner + stride + 1, corner + stride);
    }
  return mesh;
}

inline Mesh bumpy_sphere(std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> phase(0, 6), waves(1, 7);
  const float a = phase(random), b = phase(random), n = std::round(waves(random)),
              m = std::round(waves(random));
  Mesh mesh = grid_mesh(48, 32, [=](float u, float v) {
    const float pi = std::numbers::pi_v<float>, longitude = 2 * pi * u, latitude = pi * v;
    const float radius = 1 + 0.1f * std::sin(n * longitude + a) * std::sin(m * latitude + b);
    return radius * glm::vec3(std::sin(latitude) * std::cos(longitude), std::cos(latitude),
                              std::sin(latitude) * std::sin(longitude));
  });
  mesh.uvs.clear();
  return mesh;
}

inline Mesh terrain(std::uint32_t seed) {
  std::mt19937 random(seed);
  std::vector<float> heights(33 * 33);
  std::uniform_real_distribution<float> height(0, 0.2f);
  for (float& h : heights) h = height(random);
  return grid_mesh(32, 32, [heights](float u, float v) {
    const auto x = static_cast<std::size_t>(std::lround(std::clamp(u, 0.0f, 1.0f) * 32)),
               y = static_cast<std::size_t>(std::lround(std::clamp(v, 0.0f, 1.0f) * 32));
    return glm::vec3(u, heights[y * 33 + x], v);
  });
}

/// A thin pole with a knob at each end: the middle has no vertices.
inline Mesh pole() {
  Mesh mesh = grid_mesh(24, 40, [](float u, float v) {
    const float pi = std::numbers::pi_v<float>, knob = 0.1f;
    const float end = v < 0.5f ? -1.0f : 1.0f, t = v < 0.5f ? 2 * v : 2 - 2 * v;  // 0 to 1 towards the middle
    const float radius = std::max(knob * std::sin(pi * t), t > 0.5f ? 0.02f : 0.0f);
    return glm::vec3(end * (1 + knob * std::cos(pi * t)), radius * std::cos(2 * pi * u),
                     radius * std::sin(2 * pi * u));
  });
  mesh.uvs.clear();
  return mesh;
}

/// The same mesh with a normal for each triangle.
inline Mesh faceted(const Mesh& smooth) {
  Mesh mesh;
  for (const glm::uvec3& t : smooth.triangles) {
    const glm::vec3 a = smooth.positions[t.x], b = smooth.positions[t.y], c = smooth.positions[t.z];
    const glm::vec3 across = glm::cross(b - a, c - a);
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (const glm::vec3& p : {a, b, c}) {
      mesh.positions.push_back(p);
      mesh.normals.push_back(glm::length(across) > 0 ? glm::normalize(across) : glm::vec3(0, 1, 0));
    }
    mesh.triangles.emplace_back(first, first + 1, first + 2);
  }
  return mesh;
}

}  // namespace farshade
