/// Surroundings: what rays meet in a scene at time 0, without its sky (sky.h). They meet both sides of every
/// surface, also the back of a single-sided one, which nobody sees. Animated instances stay where they are at
/// time 0.
#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "stereo/frame/view.h"
#include "stereo/scene/scene.h"

namespace farshade {

struct Ray {
  Point<Stage> origin;
  Vector<Stage> direction;  ///< unit
};

inline constexpr double kNoSurface_m = std::numeric_limits<double>::infinity();

/// The first surface that a ray meets.
struct Met {
  double distance_m = kNoSurface_m;
  enum class Side : std::uint8_t {
    Front,
    Back,
    UnseenBack
  } side = Side::Front;        ///< UnseenBack: single-sided
  Vector<Stage> normal{};      ///< unit, to the surface's counter-clockwise side
  std::uint32_t instance = 0;  ///< into Scene::instances
};

struct SurroundingsOptions {
  /// A scene with more triangles is refused: its acceleration structure would need seconds and gigabytes.
  std::uint64_t most_triangles = 4'000'000;
  std::vector<std::uint32_t> without{};  ///< instances that are left out
};

class Surroundings {
 public:
  /// Builds an acceleration structure. Keeps a reference to `scene`. OutOfRange for too many triangles,
  /// Unavailable without memory.
  [[nodiscard]] static Expected<Surroundings> create(const Scene& scene,
                                                     const SurroundingsOptions& options = {});

  Surroundings(Surroundings&&) noexcept;
  Surroundings& operator=(Surroundings&&) noexcept;
  Surroundings(const Surroundings&) = delete;
  Surroundings& operator=(const Surroundings&) = delete;
  ~Surroundings();

  /// Around everything at time 0.
  [[nodiscard]] const Bounds& bounds() const;

  /// What each ray meets first. Uses all cores.
  [[nodiscard]] std::vector<Met> first_met(std::span<const Ray> rays) const;

  /// The same for what can be seen: rays pass the backs of single-sided surfaces, at most 16 of them.
  [[nodiscard]] std::vector<Met> first_seen(std::span<const Ray> rays) const;

 private:
  struct Impl;
  explicit Surroundings(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace farshade
