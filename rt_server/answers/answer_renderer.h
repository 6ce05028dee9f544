/// AnswerRenderer: draws the requested views as the client would draw them, with masks traced for exactly
/// this request. Opens its device for the first picture.
#pragma once

#include <optional>

#include "rt_server/answers/answers.h"
#include "rt_server/answers/fair_lru_cache.h"
#include "rt_server/answers/rebuilds.h"
#include "stereo/draw/renderer.h"
#include "stereo/gpu/device.h"

namespace farshade {

class AnswerRenderer {
 public:
  explicit AnswerRenderer(const AnswerContext& context) : context_(context) {}

  /// Whether a device can be opened and the scene can be drawn. Keeps no device open.
  [[nodiscard]] Expected<void> can_draw() const;

  /// Closes the device with everything made on it, and opens a device again. On failure none is open.
  [[nodiscard]] Expected<void> reopen();

  [[nodiscard]] const MemoryShare& memory() const { return context_.memory; }

  /// A drawn request. The references are valid until the next call.
  struct RenderedAnswer {
    Renderer& renderer;  ///< holds the picture with shadows
    const ShadowFrame& frame;
    ShownFrame shown;  ///< the arguments of the draw
    AnswerCost cost;
  };
  /// Traces and draws. Throws if no device can be opened, and vk::DeviceLostError if it is lost.
  [[nodiscard]] RenderedAnswer draw(const Job& job);

 private:
  Renderer& renderer_for(const Job& job);

  AnswerContext context_;
  std::optional<gpu::Device> device_;
  using Renderers = FairLruCache<Extent, std::unique_ptr<Renderer>>;
  static constexpr std::size_t kRenderers = 64;  ///< beside the limit of their memory
  [[nodiscard]] Renderers no_renderers() const { return {kRenderers, context_.memory.in_work() / 4}; }
  Renderers renderers_ = no_renderers();
  /// Of a renderer, whatever its size: its pipelines (answers_bench: 8.6 MiB, room, lavapipe), and
  /// the scene on the device, measured when one is built.
  static constexpr std::size_t kPipelines_bytes = std::size_t{10} << 20;
  std::size_t scene_bytes_ = 0;
  Rebuilds rebuilds_;
  OwnedMask mask_;
  std::optional<TracedMask> traced_;  ///< refers to mask_
  std::optional<SceneState> state_;
};

}  // namespace farshade
