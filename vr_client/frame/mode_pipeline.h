/// ModePipeline: the three steps of a frame, which each mode does in its own way; what they get, and what
/// they give back.
#pragma once

#include "stereo/draw/renderer.h"
#include "stereo/link/server_connection.h"
#include "stereo/requests/request_plan.h"
#include "stereo/scene/scene_state.h"

namespace farshade {

/// Settings that may change between frames. They are read once a frame, after Runtime::wait_frame.
struct FrameSettings {
  RequestSettings request;
  Reprojection reprojection;
  LightChanges lights{};  ///< all changes that the viewer has made so far
  SceneClock scene = SceneClock::Running;
  PixelReport report = PixelReport::Off;
};

/// What the answers of the cube mask took that came during a frame.
struct CubeMaskCost {
  std::uint64_t rays = 0;   ///< primary and shadow
  std::uint64_t bytes = 0;  ///< of their slices, before sealing
  Duration server{};
};

/// How a shown picture was made.
enum class ShownAs : std::uint8_t {
  Shaded,   ///< the client shaded it; the renderer's report has the visibility of each light
  Picture,  ///< the server drew it, or the difference that its shadows make
};

/// A frame that has begun: what it shows, and its settings.
struct FrameInputs {
  const FrameMoment& shown;
  const SceneState& state;
  Duration period;  ///< of the display
  const FrameSettings& settings;
  const PerEye<HiddenArea>* hidden = nullptr;  ///< Runtime::hidden
};

/// How a frame was drawn. References are valid until the next frame begins.
struct DrawnFrame {
  ShownAs as = ShownAs::Shaded;
  bool start_up = false;                ///< no answer that the mode needs has come yet
  std::span<const TracedMask> masks{};  ///< the masks it was drawn with, the most trusted first
  std::span<const TracedMask> cube_mask{};
  CubeMaskCost cube_mask_cost{};
  const RequestRecord* newest = nullptr;
  std::optional<Duration> age{};
  PerEye<double> black{};
  Duration decoding{};  ///< the time for decoding answers, without that of the link
};

/// The steps of a frame in one mode. The frame loop calls them in order. The modes are in
/// vr_client/modes; the steps that modes share are in modes/mask_stream.h and in the renderer.
class ModePipeline {
 public:
  virtual ~ModePipeline() = default;

  /// Draws once what later frames may draw, without a link, so that no display time waits for a pipeline's
  /// compiler, the first shadow maps or the tracer's first pages. Another pipeline of the mode runs
  /// afterwards. The default draws nothing: Renderer::compile_steps suffice.
  virtual void draw_ahead(const FrameInputs&) {}

  /// Sends this frame's request and returns it, if there is one that need not wait for the device. The
  /// default is that of modes without a server.
  virtual std::optional<FrameRequest> request(const FrameInputs&) { return std::nullopt; }

  /// Receives answers, or traces. The default does nothing.
  virtual void collect(const FrameInputs&) {}

  /// The picture must show the views that `request` and `collect` got. Otherwise `draw` may get others, which
  /// were located after these calls.
  [[nodiscard]] virtual bool keeps_views() const { return false; }

  /// Records the picture, which stays in the renderer.
  virtual DrawnFrame draw(const FrameInputs& inputs) = 0;

  /// After the frame was submitted: sends its request and returns it, if there is one that `request` did not
  /// send because it depends on what the device finds. Waits for that.
  virtual std::optional<FrameRequest> request_late(const FrameInputs&) { return std::nullopt; }
};

}  // namespace farshade
