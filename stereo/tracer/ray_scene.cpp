#include "stereo/tracer/ray_scene.h"

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <sys/types.h>

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <type_traits>

#include "stereo/base/check.h"

namespace farshade {
namespace {

template <auto Release>
struct Releaser {
  template <class Handle>
  void operator()(Handle* handle) const {
    Release(handle);
  }
};
using Device = std::unique_ptr<std::remove_pointer_t<RTCDevice>, Releaser<rtcReleaseDevice>>;
using SceneHandle = std::unique_ptr<std::remove_pointer_t<RTCScene>, Releaser<rtcReleaseScene>>;
using Geometry = std::unique_ptr<std::remove_pointer_t<RTCGeometry>, Releaser<rtcReleaseGeometry>>;

// The two calls in which Embree 3 and 4 differ. All packets are coherent, but Embree is told so only for the
// scene without instances: in Debian 12's Embree 3.13.5, a coherent rtcOccluded16 into an instance never
// returns.
enum class Coherence { Coherent, Undeclared };

#if RTC_VERSION_MAJOR >= 4
template <auto Call, class Packet>
void intersect_in(RTCScene scene, Coherence coherence, const int* valid, Packet* packet) {
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  if (coherence == Coherence::Coherent) arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
  Call(valid, scene, packet, &arguments);
}
template <auto Call, class Packet>
void occluded_in(RTCScene scene, Coherence coherence, const int* valid, Packet* packet) {
  RTCOccludedArguments arguments;
  rtcInitOccludedArguments(&arguments);
  if (coherence == Coherence::Coherent) arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
  Call(valid, scene, packet, &arguments);
}
#else
template <auto Call, class Packet>
void intersect_in(RTCScene scene, Coherence coherence, const int* valid, Packet* packet) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  if (coherence == Coherence::Coherent) context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  Call(valid, scene, &context, packet);
}
template <auto Call, class Packet>
void occluded_in(RTCScene scene, Coherence coherence, const int* valid, Packet* packet) {
  intersect_in<Call>(scene, coherence, valid, packet);
}
#endif

static_assert(sizeof(RayPacket<16>) == sizeof(RTCRay16) && sizeof(RayPacket<4>) == sizeof(RTCRay4));
static_assert(offsetof(RayPacket<16>, dir_x) == offsetof(RTCRay16, dir_x));
static_assert(offsetof(RayPacket<16>, tfar) == offsetof(RTCRay16, tfar));
static_assert(offsetof(RayPacket<16>, flags) == offsetof(RTCRay16, flags));
static_assert(sizeof(RayHitPacket<16>) >= sizeof(RTCRayHit16) &&
              sizeof(RayHitPacket<4>) >= sizeof(RTCRayHit4));
static_assert(offsetof(HitPacket<16>, u) == offsetof(RTCHit16, u));
static_assert(offsetof(HitPacket<16>, primitive) == offsetof(RTCHit16, primID));
static_assert(offsetof(HitPacket<16>, geometry) == offsetof(RTCHit16, geomID));
static_assert(offsetof(HitPacket<16>, instance) == offsetof(RTCHit16, instID));
static_assert(kNothing == RTC_INVALID_GEOMETRY_ID);

/// User data of a geometry for its filter functions.
struct FilterData {
  const Patch* patch;
  std::span<const glm::uvec3> triangles;

  [[nodiscard]] bool is_hole(const RTCFilterFunctionNArguments& a, unsigned i) const {
    const glm::uvec3 vertices = triangles[RTCHitN_primID(a.hit, a.N, i)] - patch->first_vertex;
    return patch->holes->is_hole(vertices, RTCHitN_u(a.hit, a.N, i), RTCHitN_v(a.hit, a.N, i));
  }
};

/// Ray and normal are both in the patch's own space here, so the sign of its transform's determinant does not
/// matter.
bool is_back(const RTCFilterFunctionNArguments& a, unsigned i) {
  const unsigned n = a.N;
  return RTCRayN_dir_x(a.ray, n, i) * RTCHitN_Ng_x(a.hit, n, i) +
             RTCRayN_dir_y(a.ray, n, i) * RTCHitN_Ng_y(a.hit, n, i) +
             RTCRayN_dir_z(a.ray, n, i) * RTCHitN_Ng_z(a.hit, n, i) >
         0;
}

enum class Pass { Holes, Backs, Both };

/// Filter function: lets rays pass through holes and, for primary rays, through back faces.
template <Pass What>
void pass_filter(const RTCFilterFunctionNArguments* arguments) {
  const auto& data = *static_cast<const FilterData*>(arguments->geometryUserPtr);
  const bool single = !data.patch->double_sided;
  for (unsigned i = 0; i < arguments->N; ++i) {
    if (arguments->valid[i] != -1) continue;
    const bool passes = (What != Pass::Holes && single && is_back(*arguments, i)) ||
                        (What != Pass::Backs && data.is_hole(*arguments, i));
    if (passes) arguments->valid[i] = 0;
  }
}

/// Filter function: shadow rays pass what casts no shadow.
void pass_all(const RTCFilterFunctionNArguments* arguments) {
  std::fill_n(arguments->valid, arguments->N, 0);
}

void set_filters(RTCGeometry geometry, FilterData& data) {
  const bool holes = data.patch->holes.has_value(), backs = data.patch->back_test;
  rtcSetGeometryUserData(geometry, &data);
  if (holes) rtcSetGeometryOccludedFilterFunction(geometry, pass_filter<Pass::Holes>);
  if (holes && backs) rtcSetGeometryIntersectFilterFunction(geometry, pass_filter<Pass::Both>);
  if (holes && !backs) rtcSetGeometryIntersectFilterFunction(geometry, pass_filter<Pass::Holes>);
  if (!holes && backs) rtcSetGeometryIntersectFilterFunction(geometry, pass_filter<Pass::Backs>);
  if (!data.patch->casts) rtcSetGeometryOccludedFilterFunction(geometry, pass_all);
}

SceneHandle new_scene(RTCDevice device, RTCSceneFlags flags, RTCBuildQuality quality) {
  SceneHandle scene(rtcNewScene(device));
  rtcSetSceneFlags(scene.get(), flags);
  rtcSetSceneBuildQuality(scene.get(), quality);
  return scene;
}

template <int K>
void intersect_in(RTCScene scene, Coherence coherence, const Lanes<K>& lanes, RayHitPacket<K>& packet) {
  void* const rays = &packet;
  if constexpr (K == 16)
    intersect_in<rtcIntersect16>(scene, coherence, lanes.valid, static_cast<RTCRayHit16*>(rays));
  else if constexpr (K == 8)
    intersect_in<rtcIntersect8>(scene, coherence, lanes.valid, static_cast<RTCRayHit8*>(rays));
  else
    intersect_in<rtcIntersect4>(scene, coherence, lanes.valid, static_cast<RTCRayHit4*>(rays));
}

template <int K>
void occluded_in(RTCScene scene, Coherence coherence, const Lanes<K>& lanes, RayPacket<K>& packet) {
  void* const rays = &packet;
  if constexpr (K == 16)
    occluded_in<rtcOccluded16>(scene, coherence, lanes.valid, static_cast<RTCRay16*>(rays));
  else if constexpr (K == 8)
    occluded_in<rtcOccluded8>(scene, coherence, lanes.valid, static_cast<RTCRay8*>(rays));
  else
    occluded_in<rtcOccluded4>(scene, coherence, lanes.valid, static_cast<RTCRay4*>(rays));
}

/// Counts Embree's memory. The device calls `note` from any thread.
struct MemoryCounter {
  std::atomic<std::ptrdiff_t> bytes{0}, peak{0};

  static bool note(void* self, ssize_t change, bool /*post*/) {
    auto& counter = *static_cast<MemoryCounter*>(self);
    const std::ptrdiff_t now = counter.bytes += change;
    std::ptrdiff_t most = counter.peak;
    while (now > most && !counter.peak.compare_exchange_weak(most, now)) {
    }
    return true;
  }
};

}  // namespace

/// Consecutive patches.
struct PatchRange {
  std::uint32_t first = 0, count = 0;
};

/// Patches that move together: one, or all of a rig.
struct Mover {
  std::vector<PatchRange> geometries;  ///< of `scene`, by number
  SceneHandle scene;
  Geometry instance;               ///< of `scene`
  std::vector<Geometry> deformed;  ///< the geometries of a rig; empty without one
};

/// Calls act(run) for each longest run of patches that are `alike` their neighbours.
template <class Alike, class Act>
void for_each_run(PatchRange patches, Alike alike, Act act) {
  const std::uint32_t end = patches.first + patches.count;
  for (std::uint32_t first = patches.first, next = first; first < end; first = next) {
    for (++next; next < end && alike(next - 1, next);) ++next;
    act(PatchRange{first, next - first});
  }
}

struct RayScene::Impl {
  const SurfaceModel& model;
  MemoryCounter memory;  ///< before the device, which calls it until the device is destroyed
  Device device{rtcNewDevice(nullptr)};
  std::vector<FilterData> filter_data;  ///< one per patch; Embree keeps their addresses
  SceneHandle fixed;
  SceneHandle moving;  ///< the instances of `movers`; null if nothing moves
  std::vector<Mover> movers;
  int width = 4;
  RTCBuildQuality quality = RTC_BUILD_QUALITY_HIGH;  ///< of what does not deform

  explicit Impl(const SurfaceModel& surfaces) : model(surfaces) {}

  void build();
  bool is_point(PatchRange patches) const;
  Geometry attach_patches(RTCScene scene, PatchRange patches, unsigned id, RTCBuildQuality built);
  Geometry attach_instance(RTCScene of, unsigned id);
  void add_mover(PatchRange patches);
  void name_patch(unsigned instance, unsigned& geometry, unsigned& primitive) const;
  void place(const Mover& mover);
  void update();
};

/// Whether all corners of the triangles are one point, which no ray meets. Embree's quick builder asserts
/// that the geometries of a node are not all at one point.
bool RayScene::Impl::is_point(PatchRange patches) const {
  const Patch &first = model.patches()[patches.first],
              &last = model.patches()[patches.first + patches.count - 1];
  const auto triangles = model.triangles().subspan(
      first.first_triangle, last.first_triangle + last.triangle_count - first.first_triangle);
  const auto positions = model.positions();
  const auto is_there = [&](std::uint32_t v) { return positions[v] == positions[triangles.front().x]; };
  return std::ranges::all_of(
      triangles, [&](const glm::uvec3& t) { return is_there(t.x) && is_there(t.y) && is_there(t.z); });
}

/// One geometry of all `patches`, whose triangles follow one another.
Geometry RayScene::Impl::attach_patches(RTCScene scene, PatchRange patches, unsigned id,
                                        RTCBuildQuality built) {
  Geometry geometry(rtcNewGeometry(device.get(), RTC_GEOMETRY_TYPE_TRIANGLE));
  rtcSetGeometryBuildQuality(geometry.get(), built);
  const Patch &first = model.patches()[patches.first],
              &last = model.patches()[patches.first + patches.count - 1];
  const std::size_t triangles = last.first_triangle + last.triangle_count - first.first_triangle;
  const auto positions = model.positions();
  rtcSetSharedGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, positions.data(),
                             0, sizeof(glm::vec3), positions.size() - 1);
  rtcSetSharedGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                             model.triangles().data() + first.first_triangle, 0, sizeof(glm::uvec3),
                             triangles);
  set_filters(geometry.get(), filter_data[patches.first]);
  if (is_point(patches)) rtcDisableGeometry(geometry.get());
  rtcCommitGeometry(geometry.get());
  rtcAttachGeometryByID(scene, geometry.get(), id);
  return geometry;
}

Geometry RayScene::Impl::attach_instance(RTCScene of, unsigned id) {
  Geometry instance(rtcNewGeometry(device.get(), RTC_GEOMETRY_TYPE_INSTANCE));
  rtcSetGeometryInstancedScene(instance.get(), of);
  rtcCommitGeometry(instance.get());
  rtcAttachGeometryByID(moving.get(), instance.get(), id);
  return instance;
}

void RayScene::Impl::build() {
  const auto patches = model.patches();
  filter_data.reserve(patches.size());
  for (const Patch& patch : patches)
    filter_data.push_back({&patch, model.triangles().subspan(patch.first_triangle, patch.triangle_count)});

  fixed = new_scene(device.get(), RTC_SCENE_FLAG_ROBUST, quality);
  for (unsigned i = 0; i < model.fixed_count(); ++i) attach_patches(fixed.get(), {i, 1}, i, quality);
  rtcCommitScene(fixed.get());
  if (model.fixed_count() == patches.size()) return;

  moving = new_scene(device.get(), RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_DYNAMIC, RTC_BUILD_QUALITY_MEDIUM);
  for_each_run(
      PatchRange{narrow<std::uint32_t>(model.fixed_count()),
                 narrow<std::uint32_t>(patches.size() - model.fixed_count())},
      [&](std::uint32_t a, std::uint32_t b) { return patches[a].rig && patches[a].rig == patches[b].rig; },
      [&](PatchRange of_rig) { add_mover(of_rig); });
  update();
}

/// Patches of a rig whose rays need the same filter are one geometry, so that one hierarchy without overlaps
/// holds them. Embree refits it.
void RayScene::Impl::add_mover(PatchRange patches) {
  const auto all = model.patches();
  const bool deforms = all[patches.first].rig.has_value();
  const auto flags = deforms ? RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_DYNAMIC : RTC_SCENE_FLAG_ROBUST;
  Mover mover{.geometries = {},
              .scene = new_scene(device.get(), flags, deforms ? RTC_BUILD_QUALITY_LOW : quality),
              .instance = nullptr,
              .deformed = {}};
  const auto same_filter = [&](std::uint32_t a, std::uint32_t b) {
    return !all[a].holes && !all[b].holes && all[a].back_test == all[b].back_test &&
           all[a].casts == all[b].casts;
  };
  for_each_run(patches, same_filter, [&](PatchRange run) {
    Geometry geometry = attach_patches(mover.scene.get(), run, narrow<unsigned>(mover.geometries.size()),
                                       deforms ? RTC_BUILD_QUALITY_REFIT : quality);
    mover.geometries.push_back(run);
    if (deforms) mover.deformed.push_back(std::move(geometry));
  });
  rtcCommitScene(mover.scene.get());
  mover.instance = attach_instance(mover.scene.get(), narrow<unsigned>(movers.size()));
  movers.push_back(std::move(mover));
}

void RayScene::Impl::place(const Mover& mover) {
  const Placement& placement = model.patches()[mover.geometries.front().first].placement;
  RTCGeometry instance = mover.instance.get();
  if (placement.singular) {
    rtcDisableGeometry(instance);
    return;
  }
  for (std::size_t i = 0; i < mover.deformed.size(); ++i) {
    const Geometry& geometry = mover.deformed[i];
    is_point(mover.geometries[i]) ? rtcDisableGeometry(geometry.get()) : rtcEnableGeometry(geometry.get());
    rtcUpdateGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_VERTEX, 0);
    rtcCommitGeometry(geometry.get());
  }
  if (!mover.deformed.empty()) rtcCommitScene(mover.scene.get());
  const glm::mat3& m = placement.linear;
  const std::array<glm::vec3, 4> columns{m[0], m[1], m[2], placement.translation.v};
  rtcSetGeometryTransform(instance, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, columns.data());
  rtcEnableGeometry(instance);
  rtcCommitGeometry(instance);
}

void RayScene::Impl::update() {
  for (const Mover& mover : movers) place(mover);
  if (moving) rtcCommitScene(moving.get());
}

/// Turns Embree's numbers of a hit into the number of the patch and of the triangle in it.
void RayScene::Impl::name_patch(unsigned instance, unsigned& geometry, unsigned& primitive) const {
  const PatchRange range = movers[instance].geometries[geometry];
  const auto patches = model.patches().subspan(range.first, range.count);
  const std::uint32_t triangle = patches.front().first_triangle + primitive;
  const auto next = std::ranges::upper_bound(patches, triangle, {}, &Patch::first_triangle);
  geometry = range.first + narrow<unsigned>(next - patches.begin()) - 1;
  primitive = triangle - std::prev(next)->first_triangle;
}

Expected<RayScene> RayScene::create(const SurfaceModel& model, Built built) {
  auto impl = std::make_unique<Impl>(model);
  RTCDevice device = impl->device.get();
  if (device == nullptr)
    return fail(Fault::Unavailable, "Embree has no device on this machine (error " +
                                        std::to_string(rtcGetDeviceError(nullptr)) + ").");
  if (rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED)) impl->width = 8;
  if (rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED)) impl->width = 16;
  rtcSetDeviceMemoryMonitorFunction(device, MemoryCounter::note, &impl->memory);
  impl->quality = built == Built::Well ? RTC_BUILD_QUALITY_HIGH : RTC_BUILD_QUALITY_LOW;
  impl->build();
  if (const RTCError error = rtcGetDeviceError(device); error != RTC_ERROR_NONE)
    return fail(Fault::Unavailable,
                "Embree could not build the scene (error " + std::to_string(error) + ").");
  return RayScene(std::move(impl));
}

RayScene::RayScene(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
RayScene::RayScene(RayScene&&) noexcept = default;
RayScene& RayScene::operator=(RayScene&&) noexcept = default;
RayScene::~RayScene() = default;

void RayScene::update() {
  impl_->update();
  if (const RTCError error = rtcGetDeviceError(impl_->device.get()); error != RTC_ERROR_NONE)
    throw std::runtime_error("Embree could not move the scene (error " + std::to_string(error) + ")");
}
std::size_t RayScene::bytes() const {
  return static_cast<std::size_t>(impl_->memory.bytes.load());
}
std::size_t RayScene::peak_bytes() const {
  return static_cast<std::size_t>(impl_->memory.peak.load());
}
int RayScene::width() const {
  return impl_->width;
}

template <int K>
void RayScene::intersect(const Lanes<K>& lanes, RayHitPacket<K>& packet) const {
  HitPacket<K>& hit = packet.hit;
  for (int i = 0; i < K; ++i) hit.geometry[i] = hit.instance[i] = kNothing;
  intersect_in<K>(impl_->fixed.get(), Coherence::Coherent, lanes, packet);
  if (!impl_->moving) return;
  intersect_in<K>(impl_->moving.get(), Coherence::Undeclared, lanes, packet);
  for (int i = 0; i < K; ++i)
    if (hit.instance[i] != kNothing) impl_->name_patch(hit.instance[i], hit.geometry[i], hit.primitive[i]);
}

template <int K>
void RayScene::occluded(const Lanes<K>& lanes, RayPacket<K>& packet) const {
  occluded_in<K>(impl_->fixed.get(), Coherence::Coherent, lanes, packet);
  // Rays that are already occluded have a negative tfar and are not traced again.
  if (impl_->moving) occluded_in<K>(impl_->moving.get(), Coherence::Undeclared, lanes, packet);
}

template void RayScene::intersect<4>(const Lanes<4>&, RayHitPacket<4>&) const;
template void RayScene::intersect<8>(const Lanes<8>&, RayHitPacket<8>&) const;
template void RayScene::intersect<16>(const Lanes<16>&, RayHitPacket<16>&) const;
template void RayScene::occluded<4>(const Lanes<4>&, RayPacket<4>&) const;
template void RayScene::occluded<8>(const Lanes<8>&, RayPacket<8>&) const;
template void RayScene::occluded<16>(const Lanes<16>&, RayPacket<16>&) const;

}  // namespace farshade
