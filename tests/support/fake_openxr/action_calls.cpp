// Controllers: actions have the state that the script gives their names.
#include "tests/support/fake_openxr/runtime.h"

namespace farshade::fake_openxr {
namespace {

XrResult string_to_path(XrInstance, const char* text, XrPath* path) {
  auto& paths = state().paths;
  auto found = std::ranges::find(paths, text);
  if (found == paths.end()) found = paths.emplace(paths.end(), text);
  *path = static_cast<XrPath>(found - paths.begin()) + 1;
  return XR_SUCCESS;
}

/// Empty for XR_NULL_PATH.
std::string text_of(XrPath path) {
  return path == XR_NULL_PATH ? "" : state().paths.at(path - 1);
}

XrResult path_to_string(XrInstance, XrPath path, std::uint32_t capacity, std::uint32_t* count, char* text) {
  if (path == XR_NULL_PATH || path > state().paths.size()) return XR_ERROR_PATH_INVALID;
  const std::string& whole = text_of(path);
  return enumerate<char>(std::span(whole.c_str(), whole.size() + 1), capacity, count, text);
}

XrResult create_set(XrInstance, const XrActionSetCreateInfo*, XrActionSet* set) {
  *set = state().new_handle<XrActionSet>();
  state().action_sets.insert(*set);
  ++state().script.living.action_sets;
  return XR_SUCCESS;
}

XrResult destroy_set(XrActionSet set) {
  State& all = state();
  if (all.action_sets.erase(set) == 0)
    return misuse(XR_ERROR_HANDLE_INVALID, "xrDestroyActionSet of a set that does not exist");
  --all.script.living.action_sets;
  const auto is_of_set = [set](const auto& one) { return one.second.set == set; };
  all.script.living.actions -= static_cast<int>(std::erase_if(all.actions, is_of_set));
  return XR_SUCCESS;
}

XrResult create_action(XrActionSet set, const XrActionCreateInfo* info, XrAction* action) {
  State& all = state();
  if (!all.action_sets.contains(set)) return misuse(XR_ERROR_HANDLE_INVALID, "an action of no set");
  *action = all.new_handle<XrAction>();
  all.actions[*action] = {.set = set, .name = info->actionName};
  ++all.script.living.actions;
  return XR_SUCCESS;
}

XrResult destroy_action(XrAction action) {
  if (state().actions.erase(action) == 0)
    return misuse(XR_ERROR_HANDLE_INVALID, "xrDestroyAction of an action that does not exist");
  --state().script.living.actions;
  return XR_SUCCESS;
}

XrResult suggest_bindings(XrInstance, const XrInteractionProfileSuggestedBinding* all) {
  for (const auto& one : std::span(all->suggestedBindings, all->countSuggestedBindings))
    state().script.suggested.push_back(text_of(all->interactionProfile) + " " +
                                       state().actions.at(one.action).name + " " + text_of(one.binding));
  return XR_SUCCESS;
}

XrResult attach_sets(XrSession, const XrSessionActionSetsAttachInfo* info) {
  for (XrActionSet set : std::span(info->actionSets, info->countActionSets))
    if (!state().action_sets.contains(set))
      return misuse(XR_ERROR_HANDLE_INVALID, "a set that does not exist");
  return XR_SUCCESS;
}

XrResult get_profile(XrSession, XrPath, XrInteractionProfileState* profile) {
  return string_to_path(XR_NULL_HANDLE, state().script.interaction_profile.c_str(),
                        &profile->interactionProfile);
}

XrResult sync_actions(XrSession session, const XrActionsSyncInfo*) {
  return state().sessions.at(session).state == XR_SESSION_STATE_FOCUSED ? XR_SUCCESS : XR_SESSION_NOT_FOCUSED;
}

/// As in Runtime::inputs and Runtime::poses.
std::string name_of(XrAction action, XrPath hand) {
  const std::string name = state().actions.at(action).name;
  return hand == XR_NULL_PATH ? name : name + " " + text_of(hand);
}

/// The state of an active action. Actions have states while the session has the focus.
std::optional<std::array<float, 2>> input(XrSession session, const XrActionStateGetInfo& info) {
  const auto& inputs = state().script.inputs;
  const auto found = inputs.find(name_of(info.action, info.subactionPath));
  if (found == inputs.end() || state().sessions.at(session).state != XR_SESSION_STATE_FOCUSED)
    return std::nullopt;
  return found->second;
}

XrResult get_boolean(XrSession session, const XrActionStateGetInfo* info, XrActionStateBoolean* out) {
  const auto value = input(session, *info);
  out->isActive = value.has_value();
  out->currentState = value && (*value)[0] > 0.5f;
  return XR_SUCCESS;
}

XrResult get_float(XrSession session, const XrActionStateGetInfo* info, XrActionStateFloat* out) {
  const auto value = input(session, *info);
  out->isActive = value.has_value();
  out->currentState = value ? (*value)[0] : 0;
  return XR_SUCCESS;
}

XrResult get_vector(XrSession session, const XrActionStateGetInfo* info, XrActionStateVector2f* out) {
  const auto value = input(session, *info);
  out->isActive = value.has_value();
  out->currentState = value ? XrVector2f{(*value)[0], (*value)[1]} : XrVector2f{};
  return XR_SUCCESS;
}

XrResult get_pose(XrSession, const XrActionStateGetInfo* info, XrActionStatePose* out) {
  out->isActive = state().script.poses.contains(name_of(info->action, info->subactionPath));
  return XR_SUCCESS;
}

XrResult create_action_space(XrSession session, const XrActionSpaceCreateInfo* info, XrSpace* space) {
  *space = state().new_handle<XrSpace>();
  state().spaces[*space] = {.session = session, .action = name_of(info->action, info->subactionPath)};
  ++state().script.living.spaces;
  return XR_SUCCESS;
}

/// Action spaces are where the script says. All reference spaces are the same.
XrResult locate_space(XrSpace space, XrSpace base, XrTime, XrSpaceLocation* location) {
  const auto found = state().spaces.find(space);
  if (found == state().spaces.end() || !state().spaces.contains(base))
    return misuse(XR_ERROR_HANDLE_INVALID, "xrLocateSpace of a space that does not exist");
  const auto pose = state().script.poses.find(found->second.action);
  const bool is_known = found->second.action.empty() || pose != state().script.poses.end();
  location->locationFlags =
      is_known ? XR_SPACE_LOCATION_ORIENTATION_VALID_BIT | XR_SPACE_LOCATION_POSITION_VALID_BIT |
                     XR_SPACE_LOCATION_ORIENTATION_TRACKED_BIT | XR_SPACE_LOCATION_POSITION_TRACKED_BIT
               : 0;
  location->pose = pose == state().script.poses.end() ? XrPosef{{0, 0, 0, 1}, {0, 0, 0}} : pose->second;
  return XR_SUCCESS;
}

XrResult apply_haptics(XrSession, const XrHapticActionInfo*, const XrHapticBaseHeader*) {
  return XR_SUCCESS;
}
XrResult stop_haptics(XrSession, const XrHapticActionInfo*) {
  return XR_SUCCESS;
}

}  // namespace

std::vector<Function> action_calls() {
  return {entry<"xrStringToPath", &string_to_path>(),
          entry<"xrPathToString", &path_to_string>(),
          entry<"xrCreateActionSet", &create_set>(),
          entry<"xrDestroyActionSet", &destroy_set>(),
          entry<"xrCreateAction", &create_action>(),
          entry<"xrDestroyAction", &destroy_action>(),
          entry<"xrSuggestInteractionProfileBindings", &suggest_bindings>(),
          entry<"xrAttachSessionActionSets", &attach_sets>(),
          entry<"xrGetCurrentInteractionProfile", &get_profile>(),
          entry<"xrSyncActions", &sync_actions>(),
          entry<"xrGetActionStateBoolean", &get_boolean>(),
          entry<"xrGetActionStateFloat", &get_float>(),
          entry<"xrGetActionStateVector2f", &get_vector>(),
          entry<"xrGetActionStatePose", &get_pose>(),
          entry<"xrCreateActionSpace", &create_action_space>(),
          entry<"xrLocateSpace", &locate_space>(),
          entry<"xrApplyHapticFeedback", &apply_haptics>(),
          entry<"xrStopHapticFeedback", &stop_haptics>()};
}

}  // namespace farshade::fake_openxr
