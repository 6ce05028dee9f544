// Compares the whole server frame with its tracing: a request arrives, both eyes are traced, packed, sealed
// and sent over UDP on loopback. Target: the median frame takes at most 1.35 times the median of primary and
// shadow stage.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <thread>

#include "rt_server/answers/answers.h"
#include "rt_server/work/server_core.h"
#include "stereo/base/check.h"
#include "stereo/base/heap.h"
#include "stereo/base/quantile.h"
#include "stereo/gltf/gltf.h"
#include "stereo/link/network_link.h"
#include "stereo/net/udp.h"

namespace {

using namespace farshade;

constexpr double kFigure = 1.35;

struct Options {
  std::string scene;
  std::uint32_t side_px = 1024;
  std::uint32_t frames = 30;
};

/// A head at the scene's reference camera that looks around: +-30 degrees in 60 frames.
FrameRequest request_of(const Scene& scene, std::uint32_t number, std::uint32_t side_px) {
  const double yaw_rad = 0.5 * std::sin(number * 0.105);
  const Rigid<Eye, Head> camera_from_head{glm::angleAxis(yaw_rad, glm::dvec3(0, 1, 0)), glm::dvec3(0)};
  FrameRequest request;
  request.frame = {number};
  for (const Side side : kSides) {
    const Rigid<Head, Eye> head_from_eye{{1, 0, 0, 0}, {side == Side::Left ? -0.032 : 0.032, 0, 0}};
    View& view = request.views[index_of(side)];
    view.stage_from_eye = scene.camera.value_or(Rigid<Stage, Eye>{}) * camera_from_head * head_from_eye;
    view.fov = {-0.8, 0.8, 0.8, -0.8};
    view.size = {side_px, side_px};
  }
  return request;
}

struct Row {
  double frame_ms, trace_ms, pack_ms, send_ms, datagrams, kilobytes, megarays;
};

/// Sends the messages that work() has left in the outbox when they are due. Returns the time that this took,
/// without waits.
Duration send_all(ServerCore& core) {
  Duration busy{};
  while (const std::optional<Time> due = core.next_send()) {
    if (*due > core.clock().now()) continue;
    const Stopwatch sending;
    core.send_due();
    busy += sending.elapsed();
  }
  return busy;
}

std::vector<double> column(const std::vector<Row>& rows, double Row::*value) {
  std::vector<double> values;
  for (const Row& row : rows) values.push_back(row.*value);
  return values;
}

double print(const char* stage, const std::vector<double>& values) {
  const Spread spread = spread_of(values);
  std::printf("%-18s %8.2f %8.2f %8.2f\n", stage, spread.median, spread.p95, spread.p99);
  return spread.median;
}

void print_rows(const std::vector<Row>& rows) {
  std::printf("%-18s %8s %8s %8s\n", "[ms]", "median", "p95", "p99");
  const double trace_ms = print("primary + shadow", column(rows, &Row::trace_ms));
  print("pack", column(rows, &Row::pack_ms));
  print("seal, send, rest", column(rows, &Row::send_ms));
  const double frame_ms = print("whole frame", column(rows, &Row::frame_ms));
  print("datagrams", column(rows, &Row::datagrams));
  print("payload [kB]", column(rows, &Row::kilobytes));
  print("shadow rays [M]", column(rows, &Row::megarays));
  std::printf("whole frame / (primary + shadow): %.3f (to reach: <= %.2f)\n", frame_ms / trace_ms, kFigure);
}

Expected<void> run(const Options& options) {
  const Expected<Scene> scene = load_scene(options.scene);
  if (!scene) return tl::unexpected(scene.error());
  Expected<Tracer> tracer = Tracer::create(*scene);
  if (!tracer) return tl::unexpected(tracer.error());
  const Expected<std::unique_ptr<DatagramPort>> port = listen_udp("127.0.0.1:0");
  if (!port) return tl::unexpected(port.error());
  const Expected<UdpClient> client = connect_udp(to_string((*port)->local()));
  if (!client) return tl::unexpected(client.error());

  const SteadyClock clock;
  const auto light_count = narrow<std::uint32_t>(scene->lights.size());
  const SharedKey key{.name = "bench", .secret = {1}};
  RequestHandlers answers;
  answers.add(Answer::Masks, make_masks(*tracer));
  ServerCore core({scene->hash, light_count}, {key}, std::move(answers), **port, clock);
  NetworkLink link(*client->port, clock, {client->server, key, scene->hash, {light_count}}, 8);
  {
    std::jthread welcoming([&](const std::stop_token& stop) {
      while (!stop.stop_requested()) core.receive(std::chrono::milliseconds(10));
    });
    if (const Expected<void> connected = link.connect(std::chrono::seconds(3)); !connected) return connected;
  }

  std::vector<Row> rows;
  std::uint32_t complete = 0;
  constexpr std::uint32_t kWarmUp = 3;
  for (std::uint32_t number = 1; number <= options.frames + kWarmUp; ++number) {
    link.request(request_of(*scene, number, options.side_px), {});
    core.receive(std::chrono::seconds(1));
    while (core.next_due() && *core.next_due() > clock.now())
      continue;  // until the paced datagrams of the last frame are sent
    const Stopwatch working;
    core.work();
    const Duration frame = working.elapsed() + send_all(core);
    link.poll();
    const RequestRecord& received = *link.receiver().find({number});
    if (number <= kWarmUp || !received.report) continue;
    complete += received.complete() ? 1 : 0;
    const FrameReport& report = *received.report;
    const double frame_ms = ms_of(frame), trace_ms = ms_of(report.primary + report.shadow),
                 pack_ms = ms_of(report.pack);
    rows.push_back({frame_ms, trace_ms, pack_ms, frame_ms - trace_ms - pack_ms,
                    static_cast<double>(report.slices), report.payload_bytes / 1e3,
                    static_cast<double>(report.shadow_rays) / 1e6});
  }
  if (rows.empty()) return fail(Fault::Unavailable, "no frame came back over loopback");

  std::printf("%s, %ux%u an eye, %u lights, %zu frames, %u arrived whole\n", scene->name.c_str(),
              options.side_px, options.side_px, light_count, rows.size(), complete);
  print_rows(rows);
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  keep_freed_memory();
  CLI::App app("Compares the whole server frame with its tracing.");
  Options options;
  app.add_option("--scene", options.scene, "glTF 2.0 file")->required();
  app.add_option("--size", options.side_px, "width and height of an eye in pixels")->capture_default_str();
  app.add_option("--frames", options.frames, "frames to measure")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  const Expected<void> done = run(options);
  if (!done) std::fprintf(stderr, "server_bench: %s\n", done.error().what.c_str());
  return done ? EXIT_SUCCESS : EXIT_FAILURE;
}
