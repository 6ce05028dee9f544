#include "stereo/head/plausible.h"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>

#include "stereo/head/gravity.h"
#include "stereo/math/rotation.h"

namespace farshade {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kLiesDown_rad = 45 * kDegree;  ///< no head that is worn is so far off on average
constexpr double kStands_rad = 30 * kDegree;    ///< what other axes must reach to be proposed
constexpr double kLevel_rad = 3 * kDegree;      ///< a head that leans by less is left as it is
/// The turn_width that levelling needs. Public recordings reach 0.35, a head that only swings by 0.3 rad
/// about its neck 0.04.
constexpr double kLooksAround = 0.25;

QuaternionOrder other(QuaternionOrder order) {
  return order == QuaternionOrder::Wxyz ? QuaternionOrder::Xyzw : QuaternionOrder::Wxyz;
}

/// The same four numbers, read in the order other than `order`.
std::vector<HeadSample> reordered(std::vector<HeadSample> samples, QuaternionOrder order) {
  for (auto& [time, pose] : samples) {
    const auto [x, y, z, w] = std::array{pose.rotation.x, pose.rotation.y, pose.rotation.z, pose.rotation.w};
    pose.rotation = order == QuaternionOrder::Wxyz ? glm::dquat(z, w, x, y) : glm::dquat(x, y, z, w);
  }
  return samples;
}

std::vector<HeadSample> in_stage(std::vector<HeadSample> samples, const Axes& axes) {
  for (HeadSample& sample : samples) sample.recorded_from_head = in_stage(axes, sample.recorded_from_head);
  return samples;
}

/// A recording begins near its origin's direction, which tells a turned head from a misread quaternion.
bool begins_forward(const std::vector<HeadSample>& samples) {
  return angle_between_rad(samples.front().recorded_from_head.rotation, {1, 0, 0, 0}) < std::numbers::pi / 2;
}

/// Whether only `swapped`, the samples with the other order of quaternions, are of a head that is worn. With
/// z up, the wrong order turns a head around, so it walks backwards; but that may be due to unknown axes,
/// too.
bool is_worn_better(const std::vector<HeadSample>& swapped, const std::vector<HeadSample>& samples,
                    const HeadFileOptions& options) {
  const Posture posture = posture_of(samples, kLiesDown_rad), better = posture_of(swapped, kStands_rad);
  return (posture == Posture::LiesDown && better > posture) ||
         (posture == Posture::WalksAside && options.axes && better == Posture::WalksAhead);
}

/// Whether the samples stay within kFarthestHead_m when they turn about the first.
bool may_turn(const std::vector<HeadSample>& samples) {
  return std::ranges::all_of(samples, [](const HeadSample& sample) {
    return glm::length(sample.recorded_from_head.translation) < kFarthestHead_m / 4;
  });
}

bool is_below_ground(const std::vector<HeadSample>& samples) {
  constexpr double kLowest_m = -0.5;  // of a head, on average
  double sum_m = 0;
  for (const HeadSample& sample : samples) sum_m += sample.recorded_from_head.translation.y;
  return sum_m < kLowest_m * static_cast<double>(samples.size());
}

/// The axes in which these samples stand and, if they walk steadily, look ahead: "ros or unreal".
std::string fitting_axes(const std::vector<HeadSample>& samples, Posture at_least) {
  std::string fitting;
  for (const std::string_view name : kTriedAxes) {
    const std::vector<HeadSample> tried = in_stage(samples, parse_axes(name).value());
    if (posture_of(tried, kStands_rad) >= at_least && !is_below_ground(tried))
      fitting.append(fitting.empty() ? "" : " or ").append(name);
  }
  return fitting;
}

/// `read`: as they are in the file, in the order that was taken.
std::string doubt_about(Posture posture, const std::vector<HeadSample>& read, QuaternionOrder order,
                        bool is_sure) {
  const bool lies = posture == Posture::LiesDown;
  const Posture at_least = lies ? Posture::Upright : Posture::WalksAhead;
  std::string doubt =
      lies ? "the heads are not upright on average" : "the head walks steadily, but not where it looks";
  if (const std::string axes = fitting_axes(read, at_least); !axes.empty())
    return doubt + ": --trace-axes " + axes + " would fit";
  if (is_sure) return doubt;
  if (const std::string axes = fitting_axes(reordered(read, order), at_least); !axes.empty())
    return fmt::format("{}: --trace-quaternion {} with --trace-axes {} would fit", doubt,
                       to_string(other(order)), axes);
  return doubt;
}

}  // namespace

Expected<void> check_rate(double rate_hz, const FileFacts& facts, TimeUnit unit,
                          std::optional<TimeUnit> better) {
  if (is_plausible(rate_hz)) return {};
  return fail(
      Fault::OutOfRange,
      fmt::format("{}: {:.3g} samples a second with time stamps in {}, instead of {:g} to {:g}{}", facts.file,
                  rate_hz, to_string(unit), kLeastRate_hz, kMostRate_hz,
                  better && better != unit ? fmt::format(": --trace-units {} would fit", to_string(*better))
                                           : std::string()));
}

Uprightness make_upright(std::vector<HeadSample>& samples, const FileFacts& facts,
                         const HeadFileOptions& options) {
  Uprightness upright{.order = options.order.value_or(facts.order_read)};
  if (upright.order != facts.order_read) samples = reordered(std::move(samples), facts.order_read);
  const bool axes_known = options.axes || facts.states_axes,
             order_known = options.order || facts.states_order;
  const Axes axes = options.axes.value_or(Axes());
  std::vector<HeadSample> read = samples;
  samples = in_stage(read, axes);
  if (!facts.states_axes && !order_known)
    if (std::vector<HeadSample> swapped = in_stage(reordered(read, upright.order), axes);
        begins_forward(swapped) && is_worn_better(swapped, samples, options)) {
      read = reordered(std::move(read), upright.order);
      samples = std::move(swapped);
      upright.order = other(upright.order);
    }
  const Posture posture = posture_of(samples, kLiesDown_rad);
  if (posture == Posture::LiesDown || (posture == Posture::WalksAside && !axes_known)) {
    upright.doubt = doubt_about(posture, read, upright.order, order_known);
  } else if (!axes_known && may_turn(samples) && turn_width(samples) >= kLooksAround) {
    const glm::dquat level = levelling(samples);
    const double off_rad = angle_between_rad(level, {1, 0, 0, 0});
    if (off_rad >= kLevel_rad && off_rad <= kLiesDown_rad) {
      turn(samples, level);
      upright.doubt = fmt::format("levelled by {:.1f} degrees (--trace-axes {} keeps the tilt)",
                                  off_rad / kDegree, Axes().name);
    }
  }
  return upright;
}

std::string doubt_about_units(const std::vector<HeadSample>& samples, const std::vector<double>& stamps) {
  constexpr double kFastest_m_s = 10;
  if (std::ranges::adjacent_find(stamps, [](double a, double b) { return b != a + 1; }) == stamps.end())
    return "time stamps count by one, as frame numbers do";
  double path_m = 0;
  for (std::size_t i = 1; i < samples.size(); ++i)
    path_m += glm::length(samples[i].recorded_from_head.translation -
                          samples[i - 1].recorded_from_head.translation);
  const double speed_m_s = path_m / seconds_of(samples.back().time - samples.front().time);
  if (speed_m_s < kFastest_m_s) return {};
  return fmt::format("the head moves at {:.3g} m/s on average: --trace-scale says how many units are a metre",
                     speed_m_s);
}

std::string read_as(const HeadRecording& recording, const FileFacts& facts, const HeadFileOptions& options,
                    TimeUnit unit, const Uprightness& upright) {
  constexpr std::string_view kGiven = " (given)", kStated = " (stated)", kAssumed = " (assumed)";
  const auto how = [&](bool given, bool stated) { return given ? kGiven : stated ? kStated : kAssumed; };
  const double length_s = seconds_of(recording.end() - recording.start());
  const std::string metres =
      (facts.units_a_metre == 1 ? "positions in m" : fmt::format("{:g} units a metre", facts.units_a_metre)) +
      std::string(facts.states_scale ? kStated : "");
  return fmt::format(
      "{}: {}, {} samples in {:.1f} s, {:.4g} a second; time stamps in {}{}, quaternions {}{}, axes {}{}, {}",
      facts.file, facts.format, recording.samples.size(), length_s,
      static_cast<double>(recording.samples.size() - 1) / length_s, to_string(unit),
      how(options.unit.has_value(), facts.unit.has_value()), to_string(upright.order),
      how(options.order.has_value(), facts.states_order), options.axes.value_or(Axes()).name,
      how(options.axes.has_value(), facts.states_axes), metres);
}

}  // namespace farshade
