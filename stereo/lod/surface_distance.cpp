#include "stereo/lod/surface_distance.h"

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <algorithm>
#include <limits>

#include "stereo/base/check.h"

namespace farshade {
namespace {

/// One device for all queries; Embree counts references.
RTCDevice shared_device() {
  static const std::unique_ptr<RTCDeviceTy, decltype(&rtcReleaseDevice)> device(rtcNewDevice(nullptr),
                                                                                rtcReleaseDevice);
  return device.get();
}

RTCScene make_scene(std::span<const glm::vec3> positions, std::span<const glm::uvec3> triangles) {
  RTCDevice device = shared_device();
  check(device != nullptr, "Embree makes a device");
  RTCScene scene = rtcNewScene(device);
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  // Embree reads 16 bytes at each vertex, so it gets copies that it pads itself.
  auto* vertices = static_cast<glm::vec3*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(glm::vec3), positions.size()));
  auto* indices = static_cast<glm::uvec3*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, sizeof(glm::uvec3), triangles.size()));
  check(vertices != nullptr && indices != nullptr, "Embree allocates the triangles");
  std::ranges::copy(positions, vertices);
  std::ranges::copy(triangles, indices);
  rtcSetGeometryBuildQuality(geometry, RTC_BUILD_QUALITY_LOW);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_LOW);
  rtcCommitScene(scene);
  return scene;
}

}  // namespace

void ReleaseEmbreeScene::operator()(RTCSceneTy* scene) const {
  rtcReleaseScene(scene);
}

glm::vec3 nearest_weights(const glm::vec3& p, const glm::vec3& a, const glm::vec3& b, const glm::vec3& c) {
  const glm::vec3 ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  const float d1 = glm::dot(ab, ap), d2 = glm::dot(ac, ap);
  if (d1 <= 0 && d2 <= 0) return {1, 0, 0};
  const float d3 = glm::dot(ab, bp), d4 = glm::dot(ac, bp);
  if (d3 >= 0 && d4 <= d3) return {0, 1, 0};
  const float vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return {1 - d1 / (d1 - d3), d1 / (d1 - d3), 0};
  const float d5 = glm::dot(ab, cp), d6 = glm::dot(ac, cp);
  if (d6 >= 0 && d5 <= d6) return {0, 0, 1};
  const float vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return {1 - d2 / (d2 - d6), 0, d2 / (d2 - d6)};
  const float va = d3 * d6 - d5 * d4, towards_c = d4 - d3, towards_b = d5 - d6;
  if (va <= 0 && towards_c >= 0 && towards_b >= 0)
    return {0, 1 - towards_c / (towards_c + towards_b), towards_c / (towards_c + towards_b)};
  const float sum = va + vb + vc;
  if (!(sum > 0)) return {1, 0, 0};  // the triangle is a line or a point
  return {va / sum, vb / sum, vc / sum};
}

/// The state of one point query.
struct SurfaceDistance::Query {
  const SurfaceDistance& surface;
  glm::vec3 p;
  float enough;
  NearestPoint best;

  static bool visit(RTCPointQueryFunctionArguments* arguments) {
    Query& query = *static_cast<Query*>(arguments->userPtr);
    const glm::uvec3& t = query.surface.triangles_[arguments->primID];
    const std::span<const glm::vec3> at = query.surface.positions_;
    const glm::vec3 weights = nearest_weights(query.p, at[t.x], at[t.y], at[t.z]);
    const float distance =
        glm::length(at[t.x] * weights.x + at[t.y] * weights.y + at[t.z] * weights.z - query.p);
    if (!(distance < query.best.distance)) return false;
    query.best = {distance, arguments->primID, weights};
    arguments->query->radius = distance <= query.enough ? 0 : distance;
    return true;
  }
};

SurfaceDistance::SurfaceDistance(std::span<const glm::vec3> positions, std::span<const glm::uvec3> triangles)
    : positions_(positions), triangles_(triangles), scene_(make_scene(positions, triangles)) {}

/// Searches within a radius that grows until a point is found.
NearestPoint SurfaceDistance::search(const glm::vec3& p, float enough, float guess) const {
  constexpr float kGrowth = 4, kLeast = 1e-30f;
  for (float radius = std::max({enough, guess, kLeast}) * 1.001f;; radius *= kGrowth) {
    const bool last = !(radius < 1e30f);
    if (last) radius = std::numeric_limits<float>::infinity();
    Query query{*this, p, enough, {radius, 0, {}}};
    RTCPointQuery point{.x = p.x, .y = p.y, .z = p.z, .time = 0, .radius = radius};
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    rtcPointQuery(scene_.get(), &point, &context, &Query::visit, &query);
    if (query.best.distance < radius || last) return query.best;
  }
}

NearestPoint SurfaceDistance::nearest(const glm::vec3& p, float guess) const {
  return search(p, 0, guess);
}

float SurfaceDistance::distance_above(const glm::vec3& p, float enough, float guess) const {
  return search(p, enough, guess).distance;
}

}  // namespace farshade
