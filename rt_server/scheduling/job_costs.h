/// JobCosts: how long the jobs of one key take, measured by this server, so that a job can be judged before
/// it begins. A value without clocks.
///
/// Views of kUsualPixels or fewer are never refused and never given up for others, however slow the machine
/// is: their cost is bounded by their size, and turns by key (turns.h) divide it fairly. Larger views
/// are a wish that the server grants if it can: while a client of another key is present, a job that is
/// expected to take more than kMostTurn is not begun, and one that has taken so long is given up when a
/// client of another key waits. Without other keys nothing is refused.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "stereo/base/clock.h"
#include "stereo/frame/shadow_frame.h"

namespace farshade {

/// Of one eye: 640 x 640, the size that vr_client requests without --size, with its widest guard band.
inline constexpr std::uint64_t kUsualPixels = std::uint64_t{640} * 640;
/// 14 frames of a display at 72 Hz. A client that asks again only when its masks have come leaves a moment in
/// which another key may begin such a job, so it may wait for one with each of its masks.
inline constexpr Duration kMostTurn = std::chrono::milliseconds(200);
/// A key owes no more for one job. A job takes longer only if the process was stopped meanwhile, or if the
/// machine is too slow for any client.
inline constexpr Duration kMostCharged = std::chrono::seconds(2);
/// A client is present if it was heard so recently.
inline constexpr Duration kPresent = std::chrono::seconds(1);

struct JobSize {
  Answer answer{};
  std::uint64_t pixels = 0;  ///< of both views
  bool is_usual = true;      ///< neither view has more than kUsualPixels
};

[[nodiscard]] inline JobSize size_of(const FrameRequest& request) {
  JobSize size{.answer = request.answer.kind};
  for (const View& view : request.views) {
    size.pixels += view.size.pixels();
    size.is_usual = size.is_usual && view.size.pixels() <= kUsualPixels;
  }
  return size;
}

class JobCosts {
 public:
  /// Zero while no job of this kind of answer was measured.
  [[nodiscard]] Duration estimate(const JobSize& job) const {
    return duration_from_ms(ms_per_pixel(job) * static_cast<double>(job.pixels));
  }
  void took(const JobSize& job, Duration work) {
    double& mean = ms_per_pixel_[static_cast<std::size_t>(job.answer)];
    const double measured = ms_of(work) / static_cast<double>(job.pixels);
    mean = mean == 0 ? measured : mean + kNewestWeight * (measured - mean);
  }
  /// The job would have taken longer than `work`.
  void was_given_up(const JobSize& job, Duration work) {
    double& mean = ms_per_pixel_[static_cast<std::size_t>(job.answer)];
    mean = std::max(mean, 2 * ms_of(work) / static_cast<double>(job.pixels));
  }
  /// The estimate shrinks with time, not with refusals, so that one that was wrong is tried again, and who
  /// asks more often is not tried more often.
  void was_refused(const JobSize& job, Time now) {
    const Duration since = std::clamp(now - refused_.value_or(now), Duration{}, kHalfLife);
    ms_per_pixel_[static_cast<std::size_t>(job.answer)] *=
        std::exp2(-seconds_of(since) / seconds_of(kHalfLife));
    refused_ = now;
  }

 private:
  static constexpr Duration kHalfLife = std::chrono::seconds(10);
  static constexpr double kNewestWeight = 0.2;
  [[nodiscard]] double ms_per_pixel(const JobSize& job) const {
    return ms_per_pixel_[static_cast<std::size_t>(job.answer)];
  }
  std::array<double, kAnswers> ms_per_pixel_{};
  std::optional<Time> refused_{};  ///< when a job was refused last
};

}  // namespace farshade
