/// Quality: the size of views that the server advises to a client, from the bandwidth of the path to it.
///
/// On a slow path the outbox (rt_server/sessions/outbox.h) first lowers the mask rate. Smaller views are
/// advised only when a frame takes more than four intervals between requests to send. The size of a frame in
/// bytes is assumed to grow with scale^1.5: bytes for shadow edges grow with the scale, bytes for areas with
/// its square. A larger size is advised only when its frames fit in 2.4 intervals. This hysteresis keeps the
/// size stable although the rate control varies between 0.85 and 1.1 of the path's capacity and the true
/// exponent is between 1 and 2.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "stereo/base/clock.h"
#include "stereo/frame/view_scale.h"

namespace farshade {

class Quality {
 public:
  static constexpr ViewScale kLeast{2};  ///< the smallest size that is advised
  /// The size changes by one eighth when all frames of this period called for the same change. After the path
  /// recovers from the worst case, full size returns in six steps: about 3 s.
  static constexpr Duration kDwell = std::chrono::milliseconds(500);

  /// Call for each packed frame. `bytes`: size of all its datagrams. `scale` (kLeast to full): size of its
  /// views. `bytes_per_second` (> 0): capacity of the path. `interval`: mean time between requests.
  void packed(std::size_t bytes, ViewScale scale, double bytes_per_second, Duration interval, Time now);

  /// Call for a frame that the server gave up because it took too long: the size falls by one eighth at once.
  void was_too_costly(Time now);

  /// The size to advise to the client.
  [[nodiscard]] ViewScale view_scale() const { return scale_; }

 private:
  enum class Change : std::uint8_t { None, Smaller, Larger };

  [[nodiscard]] Change change_for(double bytes_per_second, Duration interval) const;
  [[nodiscard]] double bytes_at(ViewScale scale) const;

  ViewScale scale_{};
  std::optional<double> full_bytes_;  ///< bytes of a frame at full size, smoothed over about five frames
  Change change_ = Change::None;      ///< called for by every frame since change_since_
  Time change_since_{};
};

}  // namespace farshade
