/// Motion: what has moved between two states of a scene, and so which bits of a mask are stale. For lights it
/// is a set. For instances it is the transform back to the earlier state (part_motion.h if a rig deforms
/// them), and the bounding spheres at both places: the visibility of a light can only have changed if the
/// line to the light passes one of these spheres.
#pragma once

#include <bitset>
#include <optional>
#include <vector>

#include "stereo/frame/eye_mask.h"
#include "stereo/reproject/part_motion.h"
#include "stereo/scene/scene_state.h"

namespace farshade {

struct Sphere {
  Point<Stage> centre;
  double radius = 0;
};

/// From one state of a scene to a later one.
struct Motion {
  /// Lights with another position, direction, cone or range, and lights that the viewer has changed. A light
  /// that is off now is never stale, because it is dark whatever its bit is.
  std::bitset<kMaxLights> stale_lights;
  std::bitset<kMaxLights> changed_lights;                ///< the stale lights that the viewer has changed
  std::vector<std::optional<glm::dmat4>> then_from_now;  ///< [slot], stage to stage; empty: has not moved
  std::vector<Sphere> moved;                             ///< bounding spheres; at most kMostSpheres
};

/// Whether two times are so close that nothing moves visibly between them. Predictions of display times have
/// larger errors: any limit from a microsecond to 0.1 ms would do.
[[nodiscard]] constexpr bool same_instant(Time a, Time b) {
  return a - b <= std::chrono::microseconds(1) && b - a <= std::chrono::microseconds(1);
}

/// The instances of a scene that can move. Each has a slot, counted from 0.
class MotionModel {
 public:
  /// `moves`: the plan's flag for each instance. Keeps a reference to `scene` if it has rigs.
  MotionModel(const Scene& scene, const std::vector<bool>& moves);

  /// For each instance its slot + 1, or 0 if it cannot move.
  [[nodiscard]] const std::vector<std::uint32_t>& slots() const { return slots_; }
  [[nodiscard]] std::size_t slot_count() const { return moving_.size(); }

  /// Both states are of the model's scene. `then` has the light changes of `now` up to its own revision.
  [[nodiscard]] Motion between(const SceneState& then, const SceneState& now) const;

  /// Spheres that together contain all instances that can move, where they are now; at most kMostSpheres.
  [[nodiscard]] std::vector<Sphere> bounds(const SceneState& now) const;

 private:
  struct Moving {
    std::uint32_t instance;
    Bounds box;                      ///< object space; of an instance without a rig
    std::optional<PartMotion> part;  ///< with a rig
  };
  [[nodiscard]] static std::optional<glm::dmat4> then_from_now(const Moving& mover, const SceneState& then,
                                                               const SceneState& now);
  static void add_bounds(const Moving& mover, const SceneState& state, std::vector<Sphere>& spheres);
  std::vector<Moving> moving_;
  std::vector<std::uint32_t> slots_;
};

/// The smallest sphere that contains both.
[[nodiscard]] Sphere merged(const Sphere& a, const Sphere& b);

/// Adds a sphere to a list of at most kMostSpheres. If the list is full, it merges the sphere with the one
/// that grows least.
inline constexpr std::size_t kMostSpheres = 4;
void add_sphere(const Sphere& sphere, std::vector<Sphere>& spheres);

}  // namespace farshade
