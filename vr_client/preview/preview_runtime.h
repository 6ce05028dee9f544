/// PreviewRuntime: the Runtime of the preview. Mouse and keys or a head recording move the head. A FramePacer
/// chooses the display times. Once per frame a callback supplies the controls of the head.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>

#include "stereo/head/head_recording.h"
#include "vr_client/preview/head.h"
#include "vr_client/preview/player.h"
#include "vr_client/runtime/headset.h"
#include "vr_client/runtime/runtime.h"

namespace farshade {

enum class HeadSource : std::uint8_t { Simulated, Recording };

/// Chooses the display time of each frame on the grid of the display's refreshes. A frame begins
/// on a grid point, the next frame begins n points later, and the frame is shown m >= n points after it
/// began. n follows the measured frame times, as headset runtimes throttle an application to a half or a
/// third of the refresh rate. So predictors see the true frame interval. m follows the times until the
/// picture is ready: it is above n if frames are in flight.
class FramePacer {
 public:
  /// n rises if this quantile of the last kRemembered frame times exceeds n display periods, so that one late
  /// frame in five does not change it. It falls to k if the quantile is below kRoom * k periods. m
  /// changes in the same way.
  static constexpr std::size_t kRemembered = 16;
  static constexpr double kQuantile = 0.75, kRoom = 0.9;

  /// `refresh_hz` > 0. Starts with n = m = 1.
  explicit FramePacer(double refresh_hz);

  /// Adds the frame time of the last frame.
  void learn(Duration frame_time) { between_.learn(frame_time, period_ns_); }
  /// Adds the time from the beginning of a frame until its picture was ready.
  void learn_ready(Duration after) { until_shown_.learn(after, period_ns_); }

  /// When the next frame should begin. The first frame begins at `now`. Later frames begin n points after the
  /// last one, later if they would not be shown after it, or, if that is more than half a period ago, at the
  /// nearest grid point. The result may lie up to half a period before `now`.
  [[nodiscard]] Time next_begin(Time now) const;

  /// Begins a frame at `now`. Its display time is later than all earlier ones, by whole display periods.
  [[nodiscard]] FrameTiming begin(Time now);

 private:
  [[nodiscard]] Duration after(std::int64_t ticks) const;
  [[nodiscard]] std::int64_t tick_to_begin_at(Time now) const;
  /// Display periods from the beginning of a frame until it is shown.
  [[nodiscard]] std::int64_t lead() const { return std::max(between_.count(), until_shown_.count()); }

  /// Display periods that a time takes.
  class Periods {
   public:
    void learn(Duration time, double period_ns);
    [[nodiscard]] std::uint32_t count() const { return count_; }

   private:
    std::uint32_t count_ = 1;
    std::array<double, kRemembered>
        times_ns_{};  ///< 0 at first: one slow frame at the beginning changes nothing
    std::size_t oldest_ = 0;
  };

  double period_ns_;
  Periods between_, until_shown_;
  std::optional<Time> grid_;   ///< grid point 0: when the first frame began
  std::int64_t next_ = 0;      ///< grid point at which the next frame begins, unless it is late
  std::int64_t shown_at_ = 0;  ///< grid point at which the last frame is shown
};

/// Head and headset of one frame.
struct HeadControls {
  HeadSource source = HeadSource::Simulated;
  HeadInput head;  ///< used if `source` is Simulated
  Headset headset;
};

/// Called once in each wait_frame, before the frame begins. The callback may poll the window, change the
/// player, and wait while the window is minimised; that time does not count as frame time. If it returns
/// nothing, the run ends.
using ReadControls = std::function<std::optional<HeadControls>()>;
using Sleep = std::function<void(Duration)>;

/// A head recording and its placement in the scene. Keeps a reference.
struct PlacedHeadRecording {
  const HeadRecording& head;
  Rigid<Stage, Recorded> stage_from_recorded;
};

struct PreviewSetup {
  Rigid<Stage, Head> start;  ///< initial pose of the simulated head
  std::optional<PlacedHeadRecording> recording;
  double refresh_hz = 72;
  std::optional<std::uint32_t> frames;  ///< number of frames; empty: unlimited
};

class PreviewRuntime final : public Runtime {
 public:
  /// Keeps a reference to `clock`. `sleep` must wait until that clock has advanced by at least the given
  /// span.
  PreviewRuntime(const PreviewSetup& setup, const Clock& clock, Sleep sleep, ReadControls read_controls);

  /// Sleeps until the next frame should begin, reads the controls and computes the head pose of the frame.
  /// The simulated head and the player advance by the difference of the display times. When the simulated
  /// head takes over from the recording, it starts at the last recorded pose without roll. Display times
  /// strictly increase by whole display periods; `period` is the number of periods per frame times the
  /// display period (FramePacer).
  [[nodiscard]] std::optional<FrameTiming> wait_frame() override;

  /// The simulated head has the pose of the current frame at every time, because its future is unknown. A
  /// recording is sampled at `display_time`. Call it only after the first wait_frame.
  [[nodiscard]] StereoView locate_views(Time display_time) override;

  /// The head pose at the display time of the current frame. Before the first frame: the initial pose.
  [[nodiscard]] const Rigid<Stage, Head>& stage_from_head() const { return stage_from_head_; }
  /// Display times follow the time from the beginning of a frame until its picture was ready.
  void learn_ready(Duration after) { pacer_.learn_ready(after); }
  /// The player of the recording, which does not advance while the head is simulated. Null without a
  /// recording.
  [[nodiscard]] Player* player() { return player_ ? &*player_ : nullptr; }

 private:
  void move_head(const HeadControls& controls, Duration span);
  [[nodiscard]] Rigid<Stage, Head> recorded_head(Duration ahead) const;

  PreviewSetup setup_;
  const Clock& clock_;
  Sleep sleep_;
  ReadControls read_controls_;
  FramePacer pacer_;
  std::optional<Player> player_;
  SimulatedHead simulated_;
  Rigid<Stage, Head> stage_from_head_;
  HeadSource source_ = HeadSource::Simulated;
  Headset headset_;
  std::uint32_t frames_ = 0;          ///< frames that have begun
  std::optional<Time> began_at_;      ///< begin of the current frame, on the clock
  std::optional<Time> display_time_;  ///< of the current frame
};

}  // namespace farshade
