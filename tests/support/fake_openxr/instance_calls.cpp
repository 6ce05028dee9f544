// Instance, system and events.
#include "tests/support/fake_openxr/runtime.h"

namespace farshade::fake_openxr {
namespace {

XrResult enumerate_extensions(const char*, std::uint32_t capacity, std::uint32_t* count,
                              XrExtensionProperties* properties) {
  std::vector<XrExtensionProperties> all;
  for (const std::string& name : state().script.extensions) {
    XrExtensionProperties& one =
        all.emplace_back(XrExtensionProperties{XR_TYPE_EXTENSION_PROPERTIES, nullptr, {}, 1});
    name.copy(one.extensionName, XR_MAX_EXTENSION_NAME_SIZE - 1);
  }
  return enumerate<XrExtensionProperties>(all, capacity, count, properties);
}

XrResult create_instance(const XrInstanceCreateInfo* info, XrInstance* instance) {
  Runtime& script = state().script;
  if (script.living.instances > 0) return XR_ERROR_LIMIT_REACHED;
  script.enabled.clear();
  for (const char* name : std::span(info->enabledExtensionNames, info->enabledExtensionCount)) {
    if (std::ranges::find(script.extensions, name) == script.extensions.end())
      return XR_ERROR_EXTENSION_NOT_PRESENT;
    script.enabled.emplace_back(name);
  }
  *instance = script.instance = state().new_handle<XrInstance>();
  ++script.living.instances;
  return XR_SUCCESS;
}

/// Sessions and action sets end with their instance.
XrResult destroy_instance(XrInstance instance) {
  State& all = state();
  if (instance != all.script.instance || all.script.living.instances == 0)
    return misuse(XR_ERROR_HANDLE_INVALID, "xrDestroyInstance of an instance that does not exist");
  if (!all.sessions.empty())
    static_cast<void>(misuse(XR_SUCCESS, "xrDestroyInstance before xrDestroySession"));
  all.script.living = {};
  all.action_sets.clear();
  all.actions.clear();
  all.script.instance = XR_NULL_HANDLE;
  all.instance_is_lost = false;
  return XR_SUCCESS;
}

XrResult get_instance_properties(XrInstance, XrInstanceProperties* properties) {
  properties->runtimeVersion = XR_MAKE_VERSION(1, 2, 3);
  std::strcpy(properties->runtimeName, "Fake");
  return XR_SUCCESS;
}

XrResult get_system(XrInstance, const XrSystemGetInfo* info, XrSystemId* system) {
  if (info->formFactor != XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY) return XR_ERROR_FORM_FACTOR_UNSUPPORTED;
  *system = state().script.system;
  return *system == XR_NULL_SYSTEM_ID ? XR_ERROR_FORM_FACTOR_UNAVAILABLE : XR_SUCCESS;
}

XrResult get_system_properties(XrInstance, XrSystemId system, XrSystemProperties* properties) {
  if (system != state().script.system) return XR_ERROR_SYSTEM_INVALID;
  properties->systemId = system;
  std::strcpy(properties->systemName, "Headset");
  return XR_SUCCESS;
}

XrResult enumerate_view_configurations(XrInstance, XrSystemId, std::uint32_t capacity, std::uint32_t* count,
                                       XrViewConfigurationType* types) {
  constexpr std::array kTypes{XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO};
  return enumerate<XrViewConfigurationType>(kTypes, capacity, count, types);
}

XrResult enumerate_views(XrInstance, XrSystemId system, XrViewConfigurationType type, std::uint32_t capacity,
                         std::uint32_t* count, XrViewConfigurationView* views) {
  if (system != state().script.system) return XR_ERROR_SYSTEM_INVALID;
  if (type != XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO) return XR_ERROR_VIEW_CONFIGURATION_TYPE_UNSUPPORTED;
  std::vector<XrViewConfigurationView> all;
  for (const EyeSize& size : state().script.sizes)
    all.push_back({XR_TYPE_VIEW_CONFIGURATION_VIEW, nullptr, size.recommended_width, size.largest_width,
                   size.recommended_height, size.largest_height, 1, 1});
  return enumerate<XrViewConfigurationView>(all, capacity, count, views);
}

XrResult enumerate_blend_modes(XrInstance, XrSystemId, XrViewConfigurationType, std::uint32_t capacity,
                               std::uint32_t* count, XrEnvironmentBlendMode* modes) {
  constexpr std::array kModes{XR_ENVIRONMENT_BLEND_MODE_OPAQUE};
  return enumerate<XrEnvironmentBlendMode>(kModes, capacity, count, modes);
}

/// The client knows the state of a session when it has polled the event.
XrResult poll_event(XrInstance, XrEventDataBuffer* event) {
  auto& events = state().script.events;
  if (events.empty()) return XR_EVENT_UNAVAILABLE;
  *event = events.front();
  events.pop_front();
  if (event->type == XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED) {
    XrEventDataSessionStateChanged changed;
    std::memcpy(&changed, event, sizeof changed);
    if (const auto found = state().sessions.find(changed.session); found != state().sessions.end())
      found->second.state = changed.state;
  }
  return XR_SUCCESS;
}

}  // namespace

std::vector<Function> instance_calls() {
  return {entry<"xrEnumerateInstanceExtensionProperties", &enumerate_extensions>(),
          entry<"xrCreateInstance", &create_instance>(),
          entry<"xrDestroyInstance", &destroy_instance>(),
          entry<"xrGetInstanceProperties", &get_instance_properties>(),
          entry<"xrGetSystem", &get_system>(),
          entry<"xrGetSystemProperties", &get_system_properties>(),
          entry<"xrEnumerateViewConfigurations", &enumerate_view_configurations>(),
          entry<"xrEnumerateViewConfigurationViews", &enumerate_views>(),
          entry<"xrEnumerateEnvironmentBlendModes", &enumerate_blend_modes>(),
          entry<"xrPollEvent", &poll_event>()};
}

}  // namespace farshade::fake_openxr
