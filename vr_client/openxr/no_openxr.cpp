#include "stereo/base/check.h"
#include "vr_client/openxr/headset_runtime.h"

namespace farshade {

namespace openxr {
class Instance {};
}  // namespace openxr

class HeadsetRuntime::Parts {};

HeadsetSystem::HeadsetSystem(std::unique_ptr<openxr::Instance> instance) : instance_(std::move(instance)) {}
HeadsetSystem::HeadsetSystem(HeadsetSystem&&) noexcept = default;
HeadsetSystem& HeadsetSystem::operator=(HeadsetSystem&&) noexcept = default;
HeadsetSystem::~HeadsetSystem() = default;

Expected<HeadsetSystem> HeadsetSystem::open() {
  return fail(Fault::Unavailable,
              "built without OpenXR: install libopenxr-dev (scripts/setup does) and configure again");
}
std::string HeadsetSystem::name() const {
  check_failed("no headset is opened without OpenXR", "", CallPlace::current());
}
Extent HeadsetSystem::eye_size(double) const {
  check_failed("no headset is opened without OpenXR", "", CallPlace::current());
}
gpu::VulkanMaker HeadsetSystem::vulkan() const {
  check_failed("no headset is opened without OpenXR", "", CallPlace::current());
}

HeadsetRuntime::HeadsetRuntime(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
HeadsetRuntime::~HeadsetRuntime() = default;
Expected<std::unique_ptr<HeadsetRuntime>> HeadsetRuntime::open(HeadsetSystem&, const gpu::Device&,
                                                               const gpu::Image&, HeadsetSetup) {
  check_failed("no headset is opened without OpenXR", "", CallPlace::current());
}
std::optional<FrameTiming> HeadsetRuntime::wait_frame() {
  return std::nullopt;
}
StereoView HeadsetRuntime::locate_views(Time) const {
  check_failed("no headset is opened without OpenXR", "", CallPlace::current());
}
const PerEye<HiddenArea>* HeadsetRuntime::hidden() const {
  return nullptr;
}
double HeadsetRuntime::refresh_hz() const {
  check_failed("no headset is opened without OpenXR", "", CallPlace::current());
}
void HeadsetRuntime::end_frame(Time) {}
Expected<void> HeadsetRuntime::finish() {
  return {};
}
const HeadsetRuntime::Counters& HeadsetRuntime::counters() const {
  check_failed("no headset is opened without OpenXR", "", CallPlace::current());
}
const std::string& HeadsetRuntime::history() const {
  check_failed("no headset is opened without OpenXR", "", CallPlace::current());
}

}  // namespace farshade
