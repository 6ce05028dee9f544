/// Instance: the OpenXR runtime of this machine and its headset, before a session. It makes the Vulkan
/// instance and device that the runtime can share pictures with (XR_KHR_vulkan_enable2).
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "vr_client/openxr/headset_runtime.h"
#include "vr_client/openxr/result.h"

namespace farshade::openxr {

/// The client shows two views.
inline constexpr XrViewConfigurationType kViews = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO;

/// What the runtime offers beyond OpenXR 1.0 and what this client uses.
struct Extensions {
  bool depth_layers = false;     ///< XR_KHR_composition_layer_depth
  bool visibility_mask = false;  ///< XR_KHR_visibility_mask
  bool refresh_rate = false;     ///< XR_FB_display_refresh_rate
};

class Instance final : public HeadsetSystem {
 public:
  /// Unsupported also if the runtime has no XR_KHR_vulkan_enable2 or does not allow Vulkan 1.3.
  [[nodiscard]] static Expected<std::unique_ptr<HeadsetSystem>> open();
  Instance(const Instance&) = delete;
  Instance& operator=(const Instance&) = delete;
  ~Instance() override;

  [[nodiscard]] XrInstance handle() const { return handle_; }
  [[nodiscard]] XrSystemId system() const { return system_; }
  [[nodiscard]] const Extensions& extensions() const { return extensions_; }
  /// "Monado(XRT) 25.0.0, Simulated HMD".
  [[nodiscard]] std::string name() const override { return name_; }
  [[nodiscard]] Extent eye_size(double scale) const override;

  /// Makes the Vulkan objects through the runtime. Throws if the runtime refuses.
  [[nodiscard]] gpu::VulkanMaker vulkan() const override;
  /// In headset_runtime.cpp.
  [[nodiscard]] Expected<std::unique_ptr<HeadsetRuntime>> open_runtime(const gpu::Device& device,
                                                                       const gpu::Image& shown,
                                                                       HeadsetSetup setup) override;

  /// Asks again for the headset, after a session was lost; it may have a new system id. Missing while it is
  /// not there, Unavailable if it is driven by another GPU than `device`.
  [[nodiscard]] Expected<void> find_again(const gpu::Device& device);
  /// Leaves the instance to the end of the program: a call that blocks still uses it.
  void abandon() { handle_ = XR_NULL_HANDLE; }

 private:
  Instance() = default;
  [[nodiscard]] Expected<void> create();
  [[nodiscard]] Expected<void> find_system();
  [[nodiscard]] Expected<void> read_views();
  [[nodiscard]] Expected<void> check_vulkan() const;
  void read_name();

  XrInstance handle_ = XR_NULL_HANDLE;
  XrSystemId system_ = XR_NULL_SYSTEM_ID;
  Extensions extensions_;
  std::string name_;
  Extent recommended_, largest_;  ///< of each view, as the runtime says; the larger one if eyes differ
};

/// Calls an extension's function, which the loader does not export.
template <class Function, class... Arguments>
[[nodiscard]] XrResult call(XrInstance instance, const char* name, Arguments... arguments) {
  PFN_xrVoidFunction function = nullptr;
  const XrResult found = xrGetInstanceProcAddr(instance, name, &function);
  if (XR_FAILED(found)) return found;
  return reinterpret_cast<Function>(function)(arguments...);
}

}  // namespace farshade::openxr
