#include "stereo/tracer/tracer.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <atomic>
#include <cstring>

#include "stereo/base/check.h"
#include "stereo/tracer/block_groups.h"
#include "stereo/tracer/placed_surface.h"
#include "stereo/tracer/tile_stages.h"

namespace farshade {
namespace {

/// Sums over groups. Times are core times.
struct GroupSums {
  Duration primary{}, shadow{};
  std::uint64_t primary_rays = 0;
  GroupRays rays;

  GroupSums& operator+=(const GroupSums& b) {
    primary += b.primary, shadow += b.shadow;
    primary_rays += b.primary_rays;
    rays += b.rays;
    return *this;
  }
};

/// Writes the words of the group's pixels that lie inside the picture.
template <class Word>
void write_words(const std::uint32_t (&words)[kTilePixels], const BlockGroup& group, Extent size,
                 std::byte* plane) {
  for (int block = 0; block < group.count; ++block) {
    const BlockPlace place = group.blocks[static_cast<std::size_t>(block)];
    for (int lane = 0; lane < kBlockPixels; ++lane) {
      const TilePixel pixel = kTileOrder[static_cast<std::size_t>(lane)];
      const std::size_t x = place.x + pixel.x, y = place.y + pixel.y;
      if (x >= size.width || y >= size.height) continue;
      const auto word = static_cast<Word>(words[block * kBlockPixels + lane]);
      std::memcpy(plane + (y * size.width + x) * sizeof(Word), &word, sizeof word);
    }
  }
}

void write_plane(const std::uint32_t (&words)[kTilePixels], const BlockGroup& group, std::uint32_t plane,
                 EyeMask& mask) {
  const std::size_t word_bytes = mask.layout().word_bytes();
  std::byte* const start = mask.bytes().data() + plane * mask.size().pixels() * word_bytes;
  if (word_bytes == 1) write_words<std::uint8_t>(words, group, mask.size(), start);
  if (word_bytes == 2) write_words<std::uint16_t>(words, group, mask.size(), start);
  if (word_bytes == 4) write_words<std::uint32_t>(words, group, mask.size(), start);
}

/// The pixels of a group inside the picture.
std::uint64_t pixels_of(const BlockGroup& group, Extent size) {
  std::uint64_t pixels = 0;
  for (const BlockPlace block : std::span(group.blocks).first(static_cast<std::size_t>(group.count)))
    if (block.x < size.width && block.y < size.height)
      pixels += std::uint64_t{std::min(kBlockSide_px, size.width - block.x)} *
                std::min(kBlockSide_px, size.height - block.y);
  return pixels;
}

}  // namespace

struct Tracer::Impl {
  const Scene& scene;
  TracePlan plan;
  InstructionSet set;
  SceneState state;  ///< with the lights as the scene has them: a request's changes are not kept
  SurfaceModel model;
  std::optional<RayScene> rays;
  LightSet light_set;                      ///< of the current request
  std::vector<ShadowLight> lights;         ///< of light_set
  PerEye<std::vector<BlockGroup>> groups;  ///< the work list of the current request

  Impl(const Scene& traced, const TracePlan& requested, InstructionSet allowed)
      : scene(traced),
        plan(requested),
        set(allowed),
        state(state_at(scene, Time{})),
        model(scene, state, plan) {}

  void advance_to(Time scene_time, const LightChanges& changes);
  Duration prepare(const FrameRequest& request, ShadowFrame& frame);
  [[nodiscard]] std::uint64_t lights_on() const;
  [[nodiscard]] float reach() const;
  template <int K>
  GroupRays shadow(const TileSurface& surface, BlockBits blocks, std::size_t light, std::uint32_t bit,
                   std::uint32_t (&words)[kTilePixels]) const;
  template <int K>
  GroupSums trace_group(const ViewRays& view, const BlockGroup& group, EyeMask& mask) const;
  template <int K>
  GroupSums trace_group(const PlacedEye& eye, const BlockGroup& group, EyeMask& mask) const;
  template <int K, class Source>
  GroupSums trace_group_in_best(const Source& source, const BlockGroup& group, EyeMask& mask) const;
  template <int K, class Source>
  FARSHADE_AVX2 GroupSums trace_group_avx2(const Source& source, const BlockGroup& group,
                                           EyeMask& mask) const;
  template <int K, class Source>
  FARSHADE_AVX512 GroupSums trace_group_avx512(const Source& source, const BlockGroup& group,
                                               EyeMask& mask) const;
  template <int K, class Source>
  GroupSums trace_eyes(const PerEye<Source>& sources, std::size_t eyes, PerEye<EyeMask>& masks,
                       const GiveUp& give_up) const;
  template <class Source>
  TraceStats trace_frame(const PerEye<Source>& sources, bool same, ShadowFrame& frame,
                         const GiveUp& give_up) const;
};

void Tracer::Impl::advance_to(Time scene_time, const LightChanges& changes) {
  if (scene.animation_length_s > 0 && scene_time != state.scene_time) {
    state = state_at(scene, scene_time);
    if (model.fixed_count() < model.patches().size()) {
      model.place(state);
      rays->update();
    }
  }
  light_set = state.light_set;
  apply(changes, light_set);
  lights.clear();
  for (const Light& light : light_set.lights) lights.push_back(shadow_light(light, model));
}

template <int K>
GroupRays Tracer::Impl::shadow(const TileSurface& surface, BlockBits blocks, std::size_t light,
                               std::uint32_t bit, std::uint32_t (&words)[kTilePixels]) const {
  const auto occluded = [this](const Lanes<K>& lanes, RayPacket<K>& packet) {
    rays->occluded(lanes, packet);
  };
  if (!plan.skips_rays) return shadow_whole_group<K>(surface, blocks, lights[light], bit, words, occluded);
  return shadow_group<K>(surface, blocks, lights[light], bit, words, occluded);
}

/// The tile of a group that is a whole tile.
TileRect tile_of(const BlockGroup& group, Extent size) {
  const std::uint32_t x = group.blocks[0].x, y = group.blocks[0].y;
  return {x, y, std::min(x + kTileSide_px, size.width), std::min(y + kTileSide_px, size.height)};
}

/// Calls act(light, blocks, bit, words) for the lights that are on and asked for in some `blocks`, plane by
/// plane, and writes the words to the mask.
template <class Act>
void for_each_light(std::span<const ShadowLight> lights, const BlockGroup& group, EyeMask& mask, Act act) {
  const MaskLayout layout = mask.layout();
  for (std::uint32_t plane = 0; plane < layout.planes(); ++plane) {
    std::uint32_t words[kTilePixels]{};
    for (std::uint32_t bit = 0; bit < layout.lights_in(plane); ++bit) {
      const std::uint32_t light = plane * 32 + bit;
      const BlockBits blocks = group.requested.of(light);
      if (lights[light].on && blocks != kNoBlocks) act(light, blocks, 1u << bit, words);
    }
    write_plane(words, group, plane, mask);
  }
}

template <int K>
GroupSums Tracer::Impl::trace_group(const ViewRays& view, const BlockGroup& group, EyeMask& mask) const {
  GroupSums sums;
  TileSurface surface;
  const Stopwatch watch;
  see_group<K>(*rays, model, view, group, surface);
  sums.primary = watch.elapsed();
  for_each_light(lights, group, mask,
                 [&](std::size_t light, BlockBits blocks, std::uint32_t bit, auto& words) {
                   if (surface.covered > 0) sums.rays += shadow<K>(surface, blocks, light, bit, words);
                 });
  sums.shadow = watch.elapsed() - sums.primary;
  sums.primary_rays = pixels_of(group, view.size);
  return sums;
}

template <int K>
GroupSums Tracer::Impl::trace_group(const PlacedEye& eye, const BlockGroup& group, EyeMask& mask) const {
  GroupSums sums;
  PlacedSurface surface;
  const Stopwatch watch;
  place_tile(eye, tile_of(group, eye.rays.size), surface);
  sums.primary = watch.elapsed();
  const auto occluded = [this](const Lanes<K>& lanes, RayPacket<K>& packet) {
    rays->occluded(lanes, packet);
  };
  for_each_light(lights, group, mask,
                 [&](std::size_t light, BlockBits blocks, std::uint32_t bit, auto& words) {
                   if (surface.covered > 0)
                     sums.rays += shadow_group<K>(surface, blocks, lights[light], bit, words, occluded);
                 });
  sums.shadow = watch.elapsed() - sums.primary;
  return sums;
}

template <int K, class Source>
GroupSums Tracer::Impl::trace_group_avx2(const Source& source, const BlockGroup& group, EyeMask& mask) const {
  return trace_group<K>(source, group, mask);
}

template <int K, class Source>
GroupSums Tracer::Impl::trace_group_avx512(const Source& source, const BlockGroup& group,
                                           EyeMask& mask) const {
  return trace_group<K>(source, group, mask);
}

/// The instruction set whose vectors have K lanes, if the processor has it. Without it, packets of 8 rays
/// cost 30 % more core time (tracer_bench, room.glb, 512x512: 307 ms a frame, with AVX2 226 ms).
template <int K, class Source>
GroupSums Tracer::Impl::trace_group_in_best(const Source& source, const BlockGroup& group,
                                            EyeMask& mask) const {
  if constexpr (K == 16)
    if (set == InstructionSet::Avx512) return trace_group_avx512<K>(source, group, mask);
  if constexpr (K == 8)
    if (set >= InstructionSet::Avx2) return trace_group_avx2<K>(source, group, mask);
  return trace_group<K>(source, group, mask);
}

/// The groups of all eyes are one parallel range, so that no core waits between eyes.
template <int K, class Source>
GroupSums Tracer::Impl::trace_eyes(const PerEye<Source>& sources, std::size_t eyes, PerEye<EyeMask>& masks,
                                   const GiveUp& give_up) const {
  const std::size_t left = groups[0].size(), all = eyes == 1 ? left : left + groups[1].size();
  constexpr std::size_t kGrain = 8;
  std::atomic<bool> given_up = false;
  const auto is_given_up = [&] {
    if (give_up && !given_up.load(std::memory_order_relaxed) && give_up()) given_up = true;
    return given_up.load(std::memory_order_relaxed);
  };
  const GroupSums all_sums = tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, all, kGrain), GroupSums{},
      [&](const tbb::blocked_range<std::size_t>& range, GroupSums sums) {
        for (std::size_t group = range.begin(); group < range.end() && !is_given_up(); ++group) {
          const std::size_t eye = group < left ? 0 : 1;
          sums +=
              trace_group_in_best<K>(sources[eye], groups[eye][eye == 0 ? group : group - left], masks[eye]);
        }
        return sums;
      },
      [](GroupSums a, const GroupSums& b) { return a += b; });
  if (given_up) throw TraceGivenUp();
  return all_sums;
}

std::uint64_t Tracer::Impl::lights_on() const {
  return static_cast<std::uint64_t>(std::ranges::count(lights, true, &ShadowLight::on));
}

/// The largest Facet::reach of all occluders.
float Tracer::Impl::reach() const {
  float most = 0;
  for (const Patch& patch : model.patches()) {
    if (patch.moving) {
      most = std::max(most, patch.placement.reach);
      continue;
    }
    for (const Facet& facet : model.facets().subspan(patch.first_triangle, patch.triangle_count))
      most = std::max(most, facet.reach);
  }
  return most;
}

/// Sets scene, lights and work list to those of the request, and everything of `frame` except the bits of
/// requested blocks. Returns the time of the scene's update.
Duration Tracer::Impl::prepare(const FrameRequest& request, ShadowFrame& frame) {
  for (const View& view : request.views) check(is_valid(view), "a traced view is valid");
  const Stopwatch watch;
  advance_to(request.scene_time, request.lights);
  const Duration update = watch.elapsed();
  frame.frame = request.frame;
  frame.light_set_revision = light_set.revision;
  frame.views = request.views;
  for (std::size_t eye = 0; eye < kEyes; ++eye) {
    EyeMask& mask = frame.masks[eye];
    if (mask.size() != request.views[eye].size || mask.layout() != plan.mask)
      mask = EyeMask(request.views[eye].size, plan.mask);
    const std::vector<RequestedTile>& requested = request.requested.tiles[eye];
    groups[eye] = groups_of(mask.size(), plan.mask.lights, requested);
    if (!requested.empty()) std::ranges::fill(mask.bytes(), std::byte{});  // whole views overwrite every word
  }
  return update;
}

/// Traces the masks of a prepared frame. `same`: both views coincide, and the left mask is copied.
template <class Source>
TraceStats Tracer::Impl::trace_frame(const PerEye<Source>& sources, bool same, ShadowFrame& frame,
                                     const GiveUp& give_up) const {
  const std::uint64_t on = lights_on();
  if (on == 0) {
    for (EyeMask& mask : frame.masks) std::ranges::fill(mask.bytes(), std::byte{});
    return {};
  }
  const Stopwatch watch;
  const std::size_t eyes = same ? 1 : kEyes;
  const int width = rays->width();
  const GroupSums sums = width == 16  ? trace_eyes<16>(sources, eyes, frame.masks, give_up)
                         : width == 8 ? trace_eyes<8>(sources, eyes, frame.masks, give_up)
                                      : trace_eyes<4>(sources, eyes, frame.masks, give_up);
  if (same) frame.masks[1] = frame.masks[0];

  const Duration wall = watch.elapsed();
  const double share = static_cast<double>(sums.primary.count()) /
                       static_cast<double>(std::max<std::int64_t>((sums.primary + sums.shadow).count(), 1));
  const Duration primary(static_cast<std::int64_t>(share * static_cast<double>(wall.count())));
  return {.primary = primary,
          .shadow = wall - primary,
          .primary_rays = sums.primary_rays,
          .shadow_rays = sums.rays.traced,
          .full_shadow_rays = sums.rays.all() * (same ? 2 : 1),
          .out_of_range = sums.rays.out_of_range,
          .out_of_cone = sums.rays.out_of_cone,
          .turned_away = sums.rays.away};
}

Expected<Tracer> Tracer::create(const Scene& scene, const TracePlan& plan, InstructionSet set) {
  check(set <= best_instruction_set(), "the processor has the instruction set");
  check_eq(plan.mask.lights, narrow<std::uint32_t>(scene.lights.size()), "a bit for each light of the scene");
  auto impl = std::make_unique<Impl>(scene, plan, set);
  auto rays = RayScene::create(impl->model);
  if (!rays) return tl::unexpected(rays.error());
  impl->rays.emplace(std::move(*rays));
  return Tracer(std::move(impl));
}

Tracer::Tracer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Tracer::Tracer(Tracer&&) noexcept = default;
Tracer& Tracer::operator=(Tracer&&) noexcept = default;
Tracer::~Tracer() = default;

TraceStats Tracer::trace(const FrameRequest& request, ShadowFrame& frame, const GiveUp& give_up) {
  const Duration update = impl_->prepare(request, frame);
  const Rigid<Anchor, Stage>& anchor_from_stage = impl_->model.anchor_from_stage();
  const PerEye<ViewRays> views{rays_of(request.views[0], anchor_from_stage),
                               rays_of(request.views[1], anchor_from_stage)};
  const bool same = impl_->plan.shares_views && request.views[0] == request.views[1] &&
                    request.requested.tiles[0] == request.requested.tiles[1];
  TraceStats stats = impl_->trace_frame(views, same, frame, give_up);
  stats.update = update;
  return stats;
}

TraceStats Tracer::trace(const FrameRequest& request, const PerEye<PositionPlanes>& positions,
                         const PositionGrid& grid, ShadowFrame& frame, const GiveUp& give_up) {
  check(request.requested.whole(), "positions are those of whole views");
  const Duration update = impl_->prepare(request, frame);
  const Rigid<Anchor, Stage>& anchor_from_stage = impl_->model.anchor_from_stage();
  const float reach = impl_->reach();
  const auto placed = [&](std::size_t eye) {
    for (const PixelPlane& plane : positions[eye])
      check(plane.size == request.views[eye].size, "positions are those of the view's pixels");
    return PlacedEye{positions[eye], anchor_from_stage(grid.low), grid.step_m,
                     rays_of(request.views[eye], anchor_from_stage), reach};
  };
  TraceStats stats = impl_->trace_frame(PerEye<PlacedEye>{placed(0), placed(1)}, false, frame, give_up);
  stats.update = update;
  return stats;
}

PerEye<Image<float>> Tracer::distances(const FrameMoment& moment) {
  impl_->advance_to(moment.scene_time, moment.lights);
  const auto of_view = [&](const View& view) {
    check(is_valid(view), "a traced view is valid");
    const ViewRays rays = rays_of(view, impl_->model.anchor_from_stage());
    const glm::vec3 ahead(view.stage_from_eye(Vector<Eye>{{0, 0, -1}}).v);
    const std::vector<BlockGroup> groups = groups_of(view.size, impl_->plan.mask.lights, {});
    Image<float> distances(view.size, 0.0f);
    tbb::parallel_for(std::size_t{0}, groups.size(), [&](std::size_t number) {
      TileSurface surface;
      see_group<4>(*impl_->rays, impl_->model, rays, groups[number], surface);
      for (int at = 0; at < surface.pixels; ++at) {
        const BlockPlace block = groups[number].blocks[static_cast<std::size_t>(at / kBlockPixels)];
        const TilePixel in_block = kTileOrder[static_cast<std::size_t>(at % kBlockPixels)];
        const std::uint32_t x = block.x + in_block.x, y = block.y + in_block.y;
        if (x >= view.size.width || y >= view.size.height || surface.reach[at] == 0) continue;
        const glm::vec3 p(surface.px[at], surface.py[at], surface.pz[at]);
        distances.at(x, y) = glm::dot(p - rays.origin.v, ahead);
      }
    });
    return distances;
  };
  return {of_view(moment.views[0]), of_view(moment.views[1])};
}

MaskLayout Tracer::layout() const {
  return impl_->plan.mask;
}

TracerMemory Tracer::memory() const {
  const SurfaceModel& model = impl_->model;
  return {.vertices = model.positions().size_bytes() + model.normals().size_bytes(),
          .triangles = model.triangles().size_bytes(),
          .facets = model.facets().size_bytes(),
          .hierarchy = impl_->rays->bytes(),
          .hierarchy_peak = impl_->rays->peak_bytes()};
}

}  // namespace farshade
