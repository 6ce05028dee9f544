// Prints the picture error for each network in virtual time, and the client's frame times on this machine.
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <numeric>

#include "stereo/base/quantile.h"
#include "stereo/gltf/load_lit_scene.h"
#include "stereo/gpu/device.h"
#include "stereo/head/reader.h"
#include "stereo/options/command_line.h"
#include "stereo/options/within.h"
#include "stereo/scene/lighting.h"
#include "tests/network/rehearsal.h"

namespace {

using namespace farshade;

struct Options {
  std::string scene = FARSHADE_ASSETS "/room.glb", head = FARSHADE_ASSETS "/walk.csv", csv;
  std::vector<std::string> networks;
  std::uint32_t side_px = 256, frames = 432, every = 12;
  double skip_s = 0;
};

double mean(const std::vector<double>& values) {
  return values.empty()
             ? 0
             : std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

std::vector<double> frame_ms(const Played& run) {
  std::vector<double> ms;
  for (const FrameRecord& record : run.log.records()) ms.push_back(ms_of(record.times.frame));
  return ms;
}

double median_age_ms(const Played& run) {
  std::vector<double> ms;
  for (const PlayedFrame& frame : run.frames)
    if (frame.newest) ms.push_back(ms_of(frame.at - *frame.newest_asked));
  return ms.empty() ? 0 : quantile(ms, 0.5);
}

void print_row(const Network& network, const Played& run, std::FILE* csv, double seconds) {
  const std::vector<double> error = run.worse_eye(&EyeErrors::mask_error),
                            psnr = run.worse_eye(&EyeErrors::psnr_db),
                            unknown = run.worse_eye(&EyeErrors::unknown), ms = frame_ms(run);
  const auto at = [](const std::vector<double>& values, double q) {
    return values.empty() ? 0 : quantile(values, q);
  };
  const double row[] = {100 * at(error, 0.5),
                        100 * at(error, 0.99),
                        mean(psnr),
                        at(psnr, 0.01),
                        100 * mean(unknown),
                        100 * run.mean_of(&PlayedFrame::tiles_current),
                        100 * run.mean_of(&PlayedFrame::tiles_recent),
                        median_age_ms(run),
                        static_cast<double>(run.server.frames) / seconds,
                        at(ms, 0.5),
                        at(ms, 0.99)};
  std::printf("%-34s %7.3f /%7.3f %7.2f /%6.2f %8.3f %6.1f /%6.1f %7.0f %8.1f %7.1f /%6.1f\n",
              network.name.c_str(), row[0], row[1], row[2], row[3], row[4], row[5], row[6], row[7], row[8],
              row[9], row[10]);
  std::fflush(stdout);
  if (csv == nullptr) return;
  std::fprintf(csv, "\"%s\"", network.name.c_str());
  for (const double value : row) std::fprintf(csv, ",%.4f", value);
  std::fprintf(csv, "\n");
}

Expected<void> print_table(const Options& options) {
  const Expected<Scene> scene =
      load_lit_scene(options.scene, {}).map([](LitScene&& lit) { return std::move(lit.scene); });
  if (!scene) return tl::unexpected(scene.error());
  const Expected<HeadRecording> head = load_head_recording(options.head, {});
  if (!head) return tl::unexpected(head.error());
  const Expected<gpu::Device> device = gpu::open_device({});
  if (!device) return tl::unexpected(device.error());
  std::vector<Network> networks = options.networks.empty() ? named_networks() : std::vector<Network>{};
  for (const std::string& text : options.networks) {
    const Expected<Network> network = network_from(text);
    if (!network) return tl::unexpected(network.error());
    networks.push_back(*network);
  }
  std::FILE* const csv = options.csv.empty() ? nullptr : std::fopen(options.csv.c_str(), "w");
  if (!options.csv.empty() && csv == nullptr)
    return fail(Fault::Unreadable, options.csv + " cannot be written");
  if (csv)
    std::fprintf(
        csv,
        "network,mask_error_median_percent,mask_error_p99_percent,psnr_mean_db,psnr_p99_db,unknown_percent,"
        "tiles_current_percent,tiles_recent_percent,age_median_ms,masks_per_second,client_frame_median_ms,"
        "client_frame_p99_ms\n");
  std::printf("%s, %s, %ux%u an eye, %u frames at 72 Hz, every %uth measured; worse eye\n",
              options.scene.c_str(), options.head.c_str(), options.side_px, options.side_px, options.frames,
              options.every);
  std::printf("%-34s %16s %15s %8s %14s %7s %8s %15s\n", "network, per direction", "mask error %", "PSNR dB",
              "unknown", "tiles now, or", "age", "masks", "client ms");
  std::printf("%-34s %16s %15s %8s %14s %7s %8s %15s\n", "", "median / p99", "mean / p99", "%",
              "a mask ago %", "ms", "a second", "median / p99");
  for (const Network& network : networks) {
    const Played run = play({.device = *device,
                             .scene = *scene,
                             .head = *head,
                             .size = {options.side_px, options.side_px},
                             .frames = options.frames,
                             .reference_every = options.every,
                             .skip = duration_from_ms(options.skip_s * 1e3)},
                            network);
    print_row(network, run, csv, options.frames / 72.0);
  }
  if (csv) std::fclose(csv);
  return {};
}

}  // namespace

int main(int argc, char** argv) try {
  CLI::App app("Error and run time of the whole system over bad networks, in virtual time.");
  make_readable(app);
  Options options;
  app.add_option("--scene", options.scene, "glTF scene")->capture_default_str();
  app.add_option("--trace", options.head, "recorded head")->capture_default_str();
  app.add_option("--network", options.networks,
                 "a named network or words such as loss=5%,delay=25ms; each gives a row");
  app.add_option("--size", options.side_px, "pixels a side of an eye")
      ->check(within(16, 4096))
      ->capture_default_str();
  app.add_option("--frames", options.frames, "display frames")
      ->check(within(1, 100000))
      ->capture_default_str();
  app.add_option("--every", options.every, "measure every Nth frame")
      ->check(within(1, 100000))
      ->capture_default_str();
  app.add_option("--skip", options.skip_s, "seconds of the head's beginning to leave out")
      ->capture_default_str();
  app.add_option("--csv", options.csv, "write the rows there, too");
  CLI11_PARSE(app, argc, argv);
  spdlog::set_level(spdlog::level::warn);
  const Expected<void> done = print_table(options);
  if (done) return EXIT_SUCCESS;
  std::fprintf(stderr, "network_table: %s\n", done.error().what.c_str());
  return EXIT_FAILURE;
} catch (const std::exception& error) {
  std::fprintf(stderr, "network_table: %s\n", error.what());
  return EXIT_FAILURE;
}
