/// Request plan: makes each frame's request. The client uses masks some time after it requested them. So a
/// request has the predicted views and scene time of that later time, with a guard band. The lead time is the
/// median latency of recent masks.
#pragma once

#include <deque>
#include <limits>
#include <optional>

#include "stereo/frame/shadow_frame.h"
#include "stereo/frame/view_scale.h"
#include "stereo/head/prediction.h"
#include "stereo/requests/guard_band.h"
#include "stereo/requests/steady_band.h"

namespace farshade {

enum class GuardBandUse : std::uint8_t { Off, Measured };

inline constexpr std::uint32_t kWidestBand_percent = 300;

/// The part of its views that a request asks for.
enum class Asks : std::uint8_t {
  Unknown,  ///< what earlier masks leave unknown
  Whole,
};

struct RequestSettings {
  PredictorKind predictor = kDefaultPredictor;  ///< Hold asks for the shown views at their own time
  GuardBandUse guard_band = GuardBandUse::Measured;
  std::uint32_t every = 0;                 ///< one request in so many frames; 0: as often as needed
  std::uint32_t guard_band_percent = 100;  ///< of the measured width, at most kWidestBand_percent
  Asks asks = Asks::Unknown;               ///< mode hybrid
};

/// How the client shows what it gets for other views than the shown ones.
enum class AnswerUse : std::uint8_t {
  Reprojected,  ///< each surface point looks up its place in the requested view
  Timewarped,   ///< the picture is turned; the movement of the eye is ignored
                ///< (stereo/reproject/timewarp_pass.h)
};

/// In a scene where nothing moves, masks age slowly. If they come later than this, requests so far apart give
/// about the same error as one in each frame (docs/reprojection.md).
inline constexpr Duration kStillInterval = std::chrono::milliseconds(28);

/// Whether animations move something in the scene.
enum class SceneMotion : std::uint8_t { Still, Moving };

/// Whether the scene's animations play.
enum class SceneClock : std::uint8_t { Running, Paused };

/// The pose in the middle between both eyes.
[[nodiscard]] Rigid<Stage, Head> head_of(const StereoView& views);

class RequestPlan {
 public:
  static constexpr Duration kLongestLatency = std::chrono::seconds(2);

  explicit RequestPlan(const RequestSettings& settings)
      : settings_(settings), predictor_(settings.predictor) {}

  /// The request of the frame that shows `shown`, on a display of the given period. No value on frames
  /// without a request. Unless the rate is fixed, changes of the lights are requested at once. Call once a
  /// frame.
  [[nodiscard]] std::optional<FrameRequest> ask(const FrameMoment& shown, Duration period,
                                                SceneClock scene = SceneClock::Running);

  /// Sets the settings of the following requests. A new predictor starts without history.
  void follow(const RequestSettings& settings);

  /// Sets the largest number of pixels that an eye's view may have with its guard band.
  void limit(std::uint32_t pixels) { most_pixels_ = pixels; }

  /// Sets how the following answers are used. Views of pictures that are turned get margins of steady size.
  void use(AnswerUse use) { use_ = use; }

  /// Sets whether requests without a fixed rate may be further apart. By default the scene moves.
  void expect(SceneMotion motion) { motion_ = motion; }

  /// Records the latency of an answer: the display time of the first frame that could use all of it, minus
  /// the display time of the frame that asked for it. Latencies over kLongestLatency are ignored.
  void learn(Duration latency);

  /// A frame with the views `shown` was drawn with an answer that was made for `traced` and asked for `age`
  /// ago. The guard band learns from it. Ages over kLongestLatency are ignored.
  void drawn_with(const StereoView& shown, const StereoView& traced, Duration age);

  /// Sets the scale of requested views against the shown size. A side has at least 16 pixels, or as many as
  /// the shown view if that has fewer. The guard band is added afterwards.
  void shrink(ViewScale scale);

  /// One request is made in so many frames. If the rate is not fixed, these are frames of the display,
  /// whether or not the client shows each of them.
  [[nodiscard]] std::uint32_t frames_apart(Duration period) const;

  /// The time between the frame that asks and the frame that the request is made for.
  [[nodiscard]] Duration lead(Duration period) const;

 private:
  [[nodiscard]] std::optional<Duration> median_latency() const;
  [[nodiscard]] bool is_due(const FrameMoment& shown, Duration period);

  RequestSettings settings_;
  Predictor predictor_;
  GuardBand guard_band_;
  SteadyBand steady_band_;
  AnswerUse use_ = AnswerUse::Reprojected;
  SceneMotion motion_ = SceneMotion::Moving;
  std::deque<Duration> latencies_;
  std::uint32_t frames_ = 0;
  std::optional<FrameMoment> asked_for_;  ///< what was shown at the last request
  std::uint32_t most_pixels_ = std::numeric_limits<std::uint32_t>::max();
  ViewScale scale_{};
};

}  // namespace farshade
