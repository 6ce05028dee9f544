/// Frame loop: what one run of the client consists of, and the steps of each of its frames.
#pragma once

#include <functional>

#include "stereo/base/pausable_clock.h"
#include "stereo/draw/renderer.h"
#include "stereo/scene/scene_state.h"
#include "vr_client/ask/request_plan.h"
#include "vr_client/frame/mode.h"
#include "vr_client/frame/reference.h"
#include "vr_client/link/frame_receiver.h"
#include "vr_client/runtime/runtime.h"

namespace farshade {

/// When a frame may use answers.
struct MaskPolicy {
  Pace pace = Pace::Virtual;
  Duration delay{};       ///< Pace::Virtual only: the time from a request to its answer
  Duration round_trip{};  ///< Pace::Real only: measured in the handshake
  Duration mask_wait{};   ///< how long a frame waits for its own answer before it uses earlier ones
};

/// Settings that may change between frames. They are read once a frame, after Runtime::wait_frame.
struct FrameSettings {
  RequestSettings request;
  Reprojection reprojection;
  LightChanges lights{};  ///< all changes that the viewer has made so far
  SceneClock scene = SceneClock::Running;
  PixelReport report = PixelReport::Off;
};

/// The time that the client's stages worked, without waits for the display or the server.
struct StageTimes : DrawTimes {
  Duration request{};  ///< locate views, animate the scene, predict, send
  Duration collect{};  ///< decode answers; in mode full: trace
  Duration frame{};    ///< request + collect + draw (total)
};

/// When the stages of a frame began, on the clock of the run.
struct StageStarts {
  Time request{}, collect{}, draw{}, end{};
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

/// A frame that was shown. The references are valid during the call that receives it.
struct FrameView {
  const FrameMoment& shown;     ///< what is shown
  const FrameRequest* request;  ///< this frame's request; null if it had none
  const SceneState& state;
  std::span<const TracedMask> masks;  ///< the masks it was drawn with; the shader trusts the first most
  const RequestRecord* newest;        ///< the record of the first of them; null if no server sent it
  std::optional<Duration> age;        ///< the time since that record's request
  const StageTimes& times;
  const StageStarts& starts;
  const FrameSettings& settings;  ///< the settings it was shown with
  FrameTiming timing;
  ShownAs as = ShownAs::Shaded;
  bool start_up = false;   ///< no answer that the mode needs had come yet
  PerEye<double> black{};  ///< the share of each eye that the server's picture does not cover
  std::span<const TracedMask> cube_mask{};  ///< the masks of the cube's faces it was drawn with
  CubeMaskCost cube_mask_cost{};
  std::optional<Time> silent_since{};    ///< ServerConnection::silent_since
  std::optional<LinkTraffic> traffic{};  ///< since the frame before was shown, or since the run began
};
using FrameWatcher = std::function<void(const FrameView&)>;

/// The parts of a run. The link or the tracer that the mode needs is set, unless no light casts shadows.
struct RunContext {
  const Scene& scene;
  Runtime& runtime;
  Renderer& renderer;
  ModeSettings mode{};
  ServerConnection* link = nullptr;  ///< modes with a server
  Reference* own_tracer = nullptr;   ///< mode full
  const FrameSettings& settings;     ///< read when a frame begins
  Exposure exposure{};               ///< unless the server's Welcome says another
  MaskPolicy policy;
  const Clock& clock = kSteadyClock;  ///< times the stages: StageStarts
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
  DrawTimes drawn;
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

/// The three steps of a frame in one mode. The frame loop calls them in order. The modes are in
/// vr_client/modes; the steps that modes share are in modes/mask_stream.h and in the renderer.
class ModePipeline {
 public:
  virtual ~ModePipeline() = default;

  /// Draws once what later frames may draw, without a link, so that no display time waits for a pipeline's
  /// compiler, the first shadow maps or the tracer's first pages. Another pipeline of the mode runs
  /// afterwards. The default draws nothing: Renderer::compile_steps suffice.
  virtual void draw_ahead(const FrameInputs&) {}

  /// Sends this frame's request. Returns it, valid until the next call; null if there is none.
  virtual const FrameRequest* request(const FrameInputs& inputs) = 0;

  /// Receives answers, or traces.
  virtual void collect(const FrameInputs& inputs) = 0;

  /// Draws the picture, which stays in the renderer.
  virtual DrawnFrame draw(const FrameInputs& inputs) = 0;
};

/// Shows frames until the runtime ends, `stop` returns true, or the server refuses the client for good.
/// `pipeline` is that of the context's mode (vr_client/modes/make_pipeline.h).
[[nodiscard]] Expected<void> run(const RunContext& context, ModePipeline& pipeline, const FrameWatcher& watch,
                                 const std::function<bool()>& stop);

}  // namespace farshade
