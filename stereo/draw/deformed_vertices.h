/// DeformedVertices: the vertices of deformable meshes at one time, where a pass reads them. The processor
/// deforms them (deform.h), so that they equal the tracer's to the last bit. Without rigs nothing is
/// allocated.
#pragma once

#include <optional>
#include <vector>

#include "stereo/gpu/memory.h"
#include "stereo/scene/scene_state.h"

namespace farshade {

/// Bytes of the vertices that the rigs of a scene deform; with or without normals.
[[nodiscard]] std::size_t deformed_bytes(const Scene& scene, bool normals);

class DeformedVertices {
 public:
  /// Keeps the references.
  DeformedVertices(const gpu::Device& device, const Scene& scene, bool normals);

  /// Deforms the meshes whose rig has another pose than before. The device must not read them now.
  void update(const SceneState& state);

  /// The vertices of one instance.
  struct Place {
    std::size_t positions = 0, normals = 0;  ///< offsets in buffer()
    Bounds box;                              ///< object space
    std::uint64_t shape = 0;                 ///< changes whenever the vertices do
  };
  /// Null if no rig deforms the instance.
  [[nodiscard]] const Place* of(std::size_t instance) const {
    return places_.empty() || !places_[instance] ? nullptr : &*places_[instance];
  }
  [[nodiscard]] vk::Buffer buffer() const { return *buffer_->buffer; }

 private:
  void write(std::size_t instance, const RigPose& pose);

  const Scene& scene_;
  bool normals_ = true;
  std::optional<gpu::Buffer> buffer_;
  std::vector<std::optional<Place>> places_;  ///< one per instance; empty without rigs
  std::vector<RigPose> written_;              ///< one per rig; empty before the first update
  std::vector<glm::vec3> position_, normal_;  ///< of one instance
};

}  // namespace farshade
