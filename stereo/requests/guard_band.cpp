#include "stereo/requests/guard_band.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "stereo/base/quantile.h"
#include "stereo/frame/pose_delta.h"

namespace farshade {
namespace {

/// Two seconds at 72 Hz: long enough to see rare errors, short enough to follow a head that comes to rest.
constexpr std::size_t kMemory_frames = 144;
constexpr double kQuantile = 0.95;
/// Share of the angle that the head turns within the lead at its present speed. It is added to both sides of
/// the axis: a predictor may be wrong by so much when the head has just started or stopped.
constexpr double kTurnShare = 0.15;
/// Both margins of an axis together add at most this part of the view's side: a quarter.
constexpr std::uint32_t kLargestPart = 4;

Sides<double> worst(const Sides<double>& a, const Sides<double>& b) {
  return {std::max(a.left, b.left), std::max(a.right, b.right), std::max(a.up, b.up),
          std::max(a.down, b.down)};
}

std::uint32_t stepped(double margin_px) {
  return static_cast<std::uint32_t>(std::ceil(std::max(margin_px, 0.0) / GuardBand::kStep_px)) *
         GuardBand::kStep_px;
}

std::uint32_t most_px(std::uint32_t side) {
  return (side / kLargestPart + GuardBand::kStep_px - 1) / GuardBand::kStep_px * GuardBand::kStep_px;
}

/// Rounds both margins of an axis up to whole steps, within the largest growth of the axis.
void round_axis(double low, double high, std::uint32_t side, std::uint32_t& low_px, std::uint32_t& high_px) {
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
  constexpr int kParts = 4;  // samples along each side of the border
  for (int i = 0; i <= kParts; ++i)
    for (int j = 0; j <= kParts; ++j) {
      if (i % kParts != 0 && j % kParts != 0) continue;  // not on the border
      const glm::dvec3 ray(from.left_tan + (from.right_tan - from.left_tan) * i / kParts,
                           from.up_tan + (from.down_tan - from.up_tan) * j / kParts, -1);
      for (const double nearness : {0.0, 1 / kNearest_m}) {
        const glm::dvec3 seen =
            delta.traced_from_shown.rotation * ray + delta.traced_from_shown.translation * nearness;
        // No margin helps beyond 80 degrees off the axis.
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
  const auto largest = [](std::uint32_t side) { return std::min(side + most_px(side), kMaxViewSide_px); };
  return {largest(size.width), largest(size.height)};
}

Sides<std::uint32_t> reduced_to_fit(const StereoView& views, const Sides<std::uint32_t>& needed_px,
                                    std::uint64_t most_pixels) {
  using Margins = Sides<std::uint32_t>;
  const auto fits = [&](const Margins& margins) {
    return std::ranges::all_of(views, [&](const View& view) {
      const View wide = widened(view, margins);
      return is_valid(wide) && wide.size.pixels() <= most_pixels;
    });
  };
  if (fits(needed_px)) return needed_px;
  Margins given{}, missing = needed_px;
  const auto needs_less = [&](auto a, auto b) { return missing.*a < missing.*b; };
  constexpr std::array kEach{&Margins::left, &Margins::right, &Margins::up, &Margins::down};
  for (;;) {
    const auto side = *std::ranges::max_element(kEach, needs_less);
    if (missing.*side == 0) return given;
    Margins wider = given;
    wider.*side += std::min(missing.*side, GuardBand::kStep_px);
    if (fits(wider)) {
      missing.*side -= wider.*side - given.*side;
      given = wider;
    } else {
      missing.*side = 0;
    }
  }
}

void GuardBand::observe(const StereoView& shown, const StereoView& traced) {
  const Sides<double> outside = worst(outside_px(shown[0], traced[0]), outside_px(shown[1], traced[1]));
  if (observed_px_.size() < kMemory_frames) {
    observed_px_.push_back(outside);
  } else {
    observed_px_[next_] = outside;
  }
  next_ = (next_ + 1) % kMemory_frames;
}

Sides<std::uint32_t> GuardBand::margins_px(const StereoView& views, const Twist& velocity, Duration lead,
                                           Duration spread, double share) const {
  const auto measured = [&](double Sides<double>::*side) {
    std::vector<double> values;
    for (const Sides<double>& outside : observed_px_) values.push_back(outside.*side);
    return values.empty() ? 0.0 : share * std::max(quantile(values, kQuantile), 0.0);
  };
  const FovTangents w = tangents_of(views[0].fov);
  const Extent size = views[0].size;
  // Pixels per radian at the border, where a turn moves the picture fastest.
  const auto per_rad = [](double low, double high, double pixels) {
    const double edge = std::max(std::abs(low), std::abs(high));
    return pixels / std::abs(high - low) * (1 + edge * edge);
  };
  const double per_yaw = per_rad(w.left_tan, w.right_tan, size.width),
               per_pitch = per_rad(w.up_tan, w.down_tan, size.height);
  // The head may stop as well as go on, so both sides of an axis get the same.
  const double yaw_px = share * std::abs(velocity.angular.y) * per_yaw,
               pitch_px = share * std::abs(velocity.angular.x) * per_pitch;
  const double surprise_s = kTurnShare * seconds_of(lead), spread_s = seconds_of(spread);
  // The measurement holds what the spread adds, once frames have been drawn at this speed.
  const auto margin = [&](double Sides<double>::*side, double px_per_s) {
    return std::max(measured(side), px_per_s * spread_s) + px_per_s * surprise_s;
  };
  Sides<std::uint32_t> margins;
  round_axis(margin(&Sides<double>::left, yaw_px), margin(&Sides<double>::right, yaw_px), size.width,
             margins.left, margins.right);
  round_axis(margin(&Sides<double>::up, pitch_px), margin(&Sides<double>::down, pitch_px), size.height,
             margins.up, margins.down);
  return margins;
}

}  // namespace farshade
