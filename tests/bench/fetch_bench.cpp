// fetch_bench: how long a scene of a given size takes over a limited path with cuts, against the limit of
// that path. The server's files, the path and the client are in one process, over loopback TCP.
#include <fmt/format.h>

#include <unistd.h>
#include <CLI/CLI.hpp>
#include <fstream>
#include <random>

#include "rt_server/fetch/scene_sender.h"
#include "stereo/base/files.h"
#include "tests/support/tcp_proxy.h"
#include "vr_client/fetch/fetch_scene.h"

namespace farshade {
namespace {

namespace fs = std::filesystem;

struct BenchOptions {
  double megabytes = 350, megabits = 100, delay_ms = 10;
  int cuts = 1;
};

Peer any_port() {
  return {{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xff, 0xff, 127, 0, 0, 1}, 0, 0};
}

void write_random(const fs::path& path, std::size_t bytes) {
  std::mt19937_64 random(3);
  std::ofstream file(path, std::ios::binary);
  for (std::size_t done = 0; done < bytes; done += 8) {
    const std::uint64_t word = random();
    file.write(reinterpret_cast<const char*>(&word),
               static_cast<std::streamsize>(std::min<std::size_t>(8, bytes - done)));
  }
}

/// The file as a server's loader lists it.
SceneFile listed(const fs::path& path) {
  const std::vector<std::byte> bytes = read_file(path, kMostScene_bytes).value();
  return {path.filename().string(), bytes.size(), digest_of(bytes), changed_at(path)};
}

/// Prints each tenth of the scene to standard error.
void show_progress(std::uint64_t here, std::uint64_t all, std::uint64_t& tenth) {
  if (here * 10 / all == tenth) return;
  tenth = here * 10 / all;
  fmt::print(stderr, "fetch_bench: {:.0f} of {:.0f} MB\n", static_cast<double>(here) * 1e-6,
             static_cast<double>(all) * 1e-6);
}

int bench(const BenchOptions& options, const fs::path& folder) {
  const auto bytes = static_cast<std::size_t>(options.megabytes * 1e6);
  fs::create_directories(folder);
  write_random(folder / "scene.glb", bytes);
  const SharedKey key = new_key("bench").value();
  TcpListener listener = TcpListener::listen(any_port()).value();
  const Peer server = listener.local();
  SceneSender sender(std::move(listener),
                     {.scene = folder / "scene.glb",
                      .files = {listed(folder / "scene.glb")},
                      .lighting = {},
                      .served = {},
                      .ring = {key}},
                     [] { return false; }, {.bytes_per_second = 1e9});
  BadPath path{.bytes_per_second = options.megabits * 1e6 / 8, .delay = duration_from_ms(options.delay_ms)};
  for (int i = 0; i < options.cuts; ++i)
    path.cuts.push_back(bytes / (static_cast<std::size_t>(options.cuts) + 1));
  TcpProxy proxy(server, path);
  const Stopwatch watch;
  FetchPlan plan{.servers = {proxy.address()}, .key = key, .cache = folder / "cache"};
  plan.progress = [tenth = std::uint64_t{0}](std::uint64_t here, std::uint64_t all) mutable {
    show_progress(here, all, tenth);
  };
  const Expected<FetchedScene> fetched = fetch_scene(plan);
  if (!fetched) {
    fmt::print(stderr, "fetch_bench: {}\n", fetched.error().what);
    return 1;
  }
  const double took_s = seconds_of(watch.elapsed()),
               limit_s = static_cast<double>(bytes) / path.bytes_per_second;
  fmt::print(
      "{:g} MB over {:g} Mbit/s with {:g} ms, {} connections: {:.2f} s, the path's limit for these bytes is "
      "{:.2f} s "
      "({:.1f} % more); {:.2f} MB passed the path\n",
      options.megabytes, options.megabits, options.delay_ms, proxy.connections(), took_s, limit_s,
      100 * (took_s / limit_s - 1), static_cast<double>(proxy.passed_bytes()) * 1e-6);
  const Stopwatch again;
  const Expected<FetchedScene> cached =
      fetch_scene({.servers = {server}, .key = key, .cache = folder / "cache"});
  fmt::print("with a filled cache: {:.2f} s, {} bytes fetched\n", seconds_of(again.elapsed()),
             cached ? cached->fetched_bytes : 0);
  return 0;
}

}  // namespace
}  // namespace farshade

int main(int argc, char** argv) {
  CLI::App app("Fetches a scene of random bytes over a limited path with cuts.");
  farshade::BenchOptions options;
  app.add_option("--megabytes", options.megabytes)->capture_default_str();
  app.add_option("--megabits", options.megabits, "rate of the path, Mbit/s")->capture_default_str();
  app.add_option("--delay", options.delay_ms, "ms from the server to the client")->capture_default_str();
  app.add_option("--cuts", options.cuts, "connections that are cut")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  const auto folder =
      std::filesystem::temp_directory_path() / fmt::format("farshade_fetch_bench.{}", getpid());
  const int status = farshade::bench(options, folder);
  std::filesystem::remove_all(folder);
  return status;
}
