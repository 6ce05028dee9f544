/// Request plan: what each frame asks the server for. The masks of a request are used some time later; so it
/// asks for the views that the head is predicted to have then, a guard band wider, at the scene's time then.
/// How much later is measured on the masks that have come.
#pragma once

#include <deque>
#include <limits>
#include <optional>

#include "stereo/frame/shadow_frame.h"
#include "stereo/frame/view_scale.h"
#include "stereo/head/prediction.h"
#include "vr_client/ask/guard_band.h"

namespace farshade {

enum class GuardBandUse : std::uint8_t { Off, Measured };

inline constexpr std::uint32_t kWidestBand_percent = 300;

struct RequestSettings {
  PredictorKind predictor = kDefaultPredictor;  ///< Hold asks for the shown views, at their time
  GuardBandUse guard_band = GuardBandUse::Measured;
  std::uint32_t every = 1;                 ///< frames a request: the display's rate over the masks' rate
  std::uint32_t guard_band_percent = 100;  ///< of what is measured to be needed, at most kWidestBand_percent
};

/// Whether the scene's animations go on from frame to frame.
enum class SceneClock : std::uint8_t { Runs, Stands };

/// The middle of both eyes.
[[nodiscard]] Rigid<Stage, Head> head_of(const StereoView& views);

class RequestPlan {
 public:
  static constexpr Duration kLongestLatency = std::chrono::seconds(2);

  explicit RequestPlan(const RequestSettings& wish) : wish_(wish), predictor_(wish.predictor) {}

  /// `shown` is the frame as a full trace would be asked for it, `period` the display's. Nothing on frames
  /// that ask for nothing. Call once a frame.
  [[nodiscard]] std::optional<FrameRequest> ask(const FrameRequest& shown, Duration period,
                                                SceneClock scene = SceneClock::Runs);

  /// From now on asks as `wish` says. Another predictor knows nothing yet.
  void follow(const RequestSettings& wish);

  /// From now on a guard band adds no more than leaves an eye's view at `pixels`.
  void limit(std::uint32_t pixels) { most_pixels_ = pixels; }

  /// Masks could be used `later` after the display time at which they were asked for; before any has come, a
  /// guess. It is rounded up to whole frames. More than kLongestLatency was a pause, and tells nothing.
  void learn(Duration later);

  /// From now on requests views at `scale` of the displayed size. A side has at least 16 pixels, or as many
  /// as the displayed view if that has fewer. The guard band is added afterwards.
  void shrink(ViewScale scale);

  /// From the display time at which masks are asked for to the one for which.
  [[nodiscard]] Duration lead(Duration period) const;

 private:
  struct Foreseen {
    Time display_time;
    StereoView views;  ///< neither shrunk nor widened
  };
  void compare(const FrameRequest& shown, Duration period);

  RequestSettings wish_;
  Predictor predictor_;
  GuardBand guard_band_;
  std::deque<Foreseen> foreseen_;  ///< in order of time
  std::deque<Duration> later_;
  std::uint32_t frames_ = 0;
  std::uint32_t most_pixels_ = std::numeric_limits<std::uint32_t>::max();
  ViewScale scale_{};
};

}  // namespace farshade
