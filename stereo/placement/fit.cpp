#include "stereo/placement/fit.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "stereo/math/rotation.h"
#include "stereo/placement/head_test.h"

namespace farshade {
namespace {

constexpr double kClearance_m = 0.15;
constexpr std::size_t kMostPositions = 512, kMostChecked = 64;
constexpr int kAround = 26, kDirections = 16, kRounds = 4;
constexpr int kHalvings = 7;
constexpr double kLeastScale = 0.01, kBetter = 1.01;

/// A walk that begins at the recording's start, turned to the heading of the reference.
struct Walk {
  std::vector<glm::dvec3> steps;  ///< positions in stage axes, from the recording's first position
  glm::dvec3 middle{0.0};         ///< of the box around them
  double size_m = 0;              ///< diagonal of that box
};

struct Candidate {
  Point<Stage> anchor;
  glm::dvec3 centre{0.0};  ///< the step that comes to lie at the anchor
};

struct Found {
  Candidate at;
  double scale = 0;
};

/// Number `i` of `count` indices that are spread over 0..size - 1.
std::size_t evenly(std::size_t i, std::size_t count, std::size_t size) {
  return count > 1 ? i * (size - 1) / (count - 1) : 0;
}

Walk walk_of(const HeadRecording& recording, const glm::dquat& turn) {
  const std::size_t count = std::min(recording.samples.size(), kMostPositions);
  const glm::dvec3 first = recording.samples.front().recorded_from_head.translation;
  Walk walk;
  glm::dvec3 low(0.0), high(0.0);
  for (std::size_t i = 0; i < count; ++i) {
    const HeadSample& sample = recording.samples[evenly(i, count, recording.samples.size())];
    walk.steps.push_back(turn * (sample.recorded_from_head.translation - first));
    low = glm::min(low, walk.steps.back()), high = glm::max(high, walk.steps.back());
  }
  walk.middle = (low + high) * 0.5;
  walk.size_m = glm::length(high - low);
  return walk;
}

/// Is every surface at least kClearance_m from each of the points?
bool are_clear(const Surroundings& surroundings, std::span<const Point<Stage>> points) {
  static const std::vector<Vector<Stage>> around = directions_around(kAround);
  std::vector<Ray> rays;
  for (const Point<Stage>& point : points)
    for (const Vector<Stage>& direction : around) rays.push_back({point, direction});
  return std::ranges::all_of(surroundings.first_met(rays),
                             [](const Met& met) { return met.distance_m >= kClearance_m; });
}

/// How large the walk may be so that no position is hidden from the anchor; at most 1.
double reach_of(const Surroundings& surroundings, const Walk& walk, const Candidate& candidate) {
  std::vector<Ray> rays;
  std::vector<double> lengths;
  for (const glm::dvec3& step : walk.steps) {
    const glm::dvec3 way = step - candidate.centre;
    lengths.push_back(glm::length(way));
    if (!(lengths.back() > 1e-9))
      lengths.pop_back();
    else
      rays.push_back({candidate.anchor, {way / lengths.back()}});
  }
  const std::vector<Met> met = surroundings.first_met(rays);
  double scale = 1;
  for (std::size_t i = 0; i < rays.size(); ++i)
    scale = std::min(scale, (met[i].distance_m - kClearance_m) / lengths[i]);
  return scale;
}

/// Are up to kMostChecked positions of the walk clear at this scale?
bool is_walk_clear(const Surroundings& surroundings, const Walk& walk, const Candidate& candidate,
                   double scale) {
  const std::size_t count = std::min(walk.steps.size(), kMostChecked);
  std::vector<Point<Stage>> points;
  for (std::size_t i = 0; i < count; ++i) {
    const glm::dvec3& step = walk.steps[evenly(i, count, walk.steps.size())];
    points.push_back(candidate.anchor + Vector<Stage>{(step - candidate.centre) * scale});
  }
  return are_clear(surroundings, points);
}

/// The largest scale at which the candidate's walk is clear, or 0 if it is not above `least`.
double scale_of(const Surroundings& surroundings, const Walk& walk, const Candidate& candidate,
                double least) {
  if (!are_clear(surroundings, std::array{candidate.anchor})) return 0;
  const auto is_clear = [&](double scale) { return is_walk_clear(surroundings, walk, candidate, scale); };
  double high = reach_of(surroundings, walk, candidate), low = least;
  if (high <= least) return 0;
  if (is_clear(high)) return high;
  if (!is_clear(low)) return 0;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = (low + high) * 0.5;
    (is_clear(middle) ? low : high) = middle;
  }
  return low;
}

/// Anchors around a point: near ones first. Where nothing is in the way, up to the size of the walk.
std::vector<Candidate> around(const Surroundings& surroundings, Point<Stage> point, const Walk& walk) {
  std::vector<Ray> rays{{point, {{0, 1, 0}}}, {point, {{0, -1, 0}}}};
  for (int i = 0; i < kDirections; ++i) {
    const double angle_rad = 2 * std::numbers::pi * i / kDirections;
    rays.push_back({point, {{std::sin(angle_rad), 0, -std::cos(angle_rad)}}});
  }
  const std::vector<Met> met = surroundings.first_met(rays);
  std::vector<Candidate> candidates;
  for (const double part : {0.125, 0.25, 0.5, 0.75, 1.0})
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const double free_m = std::min(met[i].distance_m - kClearance_m, walk.size_m);
      if (free_m > 0) candidates.push_back({point + rays[i].direction * (free_m * part), walk.middle});
    }
  return candidates;
}

/// Keeps a better candidate. True once nothing can be better.
bool improve(const Surroundings& surroundings, const Walk& walk, std::span<const Candidate> candidates,
             Found& best) {
  for (const Candidate& candidate : candidates) {
    const double least = std::max(best.scale * kBetter, kLeastScale);
    if (const double scale = scale_of(surroundings, walk, candidate, least); scale > 0)
      best = {candidate, scale};
    if (best.scale >= 1) return true;
  }
  return false;
}

Found search(const Surroundings& surroundings, const Walk& walk, Point<Stage> reference, Anchors anchors) {
  Found best;
  if (improve(surroundings, walk, std::array{Candidate{reference}}, best) || anchors == Anchors::Reference)
    return best;
  if (improve(surroundings, walk, std::array{Candidate{reference, walk.middle}}, best)) return best;
  Point<Stage> from = reference;
  for (int round = 0; round < kRounds; ++round) {
    const double before = best.scale;
    if (improve(surroundings, walk, around(surroundings, from, walk), best) || best.scale == before) break;
    from = best.at.anchor;
  }
  return best;
}

}  // namespace

HeadRecording scaled(HeadRecording recording, double scale) {
  for (HeadSample& sample : recording.samples) sample.recorded_from_head.translation *= scale;
  return recording;
}

Expected<Fit> fit_head(const Surroundings& surroundings, const HeadRecording& recording,
                       const Rigid<Stage, Eye>& reference, Anchors anchors) {
  const Rigid<Stage, Recorded> placed = place(recording, reference);
  const Walk walk = walk_of(recording, placed.rotation);
  const Point<Stage> start{reference.translation};
  const bool is_inside = judge(surroundings, recording, {reference.rotation, reference.translation}) ==
                         PoseVerdict::InsideGeometry;
  const Found found = is_inside ? Found{} : search(surroundings, walk, start, anchors);
  if (found.scale == 0)
    return fail(
        Fault::OutOfRange,
        "--place fit finds no free space for a head where it starts: choose another place with --stand "
        "X,Y,Z");
  const glm::dvec3 first = found.at.anchor.v - found.at.centre * found.scale;
  const glm::dvec3 recorded = recording.samples.front().recorded_from_head.translation * found.scale;
  return Fit{.scale = found.scale,
             .stage_from_recorded = {placed.rotation, first - placed.rotation * recorded},
             .moved_m = glm::length(first - start.v)};
}

}  // namespace farshade
