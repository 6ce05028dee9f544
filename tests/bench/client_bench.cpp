// Compares the client's frame with its G-buffer pass alone, and reprojection with reading the mask at the
// same pixel. The measurements alternate within one run. Targets: the median frame without guard band and
// prediction takes at most 2.0 times the median G-buffer pass; reprojecting and shading takes at most 1.5
// times shading.
#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>

#include "stereo/base/heap.h"
#include "stereo/base/quantile.h"
#include "stereo/gltf/gltf.h"
#include "stereo/gpu/device.h"
#include "stereo/head/reader.h"
#include "stereo/requests/request_plan.h"
#include "stereo/tracer/tracer.h"
#include "tests/bench/late_masks.h"
#include "tests/support/packed.h"

namespace {

using namespace farshade;
using namespace farshade::bench;

constexpr std::uint32_t kWarmUp_frames = 8;
constexpr double kFrameFigure = 2.0, kReprojectFigure = 1.5;

struct Options {
  std::string scene, trace = FARSHADE_ASSETS "/walk.csv", gpu;
  std::uint32_t side_px = 1024, frames = 24;
  float detail_px = kDefaultDetail_px;
};

/// A setting for the reprojection of masks, with the measured times.
struct ReprojectionMode {
  const char* name;
  Reprojection reprojection;
  std::vector<double> ms;
};

struct Times {
  std::vector<double> frame, collect, draw, gbuffer, depth;
  std::vector<double> request_reprojection, ask,
      requested_percent;  ///< before a request: the pass, the whole call, and what it found
  std::vector<double> full_gbuffer, full_depth;  ///< the same frames in full detail
  DrawnTriangles triangles, full_triangles;      ///< of the last frame
  std::vector<ReprojectionMode> modes{
      {"shading alone (mask at the pixel)", {.lookup = Lookup::Direct}, {}},
      {"nearest pixel, this eye", {.eyes = Eyes::This, .gaps = Gaps::Unknown, .edges = Edges::Nearest}, {}},
      {"and the other eye", {.gaps = Gaps::Unknown, .edges = Edges::Nearest}, {}},
      {"and neighbours", {.edges = Edges::Nearest}, {}},
      {"and shadow edges (default)", {}, {}}};
};

void print(const char* label, const std::vector<double>& values) {
  const Spread spread = spread_of(values);
  std::printf("  %-34s %9.2f %9.2f %9.2f\n", label, spread.median, quantile(values, 0.1), spread.p95);
}

/// Prints device memory by use: the prediction for the scene's plan and for a plan with every feature, and
/// the memory that `device` has allocated for the scene's plan.
void print_memory(const Scene& scene, const RendererLimits& limits, const gpu::Device& device) {
  const auto predicted = [&](PlanKind kind) {
    return client_memory(scene, plan_for(scene, {.kind = kind, .all_lights = true}).draw, limits);
  };
  const gpu::BytesByUse needed = predicted(PlanKind::Needed), everything = predicted(PlanKind::Everything),
                        measured = device.ledger->read().peak;
  constexpr double kMiB = 1 << 20;
  std::printf("  %-34s %9s %9s %9s\n", "device memory, MiB", "needed", "measured", "everything");
  for (std::size_t use = 0; use < gpu::kUses; ++use)
    std::printf("  %-34s %9.2f %9.2f %9.2f\n", to_string(static_cast<gpu::Use>(use)).data(),
                static_cast<double>(needed.bytes[use]) / kMiB,
                static_cast<double>(measured.bytes[use]) / kMiB,
                static_cast<double>(everything.bytes[use]) / kMiB);
  std::printf("  %-34s %9.2f %9.2f %9.2f\n", "at most at one time",
              static_cast<double>(most_at_once(needed)) / kMiB,
              static_cast<double>(device.ledger->read().peak_total) / kMiB,
              static_cast<double>(most_at_once(everything)) / kMiB);
}

void print_times(const Times& times) {
  print("client frame", times.frame);
  print("  collect masks", times.collect);
  print("  draw", times.draw);
  print("    G-buffer", times.gbuffer);
  print("    depth of requested views", times.depth);
  print("reprojecting a mask to requested views", times.request_reprojection);
  print("  with their depth, and read back", times.ask);
  print("  requested blocks, percent", times.requested_percent);
  print("    G-buffer in full detail", times.full_gbuffer);
  print("    depth in full detail", times.full_depth);
  for (const ReprojectionMode& mode : times.modes) print(mode.name, mode.ms);
}

void print_ratios(const Times& times) {
  const auto median = [](const std::vector<double>& values) { return quantile(values, 0.5); };
  const auto sum = [](const DrawnTriangles& triangles) {
    return static_cast<unsigned long long>(triangles.gbuffer + triangles.depth);
  };
  std::printf("triangles of the last frame: %llu, %llu in full detail\n", sum(times.triangles),
              sum(times.full_triangles));
  std::printf("G-buffer and depth in full detail / with levels = %.2f\n",
              (median(times.full_gbuffer) + median(times.full_depth)) /
                  (median(times.gbuffer) + median(times.depth)));
  std::printf("client frame without depth of requested views / G-buffer pass = %.3f (figure: <= %.1f)\n",
              (median(times.frame) - median(times.depth)) / median(times.gbuffer), kFrameFigure);
  std::printf("reproject and shade / shading alone = %.3f (figure: <= %.1f)\n",
              median(times.modes.back().ms) / median(times.modes.front().ms), kReprojectFigure);
}

void print_report(const Options& options, const Scene& scene, const RendererLimits& limits,
                  const gpu::Device& device, const Times& times) {
  std::printf("%s along %s on %s, %zu frames\n", scene.name.c_str(), options.trace.c_str(),
              device.name.c_str(), times.frame.size());
  std::printf("  %-34s %9s %9s %9s\n", "ms", "median", "p10", "p95");
  print_times(times);
  print_memory(scene, limits, device);
  print_ratios(times);
}

/// `full`: the same frame in full detail.
void add_frame(Times& times, const DrawTimes& drawn, const DrawTimes& full, double decode_ms) {
  times.collect.push_back(decode_ms);
  times.draw.push_back(ms_of(drawn.total));
  times.frame.push_back(decode_ms + ms_of(drawn.total));
  times.gbuffer.push_back(ms_of(drawn.gbuffer));
  times.depth.push_back(ms_of(drawn.depth));
  times.full_gbuffer.push_back(ms_of(full.gbuffer));
  times.full_depth.push_back(ms_of(full.depth));
}

void time_request_reprojection(Renderer& renderer, const FrameRequest& request, std::size_t slot,
                               const TracedMask& base, Times& times) {
  RequestReprojection reprojection;
  const Stopwatch asking;
  if (!renderer.reproject_to_request(request, slot, &base)) return;
  renderer.read_reprojected(reprojection);
  times.ask.push_back(ms_of(asking.elapsed()));
  times.request_reprojection.push_back(ms_of(renderer.finish().request_reprojection));
  times.requested_percent.push_back(100 * part_of(reprojection.requested));
}

SceneLevels levels_for(const Scene& scene, const Options& options) {
  if (options.detail_px <= 0) return {};
  const Stopwatch watch;
  SceneLevels levels = make_levels(scene);
  std::printf("levels of detail made in %.0f ms\n", ms_of(watch.elapsed()));
  return levels;
}

DrawTimes draw(Renderer& renderer, const ShownFrame& frame) {
  renderer.draw(frame);
  return renderer.finish();
}

Expected<void> run(const Options& options) {
  const Expected<Scene> scene = load_scene(options.scene);
  if (!scene) return tl::unexpected(scene.error());
  const Expected<HeadRecording> recording = load_head_recording(options.trace);
  if (!recording) return tl::unexpected(recording.error());
  const Expected<gpu::Device> device = gpu::open_device({options.gpu, gpu::Validation::Off});
  if (!device) return tl::unexpected(device.error());
  Expected<Tracer> tracer = Tracer::create(*scene);
  if (!tracer) return tl::unexpected(tracer.error());

  const Rigid<Stage, Recorded> placed =
      scene->camera ? place(*recording, *scene->camera) : Rigid<Stage, Recorded>{};
  const Extent size{options.side_px, options.side_px};
  const RendererLimits limits{size, largest_traced(size), kRing_frames};
  DrawPlan draw_plan = plan_for(*scene, {.all_lights = true, .detail_px = options.detail_px}).draw;
  const SceneLevels levels = levels_for(*scene, options);
  const std::unique_ptr<Renderer> renderer = make_renderer(*device, *scene, draw_plan, limits, levels);
  RequestPlan plan(RequestSettings{});
  plan.learn(kPeriod * kLate_frames);
  Assembler assembler(kRing_frames);
  FramePacker packer;
  ShadowFrame traced;
  const SceneState state = state_at(*scene, Time{});
  Times times;
  for (std::uint32_t number = 1; number <= kWarmUp_frames + options.frames; ++number) {
    const FrameMoment shown = shown_at(*recording, placed, number, options.side_px);
    const FrameRequest request = plan.ask(shown, kPeriod).value();
    assembler.expect(request, {draw_plan.mask.lights}, state.light_set.revision);
    tracer->trace(request, traced);
    FrameReport report;
    report.frame = request.frame;
    const double collect = collect_ms(assembler, pack(packer, traced, report));
    const std::vector<TracedMask> masks = usable_masks(assembler, shown.frame);
    ShownFrame frame{.views = shown.views,
                     .state = state,
                     .request = &request,
                     .masks = masks,
                     .reprojection = {},
                     .request_slot = assembler.find(request.frame)->slot,
                     .detail = Detail::Full};
    const DrawTimes full = draw(*renderer, frame);
    times.full_triangles = full.triangles;
    frame.detail = Detail::Levels;
    const DrawTimes drawn = draw(*renderer, frame);
    times.triangles = drawn.triangles;
    if (masks.empty()) continue;
    for (ReprojectionMode& mode : times.modes) {
      frame.reprojection = mode.reprojection;
      renderer->shade_again(frame);
      const DrawTimes again = renderer->finish();
      if (number > kWarmUp_frames) mode.ms.push_back(ms_of(again.shade));
    }
    if (number <= kWarmUp_frames) continue;
    time_request_reprojection(*renderer, request, frame.request_slot, masks[0], times);
    add_frame(times, drawn, full, collect);
  }
  print_report(options, *scene, limits, *device, times);
  return {};
}

}  // namespace

int main(int argc, char** argv) try {
  keep_freed_memory();
  CLI::App app("Times the client's frame against its G-buffer pass.");
  Options options;
  app.add_option("--scene", options.scene, "glTF 2.0 file")->required();
  app.add_option("--trace", options.trace, "recorded head")->capture_default_str();
  app.add_option("--size", options.side_px, "pixels of each side of an eye")->capture_default_str();
  app.add_option("--frames", options.frames, "frames measured")->capture_default_str();
  app.add_option("--detail-px", options.detail_px, "limit of the geometric error, pixels; 0: full detail")
      ->capture_default_str();
  app.add_option("--gpu", options.gpu, "use only a device whose name contains this");
  CLI11_PARSE(app, argc, argv);
  if (const Expected<void> done = run(options); !done) {
    std::fprintf(stderr, "client_bench: %s\n", done.error().what.c_str());
    return 1;
  }
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "client_bench: %s\n", error.what());
  return 1;
}
