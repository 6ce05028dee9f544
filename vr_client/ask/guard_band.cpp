#include "vr_client/ask/guard_band.h"

#include <algorithm>
#include <cmath>

#include "stereo/base/quantile.h"
#include "stereo/frame/pose_delta.h"

namespace farshade {
namespace {

/// Two seconds at 72 Hz: long enough for a tail, short enough to follow a head that comes to rest.
constexpr std::size_t kMemory_frames = 144;
constexpr double kQuantile = 0.95;
/// Of the angle that the head would turn within the lead at its present speed, as a margin on both sides:
/// what a predictor that has just seen the head start or stop may be wrong by.
constexpr double kOfTurn = 0.15;
/// Of a side of the view: what both margins of an axis may add at most.
constexpr std::uint32_t kMostParts = 4;

/// Left, right, up, down of each eye's worst.
Sides<double> worst(const Sides<double>& a, const Sides<double>& b) {
  return {std::max(a.left, b.left), std::max(a.right, b.right), std::max(a.up, b.up),
          std::max(a.down, b.down)};
}

std::uint32_t stepped(double margin_px) {
  return static_cast<std::uint32_t>(std::ceil(std::max(margin_px, 0.0) / GuardBand::kStep_px)) *
         GuardBand::kStep_px;
}

std::uint32_t most_px(std::uint32_t side) {
  return (side / kMostParts + GuardBand::kStep_px - 1) / GuardBand::kStep_px * GuardBand::kStep_px;
}

/// Both margins of an axis within what the axis may grow by, each in whole steps.
void fit(double low, double high, std::uint32_t side, std::uint32_t& low_px, std::uint32_t& high_px) {
  const double most = most_px(side), sum = std::max(low, 0.0) + std::max(high, 0.0);
  const double scale = sum > most ? most / sum : 1;
  low_px = std::min(stepped(low * scale), most_px(side));
  high_px = std::min(stepped(high * scale), most_px(side) - low_px);
}

}  // namespace

Sides<double> outside_px(const View& shown, const View& traced) {
  const PoseDelta delta = pose_delta(shown, {}, traced, {});
  const FovTangents from = tangents_of(shown.fov), to = tangents_of(traced.fov);
  const double width = traced.size.width, height = traced.size.height;
  Sides<double> out{-width, -width, -height, -height};
  constexpr int kParts = 4;  // of each side
  for (int i = 0; i <= kParts; ++i)
    for (int j = 0; j <= kParts; ++j) {
      if (i % kParts != 0 && j % kParts != 0) continue;  // the border alone
      const glm::dvec3 ray(from.left_tan + (from.right_tan - from.left_tan) * i / kParts,
                           from.up_tan + (from.down_tan - from.up_tan) * j / kParts, -1);
      for (const double nearness : {0.0, 1 / kNearest_m}) {
        const glm::dvec3 seen =
            delta.traced_from_shown.rotation * ray + delta.traced_from_shown.translation * nearness;
        // Beyond 80 degrees off the axis no margin helps.
        const glm::dvec2 px = ray_pixel(to, traced.size, {seen.x, seen.y, std::min(seen.z, -0.17)});
        out = worst(out, {-px.x, px.x - width, -px.y, px.y - height});
      }
    }
  return out;
}

View widened(const View& view, const Sides<std::uint32_t>& margins_px) {
  const FovTangents w = tangents_of(view.fov);
  const double x = (w.right_tan - w.left_tan) / view.size.width,
               y = (w.down_tan - w.up_tan) / view.size.height;
  return {view.stage_from_eye,
          {std::atan(w.left_tan - margins_px.left * x), std::atan(w.right_tan + margins_px.right * x),
           std::atan(w.up_tan - margins_px.up * y), std::atan(w.down_tan + margins_px.down * y)},
          {view.size.width + margins_px.left + margins_px.right,
           view.size.height + margins_px.up + margins_px.down}};
}

Extent largest_traced(Extent size) {
  return {size.width + most_px(size.width), size.height + most_px(size.height)};
}

void GuardBand::observe(const StereoView& shown, const StereoView& predicted) {
  const Sides<double> out = worst(outside_px(shown[0], predicted[0]), outside_px(shown[1], predicted[1]));
  if (seen_.size() < kMemory_frames) {
    seen_.push_back(out);
  } else {
    seen_[next_] = out;
  }
  next_ = (next_ + 1) % kMemory_frames;
}

Sides<std::uint32_t> GuardBand::margins_px(const StereoView& views, const Twist& velocity, Duration lead,
                                           Duration spread, double share) const {
  const auto measured = [&](double Sides<double>::*side) {
    std::vector<double> values;
    for (const Sides<double>& seen : seen_) values.push_back(seen.*side);
    return values.empty() ? 0.0 : share * std::max(quantile(values, kQuantile), 0.0);
  };
  const FovTangents w = tangents_of(views[0].fov);
  const Extent size = views[0].size;
  // Pixels a radian at the border, where a turn moves the picture fastest.
  const auto per_rad = [](double low, double high, double pixels) {
    const double edge = std::max(std::abs(low), std::abs(high));
    return pixels / std::abs(high - low) * (1 + edge * edge);
  };
  const double per_yaw = per_rad(w.left_tan, w.right_tan, size.width),
               per_pitch = per_rad(w.up_tan, w.down_tan, size.height);
  const double turn = kOfTurn * seconds_of(lead), late = seconds_of(spread);
  // A turn to the left (positive about +y) uncovers the left border, one upwards (about +x) the upper one.
  const double yaw = share * velocity.angular.y * per_yaw, pitch = share * velocity.angular.x * per_pitch;
  const double either_x = std::abs(yaw) * turn, either_y = std::abs(pitch) * turn;
  Sides<std::uint32_t> margins;
  fit(measured(&Sides<double>::left) + either_x + std::abs(yaw) * late,
      measured(&Sides<double>::right) + either_x + std::abs(yaw) * late, size.width, margins.left,
      margins.right);
  fit(measured(&Sides<double>::up) + either_y + std::abs(pitch) * late,
      measured(&Sides<double>::down) + either_y + std::abs(pitch) * late, size.height, margins.up,
      margins.down);
  return margins;
}

}  // namespace farshade
