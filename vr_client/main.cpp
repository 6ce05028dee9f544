// vr_client: shows a scene to both eyes along a head recording, with shadows that an rt_server traces.
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include "stereo/base/heap.h"
#include "vr_client/app.h"
#include "vr_client/doctor/doctor.h"
#include "vr_client/fetched_scene.h"
#include "vr_client/pair/pair.h"

/// What a shell gives for a program that SIGINT has ended.
constexpr int kInterrupted = 130;

int main(int argc, char** argv) try {
  using namespace farshade;
  keep_freed_memory();
  spdlog::set_default_logger(spdlog::stderr_color_mt("vr_client"));
  spdlog::set_pattern("vr_client: %v");
  tl::expected<Options, EarlyExit> options = read_options(argc, argv);
  if (!options) return options.error().status;
  if (options->pair) {
    const Expected<std::string> paired = pair_with_server(*options->pair);
    if (!paired) spdlog::error(paired.error().what);
    std::fputs(paired.value_or("").c_str(), stdout);
    return paired ? EXIT_SUCCESS : EXIT_FAILURE;
  }
  if (options->doctor) return report(examine(*options->doctor));
  if (const Expected<void> scene = fetch_if_missing(*options); !scene) {
    spdlog::error(scene.error().what);
    return EXIT_FAILURE;
  }
  const auto task = options->plan.prints_only        ? print_plan
                    : !options->export_trace.empty() ? export_head_recording
                    : !options->replay.empty()       ? run_replay
                    : options->preview               ? run_preview
                                                     : run_client;
  if (const Expected<void> done = task(*options); !done) {
    spdlog::error(done.error().what);
    return done.error().fault == Fault::Interrupted ? kInterrupted : EXIT_FAILURE;
  }
  return EXIT_SUCCESS;
} catch (const std::exception& error) {
  std::fprintf(stderr, "vr_client: %s\n", error.what());
  return EXIT_FAILURE;
}
