/// What the reader assumes where a file states nothing, and how it tells that a recording is read wrongly.
#include <gtest/gtest.h>

#include <numbers>

#include "stereo/head/reader.h"
#include "stereo/head/writer.h"
#include "tests/unit/head/worn_head.h"

namespace farshade {
namespace {

bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

HeadRecording read(const std::string& text, const HeadFileOptions& options = {}) {
  const auto recording = parse_head_recording(text, "t.csv", options);
  EXPECT_TRUE(recording) << recording.error().what;
  return recording.value_or(HeadRecording{});
}

double worst_turn_rad(const HeadRecording& recording) {
  double worst = 0;
  for (int i = 0; i < kWornSamples; ++i)
    worst = std::max(worst, angle_between_rad(
                                recording.samples.at(static_cast<std::size_t>(i)).recorded_from_head.rotation,
                                worn_head(i).rotation));
  return worst;
}

TEST(HeadStamps, HaveTheUnitOfAPlausibleRate) {
  struct Case {
    double first, step;
    const char* unit;
  };
  for (const auto& [first, step, unit] :
       {Case{1.7e9, 1 / 72.0, "s"}, Case{1.7e12, 14, "ms"}, Case{1.7e15, 13'889, "us"},
        Case{1.7e18, 13'888'888, "ns"}, Case{0, 13'888'888, "ns"}, Case{0, 13'889, "us"},
        Case{1.7e15, 200'000, "us"}, Case{1.7e12, 500, "ms"}}) {
    const HeadRecording recording = read(text_of({.first = first, .step = step}));
    EXPECT_TRUE(has(recording.read_as, std::string("time stamps in ") + unit + " (assumed)"))
        << recording.read_as;
  }
}

TEST(HeadStamps, AreRefusedBeyond1To10000Hz) {
  const std::string stated = "#timestamp [ns],x,y,z,qw,qx,qy,qz\n" + text_of({});
  const auto refused = parse_head_recording(stated, "t.csv");
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().fault, Fault::OutOfRange);
  EXPECT_TRUE(has(refused.error().what, "--trace-units s would fit")) << refused.error().what;
  EXPECT_TRUE(has(read(stated, {.unit = TimeUnit::Seconds}).read_as, "time stamps in s (given)"));
  EXPECT_FALSE(parse_head_recording(text_of({.step = 5}), "t.csv", {.unit = TimeUnit::Seconds}));
  EXPECT_FALSE(
      parse_head_recording(text_of({.first = 0, .step = 99'000}), "t.csv", {.unit = TimeUnit::Nanoseconds}));
}

TEST(HeadUnits, AreDoubtedIfStampsAreFrameNumbersOrPositionsMillimetres) {
  EXPECT_TRUE(has(read(text_of({.first = 0, .step = 1})).doubt, "frame numbers"));
  Axes millimetres;
  millimetres.units_a_metre = 1000;
  const std::string text = text_of({.axes = millimetres});
  EXPECT_TRUE(has(read(text).doubt, "--trace-scale")) << read(text).doubt;
  EXPECT_EQ(read(text, {.units_a_metre = 1000}).doubt, "");
}

TEST(HeadAxes, BecomeThoseOfTheStage) {
  for (const std::string_view name : kTriedAxes) {
    SCOPED_TRACE(name);
    const Axes axes = parse_axes(name).value();
    const HeadRecording recording = read(text_of({.axes = axes}), {.axes = axes});
    EXPECT_LT(worst_turn_rad(recording), 1e-5);
    EXPECT_LT(glm::length(recording.samples.back().recorded_from_head.translation -
                          worn_head(kWornSamples - 1).translation),
              1e-5);
    EXPECT_EQ(recording.doubt, "");
  }
}

TEST(HeadAxes, AreThoseOfTheirSources) {
  const auto ahead = [](const char* name) {
    return parse_axes(name).value().stage_from_world * glm::dvec3(1, 2, 3);
  };
  EXPECT_EQ(ahead("ros"), glm::dvec3(-2, 3, -1));
  EXPECT_EQ(ahead("optical"), glm::dvec3(1, -2, -3));
  EXPECT_EQ(ahead("euroc-imu"), ahead("ros"));
  EXPECT_EQ(ahead("unity"), glm::dvec3(1, 2, -3));
  EXPECT_EQ(ahead("unreal"), glm::dvec3(2, 3, -1));
  EXPECT_EQ(ahead("ned"), glm::dvec3(2, -3, -1));
  EXPECT_EQ(parse_axes("euroc-imu")->head_from_body * glm::dvec3(1, 2, 3), glm::dvec3(2, 1, -3));
  EXPECT_FALSE(parse_axes("unity/ros"));
  EXPECT_FALSE(parse_axes("zup"));
  EXPECT_FALSE(parse_axes("ros/"));
}

TEST(HeadGravity, WarnsAndNamesAxesThatFit) {
  const std::string lies = "the heads are not upright on average: --trace-axes ",
                    aside = "the head walks steadily, but not where it looks: --trace-axes ";
  for (const auto& [name, doubt] :
       {std::pair{"ros", aside + "ros or unreal"}, std::pair{"optical", aside + "optical"},
        std::pair{"euroc-imu", lies + "euroc-imu"}, std::pair{"unity", aside + "unity"},
        std::pair{"ned", aside + "ned"}, std::pair{"ros/optical", lies + "ros/optical"}})
    EXPECT_EQ(read(text_of({.axes = parse_axes(name).value()})).doubt, doubt + " would fit") << name;
}

TEST(HeadGravity, WarnsOfAHeadThatWalksAsideWithoutTurning) {
  std::string text;
  for (int i = 0; i < 73; ++i) text += fmt::format("{:.6f} {:.6f} 0 1.6 0 0 0 1\n", i / 72.0, i / 72.0);
  EXPECT_TRUE(has(read(text).doubt, "--trace-axes ros")) << read(text).doubt;
  const HeadRecording ros = read(text, {.axes = parse_axes("ros").value()});
  EXPECT_EQ(ros.doubt, "");
  EXPECT_LT(glm::length(ros.samples.back().recorded_from_head.translation - glm::dvec3(0, 1.6, -1)), 1e-5);
}

TEST(HeadGravity, LevelsATiltedRecordingUnlessAxesAreKnown) {
  const double tilt = 0.3;
  HeadRecording tilted;
  for (int i = 0; i < 8 * kWornSamples; ++i) {  // looks around in all directions
    const Rigid<Recorded, Head> head{rotation_exp({0, 0.05 * i, 0}) * worn_head(i % kWornSamples).rotation,
                                     {1, 1.6, 2}};
    tilted.samples.push_back(
        {time_from_ns(13'888'888LL * i), Rigid<Recorded, Recorded>{rotation_exp({0, 0, tilt}), {}} * head});
  }
  tilted.fov = kDefaultFov;
  const std::string text = euroc_text(tilted);
  const HeadRecording stated = read(text);
  EXPECT_EQ(stated.samples.front().recorded_from_head, tilted.samples.front().recorded_from_head);
  const std::string unstated = text.substr(text.find("#timestamp"));
  const HeadRecording levelled = read(unstated), kept = read(unstated, {.axes = Axes{}});
  EXPECT_TRUE(has(levelled.doubt, "levelled by 1")) << levelled.doubt;
  EXPECT_EQ(kept.doubt, "");
  EXPECT_EQ(kept.samples.front().recorded_from_head, tilted.samples.front().recorded_from_head);
  const auto& first = levelled.samples.front().recorded_from_head;
  EXPECT_LT(glm::length(first.translation - tilted.samples.front().recorded_from_head.translation), 1e-12);
  EXPECT_LT(
      angle_between_rad(rotation_exp({0, 0, -tilt}) * tilted.samples.front().recorded_from_head.rotation,
                        first.rotation),
      0.1 * tilt);
}

/// It turns a little about its own neck, which is not vertical.
TEST(HeadGravity, LeavesAHeadThatOnlyLooksDown) {
  for (const double swing_rad : {0.03, 0.1, 0.2, 0.3}) {
    std::string text;
    for (int i = 0; i < 100; ++i) {
      const glm::dquat q = rotation_exp({-0.4, 0, 0}) * rotation_exp({0, swing_rad * std::sin(i), 0});
      text += fmt::format("{:.6f} 0 1.6 0 {:.7f} {:.7f} {:.7f} {:.7f}\n", i / 72.0, q.x, q.y, q.z, q.w);
    }
    const HeadRecording recording = read(text);
    EXPECT_EQ(recording.doubt, "") << swing_rad;
    EXPECT_LT(
        angle_between_rad(recording.samples.front().recorded_from_head.rotation, rotation_exp({-0.4, 0, 0})),
        1e-6)
        << swing_rad;
  }
}

TEST(HeadQuaternion, TakesTheOrderInWhichHeadsAreUpright) {
  for (const bool scalar_first : {true, false})
    for (const char separator : {',', ' '}) {
      const HeadRecording recording = read(text_of({.separator = separator, .scalar_first = scalar_first}));
      EXPECT_TRUE(has(recording.read_as, scalar_first ? "wxyz (assumed)" : "xyzw (assumed)"))
          << recording.read_as;
      EXPECT_LT(worst_turn_rad(recording), 1e-5);
    }
  EXPECT_LT(worst_turn_rad(read(text_of({.scalar_first = false}), {.order = QuaternionOrder::Xyzw})), 1e-5);
  const HeadRecording wrong = read(text_of({.scalar_first = false}), {.order = QuaternionOrder::Wxyz});
  EXPECT_TRUE(has(wrong.doubt, "not upright")) << wrong.doubt;
}

TEST(HeadQuaternion, TakesTheOrderInWhichHeadsAreUprightInGivenAxes) {
  for (const char* name : {"ros", "optical", "unity"}) {
    SCOPED_TRACE(name);
    const Axes axes = parse_axes(name).value();
    const HeadRecording recording = read(text_of({.scalar_first = false, .axes = axes}), {.axes = axes});
    EXPECT_TRUE(has(recording.read_as, "xyzw (assumed)")) << recording.read_as;
    EXPECT_EQ(recording.doubt, "");
    EXPECT_LT(worst_turn_rad(recording), 1e-5);
  }
}

TEST(HeadRows, AreCountedWhenTheyAreBad) {
  std::string text = text_of({.separator = ' ', .scalar_first = false});
  const std::string lost =
      "1700000000.5 NaN NaN NaN NaN NaN NaN NaN\n1700000000.6 0 0 0 0 0 0 0\n1700000000.0 0 0 0 0 0 0 1\n";
  text.insert(text.find('\n', text.size() / 2) + 1, lost);
  text.erase(text.size() - 20);
  const HeadRecording recording = read(text);
  EXPECT_EQ(recording.bad_rows, 3u);
  EXPECT_EQ(recording.rows_left_out, 1u);
  EXPECT_EQ(recording.samples.size(), kWornSamples - 1u);
  EXPECT_TRUE(has(recording.doubt, "left out 4 of 147 rows (2.7 %): 3 without a pose (the first is t.csv:"))
      << recording.doubt;
}

TEST(HeadRows, AreRefusedIfMostAreBad) {
  std::string text;
  for (int i = 0; i < 20; ++i)
    text += std::to_string(14'000'000 * i) + (i % 5 < 2 ? ",0,0,0,1,0,0,0\n" : ",0,0,0,9,9,9,9\n");
  const auto refused = parse_head_recording(text, "t.csv");
  ASSERT_FALSE(refused);
  EXPECT_TRUE(has(refused.error().what, "12 of 20 rows hold no pose, the first is t.csv:3: quaternion"))
      << refused.error().what;
}

}  // namespace
}  // namespace farshade
