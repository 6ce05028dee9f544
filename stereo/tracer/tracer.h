/// Tracer: computes which lights each pixel's surface sees. It casts primary rays through the pixel centres
/// of both views, and then, for each pixel and each light that can matter there (the pixel is covered, faces
/// the light, and lies in the light's range and cone), one any-hit ray. The server answers requests with it,
/// and the client's mode `full` calls it directly.
///
/// Definition of a mask bit. tests/oracle computes it in double, and tests compare this tracer with it.
///
/// - The pixel's surface is the nearest one on the ray through the pixel's centre. A single-sided material is
///   seen from its counter-clockwise side only; a transform of negative determinant turns that side over
///   (glTF 2.0, 3.7.4). A surface has a hole where alpha, which is base colour factor x texture (bilinear,
///   level 0, wrapped) x vertex colour, is below the material's cutoff. An instance with a singular transform
///   does not exist.
/// - N is the shading normal, interpolated, and transformed to the stage by the inverse transpose. Ng is the
///   geometric normal, on the triangle's counter-clockwise side. Both are negated where the viewer sees the
///   back of a double-sided surface.
/// - The bit of a light is 1 if and only if the light is on, N . L > 0, Ng . L > 0, the point is within the
///   light's range (point, spot) and inside its outer cone (spot), and no surface lies strictly between the
///   point and the light. Both sides of a surface cast. Holes do not, and a sky (stereo/scene/sky.h) does
///   not.
/// - The bits of pixels that no surface covers are 0.
///
/// Float arithmetic makes the bits inexact within rounding of edges, and where an occluder is closer than
/// 2^-18 of the scene's extent to the surface.
#pragma once

#include <functional>
#include <memory>
#include <stdexcept>

#include "stereo/base/instruction_set.h"
#include "stereo/frame/position_grid.h"
#include "stereo/frame/shadow_frame.h"
#include "stereo/frame/trace_stats.h"
#include "stereo/plan/scene_plan.h"
#include "stereo/scene/scene_state.h"
#include "stereo/tracer/tracer_memory.h"

namespace farshade {

/// Whether a trace is to be given up. All cores call it, each before every group of 256 pixels.
using GiveUp = std::function<bool()>;

/// A trace was given up. The frame's masks are undefined.
struct TraceGivenUp : std::runtime_error {
  TraceGivenUp() : std::runtime_error("its trace was given up") {}
};

class Tracer {
 public:
  /// Builds the acceleration structure. Keeps a reference to `scene`. The stages use up to `set`, which is at
  /// most the best one; masks have the same bits with every set.
  /// Refuses (Fault::Unavailable) when the device or its memory is not available.
  [[nodiscard]] static Expected<Tracer> create(const Scene& scene, const TracePlan& plan,
                                               InstructionSet set = best_instruction_set());
  /// With the plan of the scene, which keeps all of its lights.
  [[nodiscard]] static Expected<Tracer> create(const Scene& scene) {
    return create(scene, plan_for(scene, {.all_lights = true}).trace);
  }

  /// A tracer for the masks that others are compared with: every covered pixel sends a ray to every light
  /// that is on, whatever `plan` says. So a fault in what the tracer skips cannot vouch for itself.
  [[nodiscard]] static Expected<Tracer> create_reference(const Scene& scene, TracePlan plan) {
    plan.skips_rays = false;
    return create(scene, plan);
  }
  [[nodiscard]] static Expected<Tracer> create_reference(const Scene& scene) {
    return create_reference(scene, plan_for(scene, {.all_lights = true}).trace);
  }

  Tracer(Tracer&&) noexcept;
  Tracer& operator=(Tracer&&) noexcept;
  Tracer(const Tracer&) = delete;
  Tracer& operator=(const Tracer&) = delete;
  ~Tracer();

  /// Traces `request` (valid views) into `frame`, whose buffers are reused, against the scene at the
  /// request's scene_time and with the request's lights. No light change is kept for the next request. If
  /// both views and their requested blocks coincide, one is traced and copied. One call at a time. Uses all
  /// cores.
  ///
  /// Traces only what the request asks for, and sets all other bits to 0. Bits that are asked for are the
  /// same as in a trace of the whole view. An eye has one entry per tile, or none.
  ///
  /// Throws TraceGivenUp when `give_up` (empty: never) has returned true; each core finishes its group first.
  TraceStats trace(const FrameRequest& request, ShadowFrame& frame, const GiveUp& give_up = {});

  /// The same for whole views and without primary rays: the pixels' surfaces lie at `positions` on `grid`, in
  /// planes of the views' sizes. A pixel with word 0 is not covered. The bit of a light behind a surface may
  /// have either value: a shader that knows the normal multiplies it by 0. The other bits equal those of the
  /// other `trace`, except where the grid's rounding moves a shadow: rays start up to 2 E before the surface,
  /// E = sqrt(3) / 2 steps (placed_surface.h).
  TraceStats trace(const FrameRequest& request, const PerEye<PositionPlanes>& positions,
                   const PositionGrid& grid, ShadowFrame& frame, const GiveUp& give_up = {});

  /// The surfaces that the primary rays of whole views meet: metres along -z, 0 where there is none. For
  /// comparing them with those of a rasteriser.
  [[nodiscard]] PerEye<Image<float>> distances(const FrameMoment& moment);

  [[nodiscard]] TracerMemory memory() const;
  [[nodiscard]] MaskLayout layout() const;

 private:
  struct Impl;
  explicit Tracer(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace farshade
