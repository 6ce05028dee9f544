#include "tests/unit/head/stiff_sweep.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "stereo/head/damped_motion.h"
#include "stereo/head/prediction.h"
#include "tests/unit/head/covariance.h"
#include "tests/unit/head/stiff_reference.h"

namespace farshade::stiff {
namespace {

constexpr Duration kNoGapTooLong = std::chrono::hours(1);
constexpr double kLeads_s[] = {1e-3, 0.05, 0.5};
constexpr int kSamples = 300;

/// The motion: along x at walking pace, or about y as fast as heads of the domain turn.
enum class Axis { Linear, Angular };
constexpr Axis kAxes[] = {Axis::Linear, Axis::Angular};

std::string name_of(Axis axis) {
  return axis == Axis::Linear ? "walk," : "turn,";
}

double speed_of(Axis axis) {
  return axis == Axis::Linear ? 1.0 : 1000.0 * std::numbers::pi / 180.0;
}

HeadPose posed(Axis axis, double value) {
  return axis == Axis::Linear ? HeadPose{{1, 0, 0, 0}, {value, 0, 0}}
                              : HeadPose{rotation_exp({0, value, 0}), {}};
}

/// The coordinate of the pose along or about the axis, without additional rounding.
Real coordinate(Axis axis, const HeadPose& pose) {
  return axis == Axis::Linear ? Real(pose.translation.x)
                              : 2 * std::atan2(Real(pose.rotation.y), Real(pose.rotation.w));
}

/// to - from; for an angle, the shorter direction.
Real difference(Axis axis, Real from, Real to) {
  return axis == Axis::Linear ? to - from : std::remainder(to - from, 2 * std::numbers::pi_v<Real>);
}

double component(Axis axis, const Twist& twist) {
  return axis == Axis::Linear ? twist.linear.x : twist.angular.y;
}

/// The largest allowed errors of one motion: of the velocity, relative to the fastest mean rate of a step so
/// far; of the predicted pose, relative to 1 plus its possible distance (rad or m).
struct Bounds {
  double velocity, ahead;
};

struct Sample {
  std::int64_t at_ns;
  double step_s;
  HeadPose pose;
};

std::vector<Sample> motion(Axis axis, double step_s) {
  const double speed = speed_of(axis);
  std::vector<Sample> samples;
  std::int64_t now = 0;
  double at = 0;
  for (int i = 0; i < kSamples; ++i) {
    const double part = i % 7 == 3 ? 1e-3 : i % 11 == 5 ? 10.0 : 1.0;
    const std::int64_t step_ns = std::llround(step_s * part * 1e9);
    const double moving_s = 1e-9 * static_cast<double>(step_ns);
    now += step_ns;
    if (i >= 20 && i < 120) at += speed * moving_s;
    if (i == 120) at += 0.04;
    if (i >= 140 && i < 200) at -= speed * moving_s;
    if (i >= 200) at += speed * moving_s * std::sin(0.4 * i);
    samples.push_back({now, moving_s, posed(axis, at)});
  }
  return samples;
}

/// Repeats every third stamp and then adds an earlier one, both with a pose that the head never had.
void observe(Predictor& predictor, const Sample& sample, int count) {
  const Time time{Duration(sample.at_ns)};
  predictor.observe(time, sample.pose);
  if (count % 3) return;
  const HeadPose nowhere{rotation_exp({0.3, 2.0, 0.1}), {5, 5, 5}};
  predictor.observe(time, nowhere);
  predictor.observe(time - Duration(1), nowhere);
}

double relative(Real actual, Real expected) {
  return expected == 0 ? static_cast<double>(std::abs(actual))
                       : static_cast<double>(std::abs(actual / expected - 1));
}

std::vector<double> decades(int from, int to, int parts) {
  std::vector<double> all;
  for (int part = parts * from; part <= parts * to; ++part)
    all.push_back(std::pow(10.0, static_cast<double>(part) / parts));
  return all;
}

/// Runs one filter and its reference through the motion and records their largest differences. The reference
/// has step(step_s, the sample's coordinate), velocity(), and ahead(lead), which returns a coordinate.
template <class Reference>
void compare(const PoseFilter& filter, Reference reference, Axis axis, double step_s, double constant_s,
             GridError& velocity, GridError& ahead) {
  Predictor predictor(filter, kNoGapTooLong);
  double fastest = 0;
  Real before = 0;
  int count = 0;
  for (const Sample& sample : motion(axis, step_s)) {
    const Real now = coordinate(axis, sample.pose);
    if (count > 0)
      fastest =
          std::max(fastest, static_cast<double>(std::abs(difference(axis, before, now))) / sample.step_s);
    before = now;
    observe(predictor, sample, count);
    count++ == 0 ? reference.start(now) : reference.step(Real(sample.step_s), now);
    const Real parted = component(axis, predictor.velocity()) - reference.velocity();
    if (fastest > 0) velocity.add(static_cast<double>(std::abs(parted)) / fastest, step_s, constant_s);
    for (const double lead_s : kLeads_s) {
      const Time then = Time(Duration(sample.at_ns)) + Duration(std::llround(lead_s * 1e9));
      const Real said = coordinate(axis, predictor.predict(then)), expected = reference.ahead(Real(lead_s));
      const double scale =
          1.0 + static_cast<double>(std::abs(expected)) + fastest * (lead_s + reference.memory_s());
      ahead.add(static_cast<double>(std::abs(difference(axis, expected, said))) / scale, step_s, constant_s);
    }
  }
}

struct Hold {
  Real pose = 0;

  void start(Real now) { pose = now; }
  void step(Real, Real now) { pose = now; }
  [[nodiscard]] Real velocity() const { return 0; }
  [[nodiscard]] Real ahead(Real) const { return pose; }
  [[nodiscard]] double memory_s() const { return 0; }
};

constexpr double kNoise = 3e-4;

KalmanTuning tuning_of(double fade_s) {
  return {.angular_fade_s = glm::dvec3(fade_s),
          .linear_fade_s = glm::dvec3(fade_s),
          .angular_drive = 1,
          .linear_drive = 0.1,
          .angular_noise = kNoise,
          .linear_noise = kNoise};
}

KalmanReference::Tuning reference_tuning(Axis axis, double fade_s) {
  const double drive = axis == Axis::Linear ? 0.1 : 1.0;
  return {
      .fade_s = fade_s, .drive = drive, .noise = kNoise, .unseen_vv = std::min(0.5 * drive * fade_s, 1.0)};
}

struct Kalman {
  Axis axis;
  KalmanReference filter;
  Real pose = 0;

  void start(Real now) { pose = now; }
  void step(Real step_s, Real now) {
    pose += filter.travel_s(step_s) * filter.velocity();
    filter.step(step_s, difference(axis, pose, now));
    pose += filter.corrected();
  }
  [[nodiscard]] Real velocity() const { return filter.velocity(); }
  [[nodiscard]] Real ahead(Real lead_s) { return pose + filter.travel_s(lead_s) * filter.velocity(); }
  [[nodiscard]] double memory_s() const { return 0; }
};

// Multiples of the rounding error (2e-16). The estimate of the Kalman filter is a pose: 300 m from the origin
// it is rounded by 3e-14 m, and its velocity by up to 150 times that per second.
constexpr Bounds kHeld[] = {{0, 0}, {0, 0}}, kEstimated[] = {{2e-11, 2e-13}, {2e-13, 4e-14}};

/// Both errors of a filter for both motions. `filter(constant)` and `reference(axis, constant)` make the two
/// sides.
std::vector<GridError> errors_of(const std::string& name, const Bounds (&bounds)[2], const Grid& grid,
                                 const auto& filter, const auto& reference) {
  std::vector<GridError> all;
  for (const Axis axis : kAxes) {
    const Bounds& allowed = bounds[axis == Axis::Linear ? 0 : 1];
    GridError velocity{name, name_of(axis) + " velocity", allowed.velocity};
    GridError ahead{name, name_of(axis) + " pose ahead", allowed.ahead};
    for (const double constant_s : grid.constants_s)
      for (const double step_s : grid.steps_s)
        compare(filter(constant_s), reference(axis, constant_s), axis, step_s, constant_s, velocity, ahead);
    all.insert(all.end(), {velocity, ahead});
  }
  return all;
}

GridError covariance_errors(const Grid& grid) {
  GridError all{"kalman", "covariance", 4e-14};
  for (const double constant_s : grid.constants_s)
    for (const double step_s : grid.steps_s) {
      KalmanReference expected(reference_tuning(Axis::Angular, constant_s));
      KalmanFilter filter(tuning_of(constant_s));
      filter.start({});
      for (const Sample& sample : motion(Axis::Angular, step_s)) {
        filter.step(sample.step_s, sample.pose);
        expected.step(Real(sample.step_s), 0);
        const Covariance c = expanded(filter.angular_covariance()[1]);
        for (const double error :
             {relative(c.pp, expected.pp()), relative(c.pv, expected.pv()), relative(c.vv, expected.vv())})
          all.add(error, step_s, constant_s);
      }
    }
  return all;
}

}  // namespace

void GridError::add(double error, double at_step_s, double at_constant_s) {
  if (error <= largest || std::isnan(largest)) return;  // a NaN is kept
  largest = error, step_s = at_step_s, constant_s = at_constant_s;
}

Grid whole_grid(int parts) {
  return {.steps_s = decades(-4, 0, parts), .constants_s = decades(-5, 3, parts)};
}

std::vector<GridError> step_errors(const Grid& grid) {
  GridError keep{"one damped step", "what is kept", 1e-15}, travel{"one damped step", "travel", 1e-15};
  GridError noise{"one damped step", "noise covariance", 4e-15};
  for (const double constant_s : grid.constants_s)
    for (const double step_s : grid.steps_s) {
      const DampedReference expected = damped_reference(step_s, constant_s);
      const DampedStep step = damped_step(step_s, constant_s);
      keep.add(static_cast<double>(std::abs(step.keep - expected.keep)), step_s, constant_s);
      travel.add(relative(step.travel_s, expected.travel_s), step_s, constant_s);
      for (const double error :
           {relative(step.pp, expected.pp), relative(step.pv, expected.pv), relative(step.vv, expected.vv)})
        noise.add(error, step_s, constant_s);
    }
  return {keep, travel, noise};
}

std::vector<GridError> hold_errors(const Grid& grid) {
  const auto filter = [](double) { return HoldFilter(); };
  return errors_of("hold", kHeld, {.steps_s = grid.steps_s, .constants_s = {0}}, filter,
                   [](Axis, double) { return Hold{}; });
}

std::vector<GridError> kalman_errors(const Grid& grid) {
  std::vector<GridError> all = errors_of(
      "kalman", kEstimated, grid, [](double fade_s) { return KalmanFilter(tuning_of(fade_s)); },
      [](Axis axis, double fade_s) {
        return Kalman{axis, KalmanReference(reference_tuning(axis, fade_s))};
      });
  all.push_back(covariance_errors(grid));
  return all;
}

std::vector<GridError> all_stiff_errors() {
  std::vector<GridError> all = step_errors(whole_grid(16));
  for (const auto& errors : {hold_errors, kalman_errors}) {
    const std::vector<GridError> some = errors(whole_grid(4));
    all.insert(all.end(), some.begin(), some.end());
  }
  return all;
}

}  // namespace farshade::stiff
