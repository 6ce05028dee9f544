/// A headset of the fake OpenXR runtime, and pictures to show in it.
#pragma once

#include <gtest/gtest.h>

#include "stereo/gpu/memory.h"
#include "tests/support/fake_openxr/fake_openxr.h"
#include "vr_client/openxr/headset_runtime.h"

namespace farshade::openxr {

/// Starts the fake runtime of this process anew, with a new script. No instance may exist.
[[nodiscard]] fake_openxr::Runtime& restart_fake();

inline constexpr Extent kEyeSize{16, 12};

/// Pictures of both eyes on a device that the fake runtime has made.
struct ShownPictures {
  gpu::Device device;
  gpu::Image shown, depth;
};
[[nodiscard]] Expected<ShownPictures> make_pictures();
[[nodiscard]] Expected<ShownPictures> make_pictures(const HeadsetSystem& system);
/// Those that all tests of a process share. Null without a Vulkan device.
[[nodiscard]] ShownPictures* pictures();

/// A client of the fake runtime. At the end of each test every handle has been destroyed, every call was
/// allowed, and the Vulkan validation layers had nothing to say.
class FakeHeadset : public testing::Test {
 protected:
  void SetUp() override;
  void TearDown() override;

  /// Sleeps take no time. The client does not want to end, and has a depth.
  [[nodiscard]] HeadsetSetup setup() const;
  /// False if it fails; `error` says why.
  [[nodiscard]] bool open(HeadsetSetup setup);
  /// Shows the next frame. False if there is none.
  bool show();
  /// Records and submits the picture of the frame that has begun.
  void submit(Time display_time);
  /// Shows frames until there are `most`, or there is no further one.
  void show_until(std::size_t most);
  void finish();

  fake_openxr::Runtime* fake = nullptr;
  std::unique_ptr<HeadsetSystem> system;
  std::unique_ptr<HeadsetRuntime> runtime;
  std::vector<StereoView> shown;  ///< views of the frames
  std::string error;              ///< of open or finish
};

}  // namespace farshade::openxr
