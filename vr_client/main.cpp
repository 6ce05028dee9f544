// vr_client: shows a scene to both eyes along a head recording, with shadows that an rt_server traces.
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <optional>

#include "stereo/base/heap.h"
#include "stereo/sealing/layout.h"
#include "vr_client/app.h"
#include "vr_client/doctor/device_facts.h"
#include "vr_client/doctor/doctor.h"
#include "vr_client/fetched_scene.h"
#include "vr_client/pair/pair.h"

namespace {

using namespace farshade;

/// The task that the options name. Only runs of many frames finish their files after a signal.
Expected<void> carry_out(const Options& options, std::optional<StopSignal>& stop) {
  stop.reset();
  if (options.plan.prints_only) return print_plan(options);
  if (!options.export_trace.empty()) return export_head_recording(options);
  stop.emplace();
  if (options.xr != Xr::None) {
    const Expected<std::unique_ptr<HeadsetSystem>> headset = HeadsetSystem::open();
    if (headset) return run_headset(options, **headset, *stop);
    if (options.xr == Xr::OpenXr) return tl::unexpected(headset.error());
    spdlog::info("{} is shown instead of a headset: {}", preview_follows(options) ? "a window" : "a replay",
                 headset.error().what);
  }
  if (preview_follows(options)) {
    Options window = options;
    window.preview = true;  // without a headset, --xr auto is --preview
    return run_preview(window, *stop);
  }
  return options.replay.empty() ? run_client(options, *stop) : run_replay(options, *stop);
}

/// Prints the text of a subcommand, or why there is none. Returns the exit status.
int print(const Expected<std::string>& text) {
  if (!text) spdlog::error(text.error().what);
  std::fputs(text.value_or("").c_str(), stdout);
  return text ? EXIT_SUCCESS : EXIT_FAILURE;
}

}  // namespace

int main(int argc, char** argv) try {
  check_layout();
  keep_freed_memory();
  spdlog::set_default_logger(spdlog::stderr_color_mt("vr_client"));
  spdlog::set_pattern("vr_client: %v");
  tl::expected<Options, EarlyExit> options = read_options(argc, argv);
  if (!options) return options.error().status;
  if (options->pair) return print(pair_with_server(*options->pair));
  if (options->facts) return print(device_facts(*options->facts));
  if (options->doctor) return report(examine(*options->doctor));
  std::optional<StopSignal> stop;
  Expected<void> done = fetch_if_missing(*options, stop);
  if (done) done = carry_out(*options, stop);
  if (done) return EXIT_SUCCESS;
  spdlog::error(done.error().what);
  return done.error().fault == Fault::Interrupted ? stop->exit_status() : EXIT_FAILURE;
} catch (const std::exception& error) {
  std::fprintf(stderr, "vr_client: %s\n", error.what());
  return EXIT_FAILURE;
}
