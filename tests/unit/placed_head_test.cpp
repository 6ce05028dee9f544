/// Where --place and --stand put a recorded head.
#include "vr_client/placed_head.h"

#include <gtest/gtest.h>
#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>

#include <sstream>

#include "stereo/placement/head_test.h"
#include "tests/oracle/scene_builder.h"

namespace farshade {
namespace {

/// Steps of 0.2 m to the right, in half a second each.
HeadRecording walk() {
  HeadRecording recording;
  recording.fov.fill({-0.8, 0.8, 0.8, -0.8});
  for (int i = 0; i < 5; ++i)
    recording.samples.push_back({time_from_ns(i * 500'000'000LL), {{1, 0, 0, 0}, {0.2 * i, 1.6, 0}}});
  return recording;
}

/// A hall with a block in it. The camera is in the block, or beside it.
Scene hall(bool in_block, std::optional<glm::dvec3> lamp = {}) {
  SceneBuilder builder;
  if (lamp) builder.point_light(*lamp);
  builder.add(quad({0, 0, 0}, {0, 0, 6}, {6, 0, 0}));
  for (const float side : {-1.0f, 1.0f}) {
    builder.add(quad({0, 2, 6 * side}, {6, 0, 0}, {0, 2, 0}));
    builder.add(quad({6 * side, 2, 0}, {0, 0, 6}, {0, 2, 0}));
  }
  Material solid;
  builder.add(box({0, 1.5, 0}, {0.4, 1.5, 0.4}), builder.material(solid));
  Scene scene = builder.build();
  scene.camera = look({0, 1.6, in_block ? 0.0 : 2.0}, {0, 1.6, -4}, 8).stage_from_eye;
  return scene;
}

/// A thing of 1 cm, or of another size. Without a camera.
Scene thing(float half = 0.005f, const glm::dvec3& at = {}) {
  SceneBuilder builder(at);
  builder.add(box({0, 0, 0}, {half, half, half}));
  return builder.build();
}

HeadTest test_of(const Scene& scene, const PlacedHead& placed) {
  return test_head(Surroundings::create(scene).value(), placed.recording, placed.stage_from_recorded,
                   {.until = placed.recording.end() - placed.recording.start()});
}

Options with(Place place) {
  Options options;
  options.place = place;
  return options;
}

PlacedHead placed(const Scene& scene, const Options& options) {
  Expected<PlacedHead> head = place_head(options, scene, walk());
  if (!head) throw std::runtime_error(head.error().what);
  return *std::move(head);
}

glm::dvec3 start_of(const PlacedHead& head) {
  return (head.stage_from_recorded * head.recording.samples.front().recorded_from_head).translation;
}

TEST(PlacedHead, FitsByItselfWhereTheCameraIsInsideOfSomething) {
  const Scene scene = hall(true);
  const PlacedHead automatic = placed(scene, with(Place::Auto)), fit = placed(scene, with(Place::Fit));
  EXPECT_FALSE(test_of(scene, automatic).is_bad());
  EXPECT_EQ(start_of(automatic), start_of(fit));
  EXPECT_GT(glm::length(start_of(automatic) - scene.camera->translation), 0.4);
}

TEST(PlacedHead, IsAtTheCameraIfThatIsGoodOrIfTheUserSaysSo) {
  for (const bool in_block : {false, true}) {
    const Scene scene = hall(in_block);
    const PlacedHead head = placed(scene, with(in_block ? Place::Camera : Place::Auto));
    EXPECT_LT(glm::length(start_of(head) - scene.camera->translation), 1e-9) << in_block;
    EXPECT_EQ(test_of(scene, head).is_bad(), in_block);
    EXPECT_EQ(head.test.inside, test_of(scene, head).inside);
    EXPECT_EQ(head.test.inside > 20, in_block) << "the walk begins in the block and leaves it";
  }
  Options stands = with(Place::Auto);
  stands.start_pose = StartPose{.at = {{0, 1.6, 0}}, .heading_rad = std::nullopt};
  EXPECT_LT(glm::length(start_of(placed(hall(false), stands)) - glm::dvec3(0, 1.6, 0)), 1e-9)
      << "a place that the user names is kept";
}

/// What is logged while a viewer without a recording starts in the scene.
std::string said_at_start(const Options& options, const Scene& scene) {
  std::ostringstream said;
  const std::shared_ptr<spdlog::logger> before = spdlog::default_logger();
  spdlog::set_default_logger(
      std::make_shared<spdlog::logger>("test", std::make_shared<spdlog::sinks::ostream_sink_mt>(said)));
  judge_start_meanwhile(options, scene).wait();
  spdlog::set_default_logger(before);
  return said.str();
}

TEST(PlacedHead, TheStartOfAViewerWithoutARecordingIsLookedAtToo) {
  const Scene lit = hall(false, glm::dvec3(0, 3, 3));
  Options dark;
  dark.lighting.exposure = 1e-9f;
  const Scene darkened = light_scene(lit, dark.lighting).value().scene;
  const std::string said_of_dark = said_at_start(dark, darkened), said_of_lit = said_at_start({}, lit);
  EXPECT_NE(said_of_dark.find("is black"), std::string::npos) << said_of_dark;
  EXPECT_EQ(said_of_lit.find("black"), std::string::npos) << said_of_lit;
}

/// At full size, the walk of 0.8 m leads away from it at once.
TEST(PlacedHead, KeepsASmallThingInViewOfBothEyes) {
  const Scene scene = thing();
  for (const Place place : {Place::Auto, Place::Fit}) {
    const PlacedHead head = placed(scene, with(place));
    const HeadTest test = test_of(scene, head);
    EXPECT_EQ(test.see_nothing + test.inside, 0u) << in_words(test);
    const auto walked = head.recording.samples.back().recorded_from_head.translation -
                        head.recording.samples.front().recorded_from_head.translation;
    EXPECT_GT(glm::length(walked), 0.02) << "it is scaled no further than needed";
    for (const Side side : kSides) {
      const Rigid<Stage, Eye> eye = head.stage_from_recorded * head.recording.samples[0].recorded_from_head *
                                    head_from_eye(side, head.recording.eye_distance_m);
      const glm::dvec3 seen = inverse(eye)(Point<Stage>{}).v;
      EXPECT_LT(std::abs(seen.x / seen.z), std::tan(0.4)) << "near the middle of the picture";
      EXPECT_LT(seen.z, 0);
    }
  }
}

TEST(PlacedHead, SeesATinyThingAnywhere) {
  for (const glm::dvec3& at : {glm::dvec3(0.0), glm::dvec3(100, -40, 7)})
    for (const float half : {0.0005f, 0.025f}) {
      const Scene scene = thing(half, at);
      const HeadTest test = test_of(scene, placed(scene, with(Place::Auto)));
      EXPECT_EQ(test.see_nothing + test.inside, 0u) << half << ": " << in_words(test);
    }
}

TEST(PlacedHead, LeavesACameraThatSeesNothing) {
  Scene scene = thing();
  for (const bool away : {true, false}) {
    scene.camera = look({0, 0, 5}, {0, 0, away ? 9 : 0}, 8).stage_from_eye;
    const HeadTest test = test_of(scene, placed(scene, with(Place::Auto)));
    EXPECT_EQ(test.see_nothing + test.inside, 0u) << in_words(test);
    EXPECT_GT(test_of(scene, placed(scene, with(Place::Camera))).see_nothing, 0u);
  }
}

/// What is said where the head is placed.
std::string said_of(const Scene& scene, const Options& options) {
  std::ostringstream said;
  const auto before = spdlog::default_logger();
  spdlog::set_default_logger(
      std::make_shared<spdlog::logger>("test", std::make_shared<spdlog::sinks::ostream_sink_mt>(said)));
  placed(scene, options);
  spdlog::set_default_logger(before);
  return said.str();
}

TEST(PlacedHead, NamesACureThatHelps) {
  const Scene scene = thing();
  EXPECT_NE(said_of(scene, with(Place::Camera)).find("; the cure is --place fit\n"), std::string::npos);
  Options away = with(Place::Auto);
  away.start_pose = StartPose{.at = {{0, 3, 40}}, .heading_rad = 0.0};
  EXPECT_NE(said_of(scene, away).find("; the cure is --place fit without --stand"), std::string::npos);
  EXPECT_NE(said_of(thing(5e-6f), with(Place::Auto)).find("too little to look at: make it larger"),
            std::string::npos);
}

}  // namespace
}  // namespace farshade
