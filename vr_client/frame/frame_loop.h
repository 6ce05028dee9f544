/// Session: what one run of the client is made of, and the way of one frame through it.
#pragma once

#include <functional>

#include "stereo/draw/renderer.h"
#include "stereo/scene/scene_state.h"
#include "vr_client/ask/request_plan.h"
#include "vr_client/frame/mode.h"
#include "vr_client/frame/reference.h"
#include "vr_client/link/answer_link.h"
#include "vr_client/runtime/runtime.h"

namespace farshade {

/// When masks may be used.
struct MaskPolicy {
  Pace pace = Pace::Virtual;
  Duration delay{};       ///< Virtual only: from a request to its masks
  Duration round_trip{};  ///< Real only: as measured when the server was met
  Duration mask_wait{};   ///< how long a frame waits for its own masks before it is drawn with earlier ones
};

/// What may be another from one frame to the next; read once a frame, after Runtime::wait_frame.
struct FrameSettings {
  RequestSettings wish;
  CarryOver carry_over;
  LightChanges lights{};  ///< all that the viewer has changed so far
  SceneClock scene = SceneClock::Runs;
  ShadingPass::Report report = ShadingPass::Report::Off;
};

/// Work of the client's stages; time spent waiting for the display or the server is not counted.
struct StageTimes {
  Duration request{};                                    ///< locate views, pose the scene, predict, send
  Duration collect{};                                    ///< decode and assemble slices; in mode full: trace
  Duration gbuffer{}, depth{}, maps{}, shade{}, turn{};  ///< on the device
  Duration draw{};   ///< all of them with recording, uploads, submission and the wait for the device
  Duration frame{};  ///< request + collect + draw
};

/// When a frame's stages began, on the machine's clock.
struct StageStarts {
  Time request{}, collect{}, draw{}, end{};
};

/// What a shown picture is.
enum class ShownAs : std::uint8_t {
  Shaded,   ///< shaded here, light by light: the renderer's report tells of each
  Picture,  ///< what a server drew, or what it changed
};

/// One frame as it was shown. References end with the call.
struct FrameView {
  const FrameRequest& shown;  ///< what a full trace of the views on show would be asked
  const FrameRequest* asked;  ///< what this frame asked for; null if nothing
  const SceneState& state;
  std::span<const TracedMask> masks;  ///< that the frame was drawn with, newest first
  const ReceivedFrame* newest;        ///< what the newest of them came from; null if no server sent it
  std::optional<Duration> age;        ///< of what the newest was asked with: how long ago that was
  const StageTimes& times;
  const StageStarts& starts;
  const FrameSettings& steering;  ///< that it was shown with
  FrameTiming timing;
  ShownAs as = ShownAs::Shaded;
  bool start_up = false;   ///< nothing of what the mode needs had come yet
  PerEye<double> black{};  ///< share of each eye that the server's picture does not reach
};
using FrameWatcher = std::function<void(const FrameView&)>;

/// What the mode needs is there: a link, or a tracer of one's own; neither where no light casts shadows.
struct RunContext {
  const Scene& scene;
  Runtime& runtime;
  Renderer& renderer;
  ModeSettings mode{};
  AnswerLink* link = nullptr;       ///< modes with a server
  Reference* own_tracer = nullptr;  ///< mode full
  const FrameSettings& steering;    ///< as it stands when a frame begins
  MaskPolicy policy;
};

/// Shows frames until the runtime ends, `stop` says so or the server refuses us for good.
[[nodiscard]] Expected<void> run(const RunContext& context, const FrameWatcher& watch,
                                 const std::function<bool()>& stop);

}  // namespace farshade
