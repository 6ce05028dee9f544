/// Recorded heads in boxes, rooms and landscapes: what they see there, and where they fit.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "stereo/math/rotation.h"
#include "stereo/placement/fit.h"
#include "stereo/placement/head_test.h"

namespace farshade {
namespace {

enum class Walls { Single, Double };
enum class Wound { Outwards, Inwards };  ///< the side that is seen, or the front of a double-sided wall

Scene empty_scene(Walls walls) {
  Scene scene;
  scene.name = "made.glb";
  scene.materials.emplace_back().double_sided = walls == Walls::Double;
  return scene;
}

void add_mesh(Scene& scene, Mesh mesh, const glm::dvec3& at) {
  mesh.normals.assign(mesh.positions.size(), glm::vec3(0, 1, 0));
  scene.triangle_count += mesh.triangles.size();
  scene.nodes.emplace_back().rest.translation = at;
  scene.instances.push_back(
      {static_cast<std::uint32_t>(scene.meshes.size()), static_cast<std::uint32_t>(scene.nodes.size() - 1)});
  scene.meshes.push_back(std::move(mesh));
}

void add_wound(Scene& scene, Mesh mesh, const glm::dvec3& at, Wound wound) {
  if (wound == Wound::Inwards)
    for (glm::uvec3& t : mesh.triangles) std::swap(t.y, t.z);
  add_mesh(scene, std::move(mesh), at);
}

void add_box(Scene& scene, const glm::dvec3& half, const glm::dvec3& at, Wound wound) {
  Mesh mesh;
  for (int i = 0; i < 8; ++i)
    mesh.positions.push_back(glm::vec3(half * glm::dvec3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1)));
  for (const glm::uvec4 side : {glm::uvec4(0, 4, 6, 2), glm::uvec4(1, 3, 7, 5), glm::uvec4(0, 1, 5, 4),
                                glm::uvec4(2, 6, 7, 3), glm::uvec4(0, 2, 3, 1), glm::uvec4(4, 5, 7, 6)}) {
    mesh.triangles.emplace_back(side.x, side.y, side.z);
    mesh.triangles.emplace_back(side.x, side.z, side.w);
  }
  add_wound(scene, std::move(mesh), at, wound);
}

/// A rectangle at height z. Wound::Outwards: it is seen from above.
void add_quad(Scene& scene, const glm::vec2& low, const glm::vec2& high, double z, Wound wound) {
  Mesh mesh;
  mesh.positions = {{low, 0}, {high.x, low.y, 0}, {high, 0}, {low.x, high.y, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  add_wound(scene, std::move(mesh), {0, 0, z}, wound);
}

Scene box_scene(const glm::dvec3& half, Walls walls, Wound wound) {
  Scene scene = empty_scene(walls);
  add_box(scene, half, {}, wound);
  return scene;
}

/// Ground at height 0, seen from above.
Scene landscape() {
  Scene scene = empty_scene(Walls::Single);
  Mesh mesh;
  mesh.positions = {{-500, 0, -500}, {-500, 0, 500}, {500, 0, 500}, {500, 0, -500}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  add_mesh(scene, std::move(mesh), {});
  return scene;
}

HeadRecording walk(const std::vector<glm::dvec3>& positions) {
  HeadRecording recording;
  recording.fov.fill({-0.8, 0.8, 0.8, -0.8});
  for (std::size_t i = 0; i < positions.size(); ++i)
    recording.samples.push_back({time_from_ns(static_cast<std::int64_t>(i) * 100'000'000),
                                 {.rotation = {1, 0, 0, 0}, .translation = positions[i]}});
  return recording;
}

PoseVerdict verdict(const Scene& scene, const glm::dvec3& at, double heading_rad = 0,
                    double eye_distance_m = 0.063) {
  HeadRecording recording = walk({{0, 0, 0}, {0, 0, 0}, {0, 0, 0}});
  recording.eye_distance_m = eye_distance_m;
  return judge(Surroundings::create(scene).value(), recording,
               {.rotation = rotation_exp({0, heading_rad, 0}), .translation = at});
}

TEST(HeadTest, TheInsideOfASolidIsGeometry) {
  EXPECT_EQ(verdict(box_scene({1, 1, 1}, Walls::Single, Wound::Outwards), {}), PoseVerdict::InsideGeometry);
  EXPECT_EQ(verdict(box_scene({0.3, 0.3, 0.3}, Walls::Double, Wound::Outwards), {}),
            PoseVerdict::InsideGeometry);
  EXPECT_EQ(verdict(box_scene({1, 1, 1}, Walls::Single, Wound::Outwards), {0, 0, 2}), PoseVerdict::Sees);
}

TEST(HeadTest, ABoxWithWallsAtMoreThanHalfAMetreIsARoom) {
  EXPECT_EQ(verdict(box_scene({0.7, 0.7, 0.7}, Walls::Double, Wound::Outwards), {}), PoseVerdict::Sees);
}

/// A back that is not seen hides nothing, also of what is close behind it.
/// Several things that are a point each, at the same place, would fail an assertion of Embree.
TEST(Surroundings, MayHavePoints) {
  Scene scene = empty_scene(Walls::Double);
  for (const double scale : {1.0, 1e-9, 1e-9, 1e-9}) {
    add_box(scene, glm::dvec3(0.5), {3, 0, 0}, Wound::Outwards);
    scene.nodes.back().rest.scale = glm::dvec3(scale);
  }
  scene.bounds = {{2.5, -0.5, -0.5}, {3.5, 0.5, 0.5}};
  const Surroundings surroundings = Surroundings::create(scene).value();
  const std::vector<Ray> ray{{{{0, 0, 0}}, {{1, 0, 0}}}};
  EXPECT_NEAR(surroundings.first_met(ray)[0].distance_m, 2.5, 1e-5);
}

TEST(Surroundings, AFrontCloseBehindABackIsSeen) {
  Scene scene = empty_scene(Walls::Single);
  add_quad(scene, {-1, -1}, {1, 1}, -5.0, Wound::Inwards);
  add_quad(scene, {-1, -1}, {1, 1}, -5.02, Wound::Outwards);
  const std::array rays{Ray{{}, {glm::normalize(glm::dvec3(0.1, 0.15, -1))}}};
  const Met met = Surroundings::create(scene).value().first_seen(rays).at(0);
  EXPECT_EQ(met.side, Met::Side::Front);
  EXPECT_NEAR(met.distance_m, 5.02 * glm::length(glm::dvec3(0.1, 0.15, -1)), 0.001);
}

TEST(HeadTest, AMirroredSolidIsOneToo) {
  Scene scene = box_scene({1, 1, 1}, Walls::Single, Wound::Outwards);
  scene.nodes[0].rest.scale = {-1, 1, 1};
  EXPECT_EQ(verdict(scene, {}), PoseVerdict::InsideGeometry);
}

TEST(HeadTest, ARoomIsNoGeometryHoweverItsDoubleSidedWallsAreWound) {
  for (const Wound wound : {Wound::Outwards, Wound::Inwards})
    for (const double x : {0.0, 2.7})
      EXPECT_EQ(verdict(box_scene({3, 1.5, 3}, Walls::Double, wound), {x, 0, 0}), PoseVerdict::Sees) << x;
  EXPECT_EQ(verdict(box_scene({3, 1.5, 3}, Walls::Single, Wound::Inwards), {2.7, 0, 0}), PoseVerdict::Sees);
}

TEST(HeadTest, ARoomWithSingleSidedWallsIsSeenFromOutsideButNotByAHeadThatLooksAway) {
  const Scene room = box_scene({3, 1.5, 3}, Walls::Single, Wound::Inwards);
  EXPECT_EQ(verdict(room, {0, 0, 5}), PoseVerdict::Sees) << "through the wall, whose back is not seen";
  EXPECT_EQ(verdict(room, {0, 0, 5}, std::numbers::pi), PoseVerdict::SeesNothing);
}

TEST(HeadTest, ALandscapeIsSeenFromAboveItsGroundOnly) {
  const Scene scene = landscape();
  EXPECT_EQ(verdict(scene, {0, 1.6, 0}), PoseVerdict::Sees);
  EXPECT_EQ(verdict(scene, {0, -1.6, 0}), PoseVerdict::SeesNothing);
  EXPECT_EQ(verdict(scene, {0, 0.005, 0}), PoseVerdict::InsideGeometry) << "5 mm above the ground";
  EXPECT_EQ(verdict(scene, {0, 0.015, 0}), PoseVerdict::Sees);
  EXPECT_EQ(verdict(Scene{}, {}), PoseVerdict::SeesNothing);
}

/// It covers less than a thousandth of the pictures.
TEST(HeadTest, ASmallThingIsSeenWhereItsPictureIsLargerThanHalfADegree) {
  Scene scene = box_scene({0.005, 0.005, 0.005}, Walls::Single, Wound::Outwards);
  scene.bounds = {glm::dvec3(-0.005), glm::dvec3(0.005)};
  EXPECT_EQ(verdict(scene, {0, 0, 0.3}), PoseVerdict::Sees);
  EXPECT_EQ(verdict(scene, {0.1, 0, 0.3}), PoseVerdict::Sees) << "at the side of the pictures";
  EXPECT_EQ(verdict(scene, {0, 0, 0.3}, std::numbers::pi), PoseVerdict::SeesNothing) << "behind the head";
  EXPECT_EQ(verdict(scene, {0.6, 0, 0.3}), PoseVerdict::SeesNothing) << "beside the pictures";
  EXPECT_EQ(verdict(scene, {0, 0, 4}), PoseVerdict::SeesNothing);
  scene.bounds = {};
  EXPECT_EQ(verdict(scene, {0, 0, 0.3}), PoseVerdict::SeesNothing) << "without the box, rays miss it";
}

/// Neighbouring rays of an eye, of 144, are 0.34 m apart at 2 m.
TEST(HeadTest, APictureShowsSomethingFromOnePercentOfItsRaysOn) {
  for (const auto& [left, seen] : {std::pair(-0.34f, PoseVerdict::Sees), {0.0f, PoseVerdict::SeesNothing}}) {
    Scene scene = empty_scene(Walls::Single);
    add_quad(scene, {left, 0}, {0.34f, 0.34f}, -2, Wound::Outwards);
    scene.bounds = {glm::dvec3(-10), glm::dvec3(10)};
    EXPECT_EQ(verdict(scene, {}), seen) << (left < 0 ? "4 of 288" : "2 of 288");
  }
}

TEST(HeadTest, AWallBetweenTheEyesIsGeometry) {
  Scene scene = empty_scene(Walls::Double);
  Mesh wall;
  wall.positions = {{0, -2, -2}, {0, -2, 2}, {0, 2, 2}, {0, 2, -2}};
  wall.triangles = {{0, 1, 2}, {0, 2, 3}};
  add_mesh(scene, std::move(wall), {});
  EXPECT_EQ(verdict(scene, {0, 0, 0}), PoseVerdict::InsideGeometry);
  EXPECT_EQ(verdict(scene, {0, 0, 0}, 0, 0.2), PoseVerdict::InsideGeometry);
  EXPECT_EQ(verdict(scene, {0.06, 0, 0}), PoseVerdict::Sees);
}

TEST(HeadTest, CountsThePosesOfTheShownPart) {
  const Scene box = box_scene({1, 1, 1}, Walls::Single, Wound::Outwards);
  const Surroundings surroundings = Surroundings::create(box).value();
  // Walks 4 m toward the middle of the box and stays there for as long.
  const HeadRecording recording = walk({{0, 0, 5}, {0, 0, 0}, {0, 0, 0}});
  const HeadTest all = test_head(surroundings, recording, {}, {.until = std::chrono::milliseconds(200)});
  EXPECT_EQ(all.tested, 64u);
  EXPECT_NEAR(static_cast<double>(all.inside), 64 * 0.6, 2);
  EXPECT_EQ(all.see_nothing, 0u);
  EXPECT_TRUE(all.is_bad());
  EXPECT_EQ(in_words(all), "of 64 poses of the head, 59 % are inside geometry and 0 % see nothing");
  const HeadTest begin = test_head(surroundings, recording, {}, {.until = std::chrono::milliseconds(70)});
  EXPECT_EQ(begin.inside, 0u);
  EXPECT_FALSE(begin.is_bad());
  EXPECT_EQ(test_head(surroundings, recording, {}, {}).tested, 1u) << "one frame";
}

TEST(HeadTest, CountsViewsThatWereShown) {
  const Scene box = box_scene({1, 1, 1}, Walls::Single, Wound::Outwards);
  const Surroundings surroundings = Surroundings::create(box).value();
  std::vector<StereoView> views(300);
  for (std::size_t i = 0; i < views.size(); ++i)
    for (View& view : views[i]) {
      view.fov = {-0.8, 0.8, 0.8, -0.8};
      view.stage_from_eye = {.rotation = {1, 0, 0, 0}, .translation = {0, 0, i < 100 ? 0 : 3}};
      if (i >= 250) view.stage_from_eye.rotation = rotation_exp({0, std::numbers::pi, 0});
    }
  const HeadTest test = test_views(surroundings, views);
  EXPECT_EQ(test.tested, 64u);
  EXPECT_NEAR(static_cast<double>(test.inside), 64 / 3.0, 1);
  EXPECT_NEAR(static_cast<double>(test.see_nothing), 64 / 6.0, 1);
  EXPECT_EQ(test_views(surroundings, std::span(views).first(3)).inside, 3u) << "each, if there are few";
  EXPECT_EQ(test_views(surroundings, {}).tested, 0u);
}

TEST(HeadTest, IsBadAboveFivePercent) {
  EXPECT_FALSE((HeadTest{.tested = 60, .inside = 1, .see_nothing = 2}.is_bad()));
  EXPECT_TRUE((HeadTest{.tested = 60, .inside = 2, .see_nothing = 2}.is_bad()));
}

TEST(Surroundings, RefusesAHugeSceneWithoutReadingIt) {
  Scene scene = landscape();
  scene.triangle_count = SurroundingsOptions{}.most_triangles + 1;
  const Expected<Surroundings> refused = Surroundings::create(scene);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().fault, Fault::OutOfRange);
  EXPECT_NE(refused.error().what.find("4000001 triangles"), std::string::npos) << refused.error().what;
}

TEST(Surroundings, LeavesAnimatedInstancesWhereTheyAreAtTimeZero) {
  Scene scene = box_scene({1, 1, 1}, Walls::Single, Wound::Outwards);
  scene.nodes[0].moving = true;
  scene.animation_length_s = 1;
  scene.channels.push_back({.node = 0, .keys_s = {0, 1}, .values = {{9, 0, 0, 0}, {0, 0, 0, 0}}});
  EXPECT_EQ(verdict(scene, {9, 0, 0}), PoseVerdict::InsideGeometry);
  EXPECT_NE(verdict(scene, {0, 0, 0}), PoseVerdict::InsideGeometry);
}

/// A square walk of this size around a middle at the height of its start.
HeadRecording square_walk(double size_m) {
  const double s = size_m;
  return walk({{7, 1, 7}, {7 + s, 1, 7}, {7 + s, 1, 7 + s}, {7, 1, 7 + s}, {7, 1, 7}});
}

const Rigid<Stage, Eye> kReference{.rotation = {1, 0, 0, 0}, .translation = {0.5, 0, 0.5}};

Fit fit_in(const Scene& scene, const HeadRecording& recording, Anchors anchors = Anchors::Around) {
  return fit_head(Surroundings::create(scene).value(), recording, kReference, anchors).value();
}

double farthest(const Fit& fit, const HeadRecording& recording) {
  double most = 0;
  for (const HeadSample& sample : scaled(recording, fit.scale).samples) {
    const glm::dvec3 at = (fit.stage_from_recorded * sample.recorded_from_head).translation;
    most = std::max({most, std::abs(at.x), std::abs(at.z)});
  }
  return most;
}

TEST(FitHead, KeepsAWalkThatHasRoomWhereItIs) {
  const Scene room = box_scene({4, 1.5, 4}, Walls::Single, Wound::Inwards);
  const HeadRecording recording = square_walk(2);
  const Fit fit = fit_in(room, recording);
  EXPECT_EQ(fit.scale, 1);
  EXPECT_EQ(fit.moved_m, 0);
  EXPECT_LT(glm::length(fit.stage_from_recorded.translation - place(recording, kReference).translation),
            1e-9);
}

TEST(FitHead, MovesAWalkBeforeItScales) {
  const Scene room = box_scene({2, 1.5, 2}, Walls::Double, Wound::Outwards);
  const HeadRecording recording = square_walk(3);  // from 0.5 m it would end at 3.5 m
  const Fit fit = fit_in(room, recording);
  EXPECT_EQ(fit.scale, 1);
  EXPECT_LE(farthest(fit, recording), 1.85 + 1e-6);
}

TEST(FitHead, ScalesAWalkThatIsLargerThanTheRoomAndNoMoreThanNeeded) {
  const Scene room = box_scene({2, 1.5, 2}, Walls::Double, Wound::Inwards);
  const HeadRecording recording = square_walk(10);
  const Fit fit = fit_in(room, recording);
  EXPECT_LT(fit.scale, 0.37 + 1e-6);
  EXPECT_GT(fit.scale, 0.33) << "3.7 m of 10 m are free";
  EXPECT_LE(farthest(fit, recording), 1.86) << "the rays for the clearance are not quite across the walls";
  const HeadRecording small = scaled(recording, fit.scale);
  EXPECT_EQ(small.eye_distance_m, recording.eye_distance_m);
  EXPECT_EQ(small.samples[2].recorded_from_head.rotation, recording.samples[2].recorded_from_head.rotation);
  const Fit again = fit_in(room, recording);
  EXPECT_EQ(again.stage_from_recorded, fit.stage_from_recorded) << "the same every time";
  EXPECT_EQ(again.scale, fit.scale);
}

TEST(FitHead, StaysOnThisSideOfAWallAndOutOfFurniture) {
  Scene room = box_scene({4, 1.5, 4}, Walls::Double, Wound::Inwards);
  add_box(room, {0.05, 1.5, 4}, {-0.5, 0, 0}, Wound::Outwards);  // a wall: 4.45 m are left
  add_box(room, {0.4, 1.5, 0.4}, {2, 0, -1}, Wound::Outwards);   // a cupboard
  const HeadRecording recording = square_walk(4);
  const Fit fit = fit_in(room, recording);
  const Surroundings surroundings = Surroundings::create(room).value();
  for (const HeadSample& sample : scaled(recording, fit.scale).samples) {
    const Rigid<Stage, Head> head = fit.stage_from_recorded * sample.recorded_from_head;
    EXPECT_GT(head.translation.x, -0.45 + 0.1);
    EXPECT_EQ(judge(surroundings, recording, head), PoseVerdict::Sees);
  }
  EXPECT_GT(fit.scale, 0.3);
}

/// Both of its poses have room: only the way between them is barred.
TEST(FitHead, DoesNotStepThroughAThinWall) {
  Scene room = box_scene({4, 1.5, 4}, Walls::Double, Wound::Inwards);
  add_box(room, {0.002, 1.5, 4}, {2, 0, 0}, Wound::Outwards);
  const HeadRecording recording = walk({{7, 1, 7}, {10, 1, 7}, {7, 1, 7}});  // from 0.5 to 3.5 m
  const Fit fit = fit_in(room, recording, Anchors::Reference);
  EXPECT_LT(0.5 + 3 * fit.scale, 2 - 0.15 + 0.01);
  EXPECT_GT(0.5 + 3 * fit.scale, 1.7);
}

TEST(FitHead, AtAChosenPlaceOnlyScales) {
  const Scene room = box_scene({2, 1.5, 2}, Walls::Double, Wound::Inwards);
  const Fit fit = fit_in(room, square_walk(3), Anchors::Reference);
  EXPECT_NEAR(fit.scale, 1.35 / 3, 0.02);
  EXPECT_LT(fit.moved_m, 1e-9);
}

TEST(FitHead, RefusesAPlaceInsideGeometryAndNamesTheCure) {
  const Scene box = box_scene({2, 2, 2}, Walls::Single, Wound::Outwards);
  const Expected<Fit> fit = fit_head(Surroundings::create(box).value(), square_walk(1), kReference);
  ASSERT_FALSE(fit);
  EXPECT_EQ(fit.error().fault, Fault::OutOfRange);
  EXPECT_NE(fit.error().what.find("--stand"), std::string::npos);
}

}  // namespace
}  // namespace farshade
