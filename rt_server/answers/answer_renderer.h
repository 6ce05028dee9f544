/// AnswerRenderer: a request's views as they should look, drawn as the client draws, with masks of this very
/// request. Opens its device when the first picture is wanted.
#pragma once

#include <optional>

#include "rt_server/answers/answers.h"
#include "rt_server/answers/recent.h"
#include "stereo/draw/renderer.h"

namespace farshade {

class AnswerRenderer {
 public:
  /// What `ground` refers to outlives it.
  explicit AnswerRenderer(const AnswerContext& ground) : ground_(ground) {}

  /// Whether there is a device to draw on, which is not kept, and the scene can be drawn.
  [[nodiscard]] Expected<void> can_paint() const;

  /// A request traced and drawn. What it refers to stays until the next call.
  struct RenderedAnswer {
    Renderer& renderer;  ///< holds the picture with its shadows
    const ShadowFrame& frame;
    ShownFrame shown;  ///< as it was drawn
    AnswerCost took;
  };
  /// Throws where no device can be had.
  [[nodiscard]] RenderedAnswer paint(const FrameRequest& request);

 private:
  Renderer& renderer_for(Extent size);

  AnswerContext ground_;
  std::optional<gpu::Device> device_;
  Recent<Extent, std::unique_ptr<Renderer>> renderers_{4};  ///< clients' views have few sizes
  ShadowFrame frame_;
  PerEye<KnownTiles> all_known_;
  std::optional<TracedMask> mask_;
  std::optional<SceneState> state_;
  std::uint64_t painted_ = 0;
};

}  // namespace farshade
