#include "stereo/scene/start_pose.h"

#include <gtest/gtest.h>

#include <numbers>

#include "stereo/math/rotation.h"
#include "stereo/options/parse_start_pose.h"

namespace farshade {
namespace {

TEST(StartPose, ReadsAPlaceAndPerhapsAHeading) {
  EXPECT_EQ(parse_start_pose("-3.4,1.4,-4"),
            (StartPose{.at = {{-3.4, 1.4, -4}}, .heading_rad = std::nullopt}));
  const StartPose turned = parse_start_pose("0,1e1,0,-270").value();
  EXPECT_EQ(turned.at.v, glm::dvec3(0, 10, 0));
  EXPECT_NEAR(turned.heading_rad.value(), std::numbers::pi / 2, 1e-12);
}

TEST(StartPose, RefusesEverythingElseAndQuotesIt) {
  for (const std::string text : {"", "1", "1,2", "1,2,3,4,5", "1,2,x", "1,2,nan", "1,2,3,inf", "1;2;3",
                                 "1, 2,3", "1,2,3,", "1,2,1e10"}) {
    const Expected<StartPose> start_pose = parse_start_pose(text);
    ASSERT_FALSE(start_pose) << text;
    EXPECT_NE(start_pose.error().what.find("--stand " + text), std::string::npos) << start_pose.error().what;
  }
}

TEST(StartPose, IsLevelAndReplacesTheViewpoint) {
  Scene scene;
  scene.camera = Rigid<Stage, Eye>{.rotation = rotation_exp({0, 0.5, 0}) * rotation_exp({-0.4, 0, 0}),
                                   .translation = {9, 9, 9}};
  EXPECT_EQ(viewpoint_of(scene, std::nullopt), *scene.camera);
  const Rigid<Stage, Eye> left = viewpoint_of(scene, parse_start_pose("1,2,3,90").value());
  EXPECT_EQ(left.translation, glm::dvec3(1, 2, 3));
  EXPECT_LT(glm::length(left(Vector<Eye>{{0, 0, -1}}).v - glm::dvec3(-1, 0, 0)), 1e-12);
  const Rigid<Stage, Eye> as_the_camera = viewpoint_of(scene, parse_start_pose("1,2,3").value());
  EXPECT_NEAR(heading_rad(as_the_camera.rotation), 0.5, 1e-12);
  EXPECT_LT(glm::length(as_the_camera(Vector<Eye>{{0, 1, 0}}).v - glm::dvec3(0, 1, 0)), 1e-12);
}

}  // namespace
}  // namespace farshade
