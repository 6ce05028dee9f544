// Compares the tracing stage with a bare loop over the same Embree packets, and the tracer with and without
// skipped rays (docs/tracing.md). The measurements are interleaved in one run.
//
//   tracer_bench [--scene S] [--size N] [--rounds R] [--asked | --beside OTHER]
//
// Prints medians and the spread (p10 to p90) of three times: the primary and the shadow stage of a frame
// (both eyes), and the bare loop over all shadow packets of surfaces that face the light. In CPU time, which
// other programs disturb less, it prints primary rays alone, frames with every shadow ray, and frames with
// skipped rays.
//
// With --asked it compares traces of whole views with traces of edge blocks instead: the blocks with a pixel
// whose bit differs from the bit of the pixel to the right or below. It traces them in all lights, and each
// light's alone. It prints time, core time and rays of all three, and the rays a second of the shadow stage
// and of the bare loop over its own packets.
//
// With --beside it traces both scenes at the times of R frames, 72 a second, in turns, and prints for each
// what a frame takes: all of it, moving and deforming, primary and shadow stage.
#include <tbb/parallel_for.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <ctime>
#include <optional>
#include <vector>

#include "stereo/base/check.h"
#include "stereo/base/quantile.h"
#include "stereo/gltf/gltf.h"
#include "stereo/tracer/tile_stages.h"
#include "stereo/tracer/tracer.h"

namespace farshade {
namespace {

/// The shadow packets of one frame, in the order in which the stage traces them.
template <int K>
struct Packets {
  std::vector<RayPacket<K>> rays;
  std::vector<Lanes<K>> lanes;
  std::uint64_t count = 0;  ///< rays
};

StereoView eyes_of(const Scene& scene, std::uint32_t side) {
  const Rigid<Stage, Eye> camera = scene.camera.value_or(Rigid<Stage, Eye>{});
  const auto eye = [&](double x, double left, double right) {
    const Rigid<Stage, Eye> place{camera.rotation, camera(Point<Eye>{{x, 0, 0}}).v};
    return View{place, {-left, right, 0.74, -0.85}, {side, side}};  // about a Quest Pro's
  };
  return {eye(-0.032, 0.94, 0.70), eye(0.032, 0.70, 0.94)};
}

template <int K>
Packets<K> record(const SurfaceModel& model, const RayScene& rays, const FrameRequest& request,
                  const std::vector<Light>& lights) {
  Packets<K> packets;
  const auto keep = [&](const Lanes<K>& lanes, const RayPacket<K>& ray) {
    packets.lanes.push_back(lanes);
    packets.rays.push_back(ray);
  };
  TileSurface surface;
  const auto model_lights = narrow<std::uint32_t>(lights.size());
  for (std::size_t eye = 0; eye < kEyes; ++eye) {
    const View& view = request.views[eye];
    for (const BlockGroup& group : groups_of(view.size, model_lights, request.requested.tiles[eye])) {
      see_group<K>(rays, model, rays_of(view, model.anchor_from_stage()), group, surface);
      for (std::uint32_t i = 0; i < model_lights; ++i) {
        std::uint32_t words[kTilePixels]{};
        packets.count +=
            shadow_group<K>(surface, group.requested.of(i), shadow_light(lights[i], model), 1, words, keep)
                .traced;
      }
    }
  }
  return packets;
}

/// Embree alone, with a copy of each packet, so that the packets stay unchanged.
template <int K>
double bare_loop_ms(const RayScene& scene, const Packets<K>& packets) {
  const Stopwatch watch;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, packets.rays.size(), 1024), [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      RayPacket<K> ray = packets.rays[i];
      scene.occluded(packets.lanes[i], ray);
    }
  });
  return ms_of(watch.elapsed());
}

void print(const char* what, const std::vector<double>& ms, std::uint64_t rays) {
  const double median = quantile(ms, 0.5);
  std::printf("%-28s %8.2f ms  [%.2f, %.2f]  %6.1f Mray/s\n", what, median, quantile(ms, 0.1),
              quantile(ms, 0.9), static_cast<double>(rays) / median / 1e3);
}

double cpu_ms(auto&& work) {
  const std::clock_t start = std::clock();
  work();
  return static_cast<double>(std::clock() - start) * 1e3 / CLOCKS_PER_SEC;
}

/// Times of all rounds, ms.
struct Times {
  std::vector<double> primary, shadow, bare, ratio, cpu, plain_cpu, see_cpu, plain_shadow;
};

void print_construction(const TracerMemory& memory, double made_ms) {
  std::printf("made in %.1f ms of core time; %.2f MB (peak of the hierarchy %.2f MB)\n", made_ms,
              static_cast<double>(memory.total()) / 1e6, static_cast<double>(memory.hierarchy_peak) / 1e6);
}

template <int K>
void print_times(const StereoView& views, const TraceStats& stats, const Times& times,
                 std::uint64_t packet_rays) {
  std::printf("%d wide, %u x %u an eye, shadow rays %.2f M of %.2f M\n", K, views[0].size.width,
              views[0].size.height, static_cast<double>(stats.shadow_rays) / 1e6,
              static_cast<double>(stats.full_shadow_rays) / 1e6);
  print("primary stage", times.primary, stats.primary_rays);
  std::printf("away %.3f M, range %.3f, cone %.3f\n", static_cast<double>(stats.turned_away) / 1e6,
              static_cast<double>(stats.out_of_range) / 1e6, static_cast<double>(stats.out_of_cone) / 1e6);
  print("shadow stage", times.shadow, stats.shadow_rays);
  print("core time, primary", times.see_cpu, stats.primary_rays);
  print("core time, every ray", times.plain_cpu, stats.full_shadow_rays);
  print("core time, needed rays", times.cpu, stats.full_shadow_rays);
  print("every ray", times.plain_shadow, stats.full_shadow_rays);
  print("bare loop, same packets", times.bare, packet_rays);
  std::printf("shadow stage / bare loop, rays a second: %.3f  [%.3f, %.3f]\n", quantile(times.ratio, 0.5),
              quantile(times.ratio, 0.1), quantile(times.ratio, 0.9));
}

template <int K>
void compare(const Scene& scene, const StereoView& views, int rounds) {
  const SceneState state = state_at(scene, Time{});
  const SurfaceModel model(scene, state, plan_for(scene).trace);
  const RayScene rays = RayScene::create(model).value();
  FrameRequest request;
  request.views = views;
  const Packets<K> same = record<K>(model, rays, request, state.light_set.lights);

  Tracer tracer = Tracer::create(scene).value();
  ShadowFrame frame;
  TracePlan plain_plan = plan_for(scene, {.all_lights = true}).trace;
  plain_plan.skips_rays = false;
  Tracer plain = Tracer::create(scene, plain_plan).value();
  std::optional<Tracer> making;
  const double made_ms = cpu_ms([&] { making.emplace(Tracer::create(scene).value()); });
  print_construction(tracer.memory(), made_ms);
  ShadowFrame plain_frame;
  TraceStats stats = tracer.trace(request, frame);
  plain.trace(request, plain_frame);
  std::printf("masks %s\n", plain_frame.masks == frame.masks ? "same" : "DIFFER");
  Times times;
  const auto see_all = [&] {
    TileSurface surface;
    for (const View& view : views) {
      const TileGrid grid{view.size};
      for (std::uint32_t tile = 0; tile < grid.count(); ++tile)
        see_group<K>(rays, model, rays_of(view, model.anchor_from_stage()), group_of(grid.rect(tile), 1),
                     surface);
    }
  };
  for (int round = 0; round < rounds; ++round) {
    times.see_cpu.push_back(cpu_ms(see_all));
    times.plain_cpu.push_back(cpu_ms([&] { plain.trace(request, plain_frame); }));
    times.cpu.push_back(cpu_ms([&] { tracer.trace(request, frame); }));
    times.plain_shadow.push_back(ms_of(plain.trace(request, plain_frame).shadow));
    stats = tracer.trace(request, frame);
    times.primary.push_back(ms_of(stats.primary));
    times.shadow.push_back(ms_of(stats.shadow));
    times.bare.push_back(bare_loop_ms(rays, same));
    times.ratio.push_back(times.bare.back() / times.shadow.back());
  }
  print_times<K>(views, stats, times, same.count);
}

/// The edge blocks of each light of a mask.
std::vector<RequestedTile> edge_blocks(const EyeMask& mask) {
  const TileGrid grid{mask.size()};
  std::vector<RequestedTile> tiles(grid.count());
  for (std::uint32_t plane = 0; plane < mask.layout().planes(); ++plane)
    for (std::uint32_t y = 0; y < mask.size().height; ++y)
      for (std::uint32_t x = 0; x < mask.size().width; ++x) {
        const std::uint32_t right = mask.word(std::min(x + 1, mask.size().width - 1), y, plane);
        const std::uint32_t below = mask.word(x, std::min(y + 1, mask.size().height - 1), plane);
        const std::uint32_t here = mask.word(x, y, plane), differ = (right ^ here) | (below ^ here);
        RequestedTile& tile = tiles[y / kTileSide_px * grid.columns() + x / kTileSide_px];
        for (std::uint32_t light = 0; light < 32; ++light)
          if ((differ >> light & 1) != 0)
            tile.shares[light % kMostShares] |= block_bit(x % kTileSide_px, y % kTileSide_px);
      }
  return tiles;
}

/// Asks for all lights in the requested blocks.
std::vector<RequestedTile> in_all_lights(std::vector<RequestedTile> tiles, std::uint32_t lights) {
  for (RequestedTile& tile : tiles) tile = all_lights_in(tile.any(), lights);
  return tiles;
}

/// A trace of one request, its times in all rounds, and its shadow packets.
template <int K>
struct Traced {
  const char* what = "";
  FrameRequest request{};
  Packets<K> packets{};
  TraceStats stats{};
  std::vector<double> wall{}, cpu{}, primary{}, shadow{}, bare{};
};

template <int K>
void print(const Traced<K>& of) {
  std::printf("%s: primary rays %.3f M, shadow rays %.3f M of %.3f M, in %.3f M packets\n", of.what,
              static_cast<double>(of.stats.primary_rays) / 1e6,
              static_cast<double>(of.stats.shadow_rays) / 1e6,
              static_cast<double>(of.stats.full_shadow_rays) / 1e6,
              static_cast<double>(of.packets.rays.size()) / 1e6);
  print("  time", of.wall, of.stats.primary_rays + of.stats.shadow_rays);
  print("  core time", of.cpu, of.stats.primary_rays + of.stats.shadow_rays);
  print("  primary stage", of.primary, of.stats.primary_rays);
  print("  shadow stage", of.shadow, of.stats.shadow_rays);
  print("  bare loop, same packets", of.bare, of.packets.count);
}

/// The same bits where they are asked for, and none elsewhere.
bool is_part_of(const EyeMask& part, const EyeMask& whole, const std::vector<RequestedTile>& requested) {
  const TileGrid grid{whole.size()};
  for (std::uint32_t y = 0; y < whole.size().height; ++y)
    for (std::uint32_t x = 0; x < whole.size().width; ++x) {
      const RequestedTile& tile = requested[y / kTileSide_px * grid.columns() + x / kTileSide_px];
      const auto block = std::countr_zero(block_bit(x % kTileSide_px, y % kTileSide_px));
      const std::uint32_t bits = tile.at(static_cast<std::uint32_t>(block)) * 0x01010101u;
      for (std::uint32_t plane = 0; plane < whole.layout().planes(); ++plane)
        if (part.word(x, y, plane) != (whole.word(x, y, plane) & bits)) return false;
    }
  return true;
}

template <int K>
void compare_requested(const Scene& scene, const StereoView& views, int rounds) {
  const SceneState state = state_at(scene, Time{});
  const SurfaceModel model(scene, state, plan_for(scene, {.all_lights = true}).trace);
  const RayScene rays = RayScene::create(model).value();

  Tracer tracer = Tracer::create(scene).value();
  Traced<K> whole{.what = "whole views"}, part{.what = "edge blocks in all lights"};
  Traced<K> lights{.what = "edge blocks of each light"};
  whole.request.views = part.request.views = lights.request.views = views;
  ShadowFrame whole_frame, frame;
  tracer.trace(whole.request, whole_frame);
  for (std::size_t eye = 0; eye < kEyes; ++eye)
    lights.request.requested.tiles[eye] = edge_blocks(whole_frame.masks[eye]);
  for (std::size_t eye = 0; eye < kEyes; ++eye)
    part.request.requested.tiles[eye] =
        in_all_lights(lights.request.requested.tiles[eye], whole_frame.masks[eye].lights());
  tracer.trace(lights.request, frame);
  bool same = true;
  for (std::size_t eye = 0; eye < kEyes; ++eye)
    same = same && is_part_of(frame.masks[eye], whole_frame.masks[eye], lights.request.requested.tiles[eye]);
  for (Traced<K>* const each : {&whole, &part, &lights})
    each->packets = record<K>(model, rays, each->request, state.light_set.lights);

  std::vector<double> share;
  for (int round = 0; round < rounds; ++round) {
    for (Traced<K>* const each : {&whole, &part, &lights}) {
      const Stopwatch watch;
      each->cpu.push_back(cpu_ms([&] { each->stats = tracer.trace(each->request, frame); }));
      each->wall.push_back(ms_of(watch.elapsed()));
      each->primary.push_back(ms_of(each->stats.primary));
      each->shadow.push_back(ms_of(each->stats.shadow));
      each->bare.push_back(bare_loop_ms(rays, each->packets));
    }
    share.push_back(part.cpu.back() / whole.cpu.back());
  }
  std::printf("%d wide, %u x %u an eye; bits of the requested blocks %s\n", K, views[0].size.width,
              views[0].size.height, same ? "same" : "DIFFER");
  print(whole);
  print(part);
  print(lights);
  const double pixels =
      static_cast<double>(part.stats.primary_rays) / static_cast<double>(whole.stats.primary_rays);
  std::printf("edge blocks / whole views: pixels %.3f, core time %.3f [%.3f, %.3f]\n", pixels,
              quantile(share, 0.5), quantile(share, 0.1), quantile(share, 0.9));
}

/// Times of the frames of one scene that moves, ms.
struct MovingTimes {
  std::vector<double> all, moving, primary, shadow;
  std::uint64_t primary_rays = 0, shadow_rays = 0;

  void add(double wall, const TraceStats& stats) {
    all.push_back(wall);
    primary.push_back(ms_of(stats.primary)), shadow.push_back(ms_of(stats.shadow));
    moving.push_back(wall - primary.back() - shadow.back());
    primary_rays += stats.primary_rays, shadow_rays += stats.shadow_rays;
  }
};

void print(const MovingTimes& times) {
  const std::uint64_t frames = times.all.size();
  print("  frame", times.all, (times.primary_rays + times.shadow_rays) / frames);
  print("  moving and deforming", times.moving, 0);
  print("  primary stage", times.primary, times.primary_rays / frames);
  print("  shadow stage", times.shadow, times.shadow_rays / frames);
}

/// Traces both scenes at the same times and from the camera of the first.
void compare_moving(const PerEye<const Scene*>& scenes, const StereoView& views, int frames) {
  std::array<Tracer, 2> tracers{Tracer::create(*scenes[0]).value(), Tracer::create(*scenes[1]).value()};
  std::array<MovingTimes, 2> times;
  FrameRequest request;
  request.views = views;
  ShadowFrame frame;
  for (int number = 0; number < frames; ++number) {
    request.scene_time = Time{} + std::chrono::nanoseconds(1'000'000'000LL * (number + 1) / 72);
    for (const std::size_t turn : {0u, 1u}) {
      const std::size_t scene = (turn + static_cast<std::size_t>(number)) % 2;
      const Stopwatch watch;
      const TraceStats stats = tracers[scene].trace(request, frame);
      times[scene].add(ms_of(watch.elapsed()), stats);
    }
  }
  for (const MovingTimes& of : times) {
    std::printf("%s scene\n", &of == times.data() ? "first" : "other");
    print(of);
  }
}

int run(int argc, char** argv) {
  std::string path = FARSHADE_ASSETS "/room.glb", beside;
  std::uint32_t side = 1024;
  int rounds = 21;
  bool requested = false;
  CLI::App app("Compares the tracing stage with a bare loop over Embree packets.");
  app.add_option("--scene", path);
  app.add_option("--size", side);
  app.add_option("--rounds", rounds);
  app.add_flag("--asked", requested);
  app.add_option("--beside", beside);
  CLI11_PARSE(app, argc, argv);
  const auto scene = load_scene(path);
  if (!scene) {
    std::fprintf(stderr, "%s\n", scene.error().what.c_str());
    return 1;
  }
  const SurfaceModel empty(Scene{}, SceneState{}, TracePlan{});
  const int width = RayScene::create(empty).value().width();
  const StereoView views = eyes_of(*scene, side);
  if (!beside.empty()) {
    const auto other = load_scene(beside);
    if (!other) {
      std::fprintf(stderr, "%s\n", other.error().what.c_str());
      return 1;
    }
    compare_moving({&*scene, &*other}, views, rounds);
    return 0;
  }
  if (width == 16)
    requested ? compare_requested<16>(*scene, views, rounds) : compare<16>(*scene, views, rounds);
  if (width == 8) requested ? compare_requested<8>(*scene, views, rounds) : compare<8>(*scene, views, rounds);
  if (width == 4) requested ? compare_requested<4>(*scene, views, rounds) : compare<4>(*scene, views, rounds);
  return 0;
}

}  // namespace
}  // namespace farshade

int main(int argc, char** argv) {
  return farshade::run(argc, argv);
}
