/// Mode pipeline: the three steps of a frame in one mode. The frame loop (frame_loop.cpp) calls them in
/// order. Each mode is one file in vr_client/modes; the steps that modes share are in modes/exchange.h and in
/// the renderer.
#pragma once

#include "vr_client/frame/frame_loop.h"

namespace farshade {

/// A frame that has begun: what it shows, and its settings.
struct FrameInputs {
  const FrameRequest& shown;
  const SceneState& state;
  Duration period;  ///< of the display
  const FrameSettings& steering;
};

/// How a frame was drawn. References are valid until the next frame begins.
struct DrawnFrame {
  DrawTimes drawn;
  ShownAs as = ShownAs::Shaded;
  bool start_up = false;                ///< no answer that the mode needs has come yet
  std::span<const TracedMask> masks{};  ///< the masks it was drawn with, the most trusted first
  const RequestRecord* newest = nullptr;
  std::optional<Duration> age{};
  PerEye<double> black{};
  Duration decoding{};  ///< the time for decoding answers, without that of the link
};

class ModePipeline {
 public:
  virtual ~ModePipeline() = default;

  /// Sends this frame's request. Returns it, valid until the next call; null if there is none.
  virtual const FrameRequest* request(const FrameInputs& inputs) = 0;

  /// Receives answers, or traces.
  virtual void collect(const FrameInputs& inputs) = 0;

  /// Draws the picture, which stays in the renderer.
  virtual DrawnFrame draw(const FrameInputs& inputs) = 0;
};

}  // namespace farshade
