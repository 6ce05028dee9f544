/// Frame loop: what one run of the client consists of, and the steps of each of its frames.
#pragma once

#include <functional>

#include "stereo/base/pausable_clock.h"
#include "vr_client/frame/mode.h"
#include "vr_client/frame/mode_pipeline.h"
#include "vr_client/frame/reference.h"
#include "vr_client/runtime/runtime.h"

namespace farshade {

/// When a frame may use answers.
struct MaskPolicy {
  Pace pace = Pace::Virtual;
  Duration delay{};       ///< Pace::Virtual only: the time from a request to its answer
  Duration round_trip{};  ///< Pace::Real only: measured in the handshake
  Duration mask_wait{};   ///< how long a frame waits for its own answer before it uses earlier ones
};

/// The time that the client's stages worked, without waits for the display or the server.
struct StageTimes : DrawTimes {
  Duration request{};  ///< locate views, animate the scene, predict, send
  Duration collect{};  ///< decode answers; in mode full: trace
  Duration frame{};    ///< request + collect + draw (total)
  Duration ready{};    ///< FinishedPicture: from its beginning until it was ready; 0 if there is none
};

/// The newest picture that the device has finished: with frames in flight, that of an earlier frame.
struct FinishedPicture {
  FrameId frame;
  Time begun{}, ready{};
};

/// When the stages of a frame began, on the clock of the run.
struct StageStarts {
  Time request{}, collect{}, draw{}, end{};
  Time submitted{};                      ///< to the device
  std::optional<Time> requested_late{};  ///< when its request was sent, if only after that
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
  std::optional<Time> silent_since{};         ///< ServerConnection::silent_since
  std::optional<LinkTraffic> traffic{};       ///< since the frame before was shown, or since the run began
  std::optional<FinishedPicture> finished{};  ///< the device's times in `times` are those of this picture
};
using FrameWatcher = std::function<void(const FrameView&)>;

/// The scene's clock. It advances with the display's clock while the scene's animations play.
class SceneTime {
 public:
  Time at(Time display_time, SceneClock clock) {
    if (last_ && clock == SceneClock::Running) now_ += display_time - *last_;
    last_ = display_time;
    return now_;
  }

 private:
  Time now_{};
  std::optional<Time> last_;
};

/// How far a run has come. A run that an exception has ended goes on from there with its next frame.
struct RunPosition {
  FrameId frame;  ///< that has begun last
  SceneTime scene_time;
};

/// When the views of a frame are located (Runtime::locate_views).
enum class Locate : std::uint8_t {
  Once,       ///< when the frame begins: it shows the views from which its request was predicted
  ForDrawing  ///< again just before the picture is recorded, so that it shows the newest pose of the head
};

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
  Locate locate = Locate::Once;
  const Clock& clock = kSteadyClock;  ///< times the stages: StageStarts
};

/// Shows frames until the runtime ends, `stop` returns true, or the server refuses the client for good.
/// `pipeline` is that of the context's mode (vr_client/modes/make_pipeline.h).
[[nodiscard]] Expected<void> run(const RunContext& context, ModePipeline& pipeline, const FrameWatcher& watch,
                                 const std::function<bool()>& stop);
/// The same from `position` on, which follows the run.
[[nodiscard]] Expected<void> run(const RunContext& context, ModePipeline& pipeline, const FrameWatcher& watch,
                                 const std::function<bool()>& stop, RunPosition& position);

}  // namespace farshade
