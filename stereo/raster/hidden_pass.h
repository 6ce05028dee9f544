/// HiddenPass: keeps a scene pass out of what the lens hides (stereo/frame/hidden_area.h). Before the scene
/// it gives the hidden pixels the nearest depth, so that every surface fails the depth test there; afterwards
/// the depth of no surface. So hidden pixels are like those of the sky for everything that follows. It writes
/// no colours.
#pragma once

#include "stereo/frame/hidden_area.h"
#include "stereo/gpu/upload_buffer.h"
#include "stereo/raster/scene_pipeline.h"

namespace farshade {

class HiddenPass {
 public:
  /// For scene passes with these outputs. Keeps the references.
  HiddenPass(gpu::FramesInFlight& frames, const DrawPlan& plan, Outputs outputs)
      : frames_(frames), plan_(plan), outputs_(outputs) {}

  /// Null, or no triangles: `record` does nothing, and no pipeline is created.
  void prepare(const PerEye<HiddenArea>* hidden, const StereoView& views);

  /// What `record` reads; empty if it does nothing. To be uploaded before the rendering.
  [[nodiscard]] const gpu::UploadBuffer& upload() const { return corners_; }

  enum class As : std::uint8_t { NoSurface, Nearest };
  /// Within the rendering of the scene pass, with its viewport and scissor.
  void record(const vk::raii::CommandBuffer& commands, As as) const;

  [[nodiscard]] std::size_t pipelines() const { return *pipeline_ ? 1 : 0; }

 private:
  void need_pipeline();
  void load(const PerEye<HiddenArea>& hidden);

  /// As in hidden.vert.
  struct Drawn {
    glm::vec2 scale{}, offset{};
    float depth = 0;
  };

  gpu::FramesInFlight& frames_;
  const DrawPlan& plan_;
  Outputs outputs_;
  vk::raii::PipelineLayout layout_{nullptr};
  vk::raii::Pipeline pipeline_{nullptr};
  gpu::UploadBuffer corners_;  ///< of both eyes, the left one's first
  // Of what was prepared last.
  PerEye<Drawn> drawn_;
  PerEye<std::uint32_t> counts_{};  ///< of corners
};

}  // namespace farshade
