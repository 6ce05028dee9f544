#include "stereo/draw/deformed_vertices.h"

#include <algorithm>
#include <glm/gtc/type_precision.hpp>

#include "stereo/draw/mesh_streams.h"

namespace farshade {
namespace {

std::size_t bytes_of(const Mesh& mesh, bool normals) {
  return mesh.positions.size() * (sizeof(glm::vec3) + (normals ? sizeof(glm::i16vec2) : 0));
}

}  // namespace

std::size_t deformed_bytes(const Scene& scene, bool normals) {
  std::size_t bytes = 0;
  for (const Instance& instance : scene.instances)
    if (instance.rig) bytes += bytes_of(scene.meshes[instance.mesh], normals);
  return bytes;
}

DeformedVertices::DeformedVertices(const gpu::Device& device, const Scene& scene, bool normals)
    : scene_(scene), normals_(normals) {
  if (scene.rigs.empty()) return;
  std::size_t bytes = 0;
  places_.resize(scene.instances.size());
  for (std::size_t i = 0; i < places_.size(); ++i) {
    if (!scene.instances[i].rig) continue;
    const Mesh& mesh = scene.meshes[scene.instances[i].mesh];
    places_[i].emplace();
    places_[i]->positions = bytes;
    places_[i]->normals = bytes + mesh.positions.size() * sizeof(glm::vec3);
    bytes += bytes_of(mesh, normals);
  }
  buffer_ = gpu::make_mapped_buffer(device, bytes, vk::BufferUsageFlagBits::eVertexBuffer,
                                    "deformed vertices", gpu::Use::Frame);
  std::ranges::fill(buffer_->as<std::byte>(), std::byte{0});  // a warm-up draws before the first update
}

void DeformedVertices::update(const SceneState& state) {
  if (places_.empty()) return;
  for (std::size_t i = 0; i < places_.size(); ++i) {
    const auto rig = scene_.instances[i].rig;
    if (rig && (written_.empty() || written_[*rig] != state.rigs[*rig])) write(i, state.rigs[*rig]);
  }
  written_ = state.rigs;
}

void DeformedVertices::write(std::size_t instance, const RigPose& pose) {
  const Mesh& mesh = scene_.meshes[scene_.instances[instance].mesh];
  Place& place = *places_[instance];
  position_.resize(mesh.positions.size()), normal_.resize(mesh.positions.size());
  Deformation(*mesh.deformable, pose).write(position_, normal_);
  const std::span<std::byte> bytes = buffer_->as<std::byte>();
  std::ranges::copy(std::as_bytes(std::span(position_)),
                    bytes.begin() + static_cast<std::ptrdiff_t>(place.positions));
  if (normals_) {
    auto* const packed = reinterpret_cast<glm::i16vec2*>(bytes.data() + place.normals);
    std::ranges::transform(normal_, packed, octahedral);
  }
  place.box = bounds_of(position_);
  ++place.shape;
}

}  // namespace farshade
