#include "vr_client/ask/request_plan.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "stereo/base/check.h"
#include "stereo/base/quantile.h"
#include "stereo/math/rotation.h"

namespace farshade {
namespace {

constexpr std::size_t kLatencies = 32, kMostForeseen = 256;
constexpr std::uint32_t kLeastSide_px = 16;

/// The same window with fewer pixels.
View shrunk(View view, ViewScale scale) {
  const auto side = [&](std::uint32_t full) {
    return std::max(scaled_px(full, scale), std::min(full, kLeastSide_px));
  };
  view.size = {side(view.size.width), side(view.size.height)};
  return view;
}

/// Margins of a view of size `full` as those of one of size `small`: no narrower, and whole tiles again.
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

void RequestPlan::follow(const RequestSettings& wish) {
  if (wish.predictor != wish_.predictor) predictor_ = Predictor(wish.predictor);
  wish_ = wish;
}

void RequestPlan::shrink(ViewScale scale) {
  check(is_valid(scale), "views are requested at one to eight eighths of their size");
  scale_ = scale;
}

void RequestPlan::learn(Duration later) {
  if (later > kLongestLatency) return;
  later_.push_back(later);
  if (later_.size() > kLatencies) later_.pop_front();
}

Duration RequestPlan::lead(Duration period) const {
  if (wish_.predictor == PredictorKind::Hold) return {};
  std::vector<double> later;
  for (const Duration d : later_) later.push_back(seconds_of(d));
  // Masks are used from the first frame on that begins after they have come.
  const double frames = later.empty() ? 1 : std::ceil(quantile(later, 0.5) / seconds_of(period) - 1e-3);
  const double used_s = std::max(frames, 0.0) * seconds_of(period);
  // Masks that come once in n frames are used for n frames: aim at the middle of these.
  return duration_from_ms(used_s * 1e3) + period * (wish_.every - 1) / 2;
}

/// How the views expected for this display time differ from those that are shown.
void RequestPlan::compare(const FrameRequest& shown, Duration period) {
  while (!foreseen_.empty() && foreseen_.front().display_time < shown.display_time - period / 2)
    foreseen_.pop_front();
  if (foreseen_.empty() || foreseen_.front().display_time > shown.display_time + period / 2) return;
  guard_band_.observe(shown.views, foreseen_.front().views);
}

std::optional<FrameRequest> RequestPlan::ask(const FrameRequest& shown, Duration period, SceneClock scene) {
  const Rigid<Stage, Head> head = head_of(shown.views);
  predictor_.observe(shown.display_time, head);
  compare(shown, period);
  if (frames_++ % wish_.every != 0) return std::nullopt;

  const Duration ahead = lead(period);
  FrameRequest request = shown;
  request.display_time += ahead;
  if (scene == SceneClock::Runs) request.scene_time += ahead;
  const Rigid<Stage, Head> then = predictor_.predict(request.display_time);
  if (ahead > Duration::zero() && then != head)
    for (View& view : request.views) view.stage_from_eye = then * (inverse(head) * view.stage_from_eye);
  const StereoView full = request.views;
  for (View& view : request.views) view = shrunk(view, scale_);
  if (wish_.guard_band == GuardBandUse::Off) return request;

  // Held views are used late by all of their latency; predicted ones by what the masks' rate leaves.
  const bool held = wish_.predictor == PredictorKind::Hold;
  const Time used_at =
      held ? shown.display_time + (later_.empty() ? period : later_.back()) : request.display_time;
  foreseen_.push_back({used_at, full});
  if (foreseen_.size() > kMostForeseen) foreseen_.pop_front();
  const Sides<std::uint32_t> margins =
      shrunk(guard_band_.margins_px(full, predictor_.velocity(), used_at - shown.display_time,
                                    period * (wish_.every - 1) / 2, wish_.guard_band_percent / 100.0),
             full[0].size, request.views[0].size);
  // Views at the limits of what may be asked for stay as they are.
  const StereoView wide{widened(request.views[0], margins), widened(request.views[1], margins)};
  const auto may_be_asked = [&](const View& view) {
    return is_valid(view) && view.size.pixels() <= most_pixels_;
  };
  if (may_be_asked(wide[0]) && may_be_asked(wide[1])) request.views = wide;
  return request;
}

}  // namespace farshade
