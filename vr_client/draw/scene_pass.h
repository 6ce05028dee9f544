/// ScenePass: the scene, both eyes in one layered pass, drawn by pipelines that are specialised for what each
/// material needs. The G-buffer and the depths of requested views are the same pass with other outputs.
#pragma once

#include <map>

#include "vr_client/draw/frame_data.h"
#include "vr_client/draw/scene_buffers.h"

namespace farshade {

inline constexpr vk::Format kColorFormat = vk::Format::eR8G8B8A8Srgb,
                            kSurfaceFormat = vk::Format::eR32G32Uint, kDepthFormat = vk::Format::eD32Sfloat;

/// What a pass leaves behind.
enum class Outputs : std::uint8_t {
  GBuffer,  ///< base colours, surfaces, depth
  Depth,    ///< depth alone: no normals, no colours; textures only where they cut holes
};

class ScenePass {
 public:
  /// References are kept. `frame` holds a FrameData.
  ScenePass(const gpu::Device& device, const Scene& scene, const SceneBuffers& buffers,
            const gpu::Buffer& frame, Outputs outputs);

  /// Instances, seen from `views`. Call before `record`.
  void prepare(const StereoView& views, const SceneState& state);

  /// Draws both eyes, `size` pixels each from the top left of the attachments' layers, which are cleared.
  void record(const vk::raii::CommandBuffer& commands, Extent size,
              std::span<const vk::RenderingAttachmentInfo> colors,
              const vk::RenderingAttachmentInfo& depth) const;

 private:
  /// What a pipeline is specialised for; vertex streams and texture reads exist only where a material needs
  /// them.
  struct Variant {
    bool textured = false, masked = false, colored = false;
    friend auto operator<=>(const Variant&, const Variant&) = default;
  };
  struct Draw {
    std::uint32_t instance = 0;
    std::uint32_t first_eye = 0, eyes = 0;  ///< those that may see it
    float distance = 0;
    bool mirrored = false;
  };
  [[nodiscard]] Variant variant_of(const Mesh& mesh) const;
  [[nodiscard]] vk::raii::Pipeline make_pipeline(Variant variant) const;
  void draw_instance(const vk::raii::CommandBuffer& commands, const Draw& draw) const;

  const gpu::Device& device_;
  const Scene& scene_;
  const SceneBuffers& buffers_;
  Outputs outputs_;
  gpu::Buffer instances_;
  gpu::Bindings bindings_;
  vk::raii::PipelineLayout layout_{nullptr};
  vk::raii::ShaderModule vertex_shader_{nullptr}, plain_shader_{nullptr}, textured_shader_{nullptr};
  std::map<Variant, vk::raii::Pipeline> pipelines_;
  std::vector<Draw> draws_;
};

/// An attachment that is cleared to zero and kept.
[[nodiscard]] vk::RenderingAttachmentInfo cleared(vk::ImageView view, vk::ImageLayout layout);

}  // namespace farshade
