// study_point: one point of a study, as JSON on stdout. scripts/study runs it, point by point.
#include <spdlog/spdlog.h>
#include <sys/prctl.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>

#include "stereo/head/reader.h"
#include "stereo/scene/gltf.h"
#include "tests/study/clients.h"
#include "tests/study/mode_words.h"
#include "tests/study/point.h"

namespace {

using namespace farshade;
using namespace farshade::study;

struct Wish {
  std::string scene, trace, network = "none", gpu;
  std::filesystem::path pictures;
  Rounds rounds;
  std::uint32_t side_px = 256, frames = 72, every = 8, clients = 0;
  double skip_s = 0;
  bool timing = false, versions = false;
};

/// What the figures were measured with, as far as this program alone can tell.
Expected<nlohmann::json> versions(const Wish& wish) {
  const Expected<gpu::Survey> survey = gpu::survey({.name_contains = wish.gpu});
  if (!survey) return tl::unexpected(survey.error());
  nlohmann::json told{{"compiler", STUDY_COMPILER}, {"flags", STUDY_FLAGS}, {"loader", survey->loader}};
  for (const gpu::SurveyedDevice& device : survey->devices)
    if (device.passed_over.empty())
      told.update({{"device", device.name}, {"driver", device.driver}, {"api", device.api}});
  return told;
}

Expected<nlohmann::json> measured(const Wish& wish) {
  if (wish.versions) return versions(wish);
  const Expected<Scene> scene = load_scene(wish.scene);
  if (!scene) return tl::unexpected(scene.error());
  const Expected<HeadRecording> head = load_head_recording(wish.trace, {});
  if (!head) return tl::unexpected(head.error());
  const Expected<Network> network = network_from(wish.network);
  if (!network) return tl::unexpected(network.error());
  const Expected<gpu::Device> device = gpu::open_device({.name_contains = wish.gpu});
  if (!device) return tl::unexpected(device.error());
  Play play{.device = *device,
            .scene = *scene,
            .head = *head,
            .size = {wish.side_px, wish.side_px},
            .frames = wish.frames,
            .reference_every = wish.every,
            .skip = duration_from_ms(wish.skip_s * 1e3)};
  if (wish.clients > 0) return measure_clients(play, wish.clients, wish.rounds.warm_up);
  if (wish.timing) return measure_rounds(play, *network, wish.rounds);
  return set_mode(wish.rounds.modes.at(0), play).and_then([&] {
    return measure_point(play, *network, wish.pictures);
  });
}

void add_options(CLI::App& app, Wish& wish) {
  app.add_option("--scene", wish.scene, "glTF scene");
  app.add_option("--trace", wish.trace, "recorded head");
  app.add_option("--network", wish.network, "a named network or words such as loss=5%,delay=25ms, each way");
  app.add_option("--modes", wish.rounds.modes, "mode words; one, or all that --timing compares");
  app.add_option("--size", wish.side_px, "pixels a side of an eye")->check(CLI::Range(16, 4096));
  app.add_option("--frames", wish.frames, "display frames")->check(CLI::Range(1, 100000));
  app.add_option("--every", wish.every, "measure every Nth frame")->check(CLI::Range(1, 100000));
  app.add_option("--skip", wish.skip_s, "seconds of the recording to leave out")->check(CLI::Range(0.0, 1e6));
  app.add_option("--pictures", wish.pictures, "folder for pictures of the worst frame");
  app.add_option("--clients", wish.clients, "time of a server with so many clients")
      ->check(CLI::Range(1, 64));
  app.add_flag("--timing", wish.timing, "run times of --modes, without a reference");
  app.add_option("--rounds", wish.rounds.rounds, "of --timing")->check(CLI::Range(1, 1000));
  app.add_option("--warm-up", wish.rounds.warm_up, "frames that --timing and --clients leave out");
  app.add_option("--seed", wish.rounds.seed, "of the order of modes");
  app.add_option("--gpu", wish.gpu, "use only a device whose name contains this");
  app.add_flag("--versions", wish.versions, "tell device and compiler, and measure nothing");
}

}  // namespace

int main(int argc, char** argv) try {
  prctl(PR_SET_PDEATHSIG, SIGKILL);  // a study that is killed leaves nobody behind who takes the cores
  CLI::App app("One point of a study, as JSON.");
  Wish wish;
  add_options(app, wish);
  CLI11_PARSE(app, argc, argv);
  spdlog::set_level(spdlog::level::warn);
  const Expected<nlohmann::json> told = measured(wish);
  if (told) return std::puts(told->dump(1).c_str()) < 0 ? EXIT_FAILURE : EXIT_SUCCESS;
  std::fprintf(stderr, "study_point: %s\n", told.error().what.c_str());
  return EXIT_FAILURE;
} catch (const std::exception& error) {
  std::fprintf(stderr, "study_point: %s\n", error.what());
  return EXIT_FAILURE;
}
