#include "vr_client/preview/preview_runtime.h"

#include <utility>

#include "stereo/base/check.h"

namespace farshade {

PreviewRuntime::PreviewRuntime(const PreviewSetup& setup, const Clock& clock, Sleep sleep, TakeIn take_in)
    : setup_(setup),
      clock_(clock),
      sleep_(std::move(sleep)),
      take_in_(std::move(take_in)),
      pacer_(setup.refresh_hz),
      hand_(setup.start),
      stage_from_head_(setup.start) {
  if (setup.recording) player_.emplace(setup.recording->trace.end() - setup.recording->trace.start());
}

std::optional<FrameTiming> PreviewRuntime::wait_frame() {
  if (setup_.frames && begun_ >= *setup_.frames) return std::nullopt;
  const Time now = clock_.now();
  if (began_at_) pacer_.learn(now - *began_at_);
  const Time begin = pacer_.next_begin(now);
  if (begin > now) sleep_(begin - now);

  const std::optional<HeadControls> hands = take_in_();
  if (!hands) return std::nullopt;
  began_at_ = clock_.now();
  const FrameTiming timing = pacer_.begin(*began_at_);
  move_head(*hands, timing.display_time - display_time_.value_or(timing.display_time));
  headset_ = hands->headset;
  display_time_ = timing.display_time;
  ++begun_;
  return timing;
}

void PreviewRuntime::move_head(const HeadControls& hands, Duration span) {
  const HeadSource before = std::exchange(source_, player_ ? hands.source : HeadSource::Hand);
  if (source_ == HeadSource::Recording) {
    player_->advance(span);
    stage_from_head_ = recorded_head(Duration::zero());
  } else {
    if (before == HeadSource::Recording) hand_ = SimulatedHead(stage_from_head_);
    hand_.step(hands.head, span);
    stage_from_head_ = hand_.stage_from_head();
  }
}

Rigid<Stage, Head> PreviewRuntime::recorded_head(Duration ahead) const {
  const HeadRecording& trace = setup_.recording->trace;
  return setup_.recording->stage_from_recorded *
         head_at(trace, trace.start() + player_->position_after(ahead));
}

StereoView PreviewRuntime::locate_views(Time display_time) const {
  check(display_time_.has_value(), "a frame has begun before its views are located");
  return views_of(
      source_ == HeadSource::Recording ? recorded_head(display_time - *display_time_) : stage_from_head_,
      headset_);
}

void PreviewRuntime::end_frame(Time) {}

}  // namespace farshade
