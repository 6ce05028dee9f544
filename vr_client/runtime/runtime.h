/// Runtime: where head poses come from and pictures go, in OpenXR's shape. The frame loop reads the same over
/// a recorded trace, a simulated head or a headset.
#pragma once

#include <cstdint>
#include <optional>

#include "stereo/base/clock.h"
#include "stereo/frame/view.h"

namespace farshade {

/// Whose time a session lives in. Virtual: every display time gets its frame, however long that takes, and
/// masks come after a set delay, so that a replay is the same every time. Real: the machine's clock.
enum class Pace : std::uint8_t { Virtual, Real };

struct FrameTiming {
  Time display_time;  ///< when the frame begun now will be seen
  Duration period;    ///< between two display times
};

class Runtime {
 public:
  virtual ~Runtime() = default;

  /// Blocks until the next frame should begin (xrWaitFrame); nothing when the session has ended.
  [[nodiscard]] virtual std::optional<FrameTiming> wait_frame() = 0;

  /// Both eyes' views at `display_time` (xrLocateViews).
  [[nodiscard]] virtual StereoView locate_views(Time display_time) const = 0;

  /// The frame for `display_time` is drawn (xrEndFrame).
  virtual void end_frame(Time display_time) = 0;
};

}  // namespace farshade
