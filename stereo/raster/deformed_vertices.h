/// DeformedVertices: the vertices of deformable meshes in the last few poses of their rigs, where all passes
/// of a renderer read them. The processor deforms them (deform.h), so that they equal the tracer's to the
/// last bit: each pose once, on all cores. Without rigs nothing is allocated.
#pragma once

#include <optional>
#include <vector>

#include "stereo/gpu/upload_buffer.h"
#include "stereo/plan/scene_plan.h"
#include "stereo/scene/scene_state.h"

namespace farshade {

/// Bytes of the vertices that the rigs of a scene deform, in all poses that are kept.
[[nodiscard]] std::size_t deformed_bytes(const Scene& scene, const DrawPlan& plan);

class DeformedVertices {
 public:
  /// Keeps the references. As many poses are kept as one submission can need: one for shown views,
  /// one for requested views, and one for the faces of the cube mask.
  DeformedVertices(gpu::FramesInFlight& frames, const Scene& scene, const DrawPlan& plan);

  /// The vertices of one instance.
  struct Place {
    std::size_t positions = 0, normals = 0;  ///< offsets in Pose::buffer()
    Bounds box{};                            ///< object space
    std::uint64_t shape = 0;                 ///< differs between different vertices
  };

  class Pose {
   public:
    /// Null if no rig deforms the instance.
    [[nodiscard]] const Place* of(std::size_t instance) const {
      return places_.empty() || !places_[instance] ? nullptr : &*places_[instance];
    }
    [[nodiscard]] vk::Buffer buffer() const { return *buffer_->buffer().buffer; }
    /// Null without rigs.
    [[nodiscard]] const gpu::UploadBuffer* upload() const { return buffer_ ? &*buffer_ : nullptr; }

   private:
    friend class DeformedVertices;
    std::optional<gpu::UploadBuffer> buffer_;
    std::vector<std::optional<Place>> places_;  ///< one per instance; empty without rigs
    std::vector<RigPose> rigs_;                 ///< as they were written; empty before the first time
    std::uint64_t last_use_ = 0;
  };

  /// Of a state. Replaces the pose that has not been asked for the longest, if none is of this state.
  [[nodiscard]] const Pose& at(const SceneState& state);
  /// The first pose, whatever it is. A warm-up, which covers no pixel, draws with it.
  [[nodiscard]] const Pose& any() const { return poses_.front(); }
  /// Meshes that were deformed so far.
  [[nodiscard]] std::uint64_t deformed() const { return shapes_; }

 private:
  void write(const SceneState& state, Pose& pose);

  const Scene& scene_;
  std::vector<Pose> poses_;
  std::uint64_t uses_ = 0, shapes_ = 0;
};

}  // namespace farshade
