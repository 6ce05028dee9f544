// study_point: measures one point of a study and prints it as JSON. scripts/study runs it for each point.
#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <sys/prctl.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>

#include "stereo/base/heap.h"
#include "stereo/gltf/load_lit_scene.h"
#include "stereo/gpu/device.h"
#include "stereo/head/reader.h"
#include "stereo/lod/levels.h"
#include "stereo/options/command_line.h"
#include "stereo/options/start_pose_option.h"
#include "stereo/options/within.h"
#include "stereo/scene/lighting.h"
#include "tests/study/clients.h"
#include "tests/study/mode_words.h"
#include "tests/study/point.h"

namespace {

using namespace farshade;
using namespace farshade::study;

struct Options {
  std::string scene, trace, network = "none", gpu;
  std::filesystem::path pictures;
  Rounds rounds;
  std::uint32_t side_px = 256, frames = 72, every = 8, samples = 1, clients = 0, warm_up = 10;
  double skip_s = 0;
  std::optional<StartPose> start_pose;
  bool timing = false, versions = false;
};

std::string version_text(std::uint32_t version) {
  return fmt::format("{}.{}.{}", VK_API_VERSION_MAJOR(version), VK_API_VERSION_MINOR(version),
                     VK_API_VERSION_PATCH(version));
}

/// Compiler, flags, Vulkan loader and device of this program.
Expected<nlohmann::json> versions(const Options& options) {
  const Expected<gpu::Device> device = gpu::open_device({.name_contains = options.gpu});
  if (!device) return tl::unexpected(device.error());
  const auto all =
      device->physical.getProperties2<vk::PhysicalDeviceProperties2, vk::PhysicalDeviceDriverProperties>();
  const auto& driver = all.get<vk::PhysicalDeviceDriverProperties>();
  return nlohmann::json{
      {"compiler", STUDY_COMPILER},
      {"flags", STUDY_FLAGS},
      {"loader", version_text(device->context.enumerateInstanceVersion())},
      {"device", device->name},
      {"driver", std::string(driver.driverName.data()) + " " + driver.driverInfo.data()},
      {"api", version_text(all.get<vk::PhysicalDeviceProperties2>().properties.apiVersion)}};
}

Expected<nlohmann::json> measured(const Options& options) {
  if (options.versions) return versions(options);
  Expected<Scene> scene =
      load_lit_scene(options.scene, {}).map([](LitScene&& lit) { return std::move(lit.scene); });
  if (!scene) return tl::unexpected(scene.error());
  scene->camera = viewpoint_of(*scene, options.start_pose);
  const Expected<HeadRecording> head = load_head_recording(options.trace, {});
  if (!head) return tl::unexpected(head.error());
  const Expected<Network> network = network_from(options.network);
  if (!network) return tl::unexpected(network.error());
  const Expected<gpu::Device> device = gpu::open_device({.name_contains = options.gpu});
  if (!device) return tl::unexpected(device.error());
  const SceneLevels levels = make_levels(*scene);
  Play play{.device = *device,
            .scene = *scene,
            .head = *head,
            .size = {options.side_px, options.side_px},
            .frames = options.frames,
            .reference_every = options.every,
            .reference_samples = options.samples,
            .skip = duration_from_ms(options.skip_s * 1e3),
            .levels = &levels};
  if (options.timing) return measure_rounds(play, *network, options.rounds);
  return set_mode(options.rounds.modes.at(0), play).and_then([&]() -> Expected<nlohmann::json> {
    if (options.clients > 0) return measure_clients(play, options.clients, options.warm_up);
    return measure_point(play, *network, options.pictures);
  });
}

void add_options(CLI::App& app, Options& options) {
  app.add_option("--scene", options.scene, "glTF scene");
  app.add_option("--trace", options.trace, "recorded head");
  app.add_option("--network", options.network,
                 "a named network or words such as loss=5%,delay=25ms, each way");
  app.add_option("--modes", options.rounds.modes, "mode words; one, or all that --timing compares");
  app.add_option("--size", options.side_px, "pixels a side of an eye")->check(within(16, 4096));
  app.add_option("--frames", options.frames, "display frames; with --timing, the number of timed frames")
      ->check(within(1, 100000));
  app.add_option("--samples", options.samples,
                 "compare with a full trace of N x N samples a pixel, too, which has smooth edges")
      ->check(within(1, 16));
  app.add_option("--every", options.every, "compare every Nth frame with its reference")
      ->check(within(1, 100000));
  app.add_option("--skip", options.skip_s, "seconds to skip at the start of the recording")
      ->check(within(0.0, 1e6));
  add_start_pose_option(app, options.start_pose);
  app.add_option("--pictures", options.pictures, "folder for pictures of the worst frame");
  app.add_option("--clients", options.clients, "measure the time of a server with this many clients")
      ->check(within(1, 64));
  app.add_flag("--timing", options.timing, "run times of --modes, without a reference");
  app.add_option("--rounds", options.rounds.rounds, "number of rounds of --timing")->check(within(1, 1000));
  app.add_option("--warm-up", options.warm_up, "frames before --clients starts to time");
  app.add_option("--seed", options.rounds.seed, "seed for the order of modes");
  app.add_option("--gpu", options.gpu, "use only a device whose name contains this");
  app.add_flag("--versions", options.versions, "print device and compiler, and measure nothing");
}

}  // namespace

int main(int argc, char** argv) try {
  keep_freed_memory();
  prctl(PR_SET_PDEATHSIG, SIGKILL);  // if the study is killed, its points end, too
  CLI::App app("One point of a study, as JSON.");
  make_readable(app);
  Options options;
  add_options(app, options);
  CLI11_PARSE(app, argc, argv);
  spdlog::set_level(spdlog::level::warn);
  const Expected<nlohmann::json> told = measured(options);
  if (told) return std::puts(told->dump(1).c_str()) < 0 ? EXIT_FAILURE : EXIT_SUCCESS;
  std::fprintf(stderr, "study_point: %s\n", told.error().what.c_str());
  return EXIT_FAILURE;
} catch (const std::exception& error) {
  std::fprintf(stderr, "study_point: %s\n", error.what());
  return EXIT_FAILURE;
}
