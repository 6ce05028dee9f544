#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>

#include "stereo/head/reader.h"
#include "stereo/math/rotation.h"

namespace farshade {
namespace {

const std::string kEuroc =
    "#timestamp [ns],p_RS_R_x [m],p_RS_R_y [m],p_RS_R_z [m],q_RS_w [],q_RS_x [],q_RS_y [],q_RS_z []\n"
    "1403636579763555584,1,2,3,1,0,0,0\n"
    "1403636579768555520,1.5,2,3,0.8,0.6,0,0,9,9,9\r\n"
    "\n"
    "1403636579773555456,-1e-3,2,3,0.8,0,0.6,0\n";

const std::string kEyeNavGs =
    "ViewIndex,FOV1,FOV2,FOV3,FOV4,PositionX,PositionY,PositionZ,QuaternionX,QuaternionY,QuaternionZ,"
    "QuaternionW,GazePosX,GazePosY,GazePosZ,GazeQX,GazeQY,GazeQZ,GazeQW,Timestamp\n"
    "0,-0.942,0.698,-0.942,0.733,-0.03,1,2,0,0,0,1,0,0,0,0,0,0,1,0\n"
    "1,-0.698,0.942,-0.942,0.733,0.03,1,2,0,0,0,1,0,0,0,0,0,0,1,6\n"
    "0,-0.942,0.698,-0.942,0.733,1,1,2.03,0,0.707,0,0.707,0,0,0,0,0,0,1,14\n"
    "1,-0.698,0.942,-0.942,0.733,1,1,1.97,0,0.707,0,0.707,0,0,0,0,0,0,1,20\n"
    "0,-0.942,0.698,-0.942,0.733,-0.03,1,2,0,0,0,-1,0,0,0,0,0,0,1,28.5\n"
    "1,-0.698,0.942,-0.942,0.733,0.03,1,2,0,0,0,-1,0,0,0,0,0,0,1,34\n";

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  const std::size_t at = text.find(what);
  EXPECT_NE(at, text.npos) << what;
  return text.replace(at, what.size(), by);
}

HeadRecording good(const std::string& text, std::optional<double> units_a_metre = {},
                   const std::string& name = "t.csv") {
  const auto recording = parse_head_recording(text, name, {.units_a_metre = units_a_metre});
  EXPECT_TRUE(recording) << (recording ? "" : recording.error().what);
  return recording.value_or(HeadRecording{});
}

/// Returns the sentence of the refusal. Expects that it contains `named`.
void expect_refused(const std::string& text, Fault fault, const std::string& named,
                    std::optional<double> units_a_metre = {}) {
  const auto recording = parse_head_recording(text, "t.csv", {.units_a_metre = units_a_metre});
  ASSERT_FALSE(recording) << named;
  EXPECT_EQ(recording.error().fault, fault) << recording.error().what;
  EXPECT_NE(recording.error().what.find(named), std::string::npos) << recording.error().what;
}

TEST(EurocRead, KeepsNanosecondsAndQuaternionOrder) {
  const HeadRecording recording = good(kEuroc);
  ASSERT_EQ(recording.samples.size(), 3u);
  EXPECT_EQ(ns_of(recording.samples[0].time), 1403636579763555584);
  EXPECT_EQ(recording.samples[1].recorded_from_head.translation, glm::dvec3(1.5, 2, 3));
  EXPECT_EQ(recording.samples[1].recorded_from_head.rotation, glm::dquat(0.8, 0.6, 0, 0));  // w first
  EXPECT_EQ(recording.fov, kDefaultFov);
  EXPECT_EQ(recording.eye_distance_m, kDefaultEyeDistance_m);
}

TEST(EurocRead, TakesHeadsetFromItsHeader) {
  const HeadRecording recording = good(
      "# axes: +x right, +y up, -z ahead, right-handed\n# units: m, ns\n"
      "# eye distance [m]: 0.07\n"
      "# fov right eye [rad] left right up down: -0.5 0.75 0.6 -0.8\n# who: me\n" +
      kEuroc);
  EXPECT_EQ(recording.eye_distance_m, 0.07);
  EXPECT_EQ(recording.fov[1], (EyeFov{.left_rad = -0.5, .right_rad = 0.75, .up_rad = 0.6, .down_rad = -0.8}));
  EXPECT_EQ(recording.fov[0], kDefaultFov[0]);
}

TEST(EurocRead, RefusesForeignAxesUnitsAndColumns) {
  expect_refused("# axes: z up\n" + kEuroc, Fault::Unsupported, "t.csv:1: axes should be +x right");
  expect_refused("# units: mm, us\n" + kEuroc, Fault::Unsupported, "t.csv:1: units should be m, ns");
  expect_refused(replaced(kEuroc, "q_RS_w [],q_RS_x []", "q_RS_x [],q_RS_w []"), Fault::Unsupported,
                 "t.csv:1");
  expect_refused("# fov left eye [rad] left right up down: 1 2\n" + kEuroc, Fault::Malformed, "t.csv:1: fov");
  expect_refused("# fov left eye [rad] left right up down: 1 -1 1 -1\n" + kEuroc, Fault::OutOfRange,
                 "left eye");
  expect_refused("# eye distance [m]: 63\n" + kEuroc, Fault::OutOfRange, "eye distance");
}

TEST(TumRead, HasSecondsAndTheScalarLast) {
  const HeadRecording recording = good(
      "# timestamp tx ty tz qx qy qz qw\n1403636579.763555584 1 2 3 0.6 0 0 0.8\n"
      "1403636579.7685555204 1  2\t3 0 0 0 1\n1.403636580e9 1 2 3 0 0 0 1\n");
  EXPECT_EQ(ns_of(recording.samples[0].time), 1403636579763555584);
  EXPECT_EQ(ns_of(recording.samples[1].time), 1403636579768555520);
  EXPECT_EQ(ns_of(recording.samples[2].time), 1403636580000000000);
  EXPECT_EQ(recording.samples[0].recorded_from_head.rotation, glm::dquat(0.8, 0.6, 0, 0));
}

TEST(TumRead, HandlesTimeBeforeZeroAndItsLimits) {
  const HeadRecording recording =
      good("-0.5 0 0 0 0 0 0 1\n-0.0000000015 0 0 0 0 0 0 1\n0.7 0 0 0 0 0 0 1\n");
  EXPECT_EQ(ns_of(recording.samples[0].time), -500'000'000);
  EXPECT_EQ(ns_of(recording.samples[1].time), -2);
  EXPECT_EQ(ns_of(recording.samples[2].time), 700'000'000);
  expect_refused("4611686018427387905 0 0 0 0 0 0 1\n", Fault::OutOfRange, "t.csv:1");
  expect_refused("1e300 0 0 0 0 0 0 1\n", Fault::OutOfRange, "t.csv:1");
  expect_refused("4611686018427387904.5,0,0,0,1,0,0,0\n", Fault::OutOfRange, "t.csv:1");
}

TEST(EyeNavGsRead, PutsTheHeadBetweenItsEyes) {
  const HeadRecording recording = good(kEyeNavGs, 0.5);
  ASSERT_EQ(recording.samples.size(), 3u);
  EXPECT_NEAR(recording.eye_distance_m, 0.12, 1e-12);
  EXPECT_LT(glm::length(recording.samples[0].recorded_from_head.translation - glm::dvec3(0, 2, 4)), 1e-12);
  EXPECT_EQ(ns_of(recording.samples[2].time), 28'500'000);
  EXPECT_EQ(recording.fov[0],
            (EyeFov{.left_rad = -0.942, .right_rad = 0.698, .up_rad = 0.733, .down_rad = -0.942}));
  EXPECT_EQ(recording.fov[1],
            (EyeFov{.left_rad = -0.698, .right_rad = 0.942, .up_rad = 0.733, .down_rad = -0.942}));
  // Quaternions with three decimals are off unit by 2e-4 and are normalised. A quarter turn to the left looks
  // along -x.
  const glm::dquat& turned = recording.samples[1].recorded_from_head.rotation;
  EXPECT_NEAR(glm::length(turned), 1.0, 1e-15);
  EXPECT_LT(glm::length(turned * glm::dvec3(0, 0, -1) - glm::dvec3(-1, 0, 0)), 1e-12);
}

TEST(EyeNavGsRead, KnowsScalesByNameOnly) {
  EXPECT_NEAR(good(kEyeNavGs, {}, "eyenavgs_truck_x.csv").eye_distance_m, 0.06 / 0.76, 1e-12);
  EXPECT_NEAR(good(kEyeNavGs, {}, "eyenavgs_room_x.csv").eye_distance_m, 0.03, 1e-12);
  expect_refused(kEyeNavGs, Fault::Unsupported, "give --trace-scale");
  expect_refused(kEyeNavGs, Fault::OutOfRange, "positive", -1.0);
}

TEST(EyeNavGsRead, LeavesOutALastRowWithoutItsPair) {
  const std::string more = kEyeNavGs + "0,-0.942,0.698,-0.942,0.733,0,1,2,0,0,0,1,0,0,0,0,0,0,1,40\n";
  EXPECT_EQ(good(more, 1.0).samples.size(), 3u);
}

TEST(EyeNavGsRead, CountsABadPairOnceAndSkipsComments) {
  const auto pair = [](const char* left, const char* right, int ms) {
    const std::string q = ",0,0,0,1,0,0,0,0,0,0,1,";
    return std::string(left) + ",-0.942,0.698,-0.942,0.733,-0.03,1,2" + q + std::to_string(ms) + "\n" +
           right + ",-0.698,0.942,-0.942,0.733,0.03,1,2" + q + std::to_string(ms + 6) + "\n";
  };
  const std::string all = "# who: me\n" + kEyeNavGs + "# a break\n" + pair("0", "1", 50);
  EXPECT_EQ(good(all, 1.0).samples.size(), 4u);
  EXPECT_EQ(good(all, 1.0).bad_rows, 0u);
  for (const std::string& bad :
       {pair("0,nan", "1", 40), pair("0", "1,nan", 40), pair("0,nan", "1,nan", 40), pair("nan", "1", 40),
        pair("0", "1", 40).substr(0, pair("0", "1", 40).find('\n') + 1)}) {
    SCOPED_TRACE(bad);
    const HeadRecording recording = good(replaced(all, "# a break\n", bad), 1.0);
    EXPECT_EQ(recording.samples.size(), 4u);
    EXPECT_EQ(recording.bad_rows, 1u);
  }
}

TEST(EyeNavGsRead, RefusesWhatIsNoPair) {
  constexpr double metres = 1.0;
  expect_refused(replaced(kEyeNavGs, "\n1,", "\n0,"), Fault::Malformed, "t.csv:3: left and right", metres);
  expect_refused(replaced(kEyeNavGs, "0,0.707,0,0.707", "0,0.7,0,0.714"), Fault::Malformed,
                 "t.csv:5: the pair", metres);
  expect_refused(replaced(kEyeNavGs, "1,34\n", "1,28\n"), Fault::Malformed, "t.csv:7: time stamp", metres);
  expect_refused(replaced(kEyeNavGs, "1,14\n", "1,-3\n"), Fault::Malformed, "holds 2 head samples", metres);
  expect_refused(replaced(kEyeNavGs, "-0.942,0.733", "0.942,0.733"), Fault::OutOfRange, "t.csv:2: fov",
                 metres);
  expect_refused(replaced(kEyeNavGs, "0,0,0,1,6\n", "0,0,0,1\n"), Fault::Malformed, "t.csv:3: row has 19",
                 metres);
  std::string mirrored = kEyeNavGs;
  for (const char* from : {"-0.03,1,2,0,0,0,1", "-0.03,1,2,0,0,0,-1"})
    mirrored = replaced(mirrored, from, std::string("0.09") + (from + 5));
  expect_refused(mirrored, Fault::Malformed, "right eye lies left", metres);
}

TEST(HeadRecordingRead, RefusesWhatIsNoFiniteNumber) {
  for (const char* bad : {"nan", "inf", "-inf", "1e999", "", "1,5x", "0x10", "+", "--1"})
    expect_refused(replaced(kEuroc, "1.5,", std::string(bad) + ","), Fault::Malformed, "t.csv:3: ");
  expect_refused(replaced(kEuroc, "1403636579768555520", "nan"), Fault::Malformed, "t.csv:3");
}

TEST(HeadRecordingRead, SaysThatASemicolonTableNeedsCommas) {
  const auto with_semicolons = [](std::string text) {
    std::ranges::replace(text, ',', ';');
    return text;
  };
  expect_refused(with_semicolons(kEuroc), Fault::Unsupported, "semicolons: separate them by commas");
  expect_refused(with_semicolons(kEyeNavGs), Fault::Unsupported, "t.csv:1: ");
  // Decimal commas, as spreadsheets write them in German or French.
  expect_refused("# t;x\n1;0,5;2;3;1;0;0;0\n", Fault::Unsupported, "t.csv:2: the columns are separated");
  good("# a comment; with a semicolon\n" + kEuroc);
}

TEST(HeadRecordingRead, RefusesQuaternionsThatAreFarOffUnit) {
  EXPECT_NEAR(
      glm::length(good(replaced(kEuroc, "0.8,0.6", "0.8,0.601")).samples[1].recorded_from_head.rotation), 1.0,
      1e-15);
  expect_refused(replaced(kEuroc, "0.8,0.6", "0.8,0.63"), Fault::Malformed, "t.csv:3: quaternion");
  expect_refused(replaced(kEuroc, "0.8,0.6", "0,0"), Fault::Malformed, "t.csv:3: quaternion");
}

TEST(HeadRecordingRead, LeavesOutRepeatedAndBackwardStampsAndCountsThem) {
  for (const char* stamp : {"1403636579768555520", "1403636579768555519", "1403636579000000000", "-5"}) {
    SCOPED_TRACE(stamp);
    const HeadRecording recording =
        good(replaced(kEuroc, "\n\n", std::string("\n") + stamp + ",7,7,7,1,0,0,0\n"));
    EXPECT_EQ(recording.rows_left_out, 1u);
    ASSERT_EQ(recording.samples.size(), 3u);
  }
  const HeadRecording repeated = good(replaced(kEuroc, "\n\n", "\n1403636579768555520,7,7,7,1,0,0,0\n"));
  EXPECT_EQ(repeated.samples[1].recorded_from_head.translation.x, 1.5);  // the first of the two rows is kept
}

TEST(HeadRecordingRead, LosesOneRowToOneStampThatRanAhead) {
  std::string text;
  for (int i = 0; i < 20; ++i)
    text += std::to_string(10'000'000LL * (i == 4 ? 3'600 : i)) + ",0,0,0,1,0,0,0\n";
  const HeadRecording recording = good(text);
  EXPECT_EQ(recording.rows_left_out, 1u);
  EXPECT_EQ(recording.samples.size(), 19u);
  EXPECT_EQ(ns_of(recording.end()), 190'000'000);
}

TEST(HeadRecordingRead, RefusesStampsThatRunBackwardAllTheWay) {
  expect_refused("9,0,0,0,1,0,0,0\n8,0,0,0,1,0,0,0\n7,0,0,0,1,0,0,0\n6,0,0,0,1,0,0,0\n", Fault::Malformed,
                 "holds 1 head samples in time order");
}

TEST(HeadRecordingRead, RefusesTooFewSamplesAndShortRows) {
  expect_refused("", Fault::Malformed, "holds 0 head samples");
  expect_refused("# just words\n", Fault::Malformed, "holds 0 head samples");
  expect_refused(kEuroc.substr(0, kEuroc.find("\n\n")), Fault::Malformed, "holds 2 head samples");
  expect_refused(replaced(kEuroc, ",1,0,0,0\n", ",1,0,0\n"), Fault::Malformed, "t.csv:2: row has 7 of 8");
  expect_refused(std::string(1000, '\0'), Fault::Malformed, "t.csv:1");
  expect_refused(replaced(kEuroc, "1.5,", "1e10,"), Fault::OutOfRange, "t.csv:3: head");
}

TEST(HeadRecordingRead, SurvivesEveryTruncation) {
  for (const std::string& text : {kEuroc, kEyeNavGs})
    for (std::size_t length = 0; length < text.size(); ++length) {
      const std::unique_ptr<char[]> cut(
          new char[length]);  // its own allocation, so that the sanitizer detects reads beyond the end
      text.copy(cut.get(), length);
      const auto recording = parse_head_recording({cut.get(), length}, "eyenavgs_room.csv");
      EXPECT_TRUE(!recording || recording->samples.size() >= kFewestSamples) << length;
    }
}

TEST(HeadRecordingRead, NamesAMissingFile) {
  const auto recording = load_head_recording("no/such/trace.csv");
  ASSERT_FALSE(recording);
  EXPECT_EQ(recording.error().fault, Fault::Missing);
}

}  // namespace
}  // namespace farshade
