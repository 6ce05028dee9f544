#include "tests/golden/pose_cases.h"

#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

#include "stereo/head/head_recording.h"
#include "stereo/math/rotation.h"

namespace farshade {
namespace {

constexpr EyeFov kLopsided{-0.85, 0.25, 0.20, -0.75};

constexpr std::array kCases{
    PoseCase{.name = "Yaw1", .yaw_degrees = 1},
    PoseCase{.name = "Yaw5", .yaw_degrees = 5},
    PoseCase{.name = "Yaw20", .yaw_degrees = 20},
    PoseCase{.name = "Yaw90", .yaw_degrees = 90},
    PoseCase{.name = "Yaw180", .yaw_degrees = 180},
    PoseCase{.name = "Step1cm", .step_m = 0.01},
    PoseCase{.name = "Step10cm", .step_m = 0.1},
    PoseCase{.name = "Step50cm", .step_m = 0.5},
    PoseCase{.name = "Yaw5Step10cm", .yaw_degrees = 5, .step_m = 0.1},
    PoseCase{.name = "Roll10", .roll_degrees = 10},
    PoseCase{.name = "ZoomedOut", .zoom = 1.3},
    PoseCase{.name = "ZoomedIn", .zoom = 0.75},
    PoseCase{.name = "AsymmetricFov", .yaw_degrees = 2, .step_m = 0.03, .left_fov = kLopsided},
    PoseCase{.name = "EyeDistance0", .yaw_degrees = 2, .step_m = 0.03, .eye_distance_m = 0},
    PoseCase{.name = "EyeDistance70mm", .yaw_degrees = 2, .step_m = 0.03, .eye_distance_m = 0.070}};

EyeFov zoomed(const EyeFov& fov, double zoom) {
  const auto wider = [zoom](double angle_rad) { return std::atan(zoom * std::tan(angle_rad)); };
  return {wider(fov.left_rad), wider(fov.right_rad), wider(fov.up_rad), wider(fov.down_rad)};
}

StereoView eyes(const PoseCase& pose, const Rigid<Stage, Head>& head, double zoom, std::uint32_t side_px) {
  const EyeFov left = zoomed(pose.left_fov, zoom),
               right{-left.right_rad, -left.left_rad, left.up_rad, left.down_rad};
  StereoView views;
  for (const Side side : kSides)
    views[index_of(side)] = {head * head_from_eye(side, pose.eye_distance_m),
                             side == Side::Left ? left : right,
                             {side_px, side_px}};
  return views;
}

}  // namespace

std::span<const PoseCase> pose_cases() {
  return kCases;
}

const PoseCase& pose_case(std::string_view name) {
  for (const PoseCase& pose : kCases)
    if (pose.name == name) return pose;
  throw std::runtime_error("no pose case " + std::string(name));
}

PoseViews views_of(const PoseCase& pose, const Rigid<Stage, Head>& head, std::uint32_t side_px) {
  constexpr double kDegree = std::numbers::pi / 180;
  const glm::dquat turn =
      rotation_exp({0, pose.yaw_degrees * kDegree, 0}) * rotation_exp({0, 0, pose.roll_degrees * kDegree});
  const Rigid<Stage, Head> traced = head * Rigid<Head, Head>{turn, {pose.step_m, 0, 0}};
  return {eyes(pose, head, 1, side_px), eyes(pose, traced, pose.zoom, side_px)};
}

}  // namespace farshade
