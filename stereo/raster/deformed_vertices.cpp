#include "stereo/raster/deformed_vertices.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <glm/gtc/type_precision.hpp>

#include "stereo/plan/plan_masks.h"
#include "stereo/raster/mesh_streams.h"

namespace farshade {
namespace {

std::size_t bytes_of(const Mesh& mesh) {
  return mesh.positions.size() * (sizeof(glm::vec3) + sizeof(glm::i16vec2));
}

std::size_t pose_bytes(const Scene& scene) {
  std::size_t bytes = 0;
  for (const Instance& instance : scene.instances)
    if (instance.rig) bytes += bytes_of(scene.meshes[instance.mesh]);
  return bytes;
}

std::size_t poses_of(const DrawPlan& plan) {
  return 1u + (plan.depth_pass ? 1u : 0u) + (most_cube_mask_pairs(plan) > 0 ? 1u : 0u);
}

/// Where an instance's vertices go.
struct Streams {
  WriteOnly<glm::vec3> positions;
  WriteOnly<glm::i16vec2> normals;
};

Streams streams_at(const DeformedVertices::Place& place, std::size_t vertices, gpu::UploadBuffer& buffer) {
  return {buffer.view<std::byte>(place.positions, vertices * sizeof(glm::vec3)).as<glm::vec3>(),
          buffer.view<std::byte>(place.normals, vertices * sizeof(glm::i16vec2)).as<glm::i16vec2>()};
}

/// Writes an instance's vertices in the pose of its rig. Returns their box.
Bounds deform(const Mesh& mesh, const RigPose& rig, const Streams& streams) {
  std::vector<glm::vec3> positions(mesh.positions.size()), normals(mesh.positions.size());
  Deformation(*mesh.deformable, rig).write(positions, normals);
  streams.positions.copy(positions);
  streams.normals.generate([&](std::size_t i) { return octahedral(normals[i]); });
  return bounds_of(positions);
}

}  // namespace

std::size_t deformed_bytes(const Scene& scene, const DrawPlan& plan) {
  return poses_of(plan) * pose_bytes(scene);
}

DeformedVertices::DeformedVertices(gpu::FramesInFlight& frames, const Scene& scene, const DrawPlan& plan)
    : scene_(scene), poses_(scene.rigs.empty() ? 1 : poses_of(plan)) {
  if (scene.rigs.empty()) return;
  std::vector<std::optional<Place>> places(scene.instances.size());
  std::size_t bytes = 0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (!scene.instances[i].rig) continue;
    const Mesh& mesh = scene.meshes[scene.instances[i].mesh];
    places[i] = Place{.positions = bytes, .normals = bytes + mesh.positions.size() * sizeof(glm::vec3)};
    bytes += bytes_of(mesh);
  }
  for (Pose& pose : poses_) {
    pose.places_ = places;
    pose.buffer_ = gpu::make_upload_buffer(frames, bytes, vk::BufferUsageFlagBits::eVertexBuffer,
                                           "deformed vertices", gpu::Use::Frame);
  }
  poses_.front().buffer_->view<std::byte>().fill(std::byte{0});  // `any`
}

const DeformedVertices::Pose& DeformedVertices::at(const SceneState& state) {
  const auto same = std::ranges::find(poses_, state.rigs, &Pose::rigs_);
  Pose& pose = same != poses_.end() ? *same : *std::ranges::min_element(poses_, {}, &Pose::last_use_);
  if (same == poses_.end()) write(state, pose);
  pose.last_use_ = ++uses_;
  return pose;
}

void DeformedVertices::write(const SceneState& state, Pose& pose) {
  struct Changed {
    std::size_t instance;
    Streams streams;
  };
  std::vector<Changed> changed;
  for (std::size_t i = 0; i < pose.places_.size(); ++i) {
    const auto rig = scene_.instances[i].rig;
    if (!rig || (!pose.rigs_.empty() && pose.rigs_[*rig] == state.rigs[*rig])) continue;
    pose.places_[i]->shape = ++shapes_;
    const std::size_t vertices = scene_.meshes[scene_.instances[i].mesh].positions.size();
    changed.push_back({i, streams_at(*pose.places_[i], vertices, *pose.buffer_)});
  }
  tbb::parallel_for(std::size_t{0}, changed.size(), [&](std::size_t number) {
    const Changed& one = changed[number];
    const Instance& instance = scene_.instances[one.instance];
    pose.places_[one.instance]->box =
        deform(scene_.meshes[instance.mesh], state.rigs[*instance.rig], one.streams);
  });
  pose.rigs_ = state.rigs;
}

}  // namespace farshade
