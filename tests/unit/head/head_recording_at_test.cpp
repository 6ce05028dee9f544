#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "stereo/head/head_recording.h"
#include "stereo/math/rotation.h"

namespace farshade {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

glm::dquat turned(double yaw_rad, double pitch_rad = 0.0) {
  return rotation_exp({0, yaw_rad, 0}) * rotation_exp({pitch_rad, 0, 0});
}

HeadRecording two_samples() {
  HeadRecording recording;
  recording.samples = {{time_from_ns(1000), {turned(0.0), {1, 2, 3}}},
                       {time_from_ns(2000), {turned(90 * kDegree), {3, 2, 1}}}};
  return recording;
}

void expect_near(const glm::dvec3& a, const glm::dvec3& b) {
  EXPECT_LT(glm::length(a - b), 1e-12);
}

TEST(HeadAt, GoesHalfWayBetweenNeighbours) {
  const auto head = head_at(two_samples(), time_from_ns(1500));
  expect_near(head.translation, {2, 2, 2});
  EXPECT_LT(angle_between_rad(head.rotation, turned(45 * kDegree)), 1e-12);
}

TEST(HeadAt, MeetsEverySampleExactly) {
  const HeadRecording recording = two_samples();
  for (const HeadSample& sample : recording.samples) {
    const auto head = head_at(recording, sample.time);
    expect_near(head.translation, sample.recorded_from_head.translation);
    EXPECT_LT(angle_between_rad(head.rotation, sample.recorded_from_head.rotation), 1e-12);
  }
}

TEST(HeadAt, HoldsOutsideTheRecording) {
  const HeadRecording recording = two_samples();
  EXPECT_EQ(head_at(recording, time_from_ns(-5)), recording.samples.front().recorded_from_head);
  EXPECT_EQ(head_at(recording, time_from_ns(9'000'000'000)), recording.samples.back().recorded_from_head);
}

TEST(HeadAt, TakesTheShortWayWhenTheSignFlips) {
  HeadRecording recording = two_samples();
  recording.samples[1].recorded_from_head.rotation = -recording.samples[1].recorded_from_head.rotation;
  EXPECT_LT(angle_between_rad(head_at(recording, time_from_ns(1500)).rotation, turned(45 * kDegree)), 1e-12);
}

TEST(Place, CarriesFirstHeadOverToTheReference) {
  HeadRecording recording = two_samples();
  recording.samples[0].recorded_from_head.rotation = turned(30 * kDegree, -20 * kDegree);
  const Rigid<Stage, Eye> reference{turned(-75 * kDegree, 10 * kDegree), {5, 1.6, -2}};
  const Rigid<Stage, Head> head = place(recording, reference) * recording.samples[0].recorded_from_head;
  expect_near(head.translation, reference.translation);
  EXPECT_NEAR(heading_rad(head.rotation), -75 * kDegree, 1e-12);
}

TEST(Place, LeavesGravityAndPitchAlone) {
  HeadRecording recording = two_samples();
  recording.samples[0].recorded_from_head.rotation = turned(30 * kDegree, -20 * kDegree);
  const auto stage_from_recorded = place(recording, {turned(1.0, 0.7), {0, 0, 0}});
  expect_near(stage_from_recorded.rotation * glm::dvec3(0, 1, 0), {0, 1, 0});
  const Rigid<Stage, Head> head = stage_from_recorded * recording.samples[0].recorded_from_head;
  EXPECT_NEAR(std::asin((head.rotation * glm::dvec3(0, 0, -1)).y), -20 * kDegree, 1e-12);
}

TEST(HeadFromEye, PutsEyesHalfTheirDistanceAside) {
  EXPECT_EQ(head_from_eye(Side::Left, 0.064).translation, glm::dvec3(-0.032, 0, 0));
  EXPECT_EQ(head_from_eye(Side::Right, 0.064).translation, glm::dvec3(0.032, 0, 0));
  EXPECT_EQ(head_from_eye(Side::Right, 0.0), head_from_eye(Side::Left, 0.0));
}

}  // namespace
}  // namespace farshade
