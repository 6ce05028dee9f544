/// RayScene: a SurfaceModel made traversable. Its .cpp is the one file that names Embree (3 or 4).
///
/// What is fixed lies in one scene of high build quality. If nothing moves, that is all there is; else the
/// moving patches are instances in a second, small scene, which alone is rebuilt when they are placed anew
/// and through which each packet goes after the first. Traversal is robust (watertight); filters sit only on
/// geometries whose material needs them.
#pragma once

#include <memory>
#include <string>

#include "stereo/base/expected.h"
#include "stereo/tracer/ray_packet.h"
#include "stereo/tracer/surface_model.h"

namespace farshade {

class RayScene {
 public:
  /// Refers to `model`, which must stay where it is.
  /// Refuses (Fault::Unavailable) when the device or its memory is not to be had.
  [[nodiscard]] static Expected<RayScene> create(const SurfaceModel& model);

  RayScene(RayScene&&) noexcept;
  RayScene& operator=(RayScene&&) noexcept;
  ~RayScene();

  /// Takes over the model's placements.
  void update();

  /// Bytes that the traversal's library holds, and the most that it ever held.
  [[nodiscard]] std::size_t bytes() const;
  [[nodiscard]] std::size_t peak_bytes() const;

  /// Rays a packet that this machine traces natively: 16, 8 or 4.
  [[nodiscard]] int width() const;

  /// Nearest seen surface: single-sided materials from behind and holes are passed.
  /// For K of 4, 8 and 16; coherent packets are expected. A hit's `geometry` becomes the number of its patch.
  template <int K>
  void intersect(const Lanes<K>& lanes, RayHitPacket<K>& packet) const;

  /// Sets tfar to -infinity where any surface lies strictly between tnear and tfar. Holes are passed.
  template <int K>
  void occluded(const Lanes<K>& lanes, RayPacket<K>& packet) const;

 private:
  struct Impl;
  explicit RayScene(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// Of the library that traverses, for people.
[[nodiscard]] std::string embree_version();

}  // namespace farshade
