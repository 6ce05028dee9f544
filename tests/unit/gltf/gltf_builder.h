/// Makes small glTF files in memory, for tests to change and load.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <glm/vec3.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "stereo/gltf/gltf.h"

namespace farshade {

class GltfBuilder {
 public:
  /// An empty scene. `json` may be changed in any way.
  GltfBuilder();
  nlohmann::json json;

  /// Appends values to the buffer, aligned to four bytes, with a buffer view of their own. Returns the view's
  /// number.
  template <class T>
  std::uint32_t view(const std::vector<T>& values) {
    return view_of_bytes(values.data(), values.size() * sizeof(T));
  }
  /// Adds an accessor over a buffer view, with the properties of `more`. Returns its number.
  std::uint32_t accessor(std::uint32_t view, int component, const std::string& type, std::size_t count,
                         const nlohmann::json& more = {});
  /// Adds positions as an accessor. Returns its number.
  std::uint32_t positions(const std::vector<glm::vec3>& points);
  /// Adds a mesh with one primitive and a root node that shows it. Returns the mesh's number.
  std::uint32_t mesh(const nlohmann::json& primitive);
  /// Adds a root node. Returns its number.
  std::uint32_t node(const nlohmann::json& node);
  /// Adds a KHR_lights_punctual light. Returns the extension value with which a node refers to it.
  nlohmann::json light(const nlohmann::json& light);

  [[nodiscard]] std::vector<std::byte> glb() const;
  /// The JSON text with the buffer as a data URI.
  [[nodiscard]] std::vector<std::byte> gltf() const;
  /// The bytes that the buffer views refer to.
  [[nodiscard]] std::vector<std::byte>& bytes() { return bytes_; }

 private:
  std::uint32_t view_of_bytes(const void* data, std::size_t size);
  std::vector<std::byte> bytes_;
};

/// One triangle (0,0,0) (1,0,0) (0,1,0), indexed, without normals.
[[nodiscard]] GltfBuilder triangle_file();

/// A textured, coloured, indexed quad with sparse positions that swings and spins, three kinds of light, and
/// a camera: at least one use of every supported feature.
[[nodiscard]] GltfBuilder rich_file();

[[nodiscard]] std::vector<std::byte> bytes_of_text(std::string_view text);

/// Loads a copy in an allocation that ends with the bytes.
[[nodiscard]] Expected<Scene> load_copy(const std::byte* bytes, std::size_t size);
[[nodiscard]] inline Expected<Scene> load(const GltfBuilder& file) {
  const auto bytes = file.glb();
  return load_copy(bytes.data(), bytes.size());
}

/// "drawn", the warnings of a scene that loads, or "refused: " and why.
[[nodiscard]] std::string outcome_of(const Expected<Scene>& scene);

}  // namespace farshade
