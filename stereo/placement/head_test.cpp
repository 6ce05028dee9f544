#include "stereo/placement/head_test.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

namespace farshade {
namespace {

constexpr std::size_t kMostPoses = 64;
constexpr int kRaysAround = 32;  ///< rays around an eye
constexpr int kAcross = 12;      ///< rays across and down a picture
constexpr double kTouch_m = 0.01, kSolid_m = 0.5, kLeastSeen = 0.01,
                 kSmallThing_rad = 0.5 * std::numbers::pi / 180;

View eye_of(const HeadRecording& recording, const Rigid<Stage, Head>& stage_from_head, Side side) {
  return {.stage_from_eye = stage_from_head * head_from_eye(side, recording.eye_distance_m),
          .fov = recording.fov[index_of(side)],
          .size = {}};
}

StereoView eyes_of(const HeadRecording& recording, const Rigid<Stage, Head>& stage_from_head) {
  return {eye_of(recording, stage_from_head, Side::Left), eye_of(recording, stage_from_head, Side::Right)};
}

bool is_inside_of_solid(const Met& met) {
  return met.side == Met::Side::UnseenBack || (met.side == Met::Side::Back && met.distance_m < kSolid_m);
}

bool is_inside_geometry(const Surroundings& surroundings, const StereoView& eyes) {
  static const std::vector<Vector<Stage>> around = directions_around(kRaysAround);
  const Point<Stage> left{eyes[0].stage_from_eye.translation}, right{eyes[1].stage_from_eye.translation};
  std::vector<Ray> rays;
  for (const Point<Stage> eye : {left, right})
    for (const Vector<Stage>& direction : around) rays.push_back({eye, direction});
  const double apart_m = length(right - left);
  if (apart_m > 0) rays.push_back({left, (right - left) * (1 / apart_m)});
  const std::vector<Met> met = surroundings.first_met(rays);
  if (apart_m > 0 && met.back().distance_m < apart_m) return true;
  return std::ranges::any_of(met, [](const Met& m) { return m.distance_m < kTouch_m; }) ||
         std::ranges::count_if(met, is_inside_of_solid) > kRaysAround;
}

void add_picture_rays(const View& eye, int across, std::vector<Ray>& rays) {
  const FovTangents window = tangents_of(eye.fov);
  for (int y = 0; y < across; ++y)
    for (int x = 0; x < across; ++x) {
      const double right = std::lerp(window.left_tan, window.right_tan, (x + 0.5) / across),
                   up = std::lerp(window.down_tan, window.up_tan, (y + 0.5) / across);
      const Vector<Eye> direction{glm::normalize(glm::dvec3(right, up, -1))};
      rays.push_back({{eye.stage_from_eye.translation}, eye.stage_from_eye(direction)});
    }
}

/// Rays to places within the box around the scene that are in the eye's picture. None if the eye is in the
/// box, or the box looks smaller than half a degree.
void add_box_rays(const View& view, const Bounds& box, std::vector<Ray>& rays) {
  constexpr int kPlaces = 5;  // along an axis
  const glm::dvec3 eye = view.stage_from_eye.translation, size = box.high - box.low;
  const double distance = glm::length(eye - glm::clamp(eye, box.low, box.high));
  if (!(distance > 0) || glm::length(size) < kSmallThing_rad * distance) return;
  const FovTangents window = tangents_of(view.fov);
  for (int i = 0; i < kPlaces * kPlaces * kPlaces; ++i) {
    const glm::dvec3 part =
        (glm::dvec3(i % kPlaces, i / kPlaces % kPlaces, i / (kPlaces * kPlaces)) + 0.5) * (1.0 / kPlaces);
    const Vector<Stage> way{box.low + part * size - eye};
    const glm::dvec3 seen = inverse(view.stage_from_eye)(way).v;
    const glm::dvec2 at = glm::dvec2(seen) / -seen.z;
    if (seen.z < 0 && at.x > window.left_tan && at.x < window.right_tan && at.y > window.down_tan &&
        at.y < window.up_tan)
      rays.push_back({{eye}, {glm::normalize(way.v)}});
  }
}

bool meets(const Met& met) {
  return met.distance_m != kNoSurface_m;
}

std::vector<Ray> picture_rays(const StereoView& eyes, int across) {
  std::vector<Ray> rays;
  for (const View& eye : eyes) add_picture_rays(eye, across, rays);
  return rays;
}

bool sees_nothing(const Surroundings& surroundings, const StereoView& eyes) {
  std::vector<Ray> rays = picture_rays(eyes, kAcross);
  const std::vector<Met> met = surroundings.first_seen(rays);
  const auto seen = std::ranges::count_if(met, meets);
  if (static_cast<double>(seen) >= kLeastSeen * static_cast<double>(met.size())) return false;
  rays.clear();
  for (const View& eye : eyes) add_box_rays(eye, surroundings.bounds(), rays);
  return std::ranges::none_of(surroundings.first_seen(rays), meets);
}

std::string percent(std::size_t part, std::size_t of) {
  return fmt::format("{:.0f} %", 100.0 * static_cast<double>(part) / static_cast<double>(of));
}

}  // namespace

std::vector<Vector<Stage>> directions_around(int count) {
  const double golden_rad = std::numbers::pi * (3 - std::sqrt(5.0));
  std::vector<Vector<Stage>> directions;
  for (int i = 0; i < count; ++i) {
    const double y = 1 - (2 * i + 1.0) / count, r = std::sqrt(1 - y * y);
    directions.push_back({{r * std::cos(golden_rad * i), y, r * std::sin(golden_rad * i)}});
  }
  return directions;
}

std::vector<Ray> picture_rays(const HeadRecording& recording, const Rigid<Stage, Head>& stage_from_head,
                              int across) {
  return picture_rays(eyes_of(recording, stage_from_head), across);
}

PoseVerdict judge(const Surroundings& surroundings, const StereoView& eyes) {
  if (is_inside_geometry(surroundings, eyes)) return PoseVerdict::InsideGeometry;
  return sees_nothing(surroundings, eyes) ? PoseVerdict::SeesNothing : PoseVerdict::Sees;
}

PoseVerdict judge(const Surroundings& surroundings, const HeadRecording& recording,
                  const Rigid<Stage, Head>& stage_from_head) {
  return judge(surroundings, eyes_of(recording, stage_from_head));
}

HeadTest test_head(const Surroundings& surroundings, const HeadRecording& recording,
                   const Rigid<Stage, Recorded>& stage_from_recorded, const Shown& shown) {
  const Duration span = std::max(shown.until - shown.from, Duration{});
  const std::size_t poses = span > Duration{} ? kMostPoses : 1;
  std::vector<StereoView> views;
  for (std::size_t i = 0; i < poses; ++i) {
    const double part = poses > 1 ? static_cast<double>(i) / (kMostPoses - 1) : 0;
    const Time time = recording.start() + shown.from + duration_from_ms(part * ms_of(span));
    views.push_back(eyes_of(recording, stage_from_recorded * head_at(recording, time)));
  }
  return test_views(surroundings, views);
}

HeadTest test_views(const Surroundings& surroundings, std::span<const StereoView> views) {
  HeadTest test;
  test.tested = std::min(views.size(), kMostPoses);
  for (std::size_t i = 0; i < test.tested; ++i) {
    const PoseVerdict verdict = judge(surroundings, views[i * views.size() / test.tested]);
    test.inside += verdict == PoseVerdict::InsideGeometry;
    test.see_nothing += verdict == PoseVerdict::SeesNothing;
  }
  return test;
}

std::string in_words(const HeadTest& test) {
  return fmt::format("of {} poses of the head, {} are inside geometry and {} see nothing", test.tested,
                     percent(test.inside, test.tested), percent(test.see_nothing, test.tested));
}

}  // namespace farshade
