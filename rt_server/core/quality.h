/// Quality: how large a client's views should be for its path. A slow path lowers the mask rate by itself
/// (outbox.h); smaller views are advised only when a frame takes more than four display intervals. Bytes are
/// taken to go with scale^1.5: edges grow with the first power, areas with the second. Going up needs two
/// thirds more rate than staying, so that neither the rate control's own swing (0.85 to 1.1 of what the path
/// carries) nor bytes that go with scale^1 or scale^2 make the size swing.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "stereo/base/clock.h"

namespace farshade {

class Quality {
 public:
  static constexpr std::uint32_t kFull = 8, kLeast = 2;  ///< eighths of the full width and height
  /// A step is taken when it has been called for by every frame of this time. So full size is back 3 s (six
  /// steps) and a frame a step after the path can carry it.
  static constexpr Duration kDwell = std::chrono::milliseconds(500);

  /// A frame has been packed: `bytes` of all its datagrams, traced at `scale_eighths` (kLeast to kFull), for
  /// a path of `bytes_per_second` (> 0) and a display that shows a picture every `interval`.
  void packed(std::size_t bytes, std::uint32_t scale_eighths, double bytes_per_second, Duration interval,
              Time now);

  /// To be advised to the client.
  [[nodiscard]] std::uint32_t scale_eighths() const { return scale_; }

 private:
  enum class Wish : std::uint8_t { Stay, Smaller, Larger };

  [[nodiscard]] Wish wish(double bytes_per_second, Duration interval) const;
  [[nodiscard]] double bytes_at(std::uint32_t scale) const;

  std::uint32_t scale_ = kFull;
  std::optional<double> full_bytes_;  ///< a frame at full size, smoothed over about five frames
  Wish wish_ = Wish::Stay;
  Time wished_since_{};
};

}  // namespace farshade
