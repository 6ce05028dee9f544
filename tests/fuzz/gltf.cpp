// glTF: bytes are refused with one sentence, or they decode to a scene, with one line for each repair, whose
// indices and numbers are all in range. Decoding again gives the same scene. No file is opened. Limits are
// low, so that an allocation exceeds them if the input controls its size. An input with a zero byte that is
// no GLB is split at that byte into JSON and binary chunk, and both are put into a GLB. So the fuzzer can
// change the length of either.
#include "stereo/gltf/gltf.h"

#include <cmath>

#include "stereo/scene/scene_state.h"
#include "tests/fuzz/target.h"

using namespace farshade;

namespace {

constexpr SceneLimits kLimits{.file_bytes = 1 << 20, .external_bytes = 0, .image_pixels = 1 << 16};

template <class V>
bool is_finite(const V& v) {
  for (int i = 0; i < V::length(); ++i)
    if (!std::isfinite(v[i])) return false;
  return true;
}

void check_mesh(const Scene& scene, const Mesh& mesh) {
  check(mesh.material < scene.materials.size(), "a mesh has a material");
  check_eq(mesh.normals.size(), mesh.positions.size(), "normals");
  check(mesh.uvs.empty() || mesh.uvs.size() == mesh.positions.size(), "uvs are all or none");
  check(mesh.colors.empty() || mesh.colors.size() == mesh.positions.size(), "colours are all or none");
  for (const glm::uvec3& triangle : mesh.triangles)
    for (int i = 0; i < 3; ++i) check(triangle[i] < mesh.positions.size(), "a triangle's vertices exist");
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    check(is_finite(mesh.positions[i]) && is_finite(mesh.normals[i]), "vertices are finite");
    check(std::abs(glm::length(mesh.normals[i]) - 1.0f) < 1e-3f, "normals are unit");
    check(mesh.uvs.empty() || is_finite(mesh.uvs[i]), "uvs are finite");
  }
}

void check_line(std::string_view text) {
  for (const char c : text) check(c != '\n' && c != '\x1b', "a message is one plain line");
}

void check_promises(const Scene& scene) {
  check(scene.warnings.size() < 100, "faults of one kind are counted");
  for (const std::string& warning : scene.warnings) check_line(warning);
  for (const Mesh& mesh : scene.meshes) check_mesh(scene, mesh);
  for (const Material& material : scene.materials)
    check(!material.texture || *material.texture < scene.textures.size(), "a material's texture exists");
  for (std::size_t i = 0; i < scene.nodes.size(); ++i)
    check(!scene.nodes[i].parent || *scene.nodes[i].parent < i, "parents come before their children");
  for (const Instance& instance : scene.instances)
    check(instance.mesh < scene.meshes.size() && instance.node < scene.nodes.size(),
          "an instance is of something");
  check(scene.lights.size() <= kLimits.lights, "lights within their limit");
  for (const LightSource& light : scene.lights) check(light.node < scene.nodes.size(), "a light has a node");
  check(is_finite(scene.bounds.low) && is_finite(scene.bounds.high), "bounds are finite");
}

void check_state(const Scene& scene, Time time) {
  const SceneState state = state_at(scene, time);
  check_eq(state.stage_from_object.size(), scene.instances.size(), "transforms of instances");
  check_eq(state.light_set.lights.size(), scene.lights.size(), "lights of the state");
  for (const Light& light : state.light_set.lights) {
    check(is_finite(light.position.v) && is_finite(light.intensity), "lights are finite");
    check(light.kind == LightKind::Point || std::abs(glm::length(light.direction.v) - 1.0) < 1e-6,
          "directions are unit");
  }
}

void append(std::vector<std::byte>& file, std::string_view text) {
  const auto bytes = std::as_bytes(std::span(text));
  file.insert(file.end(), bytes.begin(), bytes.end());
}

void append_u32(std::vector<std::byte>& file, std::size_t value) {
  for (int i = 0; i < 4; ++i) file.push_back(static_cast<std::byte>(value >> 8 * i & 0xff));
}

/// A GLB in an allocation of exactly its own size.
std::vector<std::byte> glb_of(std::string json, std::string binary) {
  json.resize((json.size() + 3) / 4 * 4, ' ');
  binary.resize((binary.size() + 3) / 4 * 4);
  std::vector<std::byte> file;
  file.reserve(28 + json.size() + binary.size());
  append(file, "glTF");
  append_u32(file, 2);
  append_u32(file, file.capacity());
  append_u32(file, json.size());
  append(file, "JSON" + json);
  append_u32(file, binary.size());
  append(file, std::string("BIN\0", 4) + binary);
  return file;
}

std::vector<std::byte> file_from(std::string_view input) {
  const std::size_t zero = input.find('\0');
  if (!input.starts_with("glTF") && zero != input.npos)
    return glb_of(std::string(input.substr(0, zero)), std::string(input.substr(zero + 1)));
  const auto bytes = std::as_bytes(std::span(input));
  return {bytes.begin(), bytes.end()};
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::vector<std::byte> file = file_from(fuzz::text_of(data, size));
  const Expected<Scene> scene = load_scene_from_memory(file, {}, kLimits);
  if (!scene) {
    check_line(scene.error().what);
    return 0;
  }
  check_promises(*scene);
  for (const std::int64_t ns : {std::int64_t{0}, std::int64_t{700'000'000}, std::int64_t{1} << 60})
    check_state(*scene, time_from_ns(ns));
  check(load_scene_from_memory(file, {}, kLimits).value().hash == scene->hash,
        "the same bytes, the same scene");
  return 0;
}
