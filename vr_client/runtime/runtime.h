/// Runtime: supplies display times and head poses, with the interface of OpenXR. The frame loop is the same
/// for a head recording, a simulated head and a headset.
#pragma once

#include <cstdint>
#include <optional>

#include "stereo/base/clock.h"
#include "stereo/frame/hidden_area.h"
#include "stereo/frame/view.h"
#include "stereo/gpu/recording.h"

namespace farshade {

/// The clock of a run. Virtual: every display time gets its frame, however long it takes to draw, and masks
/// are used after a fixed delay, so that a run can be repeated exactly. Real: the machine's clock.
enum class Pace : std::uint8_t { Virtual, Real };

struct FrameTiming {
  Time display_time;  ///< when the display will show the frame that begins now
  Duration period;    ///< time between two frames
};

class Runtime {
 public:
  virtual ~Runtime() = default;

  /// Blocks until the next frame should begin (xrWaitFrame). Returns nothing at the end of the run.
  [[nodiscard]] virtual std::optional<FrameTiming> wait_frame() = 0;

  /// Both eyes' views at `display_time` (xrLocateViews), as far as they are known now. A later call in the
  /// same frame may know them better. A frame shows the views that were located last.
  [[nodiscard]] virtual StereoView locate_views(Time display_time) = 0;

  /// What the lenses hide of the views of the frame that has begun. Null: nothing. Valid until the next
  /// wait_frame.
  [[nodiscard]] virtual const PerEye<HiddenArea>* hidden() const { return nullptr; }

  /// Called when the picture of a frame has been recorded: records what takes it to the display.
  virtual void add_output(const gpu::Recorder& /*append*/) {}

  /// Called when the frame for `display_time` was submitted (xrEndFrame).
  virtual void end_frame(Time /*display_time*/) {}
};

}  // namespace farshade
