#include "stereo/head/gravity.h"

#include <algorithm>
#include <cmath>
#include <glm/matrix.hpp>
#include <numbers>

namespace farshade {
namespace {

constexpr glm::dvec3 kRight{1, 0, 0}, kUp{0, 1, 0}, kAhead{0, 0, -1};

/// The way that the head went, in its own axes.
struct Walk {
  glm::dvec3 net_m{0.0};
  double path_m = 0;
};

Walk walk_of(std::span<const HeadSample> samples) {
  Walk walk;
  for (std::size_t i = 1; i < samples.size(); ++i) {
    const Rigid<Recorded, Head>&from = samples[i - 1].recorded_from_head, &to = samples[i].recorded_from_head;
    const glm::dvec3 step = glm::conjugate(from.rotation) * (to.translation - from.translation);
    walk.net_m += step;
    walk.path_m += glm::length(step);
  }
  return walk;
}

/// The mean outer product of the heads' right directions.
glm::dmat3 rights_of(std::span<const HeadSample> samples) {
  glm::dmat3 rights(0.0);
  for (const HeadSample& sample : samples) {
    const glm::dvec3 right = sample.recorded_from_head.rotation * kRight;
    rights += glm::outerProduct(right, right);
  }
  return rights / static_cast<double>(samples.size());
}

}  // namespace

Posture posture_of(std::span<const HeadSample> samples, double most_off_rad) {
  constexpr double kLeastWalk_m = 0.5, kSteady = 0.8, kCos60 = 0.5;
  glm::dvec3 up{0.0};
  for (const HeadSample& sample : samples) up += sample.recorded_from_head.rotation * kUp;
  if (!(up.y > std::cos(most_off_rad) * glm::length(up))) return Posture::LiesDown;
  const Walk walk = walk_of(samples);
  const double net_m = glm::length(walk.net_m);
  if (net_m < kLeastWalk_m || net_m < kSteady * walk.path_m) return Posture::Upright;
  return glm::dot(walk.net_m, kAhead) > kCos60 * net_m ? Posture::WalksAhead : Posture::WalksAside;
}

glm::dquat levelling(std::span<const HeadSample> samples) {
  // Minimises the mean of (up . right of a head)^2 + kPrior |up - y|^2. The prior is as strong as a roll of 6
  // degrees.
  constexpr double kPrior = 0.01;
  const glm::dvec3 up = glm::normalize(glm::inverse(rights_of(samples) + glm::dmat3(kPrior)) * kUp);
  const glm::dvec3 axis = glm::cross(up, kUp);
  return glm::normalize(glm::dquat(1.0 + glm::dot(up, kUp), axis.x, axis.y, axis.z));
}

double turn_width(std::span<const HeadSample> samples) {
  // O. K. Smith, "Eigenvalues of a symmetric 3x3 matrix", 1961. The trace is 1.
  const glm::dmat3 apart = rights_of(samples) - glm::dmat3(1.0 / 3);
  double squares = 0;
  for (int i = 0; i < 3; ++i) squares += glm::dot(apart[i], apart[i]);
  const double p = std::sqrt(squares / 6);
  const double angle = std::acos(std::clamp(glm::determinant(apart / p) / 2, -1.0, 1.0)) / 3;
  return 1.0 / 3 + 2 * p * std::cos(angle - 2 * std::numbers::pi / 3);
}

void turn(std::span<HeadSample> samples, const glm::dquat& rotation) {
  const glm::dvec3 centre = samples.front().recorded_from_head.translation;
  for (auto& [time, pose] : samples)
    pose = {glm::normalize(rotation * pose.rotation), centre + rotation * (pose.translation - centre)};
}

}  // namespace farshade
