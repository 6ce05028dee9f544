#include "vr_client/preview/preview_runtime.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "stereo/base/check.h"
#include "stereo/base/quantile.h"

namespace farshade {

FramePacer::FramePacer(double refresh_hz) : period_ns_(1e9 / refresh_hz) {
  check(std::isfinite(refresh_hz) && refresh_hz > 0, "the refresh rate is finite and above 0");
}

void FramePacer::Periods::learn(Duration time, double period_ns) {
  times_ns_[oldest_] = static_cast<double>(time.count());
  oldest_ = (oldest_ + 1) % kRemembered;
  const double typical = quantile({times_ns_.begin(), times_ns_.end()}, kQuantile) / period_ns;
  const auto fits = static_cast<std::uint32_t>(std::max(1.0, std::ceil(typical)));
  const auto fits_with_room = static_cast<std::uint32_t>(std::max(1.0, std::ceil(typical / kRoom)));
  count_ = std::clamp(count_, fits, fits_with_room);
}

Time FramePacer::next_begin(Time now) const {
  return grid_ ? *grid_ + after(tick_to_begin_at(now)) : now;
}

FrameTiming FramePacer::begin(Time now) {
  if (!grid_) grid_ = now;
  const std::int64_t begin = tick_to_begin_at(now);
  next_ = begin + between_.count();
  shown_at_ = begin + lead();
  return {*grid_ + after(shown_at_), after(between_.count())};
}

Duration FramePacer::after(std::int64_t ticks) const {
  return Duration(std::llround(static_cast<double>(ticks) * period_ns_));
}

std::int64_t FramePacer::tick_to_begin_at(Time now) const {
  return std::max<std::int64_t>(std::max(next_, shown_at_ + 1 - lead()),
                                std::llround(static_cast<double>((now - *grid_).count()) / period_ns_));
}

PreviewRuntime::PreviewRuntime(const PreviewSetup& setup, const Clock& clock, Sleep sleep,
                               ReadControls read_controls)
    : setup_(setup),
      clock_(clock),
      sleep_(std::move(sleep)),
      read_controls_(std::move(read_controls)),
      pacer_(setup.refresh_hz),
      simulated_(setup.start),
      stage_from_head_(setup.start) {
  if (setup.recording) player_.emplace(setup.recording->head.end() - setup.recording->head.start());
}

std::optional<FrameTiming> PreviewRuntime::wait_frame() {
  if (setup_.frames && frames_ >= *setup_.frames) return std::nullopt;
  const Time now = clock_.now();
  if (began_at_) pacer_.learn(now - *began_at_);
  const Time begin = pacer_.next_begin(now);
  if (begin > now) sleep_(begin - now);

  const std::optional<HeadControls> controls = read_controls_();
  if (!controls) return std::nullopt;
  began_at_ = clock_.now();
  const FrameTiming timing = pacer_.begin(*began_at_);
  move_head(*controls, timing.display_time - display_time_.value_or(timing.display_time));
  headset_ = controls->headset;
  display_time_ = timing.display_time;
  ++frames_;
  return timing;
}

void PreviewRuntime::move_head(const HeadControls& controls, Duration span) {
  const HeadSource before = std::exchange(source_, player_ ? controls.source : HeadSource::Simulated);
  if (source_ == HeadSource::Recording) {
    player_->advance(span);
    stage_from_head_ = recorded_head(Duration::zero());
  } else {
    if (before == HeadSource::Recording) simulated_ = SimulatedHead(stage_from_head_);
    simulated_.step(controls.head, span);
    stage_from_head_ = simulated_.stage_from_head();
  }
}

Rigid<Stage, Head> PreviewRuntime::recorded_head(Duration ahead) const {
  const HeadRecording& head = setup_.recording->head;
  return setup_.recording->stage_from_recorded * head_at(head, head.start() + player_->position_after(ahead));
}

StereoView PreviewRuntime::locate_views(Time display_time) {
  check(display_time_.has_value(), "views are located after a frame has begun");
  return views_of(
      source_ == HeadSource::Recording ? recorded_head(display_time - *display_time_) : stage_from_head_,
      headset_);
}

}  // namespace farshade
