// The client's frame against its bare G-buffer pass, interleaved in one run: slices decoded and assembled,
// both eyes drawn, masks carried over, shaded. Figure to reach: median frame <= 2.0 x median bare G-buffer
// pass.
#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>

#include "stereo/base/quantile.h"
#include "stereo/net/assembler.h"
#include "stereo/net/frame_packer.h"
#include "stereo/scene/gltf.h"
#include "stereo/trace/reader.h"
#include "stereo/tracer/tracer.h"
#include "vr_client/draw/renderer.h"

namespace {

using namespace farshade;

constexpr double kFigure = 2.0;
constexpr std::uint32_t kStaleness_frames = 2;
constexpr std::size_t kRing_frames = kStaleness_frames + ShadingPass::kMaxMasks + 1;

struct Options {
  std::string scene, trace = FARSHADE_ASSETS "/walk.csv", gpu;
  std::uint32_t side_px = 1024, frames = 24;
};

struct Times {
  std::vector<double> bare, bare_device, frame, collect, draw, gbuffer, shade, shade_direct;
};

TraceRequest request_at(const HeadTrace& trace, const Rigid<Stage, Recorded>& placed, std::uint32_t number,
                        std::uint32_t side_px) {
  const Time time = trace.start() + Duration(std::llround(number * 1e9 / 72));
  TraceRequest request{{number}, time, Time{}, {}};
  for (const Side side : kSides)
    request.views[index_of(side)] = {
        placed * head_at(trace, time) * head_from_eye(side, trace.eye_distance_m),
        trace.fov[index_of(side)],
        {side_px, side_px}};
  return request;
}

/// Takes in a frame's datagrams as the client does; the time that took.
double collect_ms(Assembler& assembler, std::span<const std::vector<std::byte>> datagrams) {
  const Stopwatch watch;
  for (const std::vector<std::byte>& datagram : datagrams) {
    const Decoded<ServerMessage> message = decode_server(datagram);
    if (const auto* slice = message ? std::get_if<Slice>(&*message) : nullptr) assembler.accept(*slice);
  }
  return ms_of(watch.elapsed());
}

std::vector<MaskInHand> masks_in_hand(const Assembler& assembler, FrameId shown) {
  std::vector<MaskInHand> masks;
  for (std::uint32_t age = kStaleness_frames; age < kStaleness_frames + ShadingPass::kMaxMasks; ++age)
    if (const ReceivedFrame* frame = assembler.find({shown.value - age}); frame && frame->complete())
      masks.push_back({frame->request.frame, frame->request.display_time, frame->request.views, frame->masks,
                       frame->known_tiles, 1});
  return masks;
}

void print(const char* label, const std::vector<double>& values) {
  const Spread spread = spread_of(values);
  std::printf("  %-34s %9.2f %9.2f %9.2f\n", label, spread.median, quantile(values, 0.1), spread.p95);
}

Expected<void> run(const Options& options) {
  const Expected<Scene> scene = load_scene(options.scene);
  if (!scene) return tl::unexpected(scene.error());
  const Expected<HeadTrace> trace = load_head_trace(options.trace);
  if (!trace) return tl::unexpected(trace.error());
  const Expected<gpu::Device> device = gpu::open_device({options.gpu, gpu::Validation::Off});
  if (!device) return tl::unexpected(device.error());
  Expected<Tracer> tracer = Tracer::create(*scene);
  if (!tracer) return tl::unexpected(tracer.error());

  const Rigid<Stage, Recorded> placed =
      scene->camera ? place(*trace, *scene->camera) : Rigid<Stage, Recorded>{};
  const auto lights = static_cast<std::uint32_t>(scene->lights.size());
  Renderer renderer(*device, *scene, {options.side_px, options.side_px}, kRing_frames);
  Assembler assembler(kRing_frames);
  FramePacker packer;
  ShadowFrame traced;
  const SceneState state = state_at(*scene, Time{});
  Times times;
  constexpr std::uint32_t warm_up = 8;
  for (std::uint32_t number = 1; number <= warm_up + options.frames; ++number) {
    const TraceRequest request = request_at(*trace, placed, number, options.side_px);
    assembler.expect(request, lights, state.light_set.revision);
    const ShownFrame bare{request.frame, request.views, state, {}};
    const DrawTimes gbuffer = renderer.draw_gbuffer(bare);

    tracer->trace(request, traced);
    FrameReport report;
    report.frame = request.frame;
    const double collect = collect_ms(assembler, packer.pack(traced, report));
    const std::vector<MaskInHand> masks = masks_in_hand(assembler, request.frame);
    if (masks.empty()) continue;
    const ShownFrame frame{request.frame, request.views, state, masks};
    const DrawTimes drawn = renderer.draw(frame);
    const DrawTimes direct = renderer.shade_again(frame, masks.front());
    if (number <= warm_up) continue;
    times.bare.push_back(ms_of(gbuffer.total));
    times.bare_device.push_back(ms_of(gbuffer.gbuffer));
    times.collect.push_back(collect);
    times.draw.push_back(ms_of(drawn.total));
    times.frame.push_back(collect + ms_of(drawn.total));
    times.gbuffer.push_back(ms_of(drawn.gbuffer));
    times.shade.push_back(ms_of(drawn.shade));
    times.shade_direct.push_back(ms_of(direct.shade));
  }
  std::printf("%s along %s on %s, %zu frames\n", scene->name.c_str(), options.trace.c_str(),
              device->name.c_str(), times.frame.size());
  std::printf("  %-34s %9s %9s %9s\n", "ms", "median", "p10", "p95");
  print("bare G-buffer pass", times.bare);
  print("  of it on the device", times.bare_device);
  print("client frame", times.frame);
  print("  collect masks", times.collect);
  print("  draw", times.draw);
  print("    G-buffer", times.gbuffer);
  print("    reproject and shade", times.shade);
  print("shading alone (mask at the pixel)", times.shade_direct);
  const double ratio = quantile(times.frame, 0.5) / quantile(times.bare, 0.5);
  std::printf("client frame / bare G-buffer pass = %.3f (figure: <= %.1f)\n", ratio, kFigure);
  return {};
}

}  // namespace

int main(int argc, char** argv) try {
  CLI::App app("Times the client's frame against its bare G-buffer pass.");
  Options options;
  app.add_option("--scene", options.scene, "glTF 2.0 file")->required();
  app.add_option("--trace", options.trace, "recorded head")->capture_default_str();
  app.add_option("--size", options.side_px, "pixels of each side of an eye")->capture_default_str();
  app.add_option("--frames", options.frames, "frames measured")->capture_default_str();
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
