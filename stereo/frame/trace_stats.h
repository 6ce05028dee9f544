/// TraceStats: what tracing a frame took: its time, the rays, and the pixel-lights that needed none.
#pragma once

#include <cstdint>

#include "stereo/base/clock.h"

namespace farshade {

struct TraceStats {
  /// Wall time in which vertices and hierarchies were brought to the time of the request.
  Duration update{};
  /// Wall time of both eyes. The two stages of a tile run directly after one another, so the wall time is
  /// divided in proportion to the core time of each stage.
  Duration primary{}, shadow{};
  std::uint64_t primary_rays = 0, shadow_rays = 0;  ///< primary rays: pixels of requested blocks
  /// Shadow rays of a trace that skips nothing: for each light that is on, the covered pixels of the blocks
  /// that are asked for in this light, both eyes.
  std::uint64_t full_shadow_rays = 0;
  /// Shadow rays that were skipped, each counted by the first reason that holds: the pixel is beyond the
  /// light's range, outside of its cone, turned away from it.
  std::uint64_t out_of_range = 0, out_of_cone = 0, turned_away = 0;

  TraceStats& operator+=(const TraceStats& more) {
    update += more.update, primary += more.primary, shadow += more.shadow;
    primary_rays += more.primary_rays, shadow_rays += more.shadow_rays;
    full_shadow_rays += more.full_shadow_rays;
    out_of_range += more.out_of_range, out_of_cone += more.out_of_cone;
    turned_away += more.turned_away;
    return *this;
  }
};

}  // namespace farshade
