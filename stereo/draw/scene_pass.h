/// ScenePass: the scene, both eyes in one layered pass, drawn by pipelines that are specialised for what the
/// plan says each mesh needs. The G-buffer and the depths of requested views are the same pass with other
/// outputs.
#pragma once

#include <map>

#include "stereo/draw/frame_data.h"
#include "stereo/draw/scene_buffers.h"
#include "stereo/draw/shading_layout.h"

namespace farshade {

inline constexpr vk::Format kColorFormat = vk::Format::eR8G8B8A8Srgb, kDepthFormat = vk::Format::eD32Sfloat;

/// Shading normals and, where masks are carried over, geometric normals and instances.
[[nodiscard]] constexpr vk::Format surface_format(const DrawPlan& plan) {
  return carries_masks(plan) ? vk::Format::eR32G32Uint : vk::Format::eR32Uint;
}

/// What a pass leaves behind.
enum class Outputs : std::uint8_t {
  GBuffer,  ///< base colours, surfaces, depth
  Depth,    ///< depth alone: no normals, no colours; textures only where they cut holes
  Casters,  ///< the same, of both sides of every surface: what stands in a light's way
};

class ScenePass {
 public:
  /// References are kept. `frame` holds a FrameData. `pairs`: how often a frame draws the scene, each time
  /// into two layers.
  ScenePass(const gpu::Device& device, const Scene& scene, const DrawPlan& plan, const SceneBuffers& buffers,
            const gpu::Buffer& frame, Outputs outputs, std::size_t pairs = 1);

  /// Instances, seen from `views`, and the pipelines that draw them. Call before `record`.
  void prepare(const StereoView& views, const SceneState& state);
  /// As seen by others than eyes, depth alone: one a pair, of its two layers.
  void prepare(std::span<const PerEye<glm::dmat4>> clip_from_stage, const SceneState& state);

  /// Draws both eyes, `size` pixels each from the top left of the attachments' layers, which are cleared. Of
  /// the pairs one.
  void record(const vk::raii::CommandBuffer& commands, Extent size,
              std::span<const vk::RenderingAttachmentInfo> colors, const vk::RenderingAttachmentInfo& depth,
              std::size_t pair = 0) const;

  [[nodiscard]] std::size_t pipelines() const { return pipelines_.size(); }
  [[nodiscard]] std::size_t bindings() const { return bindings_.kinds.size(); }
  /// Of streams and indices, what the last `prepare`d draws read.
  [[nodiscard]] std::uint64_t vertex_bytes_read() const { return vertex_bytes_read_; }

 private:
  /// What a pipeline is specialised for.
  struct Variant {
    bool textured = false, masked = false, colored = false;
    friend auto operator<=>(const Variant&, const Variant&) = default;
  };
  struct Draw {
    std::uint32_t instance = 0;
    std::uint32_t data = 0;                 ///< its InstanceData of this pair
    std::uint32_t first_eye = 0, eyes = 0;  ///< those that may see it
    float distance = 0;
    bool mirrored = false;
  };
  [[nodiscard]] Variant variant_of(std::size_t mesh) const;
  void need_pipeline(Variant variant);
  [[nodiscard]] vk::raii::Pipeline make_pipeline(Variant variant) const;
  [[nodiscard]] std::uint64_t bytes_read(std::size_t mesh) const;
  /// `seen_as`: an instance's InstanceData from its place in the stage.
  template <class SeenAs>
  void add_draws(std::size_t pair, const SceneState& state, const SeenAs& seen_as);
  void draw_instance(const vk::raii::CommandBuffer& commands, const Draw& draw) const;

  const gpu::Device& device_;
  const Scene& scene_;
  const DrawPlan& plan_;
  const SceneBuffers& buffers_;
  Outputs outputs_;
  gpu::Buffer instances_;
  gpu::Bindings bindings_;
  vk::raii::PipelineLayout layout_{nullptr};
  std::map<Variant, vk::raii::Pipeline> pipelines_;
  std::vector<std::vector<Draw>> draws_;  ///< of each pair
  std::uint64_t vertex_bytes_read_ = 0;
};

/// An attachment that is cleared to zero and kept.
[[nodiscard]] vk::RenderingAttachmentInfo cleared(vk::ImageView view, vk::ImageLayout layout);

}  // namespace farshade
