/// RayScene: the acceleration structure over a SurfaceModel. Its .cpp is the only file that names Embree (3
/// or 4).
///
/// The fixed patches lie in one Embree scene of high build quality. If patches move, they are instances in a
/// second, small scene. Only that one is rebuilt when they are placed, and each packet traverses it after the
/// first. The patches of a rig share one instance, whose hierarchy is refitted to their new vertices.
/// Traversal is robust (watertight). Only geometries whose material needs it have filter functions.
#pragma once

#include <memory>

#include "stereo/base/expected.h"
#include "stereo/tracer/ray_packet.h"
#include "stereo/tracer/surface_model.h"

namespace farshade {

class RayScene {
 public:
  enum class Built : std::uint8_t {
    Well,     ///< for many rays
    Quickly,  ///< for a few thousand rays, which cost more
  };

  /// Keeps a reference to `model`, whose address must not change.
  /// Refuses (Fault::Unavailable) when the device or its memory is not available.
  [[nodiscard]] static Expected<RayScene> create(const SurfaceModel& model, Built built = Built::Well);

  RayScene(RayScene&&) noexcept;
  RayScene& operator=(RayScene&&) noexcept;
  RayScene(const RayScene&) = delete;
  RayScene& operator=(const RayScene&) = delete;
  ~RayScene();

  /// Moves the instances to the model's current placements.
  void update();

  /// Bytes that Embree holds now, and the most that it ever held.
  [[nodiscard]] std::size_t bytes() const;
  [[nodiscard]] std::size_t peak_bytes() const;

  /// Rays per packet that this machine traces natively: 16, 8 or 4.
  [[nodiscard]] int width() const;

  /// Finds the nearest seen surface. Rays pass through holes and the back faces of single-sided materials.
  /// K is 4, 8 or 16. Packets should be coherent. A hit's `geometry` becomes the number of its patch.
  template <int K>
  void intersect(const Lanes<K>& lanes, RayHitPacket<K>& packet) const;

  /// Sets tfar to -infinity for rays with any surface strictly between tnear and tfar. Rays pass through
  /// holes.
  template <int K>
  void occluded(const Lanes<K>& lanes, RayPacket<K>& packet) const;

 private:
  struct Impl;
  explicit RayScene(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace farshade
