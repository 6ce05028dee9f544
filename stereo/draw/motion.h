/// Motion: what a mask may no longer know. Two states of a scene say which lights and instances have moved
/// or were changed between them; of an instance it keeps how its points are carried back, and the spheres
/// about it then and now, since a shadow can only have changed on the way to a light that passes one of them.
#pragma once

#include <bitset>
#include <optional>
#include <vector>

#include "stereo/frame/eye_mask.h"
#include "stereo/scene/scene_state.h"

namespace farshade {

struct Sphere {
  Point<Stage> centre;
  double radius = 0;
};

/// From one state of a scene to a later one.
struct Motion {
  /// Another place, direction, cone or range now, or changed by the viewer since. A light that is off now
  /// never is: it is dark whatever a mask says.
  std::bitset<kMaxLights> stale_lights;
  std::bitset<kMaxLights> changed_lights;  ///< of these, those that the viewer has changed since
  std::vector<std::optional<glm::dmat4>> then_from_now;  ///< stage to stage; one a slot; none = has not moved
  std::vector<Sphere> moved;                             ///< at most kMostSpheres

  /// Nothing has moved.
  [[nodiscard]] bool is_still() const { return stale_lights.none() && moved.empty(); }
};

/// Less than any clock that predicts display times is off by, and too short for anything to move visibly.
[[nodiscard]] constexpr bool same_instant(Time a, Time b) {
  return a - b <= std::chrono::microseconds(1) && b - a <= std::chrono::microseconds(1);
}

/// The instances that move, by a plan; numbered from 0: their slots.
class MotionModel {
 public:
  /// `moves`: one an instance.
  MotionModel(const Scene& scene, const std::vector<bool>& moves);

  /// Slot + 1 of each instance, 0 for one that does not move.
  [[nodiscard]] const std::vector<std::uint32_t>& slots() const { return slots_; }
  [[nodiscard]] std::size_t slot_count() const { return moving_.size(); }

  /// Both states of the model's scene, `then` made with what `now`'s changes were up to its revision.
  [[nodiscard]] Motion between(const SceneState& then, const SceneState& now) const;

 private:
  struct Moving {
    std::uint32_t instance;
    glm::dvec3 low, high;  ///< object-space box
  };
  std::vector<Moving> moving_;
  std::vector<std::uint32_t> slots_;
};

/// The smallest sphere that holds both.
[[nodiscard]] Sphere merged(const Sphere& a, const Sphere& b);

/// Adds to at most kMostSpheres; where there is no room, to the one that grows least.
inline constexpr std::size_t kMostSpheres = 4;
void add_sphere(const Sphere& sphere, std::vector<Sphere>& spheres);

}  // namespace farshade
