#include "stereo/placement/surroundings.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <optional>

#include "stereo/plan/scene_plan.h"
#include "stereo/tracer/ray_scene.h"

namespace farshade {
namespace {

constexpr int kLanes = 4;
constexpr int kMostBacks = 16;
/// A ray starts anew behind a back at this multiple of the back's distance.
constexpr float kBehind = 1 + 1e-5f;

/// Rays meet both sides, and nothing moves.
TracePlan plan_of(const Scene& scene) {
  TracePlan plan = plan_for(scene, {.surround = false, .all_lights = true}).trace;
  for (SurfaceNeeds& needs : plan.surfaces) needs.back_test = false;
  plan.moves.assign(plan.moves.size(), false);
  return plan;
}

}  // namespace

struct Surroundings::Impl {
  Bounds bounds;
  SurfaceModel model;
  std::optional<RayScene> rays;

  explicit Impl(const Scene& scene)
      : bounds(scene.bounds), model(scene, state_at(scene, Time{}), plan_of(scene)) {}

  /// Traces the rays [begin, begin + kLanes) beyond the distances in `met`.
  void trace(std::span<const Ray> rays_in, std::size_t begin, std::span<const std::size_t> numbers,
             std::span<Met> met) const;
  [[nodiscard]] Met::Side side_of(const RayHitPacket<kLanes>& packet, int lane) const;
  void trace_all(std::span<const Ray> rays_in, std::span<const std::size_t> numbers,
                 std::span<Met> met) const;
};

Met::Side Surroundings::Impl::side_of(const RayHitPacket<kLanes>& packet, int lane) const {
  const auto& [ray, hit] = packet;
  const float along =
      ray.dir_x[lane] * hit.ng_x[lane] + ray.dir_y[lane] * hit.ng_y[lane] + ray.dir_z[lane] * hit.ng_z[lane];
  if (along <= 0) return Met::Side::Front;
  return model.patches()[hit.geometry[lane]].double_sided ? Met::Side::Back : Met::Side::UnseenBack;
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
  for (int i = 0; i < count; ++i) {
    Met& found = met[numbers[begin + static_cast<std::size_t>(i)]];
    found = {};
    if (packet.hit.geometry[i] != kNothing)
      found = {.distance_m = packet.ray.tfar[i], .side = side_of(packet, i)};
  }
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

Expected<Surroundings> Surroundings::create(const Scene& scene) {
  if (scene.triangle_count > kMostTriangles)
    return fail(Fault::OutOfRange,
                fmt::format("{} has {} triangles: whether a head has room is tested up to {} million",
                            scene.name, scene.triangle_count, kMostTriangles / 1'000'000));
  auto impl = std::make_unique<Impl>(scene);
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
