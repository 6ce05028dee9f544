#include "tests/oracle/oracle.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "stereo/base/check.h"
#include "tests/oracle/surfaces.h"

namespace farshade::oracle {
namespace {

/// The surface that a ray sees.
struct Surface {
  bool covered = false;
  std::uint32_t instance = 0;
  glm::dvec3 point{0.0}, shading{0.0},
      facing{0.0};  ///< unit normals, turned to the viewer as in the definition
};

/// One light at one surface point.
struct Verdict {
  bool lit = false, grazing = false;
};

Surface see(const Surfaces& surfaces, const Ray& ray) {
  const std::optional<Hit> hit = surfaces.nearest(ray);
  if (!hit) return {};
  const Triangle& t = *hit->triangle;
  const double w = 1 - hit->u - hit->v;
  const double side = t.material->double_sided && glm::dot(ray.direction, t.facing) > 0 ? -1 : 1;
  const auto mix = [&](const std::array<glm::dvec3, 3>& of) {
    return of[0] * w + of[1] * hit->u + of[2] * hit->v;
  };
  return {true, t.instance, mix(t.position), glm::normalize(mix(t.normal)) * side,
          glm::normalize(t.facing) * side};
}

bool reaches(const Light& light, const glm::dvec3& to_light) {
  if (light.kind == LightKind::Directional) return true;
  if (light.range_m > 0 && glm::length(to_light) >= double{light.range_m}) return false;
  if (light.kind == LightKind::Point) return true;
  const glm::dvec3 axis = glm::normalize(light.direction.v), away = -glm::normalize(to_light);
  return std::atan2(glm::length(glm::cross(axis, away)), glm::dot(axis, away)) < double{light.outer_cone_rad};
}

Verdict judge(const Surfaces& surfaces, const Surface& seen, const Light& light) {
  if (!seen.covered || !light.on) return {};
  const bool directional = light.kind == LightKind::Directional;
  const glm::dvec3 to_light = directional ? -light.direction.v : light.position.v - seen.point;
  const glm::dvec3 l = glm::normalize(to_light);
  const double facing = glm::dot(seen.facing, l), shading = glm::dot(seen.shading, l);
  Verdict verdict{false, std::min(std::abs(facing), std::abs(shading)) < kGrazing};
  if (!(facing > 0 && shading > 0 && reaches(light, to_light))) return verdict;

  // Rounding of coordinates in double may place the point below its surface by this much.
  const glm::dvec3 size =
      glm::max(glm::abs(seen.point), glm::abs(directional ? seen.point : light.position.v));
  const double free = 256 * 0x1p-53 * std::max({size.x, size.y, size.z});
  const glm::dvec3 start = seen.point + seen.facing * free;
  const Ray ray{start, directional ? to_light : light.position.v - start};
  const double end = directional ? 1.0 / 0.0 : 1 - free / glm::length(to_light);
  verdict.lit = !surfaces.blocked(ray, end);
  return verdict;
}

/// Whether the surface of `a` continues at `b`.
bool continues(const Surface& a, const Surface& b) {
  if (!a.covered && !b.covered) return true;
  if (a.covered != b.covered || a.instance != b.instance) return false;
  const glm::dvec3 step = b.point - a.point;
  return std::abs(glm::dot(step, a.facing)) <= 0.5 * glm::length(step);
}

constexpr std::array<glm::dvec2, 4> kBandCorners{
    glm::dvec2(-kBandRadius_px, -kBandRadius_px), glm::dvec2(kBandRadius_px, -kBandRadius_px),
    glm::dvec2(-kBandRadius_px, kBandRadius_px), glm::dvec2(kBandRadius_px, kBandRadius_px)};

}  // namespace

Masks trace(const Scene& scene, const SceneState& state, const View& view, Search search) {
  const Surfaces surfaces(scene, state, search);
  const std::vector<Light>& lights = state.light_set.lights;
  Masks masks{view.size, static_cast<std::uint32_t>(lights.size()), {}, {}, {}};
  masks.covered.resize(view.size.pixels());
  masks.lit.resize(view.size.pixels() * lights.size());
  masks.in_band.resize(masks.lit.size());
  const FovTangents window = tangents_of(view.fov);
  const auto see_at = [&](const glm::dvec2& pixel) {
    const Vector<Eye> toward{pixel_ray(window, view.size, pixel)};
    return see(surfaces, {view.stage_from_eye.translation, view.stage_from_eye(toward).v});
  };
  for (std::uint32_t y = 0; y < view.size.height; ++y)
    for (std::uint32_t x = 0; x < view.size.width; ++x) {
      const glm::dvec2 centre(x + 0.5, y + 0.5);
      const Surface seen = see_at(centre);
      masks.covered[masks.pixel(x, y)] = seen.covered;
      std::array<Surface, 4> around;
      for (std::size_t i = 0; i < around.size(); ++i) around[i] = see_at(centre + kBandCorners[i]);
      for (std::uint32_t i = 0; i < masks.lights; ++i) {
        const Verdict verdict = judge(surfaces, seen, lights[i]);
        const bool steady = std::all_of(around.begin(), around.end(), [&](const Surface& corner) {
          return continues(seen, corner) && judge(surfaces, corner, lights[i]).lit == verdict.lit;
        });
        masks.lit[masks.at(x, y, i)] = verdict.lit;
        masks.in_band[masks.at(x, y, i)] = verdict.grazing || !steady;
      }
    }
  return masks;
}

Agreement compare(const EyeMask& mask, const Masks& truth) {
  check(mask.size() == truth.size && mask.lights() == truth.lights, "both masks have the same shape");
  Agreement result;
  for (std::uint32_t y = 0; y < truth.size.height; ++y)
    for (std::uint32_t x = 0; x < truth.size.width; ++x)
      for (std::uint32_t i = 0; i < truth.lights; ++i) {
        const std::size_t at = truth.at(x, y, i);
        const bool lit = truth.lit[at] != 0, differs = mask.lit(x, y, i) != lit;
        ++result.pixel_lights;
        result.lit += lit;
        result.in_band += truth.in_band[at];
        if (truth.in_band[at]) {
          result.wrong_in_band += differs;
        } else if (differs) {
          ++result.wrong;
          result.wrong_x = x, result.wrong_y = y, result.wrong_light = i;
        }
      }
  return result;
}

}  // namespace farshade::oracle
