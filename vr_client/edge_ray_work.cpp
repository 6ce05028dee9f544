#include "vr_client/edge_ray_work.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <sys/resource.h>

#include <chrono>
#include <utility>

#include "stereo/base/clock.h"
#include "stereo/base/user_folders.h"
#include "stereo/edge_rays/edge_ray_cache.h"

namespace farshade {
namespace {

constexpr int kNiceness = 10;

/// Without memory or threads for the data, no light has a buffer.
EdgeRayData make(const Scene& scene, const DrawPlan& plan, std::uint64_t most_texels,
                 const std::stop_token& stop) try {
  const Stopwatch watch;
  CachedEdgeRayData made =
      cached_edge_ray_data(edge_ray_input(scene, plan, most_texels), cache_folder(), stop);
  if (stop.stop_requested()) return {};
  if (!made.trouble.empty()) spdlog::warn("edge rays: {}", made.trouble);
  spdlog::info("edge rays: {}, {} in {:.0f} ms", in_words(made.data),
               made.from_file ? "read from the cache" : "made", ms_of(watch.elapsed()));
  return std::move(made.data);
} catch (const std::exception& error) {
  spdlog::warn("edge rays: the light buffers could not be made: {}", error.what());
  return {};
}

}  // namespace

EdgeRayWork::EdgeRayWork(const Scene& scene, const DrawPlan& plan, std::uint64_t most_texels) {
  std::promise<EdgeRayData> made;
  data_ = made.get_future().share();
  thread_ =
      std::jthread([&scene, plan, most_texels, made = std::move(made)](const std::stop_token& stop) mutable {
        setpriority(PRIO_PROCESS, 0, kNiceness);  // of this thread and those that it starts
        made.set_value(make(scene, plan, most_texels, stop));
      });
}

bool EdgeRayWork::is_done() const {
  return data_.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
}

std::string in_words(const EdgeRayData& data) {
  return fmt::format("{:.1f} MB of light buffers and triangles, for {} of {} lights",
                     static_cast<double>(data.bytes()) * 1e-6, data.buffers(), data.lights.size());
}

}  // namespace farshade
