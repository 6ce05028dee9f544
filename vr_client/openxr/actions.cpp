#include "vr_client/openxr/actions.h"

#include <spdlog/spdlog.h>

#include <cstring>
#include <vector>

#include "vr_client/openxr/pose.h"

namespace farshade::openxr {
namespace {

constexpr ActionFacts kActionFacts[] = {
    {Action::Walk, "walk", "Walk", XR_ACTION_TYPE_VECTOR2F_INPUT, PerHandAction::No},
    {Action::Turn, "turn", "Turn", XR_ACTION_TYPE_FLOAT_INPUT, PerHandAction::No},
    {Action::Grab, "grab", "Grab a light", XR_ACTION_TYPE_FLOAT_INPUT, PerHandAction::Yes},
    {Action::Ahead, "ahead", "Walk where the hand points", XR_ACTION_TYPE_BOOLEAN_INPUT, PerHandAction::Yes},
    {Action::Aim, "aim", "Aim", XR_ACTION_TYPE_POSE_INPUT, PerHandAction::Yes},
    {Action::NextOverlay, "next-overlay", "Next overlay", XR_ACTION_TYPE_BOOLEAN_INPUT, PerHandAction::No},
};

/// It has no sticks. So select walks ahead, too, where it grabs no light, and the right menu button turns
/// right: the runtime gives a pressed button as the float 1.
constexpr Binding kSimple[] = {
    {Action::Aim, "/user/hand/left/input/aim/pose"},
    {Action::Aim, "/user/hand/right/input/aim/pose"},
    {Action::Grab, "/user/hand/left/input/select/click"},
    {Action::Grab, "/user/hand/right/input/select/click"},
    {Action::Ahead, "/user/hand/left/input/select/click"},
    {Action::Ahead, "/user/hand/right/input/select/click"},
    {Action::NextOverlay, "/user/hand/left/input/menu/click"},
    {Action::Turn, "/user/hand/right/input/menu/click"},
};

constexpr Binding kTouch[] = {
    {Action::Aim, "/user/hand/left/input/aim/pose"},
    {Action::Aim, "/user/hand/right/input/aim/pose"},
    {Action::Walk, "/user/hand/left/input/thumbstick"},
    {Action::Turn, "/user/hand/right/input/thumbstick/x"},
    {Action::Grab, "/user/hand/left/input/trigger/value"},
    {Action::Grab, "/user/hand/right/input/trigger/value"},
    {Action::Grab, "/user/hand/left/input/squeeze/value"},
    {Action::Grab, "/user/hand/right/input/squeeze/value"},
    {Action::NextOverlay, "/user/hand/left/input/x/click"},
    {Action::NextOverlay, "/user/hand/right/input/a/click"},
};

/// A hand that only holds the controller reaches squeeze/value 1, so grabbing asks for force.
constexpr Binding kIndex[] = {
    {Action::Aim, "/user/hand/left/input/aim/pose"},
    {Action::Aim, "/user/hand/right/input/aim/pose"},
    {Action::Walk, "/user/hand/left/input/thumbstick"},
    {Action::Turn, "/user/hand/right/input/thumbstick/x"},
    {Action::Grab, "/user/hand/left/input/trigger/value"},
    {Action::Grab, "/user/hand/right/input/trigger/value"},
    {Action::Grab, "/user/hand/left/input/squeeze/force"},
    {Action::Grab, "/user/hand/right/input/squeeze/force"},
    {Action::NextOverlay, "/user/hand/left/input/a/click"},
    {Action::NextOverlay, "/user/hand/right/input/a/click"},
};

constexpr ControllerProfile kProfiles[] = {
    {"/interaction_profiles/khr/simple_controller", kSimple},
    {"/interaction_profiles/oculus/touch_controller", kTouch},
    {"/interaction_profiles/valve/index_controller", kIndex},
};

/// Reads the states of actions until a call fails. An action without an active input is at rest.
struct StateReader {
  XrSession session;
  Called last{};

  bool pressed(XrAction action, XrPath hand) {
    XrActionStateBoolean state{XR_TYPE_ACTION_STATE_BOOLEAN, nullptr, XR_FALSE, XR_FALSE, 0, XR_FALSE};
    get(&xrGetActionStateBoolean, "xrGetActionStateBoolean", action, hand, state);
    return state.isActive && state.currentState;
  }
  double number(XrAction action, XrPath hand) {
    XrActionStateFloat state{XR_TYPE_ACTION_STATE_FLOAT, nullptr, 0, XR_FALSE, 0, XR_FALSE};
    get(&xrGetActionStateFloat, "xrGetActionStateFloat", action, hand, state);
    return state.isActive ? state.currentState : 0.0;
  }
  glm::dvec2 stick(XrAction action) {
    XrActionStateVector2f state{XR_TYPE_ACTION_STATE_VECTOR2F, nullptr, {0, 0}, XR_FALSE, 0, XR_FALSE};
    get(&xrGetActionStateVector2f, "xrGetActionStateVector2f", action, XR_NULL_PATH, state);
    return state.isActive ? glm::dvec2(state.currentState.x, state.currentState.y) : glm::dvec2(0.0);
  }
  std::optional<Rigid<Tracked, Hand>> pose(XrAction action, XrPath hand, XrSpace of, XrSpace in,
                                           XrTime time) {
    XrActionStatePose state{XR_TYPE_ACTION_STATE_POSE, nullptr, XR_FALSE};
    get(&xrGetActionStatePose, "xrGetActionStatePose", action, hand, state);
    if (XR_FAILED(last.result) || !state.isActive) return std::nullopt;
    XrSpaceLocation location{XR_TYPE_SPACE_LOCATION, nullptr, 0, kOrigin};
    last = {xrLocateSpace(of, in, time, &location), "xrLocateSpace"};
    constexpr XrSpaceLocationFlags valid =
        XR_SPACE_LOCATION_ORIENTATION_VALID_BIT | XR_SPACE_LOCATION_POSITION_VALID_BIT;
    const bool is_tracked = XR_SUCCEEDED(last.result) && (location.locationFlags & valid) == valid;
    if (!is_tracked || !is_pose(location.pose)) return std::nullopt;
    return rigid<Hand>(location.pose);
  }

 private:
  template <class State>
  void get(XrResult (*function)(XrSession, const XrActionStateGetInfo*, State*), const char* name,
           XrAction action, XrPath hand, State& state) {
    if (XR_FAILED(last.result)) return;
    const XrActionStateGetInfo info{XR_TYPE_ACTION_STATE_GET_INFO, nullptr, action, hand};
    last = {function(session, &info, &state), name};
  }
};

}  // namespace

std::span<const ActionFacts> action_facts() {
  return kActionFacts;
}

std::span<const ControllerProfile> controller_profiles() {
  return kProfiles;
}

Expected<std::unique_ptr<Actions>> Actions::create(XrInstance instance) {
  std::unique_ptr<Actions> actions(new Actions(instance));
  Expected<void> done = actions->create_actions();
  if (done) done = actions->suggest_bindings();
  if (!done) return tl::unexpected(done.error());
  return actions;
}

Actions::~Actions() {
  if (set_ != XR_NULL_HANDLE) xrDestroyActionSet(set_);
}

Expected<XrPath> Actions::path(const char* text) const {
  XrPath path = XR_NULL_PATH;
  if (auto done = succeeded(xrStringToPath(instance_, text, &path), "xrStringToPath"); !done)
    return tl::unexpected(done.error());
  return path;
}

Expected<void> Actions::create_actions() {
  constexpr PerHand<const char*> names{"/user/hand/left", "/user/hand/right"};
  for (std::size_t side = 0; side < names.size(); ++side) {
    const Expected<XrPath> hand = path(names[side]);
    if (!hand) return tl::unexpected(hand.error());
    hands_[side] = *hand;
  }
  XrActionSetCreateInfo set{XR_TYPE_ACTION_SET_CREATE_INFO, nullptr, {}, {}, 0};
  std::strcpy(set.actionSetName, "scene");
  std::strcpy(set.localizedActionSetName, "Scene");
  if (auto done = succeeded(xrCreateActionSet(instance_, &set, &set_), "xrCreateActionSet"); !done)
    return done;
  for (const ActionFacts& facts : kActionFacts) {
    XrActionCreateInfo info{XR_TYPE_ACTION_CREATE_INFO, nullptr, {}, facts.type, 0, nullptr, {}};
    std::strcpy(info.actionName, facts.name);
    std::strcpy(info.localizedActionName, facts.description);
    if (facts.per_hand == PerHandAction::Yes) {
      info.countSubactionPaths = static_cast<std::uint32_t>(hands_.size());
      info.subactionPaths = hands_.data();
    }
    XrAction& made = actions_[static_cast<std::size_t>(facts.action)];
    if (auto done = succeeded(xrCreateAction(set_, &info, &made), "xrCreateAction"); !done) return done;
  }
  return {};
}

Expected<void> Actions::suggest_bindings() const {
  for (const ControllerProfile& profile : kProfiles) {
    std::vector<XrActionSuggestedBinding> bindings;
    for (const Binding& binding : profile.bindings) {
      const Expected<XrPath> input = path(binding.input);
      if (!input) return tl::unexpected(input.error());
      bindings.push_back({action(binding.action), *input});
    }
    const Expected<XrPath> name = path(profile.path);
    if (!name) return tl::unexpected(name.error());
    const XrInteractionProfileSuggestedBinding suggested{
        XR_TYPE_INTERACTION_PROFILE_SUGGESTED_BINDING, nullptr, *name,
        static_cast<std::uint32_t>(bindings.size()), bindings.data()};
    const XrResult result = xrSuggestInteractionProfileBindings(instance_, &suggested);
    if (result == XR_ERROR_PATH_UNSUPPORTED)
      spdlog::info("the OpenXR runtime does not know the controllers {}", profile.path);
    else if (auto done = succeeded(result, "xrSuggestInteractionProfileBindings"); !done)
      return done;
  }
  return {};
}

Expected<void> Actions::attach(XrSession session) {
  session_ = session;
  for (std::size_t side = 0; side < aims_.size(); ++side) {
    const XrActionSpaceCreateInfo info{XR_TYPE_ACTION_SPACE_CREATE_INFO, nullptr, action(Action::Aim),
                                       hands_[side], kOrigin};
    if (auto done = succeeded(xrCreateActionSpace(session, &info, &aims_[side]), "xrCreateActionSpace");
        !done)
      return done;
  }
  const XrSessionActionSetsAttachInfo info{XR_TYPE_SESSION_ACTION_SETS_ATTACH_INFO, nullptr, 1, &set_};
  return succeeded(xrAttachSessionActionSets(session, &info), "xrAttachSessionActionSets");
}

Called Actions::read(XrSpace space, XrTime time, std::optional<Hands>& hands) const {
  hands.reset();
  const XrActiveActionSet active{set_, XR_NULL_PATH};
  const XrActionsSyncInfo info{XR_TYPE_ACTIONS_SYNC_INFO, nullptr, 1, &active};
  const Called synced{xrSyncActions(session_, &info), "xrSyncActions"};
  if (XR_FAILED(synced.result) || synced.result == XR_SESSION_NOT_FOCUSED) return synced;
  StateReader states{session_};
  Hands found;
  for (std::size_t side = 0; side < hands_.size(); ++side)
    found.hand[side] = {
        .tracked_from_hand = states.pose(action(Action::Aim), hands_[side], aims_[side], space, time),
        .grab = states.number(action(Action::Grab), hands_[side]),
        .ahead = states.pressed(action(Action::Ahead), hands_[side])};
  found.walk = states.stick(action(Action::Walk));
  found.turn = states.number(action(Action::Turn), XR_NULL_PATH);
  found.next_overlay = states.pressed(action(Action::NextOverlay), XR_NULL_PATH);
  if (XR_SUCCEEDED(states.last.result)) hands = found;
  return states.last;
}

}  // namespace farshade::openxr
