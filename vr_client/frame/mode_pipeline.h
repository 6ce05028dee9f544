/// Way: how a mode's frames come by their light. The loop (session.cpp) begins a frame and walks three steps;
/// each mode is one file beside this one with its three steps in it, and the stages that modes share are
/// exchange.h and the renderer's.
#pragma once

#include <memory>

#include "vr_client/frame/frame_loop.h"

namespace farshade {

/// A frame that has begun: what it is to show, and what it is steered by.
struct FrameInputs {
  const FrameRequest& shown;
  const SceneState& state;
  Duration period;  ///< the display's
  const FrameSettings& steering;
};

/// What a frame was shown with. What it refers to stays until the next frame begins.
struct DrawnFrame {
  DrawTimes drawn;
  ShownAs as = ShownAs::Shaded;
  bool start_up = false;                ///< nothing of what it needs has come yet
  std::span<const TracedMask> masks{};  ///< that it was drawn with, newest first
  const ReceivedFrame* newest = nullptr;
  std::optional<Duration> age{};
  PerEye<double> black{};
  Duration decoding{};  ///< of what came, beyond what the link does
};

class ModePipeline {
 public:
  virtual ~ModePipeline() = default;

  /// Asks the server, where the mode has one, and says for what. It stays until the next call.
  virtual const FrameRequest* request(const FrameInputs& inputs) = 0;

  /// Takes in what has come, or traces.
  virtual void collect(const FrameInputs& inputs) = 0;

  /// Leaves the picture in the renderer.
  virtual DrawnFrame draw(const FrameInputs& inputs) = 0;
};

// Each in its own file. What the mode needs of `session` (link, own tracer) is there, or no light casts
// shadows. References are kept.
[[nodiscard]] std::unique_ptr<ModePipeline> make_hybrid(const RunContext& context);
[[nodiscard]] std::unique_ptr<ModePipeline> make_client_positions(const RunContext& context);
[[nodiscard]] std::unique_ptr<ModePipeline> make_server_gbuffer(const RunContext& context);
[[nodiscard]] std::unique_ptr<ModePipeline> make_remote(const RunContext& context);
[[nodiscard]] std::unique_ptr<ModePipeline> make_delta(const RunContext& context);
[[nodiscard]] std::unique_ptr<ModePipeline> make_local(const RunContext& context);
[[nodiscard]] std::unique_ptr<ModePipeline> make_full(const RunContext& context);

/// That of session.mode.
[[nodiscard]] std::unique_ptr<ModePipeline> make_pipeline(const RunContext& context);

}  // namespace farshade
