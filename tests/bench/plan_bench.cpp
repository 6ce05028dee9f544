// What a scene's plan saves. Each frame is traced and drawn twice, with the features that the scene needs and
// with all features; the order alternates. Target: the plan with the needed features is better in every row.
#include <CLI/CLI.hpp>
#include <cstdio>

#include "stereo/base/quantile.h"
#include "stereo/gltf/gltf.h"
#include "stereo/gpu/device.h"
#include "stereo/head/reader.h"
#include "stereo/requests/request_plan.h"
#include "stereo/tracer/tracer.h"
#include "tests/bench/late_masks.h"
#include "tests/support/packed.h"

namespace farshade::bench {
namespace {

struct Options {
  std::string scene, trace = FARSHADE_ASSETS "/walk.csv", gpu;
  std::uint32_t side_px = 1024, frames = 30;
};

template <class T>
T value_of(Expected<T> value) {
  if (!value) throw std::runtime_error(value.error().what);
  return std::move(*value);
}

/// One frame's figures, in the order of kRows.
struct Figures {
  double rays, shadow_rays, bytes, server_bytes, client_bytes, trace_ms, pack_ms, collect_ms, gbuffer_ms,
      depth_ms, shade_ms, client_ms;
};

struct Row {
  const char* name;
  double Figures::*value;
  double unit;
  const char* format;
};
constexpr std::array kRows{Row{"rays, millions", &Figures::rays, 1e-6, "%10.3f"},
                           Row{"  shadow rays among them", &Figures::shadow_rays, 1e-6, "%10.3f"},
                           Row{"bytes of masks, kB", &Figures::bytes, 1e-3, "%10.1f"},
                           Row{"server: trace, ms", &Figures::trace_ms, 1, "%10.1f"},
                           Row{"server: pack, ms", &Figures::pack_ms, 1, "%10.2f"},
                           Row{"client: decode masks, ms", &Figures::collect_ms, 1, "%10.2f"},
                           Row{"client: G-buffer, ms", &Figures::gbuffer_ms, 1, "%10.1f"},
                           Row{"client: requested depth, ms", &Figures::depth_ms, 1, "%10.1f"},
                           Row{"client: reproject, shade, ms", &Figures::shade_ms, 1, "%10.1f"},
                           Row{"client: frame, ms", &Figures::client_ms, 1, "%10.1f"},
                           Row{"server: memory, MB", &Figures::server_bytes, 1e-6, "%10.1f"},
                           Row{"client: memory on the device, MB", &Figures::client_bytes, 1e-6, "%10.1f"}};

/// A server and a client that follow one plan.
class PlanPair {
 public:
  PlanPair(const Options& options, const Scene& scene, PlanKind kind, Extent size)
      : planned_(plan_scene(scene, {.kind = kind})),
        device_(value_of(gpu::open_device({options.gpu, gpu::Validation::Off}))),
        tracer_(value_of(Tracer::create(planned_.scene, planned_.plan.trace))),
        renderer_(make_renderer(device_, planned_.scene, planned_.plan.draw,
                                {size, largest_traced(size), kRing_frames})),
        state_(state_at(planned_.scene, Time{})) {}

  /// No figures while there are no masks to draw with.
  std::optional<Figures> frame(const FrameMoment& shown, const FrameRequest& request) {
    assembler_.expect(request, planned_.plan.draw.mask, state_.light_set.revision);
    const Stopwatch tracing;
    const TraceStats stats = tracer_.trace(request, traced_);
    const double trace_ms = ms_of(tracing.elapsed());
    const Stopwatch packing;
    const auto datagrams = pack(packer_, traced_, {.frame = request.frame});
    const double pack_ms = ms_of(packing.elapsed());
    double bytes = 0;
    for (const std::vector<std::byte>& datagram : datagrams) bytes += static_cast<double>(datagram.size());
    const double taken_ms = collect_ms(assembler_, datagrams);
    const std::vector<TracedMask> masks = usable_masks(assembler_, shown.frame);
    renderer_->draw({.views = shown.views,
                     .state = state_,
                     .request = &request,
                     .masks = masks,
                     .reprojection = {},
                     .request_slot = assembler_.find(request.frame)->slot});
    const DrawTimes drawn = renderer_->finish();
    if (masks.empty()) return std::nullopt;
    return Figures{.rays = static_cast<double>(stats.primary_rays + stats.shadow_rays),
                   .shadow_rays = static_cast<double>(stats.shadow_rays),
                   .bytes = bytes,
                   .server_bytes = static_cast<double>(server_bytes()),
                   .client_bytes = static_cast<double>(renderer_->counters().memory.peak_total),
                   .trace_ms = trace_ms,
                   .pack_ms = pack_ms,
                   .collect_ms = taken_ms,
                   .gbuffer_ms = ms_of(drawn.gbuffer),
                   .depth_ms = ms_of(drawn.depth),
                   .shade_ms = ms_of(drawn.shade),
                   .client_ms = taken_ms + ms_of(drawn.total)};
  }

  [[nodiscard]] const PlannedScene& planned() const { return planned_; }
  [[nodiscard]] const gpu::Device& device() const { return device_; }
  [[nodiscard]] double building_mb() const { return static_cast<double>(tracer_.memory().most()) * 1e-6; }

 private:
  /// tracer and masks
  [[nodiscard]] std::size_t server_bytes() const {
    return tracer_.memory().total() + traced_.masks[0].bytes().size() + traced_.masks[1].bytes().size();
  }

  PlannedScene planned_;
  gpu::Device device_;  ///< its own device, because memory is counted per device
  Tracer tracer_;
  FramePacker packer_;
  Assembler assembler_{kRing_frames};
  ShadowFrame traced_;
  std::unique_ptr<Renderer> renderer_;
  SceneState state_;
};

double median(const std::vector<Figures>& figures, const Row& row) {
  std::vector<double> values;
  for (const Figures& one : figures) values.push_back(one.*row.value * row.unit);
  return quantile(values, 0.5);
}

/// Prints one figure of both plans. Returns true if the needed plan is better.
bool print_row(const char* name, const char* format, double needed, double everything) {
  std::printf("  %-32s ", name);
  std::printf(format, needed);
  std::printf(" ");
  std::printf(format, everything);
  std::printf(" %8.3f\n", needed / everything);
  return needed < everything;
}

bool compare(const Options& options) {
  const Scene scene = value_of(load_scene(options.scene));
  const HeadRecording head = value_of(load_head_recording(options.trace));
  const Extent size{options.side_px, options.side_px};
  const auto placed = scene.camera ? place(head, *scene.camera) : Rigid<Stage, Recorded>{};
  std::array<PlanPair, 2> pairs{PlanPair(options, scene, PlanKind::Needed, size),
                                PlanPair(options, scene, PlanKind::Everything, size)};
  RequestPlan plan(RequestSettings{});
  plan.learn(kPeriod * kLate_frames);
  std::array<std::vector<Figures>, 2> figures;
  constexpr std::uint32_t kWarmUp = 8;
  for (std::uint32_t number = 1; number <= kWarmUp + options.frames; ++number) {
    const FrameMoment shown = shown_at(head, placed, number, options.side_px);
    const FrameRequest request = plan.ask(shown, kPeriod).value();
    for (const std::size_t pair : {number % 2, 1 - number % 2}) {
      const std::optional<Figures> taken = pairs[pair].frame(shown, request);
      if (taken && number > kWarmUp) figures[pair].push_back(*taken);
    }
  }
  std::printf("%s%s along %s on %s, %ux%u an eye, medians of %zu frames\n",
              in_words(pairs[0].planned().plan, pairs[0].planned().scene).c_str(), scene.name.c_str(),
              options.trace.c_str(), pairs[0].device().name.c_str(), size.width, size.height,
              figures[0].size());
  std::printf("  %-32s %10s %10s %8s\n", "a frame, both eyes", "needed", "everything", "ratio");
  bool ahead = true;
  for (const Row& row : kRows)
    ahead &= print_row(row.name, row.format, median(figures[0], row), median(figures[1], row));
  std::printf("peak memory of the server's tracer while it is built: %.1f MB and %.1f MB\n",
              pairs[0].building_mb(), pairs[1].building_mb());
  std::printf("the plan is %s\n", ahead ? "better in every row" : "NOT better in every row");
  return ahead;
}

}  // namespace
}  // namespace farshade::bench

int main(int argc, char** argv) try {
  farshade::bench::Options options;
  CLI::App app("Measures what a scene's plan saves, compared with a plan that has every feature.");
  app.add_option("--scene", options.scene, "glTF 2.0 file")->required();
  app.add_option("--trace", options.trace, "recorded head")->capture_default_str();
  app.add_option("--size", options.side_px, "pixels a side of an eye")->capture_default_str();
  app.add_option("--frames", options.frames, "frames to measure")->capture_default_str();
  app.add_option("--gpu", options.gpu, "use only a device whose name contains this");
  CLI11_PARSE(app, argc, argv);
  return farshade::bench::compare(options) ? EXIT_SUCCESS : EXIT_FAILURE;
} catch (const std::exception& error) {
  std::fprintf(stderr, "plan_bench: %s\n", error.what());
  return EXIT_FAILURE;
}
