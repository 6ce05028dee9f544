/// G-buffer pass: both eyes in one layered pass - base colour, normals, instance, and depth into a ring.
/// The ring keeps the depths of the views that were asked for, so that a mask that comes back later can be
/// tested against what its views saw.
#pragma once

#include <map>

#include "stereo/frame/frame_id.h"
#include "vr_client/draw/frame_data.h"
#include "vr_client/draw/scene_buffers.h"

namespace farshade {

/// The G-buffer has 16 bits for an instance.
inline constexpr std::size_t kMaxInstances = 1 << 16;

class GBufferPass {
 public:
  /// At most kMaxInstances instances. `size` pixels an eye; the ring holds the depths of `depth_frames`
  /// frames.
  GBufferPass(const gpu::Device& device, const Scene& scene, Extent size, std::uint32_t depth_frames);

  /// Instances, seen from `views`. Call before `record`.
  void prepare(const StereoView& views, const SceneState& state);

  /// Draws into the ring slot of `frame`. Afterwards every image here is readable by shaders.
  void record(const vk::raii::CommandBuffer& commands, FrameId frame);

  [[nodiscard]] bool has_depth(FrameId frame) const;
  /// Layer of the left eye in the depth ring; the right eye's is the next.
  [[nodiscard]] std::uint32_t depth_layer(FrameId frame) const;

  [[nodiscard]] const gpu::Image& depth_ring() const { return depth_ring_; }
  [[nodiscard]] const gpu::Image& base_colors() const { return base_colors_; }
  [[nodiscard]] const gpu::Image& surfaces() const { return surfaces_; }
  /// The buffer of one FrameData that all passes read.
  [[nodiscard]] const gpu::Buffer& frame_buffer() const { return frame_buffer_; }

 private:
  /// What a pipeline is specialised for; vertex streams and texture reads exist only where a material needs
  /// them.
  struct Variant {
    bool textured = false, masked = false, colored = false;
    friend auto operator<=>(const Variant&, const Variant&) = default;
  };
  [[nodiscard]] Variant variant_of(const Mesh& mesh) const;
  [[nodiscard]] vk::raii::Pipeline make_pipeline(Variant variant) const;
  [[nodiscard]] std::size_t slot_of(FrameId frame) const { return frame.value % slots_.size(); }

  struct Slot {
    std::optional<FrameId> frame;
    vk::raii::ImageView view{nullptr};  ///< both eyes' layers
  };
  struct Draw {
    std::uint32_t instance = 0;
    std::uint32_t first_eye = 0, eyes = 0;  ///< those that may see it
    float distance = 0;
    bool mirrored = false;
  };

  void draw_instance(const vk::raii::CommandBuffer& commands, const Draw& draw) const;

  const gpu::Device& device_;
  const Scene& scene_;
  Extent size_;
  SceneBuffers buffers_;
  gpu::Buffer instance_buffer_, frame_buffer_;
  gpu::Image base_colors_, surfaces_, depth_ring_;
  std::vector<Slot> slots_;
  gpu::Bindings bindings_;
  vk::raii::PipelineLayout layout_{nullptr};
  vk::raii::ShaderModule vertex_shader_{nullptr}, plain_shader_{nullptr}, textured_shader_{nullptr};
  std::map<Variant, vk::raii::Pipeline> pipelines_;
  std::vector<Draw> draws_;
};

}  // namespace farshade
