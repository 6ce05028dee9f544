#include "stereo/placement/surroundings.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <glm/geometric.hpp>
#include <optional>

#include "stereo/plan/scene_plan.h"
#include "stereo/scene/sky.h"
#include "stereo/tracer/ray_scene.h"

namespace farshade {
namespace {

constexpr int kLanes = 4;
constexpr int kMostBacks = 16;
/// A ray starts anew behind a back at this multiple of the back's distance: more than the rounding of a
/// distance. Any share from 1e-6 to 1e-4 would do.
constexpr float kBehind = 1 + 1e-5f;

/// The scene at time 0 without its sky: an instance with a singular transform does not exist.
SceneState state_without_sky(const Scene& scene, const std::vector<std::uint32_t>& without) {
  SceneState state = state_at(scene, Time{});
  for (std::uint32_t i = 0; i < scene.instances.size(); ++i)
    if (!scene.instances[i].casts || std::ranges::count(without, i) > 0)
      state.stage_from_object[i].matrix = glm::dmat4(0.0);
  return state;
}

/// Rays meet both sides, and nothing moves.
TracePlan plan_of(const Scene& scene) {
  TracePlan plan = plan_for(scene, {.cube_mask = false, .all_lights = true}).trace;
  for (SurfaceNeeds& needs : plan.surfaces) needs.back_test = false;
  plan.moves.assign(plan.moves.size(), false);
  return plan;
}

}  // namespace

struct Surroundings::Impl {
  Bounds bounds;
  SurfaceModel model;
  std::optional<RayScene> rays;

  Impl(const Scene& scene, const std::vector<std::uint32_t>& without)
      : bounds(bounds_without_sky(scene)), model(scene, state_without_sky(scene, without), plan_of(scene)) {}

  /// Traces the rays [begin, begin + kLanes) beyond the distances in `met`.
  void trace(std::span<const Ray> rays_in, std::size_t begin, std::span<const std::size_t> numbers,
             std::span<Met> met) const;
  [[nodiscard]] Met met_at(const RayHitPacket<kLanes>& packet, int lane) const;
  void trace_all(std::span<const Ray> rays_in, std::span<const std::size_t> numbers,
                 std::span<Met> met) const;
};

Met Surroundings::Impl::met_at(const RayHitPacket<kLanes>& packet, int lane) const {
  const auto& [ray, hit] = packet;
  if (hit.geometry[lane] == kNothing) return {};
  const Patch& patch = model.patches()[hit.geometry[lane]];
  const glm::dvec3 direction(ray.dir_x[lane], ray.dir_y[lane], ray.dir_z[lane]);
  const glm::dvec3 normal(hit.ng_x[lane], hit.ng_y[lane], hit.ng_z[lane]);
  const double size = glm::length(normal);
  Met met{.distance_m = ray.tfar[lane], .instance = patch.instance};
  met.normal.v = size > 0 ? normal / size : -direction;
  if (glm::dot(direction, normal) > 0)
    met.side = patch.double_sided ? Met::Side::Back : Met::Side::UnseenBack;
  return met;
}

void Surroundings::Impl::trace(std::span<const Ray> rays_in, std::size_t begin,
                               std::span<const std::size_t> numbers, std::span<Met> met) const {
  Lanes<kLanes> lanes{};
  RayHitPacket<kLanes> packet{};
  set_constants(packet.ray);
  const int count = static_cast<int>(std::min<std::size_t>(kLanes, numbers.size() - begin));
  for (int i = 0; i < kLanes; ++i) {
    const std::size_t number = numbers[begin + static_cast<std::size_t>(std::min(i, count - 1))];
    const Ray& ray = rays_in[number];
    const glm::vec3 origin(model.anchor_from_stage()(ray.origin).v), direction(ray.direction.v);
    lanes.valid[i] = i < count ? -1 : 0;
    packet.ray.org_x[i] = origin.x, packet.ray.org_y[i] = origin.y, packet.ray.org_z[i] = origin.z;
    packet.ray.dir_x[i] = direction.x, packet.ray.dir_y[i] = direction.y, packet.ray.dir_z[i] = direction.z;
    const bool starts = met[number].distance_m == kNoSurface_m;
    packet.ray.tnear[i] = starts ? 0 : static_cast<float>(met[number].distance_m) * kBehind;
    packet.ray.tfar[i] = kFar;
  }
  rays->intersect(lanes, packet);
  for (int i = 0; i < count; ++i) met[numbers[begin + static_cast<std::size_t>(i)]] = met_at(packet, i);
}

void Surroundings::Impl::trace_all(std::span<const Ray> rays_in, std::span<const std::size_t> numbers,
                                   std::span<Met> met) const {
  const std::size_t packets = (numbers.size() + kLanes - 1) / kLanes;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, packets, 64), [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) trace(rays_in, i * kLanes, numbers, met);
  });
}

Surroundings::Surroundings(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Surroundings::Surroundings(Surroundings&&) noexcept = default;
Surroundings& Surroundings::operator=(Surroundings&&) noexcept = default;
Surroundings::~Surroundings() = default;

Expected<Surroundings> Surroundings::create(const Scene& scene, const SurroundingsOptions& options) {
  if (scene.triangle_count > options.most_triangles)
    return fail(Fault::OutOfRange,
                fmt::format("{} has {} triangles: whether a head has room is tested up to {} million",
                            scene.name, scene.triangle_count, options.most_triangles / 1'000'000));
  auto impl = std::make_unique<Impl>(scene, options.without);
  Expected<RayScene> rays = RayScene::create(impl->model, RayScene::Built::Quickly);
  if (!rays) return tl::unexpected(rays.error());
  impl->rays.emplace(std::move(*rays));
  return Surroundings(std::move(impl));
}

const Bounds& Surroundings::bounds() const {
  return impl_->bounds;
}

std::vector<Met> Surroundings::first_met(std::span<const Ray> rays) const {
  std::vector<Met> met(rays.size());
  std::vector<std::size_t> numbers(rays.size());
  for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = i;
  impl_->trace_all(rays, numbers, met);
  return met;
}

std::vector<Met> Surroundings::first_seen(std::span<const Ray> rays) const {
  std::vector<Met> met = first_met(rays);
  std::vector<std::size_t> numbers;
  for (int backs = 0; backs <= kMostBacks; ++backs) {
    numbers.clear();
    for (std::size_t i = 0; i < met.size(); ++i)
      if (met[i].side == Met::Side::UnseenBack) numbers.push_back(i);
    if (numbers.empty()) return met;
    impl_->trace_all(rays, numbers, met);
  }
  for (const std::size_t i : numbers)
    if (met[i].side == Met::Side::UnseenBack) met[i] = {};
  return met;
}

}  // namespace farshade
