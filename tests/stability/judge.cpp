#include "tests/stability/judge.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <numbers>

#include "stereo/base/quantile.h"
#include "tests/golden/reproject_reference.h"
#include "tests/oracle/oracle.h"
#include "tests/oracle/surfaces.h"
#include "tests/stability/thin.h"

namespace farshade::stability {
namespace {

/// The bound for float reprojection against the same in double: as in
/// tests/golden/reproject_reference_test.cpp, but for sides of more than 4,194 pixels twice the resolution of
/// a float position.
double most_off_double_px(const Dump& dump) {
  const Extent size = dump.traced[0].size;
  return std::max(1e-3, 0x1p-22 * std::max(size.width, size.height));
}
/// The bound for the distance from the true surface: the grid of the rasteriser.
constexpr double kMostOffSurface_px = 1.0 / 256;
/// Rounding to 8 bits, and normals with 16 bits.
constexpr double kMostOffPicture_levels = 2;

struct Wrong {
  std::uint64_t pixel_lights = 0, in_band = 0, shadow = 0, light = 0;
};

void add(const Image<std::uint16_t>& mask, const oracle::Masks& truth, Wrong& wrong) {
  for (std::uint32_t y = 0; y < truth.size.height; ++y)
    for (std::uint32_t x = 0; x < truth.size.width; ++x)
      for (std::uint32_t i = 0; i < std::min(truth.lights, kJudgedLights); ++i) {
        const std::size_t at = truth.at(x, y, i);
        const bool lit = truth.lit[at] != 0, said = (mask.at(x, y) >> i & 1) != 0;
        ++wrong.pixel_lights;
        wrong.in_band += truth.in_band[at];
        if (truth.in_band[at]) continue;
        wrong.shadow += lit && !said;
        wrong.light += said && !lit;
      }
}

std::vector<Figure> figures_of(const Wrong& wrong, const std::string& masks) {
  const auto share = [&](std::uint64_t count) {
    return wrong.pixel_lights == 0
               ? 0.0
               : 100.0 * static_cast<double>(count) / static_cast<double>(wrong.pixel_lights);
  };
  return {{"false shadow " + masks, "%", share(wrong.shadow), 0},
          {"false light " + masks, "%", share(wrong.light), 0},
          {"band " + masks, "%", share(wrong.in_band)}};
}

/// Whether some of the 3x3 pixels around (x, y) has this bit in the oracle, or lies in its band.
bool is_beside(bool lit, const oracle::Masks& truth, std::uint32_t x, std::uint32_t y, std::uint32_t light) {
  for (std::uint32_t v = std::max(y, 1u) - 1; v <= std::min(y + 1, truth.size.height - 1); ++v)
    for (std::uint32_t u = std::max(x, 1u) - 1; u <= std::min(x + 1, truth.size.width - 1); ++u) {
      const std::size_t at = truth.at(u, v, light);
      if (truth.in_band[at] || (truth.lit[at] != 0) == lit) return true;
    }
  return false;
}

/// The surface of a pixel in the oracle.
struct SurfacePoint {
  glm::dvec3 point, normal, base_color;
  Met met;
};

std::optional<SurfacePoint> see(const oracle::Surfaces& surfaces, const View& view, std::uint32_t x,
                                std::uint32_t y) {
  const glm::dvec3 ray = pixel_ray(tangents_of(view.fov), view.size, {x + 0.5, y + 0.5});
  const glm::dvec3 toward = view.stage_from_eye(Vector<Eye>{ray}).v;
  const auto hit = surfaces.nearest({view.stage_from_eye.translation, toward});
  if (!hit) return std::nullopt;
  const oracle::Triangle& t = *hit->triangle;
  const auto mix = [&](const std::array<glm::dvec3, 3>& of) {
    return of[0] * (1 - hit->u - hit->v) + of[1] * hit->u + of[2] * hit->v;
  };
  const double side = t.material->double_sided && glm::dot(toward, t.facing) > 0 ? -1 : 1;
  // The ray has length 1 along -z, so t is the distance along -z.
  return SurfacePoint{mix(t.position),
                      glm::normalize(mix(t.normal)) * side,
                      glm::dvec3(t.material->base_color),
                      {t.position, hit->t}};
}

/// The unshadowed irradiance of `light` at the point (KHR_lights_punctual), times N . L.
glm::dvec3 radiance(const Light& light, const SurfacePoint& point) {
  const bool directional = light.kind == LightKind::Directional;
  const glm::dvec3 to_light = directional ? -light.direction.v : light.position.v - point.point;
  const double distance2 = glm::dot(to_light, to_light);
  const glm::dvec3 l = to_light / std::sqrt(distance2);
  double strength = std::max(glm::dot(point.normal, l), 0.0) / (directional ? 1 : distance2);
  if (light.range_m > 0)
    strength *= std::clamp(1 - std::pow(distance2 / (double{light.range_m} * light.range_m), 2), 0.0, 1.0);
  if (light.kind == LightKind::Spot) {
    const double inner = std::cos(light.inner_cone_rad), outer = std::cos(light.outer_cone_rad);
    const double falloff =
        std::clamp((-glm::dot(light.direction.v, l) - outer) / std::max(0.001, inner - outer), 0.0, 1.0);
    strength *= falloff * falloff;
  }
  return glm::dvec3(light.intensity) * strength;
}

double srgb_level(double linear) {
  const double c = std::clamp(linear, 0.0, 1.0);
  return 255 * (c <= 0.0031308 ? 12.92 * c : 1.055 * std::pow(c, 1 / 2.4) - 0.055);
}

/// The difference of a shown pixel from the formula, in levels; 0 in the oracle's band.
double off_picture(const SurfacePoint& point, const LightSet& lights, const oracle::Masks& truth,
                   std::uint32_t x, std::uint32_t y, const Rgb8& shown) {
  glm::dvec3 irradiance(0.0);
  for (std::uint32_t i = 0; i < truth.lights; ++i) {
    if (truth.in_band[truth.at(x, y, i)]) return 0;
    if (truth.lit[truth.at(x, y, i)]) irradiance += radiance(lights.lights[i], point);
  }
  const glm::dvec3 color = point.base_color * irradiance / std::numbers::pi;
  double off = 0;
  for (int c = 0; c < 3; ++c) off = std::max(off, std::abs(srgb_level(color[c]) - shown[c]));
  return off;
}

void add_spread(std::vector<Figure>& figures, const std::string& name, const std::string& unit,
                std::vector<double> values, double most) {
  const Spread spread = spread_of(values);
  const double largest = values.empty() ? 0 : *std::ranges::max_element(values);
  figures.push_back({name + " p50", unit, spread.median});
  figures.push_back({name + " p99", unit, spread.p99});
  figures.push_back({name + " largest", unit, largest, most});
}

/// All lights of the pixel lie in the band, so the pixel may show another surface.
bool in_doubt(const oracle::Masks& truth, std::uint32_t x, std::uint32_t y) {
  for (std::uint32_t i = 0; i < truth.lights; ++i)
    if (!truth.in_band[truth.at(x, y, i)]) return false;
  return true;
}

}  // namespace

std::vector<Figure> judge_traced(const Scene& scene, const Dump& dump) {
  const SceneState state = state_at(scene, dump.traced_scene_time);
  Wrong wrong;
  for (std::size_t eye = 0; eye < kEyes; ++eye)
    add(dump.eyes[eye].mask_traced, oracle::trace(scene, state, dump.traced[eye]), wrong);
  return figures_of(wrong, "traced");
}

std::vector<Figure> judge_shown(const Scene& scene, const Dump& dump) {
  const SceneState state = state_at(scene, dump.scene_time);
  const oracle::Surfaces surfaces(scene, state, oracle::Search::Tree);
  const std::vector<Corners> triangles = triangles_of(scene, state);
  Wrong wrong;
  double levels = 0, other = 0, distance_off = 0;
  for (std::size_t e = 0; e < kEyes; ++e) {
    const DumpedEye& eye = dump.eyes[e];
    const View& view = dump.shown[e];
    const oracle::Masks truth = oracle::trace(scene, state, view);
    add(eye.mask_shown, truth, wrong);
    for (std::uint32_t y = 0; y < view.size.height; ++y)
      for (std::uint32_t x = 0; x < view.size.width; ++x) {
        const auto surface = see(surfaces, view, x, y);
        const Met* const met = surface ? &surface->met : nullptr;
        if (const double drawn_m = eye.distance_m.at(x, y); is_other(drawn_m, met))
          other += !may_be_seen(drawn_m, met, view, {x + 0.5, y + 0.5}, triangles);
        else if (surface) {
          distance_off = std::max(distance_off, std::abs(drawn_m / met->distance_m - 1));
          levels = std::max(levels, off_picture(*surface, state.light_set, truth, x, y, eye.shown.at(x, y)));
        }
      }
  }
  std::vector<Figure> figures = figures_of(wrong, "shown");
  figures.push_back({"other surface drawn", "pixels", other, 0});
  figures.push_back({"distance off", "%", 100 * distance_off});
  figures.push_back({"picture off", "levels", levels, kMostOffPicture_levels});
  return figures;
}

std::vector<Figure> judge_reprojected(const Scene& scene, const Dump& dump) {
  const SceneState state = state_at(scene, dump.scene_time);
  std::uint64_t pixel_lights = 0, wrong = 0;
  for (std::size_t eye = 0; eye < kEyes; ++eye) {
    const oracle::Masks truth = oracle::trace(scene, state, dump.shown[eye]);
    for (std::uint32_t y = 0; y < truth.size.height; ++y)
      for (std::uint32_t x = 0; x < truth.size.width; ++x)
        for (std::uint32_t i = 0; i < std::min(truth.lights, kJudgedLights); ++i, ++pixel_lights)
          wrong += !is_beside((dump.eyes[eye].mask_shown.at(x, y) >> i & 1) != 0, truth, x, y, i);
  }
  const double share =
      static_cast<double>(wrong) / static_cast<double>(std::max<std::uint64_t>(pixel_lights, 1));
  return {{"wrong, carried", "%", 100 * share, 0}};
}

std::vector<Figure> judge_lookup(const Scene& scene, const Dump& dump) {
  const SceneState state = state_at(scene, dump.scene_time);
  const oracle::Surfaces surfaces(scene, state, oracle::Search::Tree);
  std::vector<double> off_double, off_surface;
  for (std::size_t e = 0; e < kEyes; ++e) {
    const DumpedEye& eye = dump.eyes[e];
    const View &view = dump.shown[e], &traced = dump.traced[e];
    const oracle::Masks truth = oracle::trace(scene, state, view);
    const EyeDepth eye_depth{view, eye.distance_m};
    for (std::uint32_t y = 0; y < view.size.height; ++y)
      for (std::uint32_t x = 0; x < view.size.width; ++x) {
        if (eye.source.at(x, y) != 0) continue;  // not from the newest mask that was traced for this eye
        const glm::dvec2 at(eye.lookup_x.at(x, y), eye.lookup_y.at(x, y));
        const std::optional<ReprojectedPixel> reprojected = reproject(eye_depth, x, y, traced);
        off_double.push_back(reprojected ? glm::length(reprojected->at - at) : HUGE_VAL);
        if (in_doubt(truth, x, y)) continue;
        const auto surface = see(surfaces, view, x, y);
        if (!surface || is_other(eye.distance_m.at(x, y), &surface->met)) continue;  // judged in judge_shown
        const glm::dvec3 p = inverse(traced.stage_from_eye)(Point<Stage>{surface->point}).v;
        if (p.z < 0)
          off_surface.push_back(glm::length(ray_pixel(tangents_of(traced.fov), traced.size, p) - at));
      }
  }
  std::vector<Figure> figures{{"looked up", "pixels", static_cast<double>(off_double.size())}};
  add_spread(figures, "reprojection", "px", off_double, most_off_double_px(dump));
  add_spread(figures, "surface", "px", off_surface, kMostOffSurface_px);
  return figures;
}

}  // namespace farshade::stability
