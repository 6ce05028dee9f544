#include "vr_client/fetched_scene.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>

#include "vr_client/client.h"
#include "vr_client/fetch/fetch_scene.h"

namespace farshade {
namespace {

/// Prints to standard error how much has come, if the fetch takes more than a second: one line that is
/// overwritten on a terminal, elsewhere a line for each tenth.
class FetchProgress {
 public:
  void show(std::uint64_t here, std::uint64_t all) {
    if (!began_at_) began_at_ = here;
    const double s = seconds_of(watch_.elapsed());
    const bool is_due = on_terminal_ ? s > shown_s_ + 0.1 : here * 10 / all > tenth_ || here == all;
    if (s < 1 || !is_due) return;
    shown_s_ = s;
    tenth_ = here * 10 / all;
    const double rate = static_cast<double>(here - *began_at_) / s;
    fmt::print(stderr, "{}fetching the scene: {:.1f} of {:.1f} MB, {:.1f} MB/s, about {:.0f} s left   {}",
               on_terminal_ ? "\r" : "", static_cast<double>(here) * 1e-6, static_cast<double>(all) * 1e-6,
               rate * 1e-6, static_cast<double>(all - here) / std::max(rate, 1.0), on_terminal_ ? "" : "\n");
    line_is_open_ = on_terminal_;
    std::fflush(stderr);
  }
  void end() const {
    if (line_is_open_) fmt::print(stderr, "\n");
  }

 private:
  bool on_terminal_ = isatty(STDERR_FILENO) != 0, line_is_open_ = false;
  std::optional<std::uint64_t> began_at_;
  double shown_s_ = 0;
  std::uint64_t tenth_ = 0;
  Stopwatch watch_;
};

Expected<FetchPlan> plan_for(const Options& options) {
  Expected<std::vector<Peer>> servers = resolve_tcp(options.server);
  if (!servers) return tl::unexpected(servers.error());
  const auto elsewhere = std::ranges::find_if_not(*servers, is_loopback);
  Expected<SharedKey> key = key_for(options, elsewhere == servers->end() ? servers->front() : *elsewhere);
  if (!key) return tl::unexpected(key.error());
  return FetchPlan{.servers = *std::move(servers), .key = *std::move(key), .cache = scene_cache_folder()};
}

}  // namespace

Expected<void> fetch_if_missing(Options& options, std::optional<StopSignal>& stop) {
  if (!options.scene.empty() || !options.export_trace.empty()) return {};
  Expected<std::string> server = server_address(options.server);
  if (!server) return tl::unexpected(server.error());
  options.server = *server;
  Expected<FetchPlan> plan = plan_for(options);  // before the signals are held back: a name may take long
  if (!plan) return tl::unexpected(plan.error());
  stop.emplace();
  FetchProgress progress;
  plan->stopped = [&] { return stop->has_come(); };
  plan->progress = [&](std::uint64_t here, std::uint64_t all) { progress.show(here, all); };
  plan->note = [](const std::string& note) { spdlog::info(note); };
  Expected<FetchedScene> fetched = fetch_scene(*plan);
  progress.end();
  if (!fetched && stop->has_come()) return fail(Fault::Interrupted, fetched.error().what);
  if (!fetched && fetched.error().fault == Fault::Missing)
    return fail(
        Fault::Missing,
        fmt::format("the scene cannot be fetched: {}. Is rt_server running there without --no-scene-fetch, "
                    "and is TCP port {} open? Otherwise copy the scene and give --scene",
                    fetched.error().what, plan->servers.front().port));
  if (!fetched) return tl::unexpected(fetched.error());
  if (fetched->fetched_bytes > 0)
    spdlog::info("fetched {:.1f} MB of the scene to {}", static_cast<double>(fetched->fetched_bytes) * 1e-6,
                 fetched->scene.parent_path().string());
  options.scene = fetched->scene;
  options.lighting = fetched->lighting;
  options.served = fetched->hash;
  return {};
}

}  // namespace farshade
