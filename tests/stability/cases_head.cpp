/// Extreme heads: speed, turns between masks, faults of recordings, prediction far ahead.
#include <cmath>
#include <numbers>

#include "stereo/math/rotation.h"
#include "tests/stability/cases.h"

namespace farshade::stability {
namespace {

constexpr std::uint32_t kFrames = 30;

/// A head that turns on the spot and looks at the geometry in the compared frame.
Setting turning(double degrees_s, std::uint32_t frames = kFrames) {
  Setting setting = ordinary();
  setting.frames = frames;
  setting.head = recorded(
      {.turn_degrees_s = degrees_s, .drift_m_s = {0.05, 0, 0}, .faces_at_s = last_shown_s(frames)}, 2);
  return setting;
}

Setting late(double delay_ms, double degrees_s) {
  Setting setting = turning(degrees_s, kFrames + static_cast<std::uint32_t>(delay_ms * 1e-3 * 72));
  setting.delay_ms = delay_ms;
  return setting;
}

/// Looks in one direction for a second of samples, and in the other direction afterwards.
Setting flips() {
  Setting setting = turning(0);
  const glm::dquat back = rotation_exp({0, std::numbers::pi, 0});
  for (std::size_t i = 70; i < setting.head.samples.size(); ++i) {
    glm::dquat& q = setting.head.samples[i].recorded_from_head.rotation;
    q = back * q;
  }
  return setting;
}

Setting jumps() {
  Setting setting = turning(20);
  for (std::size_t i = 70; i < setting.head.samples.size(); ++i)
    setting.head.samples[i].recorded_from_head.translation += glm::dvec3(-0.8, 0.3, -0.7);
  return setting;
}

/// `fault` may change the rows of a head that turns by 60 degrees a second.
Setting faulty(const std::function<void(std::vector<HeadSample>&)>& fault) {
  Setting setting = turning(60);
  fault(setting.head.samples);
  return setting;
}

void leave_gap(std::vector<HeadSample>& rows) {
  rows.erase(rows.begin() + 20, rows.begin() + 80);
}

void repeat_stamps(std::vector<HeadSample>& rows) {
  for (std::size_t i = 5; i + 1 < rows.size(); i += 7) rows[i + 1].time = rows[i].time;
}

void step_back(std::vector<HeadSample>& rows) {
  for (std::size_t i = 10; i < rows.size(); i += 25) rows[i].time -= std::chrono::milliseconds(40);
}

void run_ahead_once(std::vector<HeadSample>& rows) {
  rows[30].time += std::chrono::hours(1);
}

void lose_tracking(std::vector<HeadSample>& rows) {
  for (std::size_t i = 10; i < rows.size(); i += 25)
    rows[i].recorded_from_head = {glm::dquat(0, 0, 0, 0), glm::dvec3(i % 2 == 0 ? 0.0 : NAN)};
}

void off_unit(std::vector<HeadSample>& rows) {
  for (std::size_t i = 0; i < rows.size(); ++i) {
    glm::dquat& q = rows[i].recorded_from_head.rotation;
    q = q * (i % 2 == 0 ? 1 + 1e-3 : 1 - 1e-3);
  }
}

void other_sign(std::vector<HeadSample>& rows) {
  for (std::size_t i = 0; i < rows.size(); i += 2) {
    glm::dquat& q = rows[i].recorded_from_head.rotation;
    q = -q;
  }
}

void burst(std::vector<HeadSample>& rows) {
  // Ten rows within 10 ns, like stamps of a buffer that was read late.
  for (std::size_t i = 40; i < 50; ++i)
    rows[i].time = rows[40].time + Duration(static_cast<std::int64_t>(i) - 40);
}

Case head(const char* name, const char* extreme, std::function<Setting()> make,
          HeadBound bound = HeadBound::NoWorseThanHeld) {
  return {.name = name, .extreme = extreme, .make = std::move(make), .head = bound};
}

}  // namespace

std::vector<Case> head_cases() {
  const auto fault = [](const char* name, const char* extreme, void (*how)(std::vector<HeadSample>&)) {
    return head(name, extreme, [how] { return faulty(how); });
  };
  return {
      head("head-still", "a head that does not move", [] { return turning(0); }),
      head("head-300-deg-s", "300 degrees/s", [] { return turning(300); }),
      head("head-1000-deg-s", "1,000 degrees/s", [] { return turning(1000); }),
      head("head-flips-180", "180 degrees from one sample to the next", flips),
      head("head-jumps-1m", "put elsewhere from one sample to the next", jumps),
      head("prediction-100ms", "masks 100 ms late at 200 degrees/s", [] { return late(100, 200); }),
      head("prediction-500ms", "masks 500 ms late at 100 degrees/s", [] { return late(500, 100); }),
      fault("trace-gap-300ms", "300 ms without a sample", leave_gap),
      fault("trace-repeated", "every seventh stamp is the one before", repeat_stamps),
      fault("trace-backward", "every 25th stamp 40 ms back", step_back),
      fault("trace-one-stamp-ahead", "one stamp an hour ahead of the rest", run_ahead_once),
      fault("trace-lost", "every 25th row zeros or NaN, as without tracking", lose_tracking),
      fault("trace-off-unit-1e-3", "quaternions off unit by 1e-3", off_unit),
      fault("trace-sign-flips", "every other quaternion negated", other_sign),
      head(
          "trace-burst", "ten samples within 10 ns", [] { return faulty(burst); }, HeadBound::TwiceHeld),
  };
}

}  // namespace farshade::stability
