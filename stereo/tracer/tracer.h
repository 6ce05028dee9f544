/// Tracer: which lights does each pixel's surface see? Primary rays through the pixel centres of both views,
/// then for each pixel and each light that can matter there (covered, facing, in range and cone) one any-hit
/// ray. The server answers requests with it; the client's reference mode `full` calls it directly.
///
/// A mask bit, defined (tests/oracle holds this tracer to it, in double):
///  - The pixel's surface is the nearest one on the ray through the pixel's centre. Single-sided materials
///  are seen
///    from their counter-clockwise side only, which a transform of negative determinant turns over (glTF 2.0,
///    3.7.4). Where alpha = base colour factor x texture (bilinear, level 0, wrapped) x vertex colour is
///    below the material's cutoff there is a hole. An instance whose transform is singular is not there.
///  - The shading normal N is interpolated and carried to the stage by the inverse transpose; the geometric
///  normal Ng
///    is the triangle's, on its counter-clockwise side. Where the back of a double-sided surface is seen,
///    both turn.
///  - Light i's bit is 1 iff the light is on, N . L > 0 and Ng . L > 0, the point is nearer than the light's
///    range (point, spot) and inside its outer cone (spot), and no surface lies strictly between the point
///    and the light. Both sides of a surface cast; holes do not.
///  - Pixels that no surface covers are 0.
/// Float makes it inexact within rounding of edges, and of things closer than 2^-18 of the scene's extent to
/// a surface.
#pragma once

#include <memory>

#include "stereo/frame/position_grid.h"
#include "stereo/frame/shadow_frame.h"
#include "stereo/plan/scene_plan.h"
#include "stereo/scene/scene_state.h"
#include "stereo/tracer/tracer_memory.h"

namespace farshade {

struct TraceStats {
  /// Wall time of both eyes; the stages of a tile follow each other at once, so it is shared out by their
  /// core time.
  Duration primary{}, shadow{};
  std::uint64_t primary_rays = 0, shadow_rays = 0;
  /// What a trace that leaves nothing out would cost: covered pixels x lights that are on, both eyes.
  std::uint64_t full_shadow_rays = 0;
  /// Those of them that are not traced. Dark, by the first of these: beyond the light's range, outside of its
  /// cone, turned away from it. Lit: proven to have nothing in between.
  std::uint64_t out_of_range = 0, out_of_cone = 0, turned_away = 0, proven = 0;

  TraceStats& operator+=(const TraceStats& more) {
    primary += more.primary, shadow += more.shadow;
    primary_rays += more.primary_rays, shadow_rays += more.shadow_rays;
    full_shadow_rays += more.full_shadow_rays;
    out_of_range += more.out_of_range, out_of_cone += more.out_of_cone;
    turned_away += more.turned_away, proven += more.proven;
    return *this;
  }
};

class Tracer {
 public:
  /// Builds the acceleration structure. Keeps a reference to `scene`.
  /// Refuses (Fault::Unavailable) when the device or its memory is not to be had.
  [[nodiscard]] static Expected<Tracer> create(const Scene& scene, const TracePlan& plan);
  /// With the plan of the scene, all of its lights kept.
  [[nodiscard]] static Expected<Tracer> create(const Scene& scene) {
    return create(scene, plan_for(scene, {.all_lights = true}).trace);
  }

  Tracer(Tracer&&) noexcept;
  Tracer& operator=(Tracer&&) noexcept;
  ~Tracer();

  /// Traces `request` (valid views) against the scene at its scene_time and with its lights into `frame`,
  /// whose buffers are reused. Nothing is kept of one request's lights for the next. Where both views
  /// coincide one is traced and copied. One call at a time; uses all cores.
  TraceStats trace(const FrameRequest& request, ShadowFrame& frame);

  /// The same without primary rays: the pixels' surfaces lie at `positions` on `grid`, planes of the views'
  /// sizes. What has no word is not covered. Bits of lights behind a surface may be either: a shader that
  /// knows the normal multiplies them by 0. The others are those of `trace` but for shadows that the grid
  /// moves: rays start up to 2 E before the surface, E = sqrt(3) / 2 steps (placed_surface.h).
  TraceStats trace(const FrameRequest& request, const PerEye<PositionPlanes>& positions,
                   const PositionGrid& grid, ShadowFrame& frame);

  [[nodiscard]] TracerMemory memory() const;

 private:
  struct Impl;
  explicit Tracer(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace farshade
