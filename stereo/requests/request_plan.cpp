#include "stereo/requests/request_plan.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "stereo/base/check.h"
#include "stereo/base/quantile.h"
#include "stereo/math/rotation.h"

namespace farshade {
namespace {

constexpr std::size_t kLatencies = 32;
constexpr std::uint32_t kLeastSide_px = 16;

/// The same window with fewer pixels, rounded to the nearest.
View shrunk(View view, ViewScale scale) {
  const auto side = [&](std::uint32_t full) {
    return std::max(scaled_px(full, scale), std::min(full, kLeastSide_px));
  };
  view.size = {side(view.size.width), side(view.size.height)};
  return view;
}

/// The margins of a view of size `full`, converted to a view of size `small`. They are rounded up to whole
/// tiles, so they cover no smaller angle.
Sides<std::uint32_t> shrunk(const Sides<std::uint32_t>& margins_px, Extent full, Extent small) {
  const auto margin = [](std::uint32_t px, std::uint32_t from, std::uint32_t to) {
    const std::uint64_t step = std::uint64_t{from} * GuardBand::kStep_px;
    return static_cast<std::uint32_t>((std::uint64_t{px} * to + step - 1) / step) * GuardBand::kStep_px;
  };
  return {margin(margins_px.left, full.width, small.width), margin(margins_px.right, full.width, small.width),
          margin(margins_px.up, full.height, small.height),
          margin(margins_px.down, full.height, small.height)};
}

}  // namespace

Rigid<Stage, Head> head_of(const StereoView& views) {
  const auto &left = views[0].stage_from_eye, &right = views[1].stage_from_eye;
  return {slerp(left.rotation, right.rotation, 0.5), (left.translation + right.translation) * 0.5};
}

void RequestPlan::follow(const RequestSettings& settings) {
  if (settings.predictor != settings_.predictor) predictor_ = Predictor(settings.predictor);
  settings_ = settings;
}

void RequestPlan::shrink(ViewScale scale) {
  check(is_valid(scale), "views are requested at one to eight eighths of their size");
  scale_ = scale;
}

void RequestPlan::learn(Duration latency) {
  if (latency > kLongestLatency) return;
  latencies_.push_back(latency);
  if (latencies_.size() > kLatencies) latencies_.pop_front();
}

void RequestPlan::drawn_with(const StereoView& shown, const StereoView& traced, Duration age) {
  if (age > kLongestLatency) return;
  // The traced views at full size and without their guard band: the shown window at the traced pose.
  StereoView unwidened = shown;
  for (std::size_t eye = 0; eye < kEyes; ++eye) {
    unwidened[eye].stage_from_eye.rotation = traced[eye].stage_from_eye.rotation;
    if (use_ == AnswerUse::Reprojected)
      unwidened[eye].stage_from_eye.translation = traced[eye].stage_from_eye.translation;
  }
  guard_band_.observe(shown, unwidened);
}

std::optional<Duration> RequestPlan::median_latency() const {
  if (latencies_.empty()) return std::nullopt;
  std::vector<double> latencies_ms;
  for (const Duration latency : latencies_) latencies_ms.push_back(ms_of(latency));
  return duration_from_ms(quantile(latencies_ms, 0.5));
}

std::uint32_t RequestPlan::frames_apart(Duration period) const {
  if (settings_.every > 0) return settings_.every;
  if (motion_ == SceneMotion::Moving || median_latency().value_or(Duration::zero()) < kStillInterval)
    return 1;
  return static_cast<std::uint32_t>(std::max((kStillInterval + period / 2) / period, Duration::rep{1}));
}

Duration RequestPlan::lead(Duration period) const {
  if (settings_.predictor == PredictorKind::Hold) return {};
  // The first frame that begins after the masks have come is the first to use them. The tolerance keeps a
  // latency of whole frames from being rounded up to one more.
  const double frames = std::ceil(seconds_of(median_latency().value_or(period)) / seconds_of(period) - 1e-3);
  const double used_s = std::max(frames, 0.0) * seconds_of(period);
  // With one request in n periods, masks are used for n periods: aim at the middle of them.
  return duration_from_ms(used_s * 1e3) + period * (frames_apart(period) - 1) / 2;
}

bool RequestPlan::is_due(const FrameMoment& shown, Duration period) {
  const std::uint32_t frame = frames_++;
  if (settings_.every > 0) return frame % settings_.every == 0;
  const std::uint32_t apart = frames_apart(period);
  if (apart == 1 || !asked_for_ || shown.lights != asked_for_->lights) return true;
  const Duration since = shown.display_time - asked_for_->display_time;
  return since < Duration::zero() || since >= period * apart - period / 2;
}

std::optional<FrameRequest> RequestPlan::ask(const FrameMoment& shown, Duration period, SceneClock scene) {
  const Rigid<Stage, Head> head = head_of(shown.views);
  predictor_.observe(shown.display_time, head);
  if (!is_due(shown, period)) return std::nullopt;
  asked_for_ = shown;

  const Duration ahead = lead(period);
  FrameRequest request{shown};
  request.display_time += ahead;
  if (scene == SceneClock::Running) request.scene_time += ahead;
  const Rigid<Stage, Head> then = predictor_.predict(request.display_time);
  if (ahead > Duration::zero() && then != head)
    for (View& view : request.views) view.stage_from_eye = then * (inverse(head) * view.stage_from_eye);
  const StereoView full = request.views;
  for (View& view : request.views) view = shrunk(view, scale_);
  if (settings_.guard_band == GuardBandUse::Off) return request;

  // Held views are not predicted, but used after the whole latency. Any latency gives the same margins:
  // Hold knows no velocity.
  const bool is_held = settings_.predictor == PredictorKind::Hold;
  const Duration used_after = !is_held ? ahead : latencies_.empty() ? period : latencies_.back();
  Sides<std::uint32_t> needed = shrunk(
      guard_band_.margins_px(full, predictor_.velocity(), used_after, period * (frames_apart(period) - 1) / 2,
                             settings_.guard_band_percent / 100.0),
      full[0].size, request.views[0].size);
  if (use_ == AnswerUse::Timewarped) needed = steady_band_.margins_px(needed, request.views[0].size);
  const Sides<std::uint32_t> margins = reduced_to_fit(request.views, needed, most_pixels_);
  const StereoView wide{widened(request.views[0], margins), widened(request.views[1], margins)};
  if (is_valid(wide[0]) && is_valid(wide[1])) request.views = wide;  // rounding may exceed a limit
  return request;
}

}  // namespace farshade
