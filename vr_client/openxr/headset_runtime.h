/// HeadsetRuntime: the Runtime of a headset, through OpenXR. First a HeadsetSystem is opened, then a Vulkan
/// device that its runtime makes (DeviceOptions::maker), then the HeadsetRuntime on that device. Builds
/// without OpenXR compile no_openxr.cpp instead. docs/openxr.md.
#pragma once

#include <functional>
#include <memory>

#include "stereo/base/expected.h"
#include "stereo/gpu/device_options.h"
#include "vr_client/runtime/hands.h"
#include "vr_client/runtime/runtime.h"

namespace farshade::gpu {
struct Device;
struct Image;
}  // namespace farshade::gpu

namespace farshade {

/// A depth for each eye: near / distance (kNearPlane_m), 0 where there is no surface; two layers of
/// D32_SFLOAT, whose upper left part has the size of an eye; layout ShaderReadOnlyOptimal.
struct HeadsetDepth {
  const gpu::Image& image;
  std::uint32_t first_layer = 0;
};

struct HeadsetSetup {
  Rigid<Stage, Eye> start;              ///< where the head is placed in the scene when it is first seen
  Extent eye_size;                      ///< pixels
  std::function<bool()> wants_to_end;   ///< the user wants to end the client
  std::function<void()> idle;           ///< called at least every 100 ms while no frame is shown
  std::function<HeadsetDepth()> depth;  ///< of the picture, called in end_frame; empty: it has none
  /// Called in wait_frame with the head and the controllers of the frame. Returns the new stage_from_tracked,
  /// which moves the viewer. Empty: controllers are not used.
  std::function<Rigid<Stage, Tracked>(const ViewerInput&)> follow_hands = {};
  /// A runtime that has not ended the session so long after the user wanted it has stopped.
  Duration longest_exit = std::chrono::seconds(5);
  bool hides = true;                         ///< what the lenses hide is not drawn
  std::function<void(Duration)> sleep = {};  ///< between two looks at the runtime; empty: of this thread
};

/// The frames of a session, from its begin to its end.
class HeadsetRuntime : public Runtime {
 public:
  /// Waits until the runtime shows frames of this client, however long that takes, and for the next of these
  /// frames. Returns nothing when the session has ended or failed, or the user wants to end; `longest_exit`
  /// later also while xrWaitFrame blocks.
  [[nodiscard]] std::optional<FrameTiming> wait_frame() override = 0;
  /// The views of the frame that has begun. The runtime predicts them for `display_time` in each call.
  [[nodiscard]] StereoView locate_views(Time display_time) override = 0;

  /// The device is lost: ends the session, which is bound to it. There are no frames until take_device.
  virtual void leave_device() = 0;
  /// Another device has been opened in the place of the lost one. Waits for the headset, as after the loss of
  /// a session, and makes a session on the device. `shown` is that of open_runtime, on the new device.
  virtual void take_device(const gpu::Image& shown) = 0;

  /// Ends the session as the specification asks for: requests the exit and waits for it, at most
  /// `longest_exit`. Returns why frames ended early: a call that failed, or a runtime that has ended.
  [[nodiscard]] virtual Expected<void> finish() = 0;

  struct Counters {
    std::uint64_t submitted = 0;  ///< frames with a picture
    std::uint64_t empty = 0;      ///< frames without one, which the runtime did not show
  };
  [[nodiscard]] virtual const Counters& counters() const = 0;
  /// Of the display, as the runtime states it, or as the period of the last frame says. Call after a frame
  /// has begun.
  [[nodiscard]] virtual double refresh_hz() const = 0;
  /// The states of the session in their order, for example "idle, ready, synchronized, visible, focused".
  [[nodiscard]] virtual const std::string& history() const = 0;
};

/// The OpenXR runtime of this machine with its headset.
class HeadsetSystem {
 public:
  /// Missing if there is no runtime or no headset, Unsupported if it lacks what the client needs, Unavailable
  /// if this build has no OpenXR. The sentence names the cure.
  [[nodiscard]] static Expected<std::unique_ptr<HeadsetSystem>> open();
  virtual ~HeadsetSystem() = default;

  [[nodiscard]] virtual std::string name() const = 0;  ///< of runtime and headset
  /// The recommended size of an eye times `scale`, at most the largest size that the runtime allows.
  [[nodiscard]] virtual Extent eye_size(double scale) const = 0;
  /// For DeviceOptions::maker. It refers to this system.
  [[nodiscard]] virtual gpu::VulkanMaker vulkan() const = 0;

  /// Makes a session. `device` was made by this system. `shown` is the picture of both eyes that each
  /// frame submits: two layers of rgba8 UNORM, coded as sRGB, layout General. Keeps all references.
  [[nodiscard]] virtual Expected<std::unique_ptr<HeadsetRuntime>> open_runtime(const gpu::Device& device,
                                                                               const gpu::Image& shown,
                                                                               HeadsetSetup setup) = 0;
};

}  // namespace farshade
