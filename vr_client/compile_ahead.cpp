#include "vr_client/compile_ahead.h"

#include <fmt/format.h>
#include <sched.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <cstdio>
#include <mutex>
#include <thread>
#include <utility>

#include "stereo/base/user_folders.h"
#include "stereo/gpu/pipeline_cache.h"

namespace farshade {
namespace {

/// The second device has a copy of the scene and of all pictures.
constexpr std::uint64_t kMostCopied_bytes = std::uint64_t{256} << 20;

/// A pipeline that comes from a cache takes less than this, a compiler takes more.
constexpr Duration kCold = std::chrono::milliseconds(50);

using Steps = std::vector<std::function<void()>>;

/// Numbers of steps, which two threads take from both ends.
class StepNumbers {
 public:
  /// Both threads say how many there are, which is the same; whichever comes first.
  void begin(std::size_t count) {
    const std::lock_guard lock(mutex_);
    if (!std::exchange(has_begun_, true)) end_ = count;
  }
  std::optional<std::size_t> take_first() {
    const std::lock_guard lock(mutex_);
    return first_ < end_ ? std::optional(first_++) : std::nullopt;
  }
  std::optional<std::size_t> take_last() {
    const std::lock_guard lock(mutex_);
    return first_ < end_ ? std::optional(--end_) : std::nullopt;
  }

 private:
  std::mutex mutex_;
  bool has_begun_ = false;
  std::size_t first_ = 0, end_ = 0;
};

class ShownProgress {
 public:
  ShownProgress() = default;
  ~ShownProgress() {
    if (on_terminal_) fmt::print(stderr, "\x1b[K");
  }
  ShownProgress(const ShownProgress&) = delete;
  ShownProgress& operator=(const ShownProgress&) = delete;
  /// Any thread may call it. Returns the progress in words.
  std::string add_one(std::size_t all) {
    const std::lock_guard lock(mutex_);
    std::string words = fmt::format("compiling pipelines: {} of {}", ++done_, all);
    if (!on_terminal_) return words;
    // The cursor stays at the beginning of the line, so that whatever is printed next replaces it.
    fmt::print(stderr, "\x1b[K{}\r", words);
    std::fflush(stderr);
    return words;
  }

 private:
  std::mutex mutex_;
  std::size_t done_ = 0;
  const bool on_terminal_ = isatty(STDERR_FILENO) != 0;
};

bool has_two_cores() {
  cpu_set_t cores;
  return ::sched_getaffinity(0, sizeof cores, &cores) == 0 && CPU_COUNT(&cores) > 1;
}

/// Whether a second device would help if there is much to compile, and has the memory for a copy of the
/// scene. Light buffers are not copied.
bool may_help(const Client& client) {
  gpu::BytesByUse copied = client_memory(client.scene, client.plan.draw, client.limits, client.levels);
  copied[gpu::Use::EdgeRays] = 0;
  return client.device.is_cpu && has_two_cores() && copied.total() <= kMostCopied_bytes;
}

/// Compiles on a device of its own until no number is left. What it cannot do, the first device does.
void compile_beside(const Client& client, const std::function<Steps(Renderer&)>& steps_of,
                    StepNumbers& numbers, ShownProgress& progress) try {
  const Expected<gpu::Device> device = gpu::open_device({.name_contains = client.device.name});
  if (!device) return;
  // With the same limits: lavapipe's code depends on whether the sides of textures are powers of two.
  const std::unique_ptr<Renderer> renderer =
      make_renderer(*device, client.scene, client.plan.draw, client.limits, client.levels);
  const Steps steps = steps_of(*renderer);
  numbers.begin(steps.size());
  while (const auto number = numbers.take_last()) {
    steps[*number]();
    progress.add_one(steps.size());
  }
} catch (const std::exception& error) {
  spdlog::debug("pipelines are compiled on one device: {}", error.what());
}

}  // namespace

void compile_ahead(Client& client, const Reprojection& reprojection, PixelReport report, Changes changes,
                   const TellWaiting& tell) {
  const Stopwatch watch;
  const auto steps_of = [&](Renderer& renderer) {
    return renderer.compile_steps(reprojection, report, changes);
  };
  {
    StepNumbers numbers;
    ShownProgress progress;
    std::jthread beside;
    const auto start_beside = [&] {
      beside = std::jthread([&] { compile_beside(client, steps_of, numbers, progress); });
    };
    const bool helps = may_help(client);
    if (helps && client.is_first_start) start_beside();
    const Steps steps = steps_of(*client.renderer);
    numbers.begin(steps.size());
    std::vector<bool> done(steps.size(), false);
    while (const auto number = numbers.take_first()) {
      const Stopwatch step;
      steps[*number]();
      const bool is_cold = step.elapsed() > kCold;
      done[*number] = true;
      const std::string words = progress.add_one(steps.size());
      if (tell) tell(words);
      if (helps && is_cold && !beside.joinable()) start_beside();
    }
    if (beside.joinable()) beside.join();
    for (std::size_t i = 0; i < steps.size(); ++i)
      if (!done[i]) steps[i]();
  }
  spdlog::info("pipelines compiled in {:.0f} ms", ms_of(watch.elapsed()));
  if (const Expected<void> saved = gpu::save_pipelines(client.device, cache_folder()); !saved)
    spdlog::warn("the compiled pipelines are not kept: {}", saved.error().what);
}

}  // namespace farshade
