/// Actions: the controllers through OpenXR's action system. The program has six actions; the table of
/// suggested bindings says which inputs of each known controller make them. The user can bind others in the
/// runtime's settings. Source: OpenXR 1.0 specification, chapter "Input and Haptics" and section "Interaction
/// Profile Paths".
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "vr_client/openxr/result.h"
#include "vr_client/runtime/hands.h"

namespace farshade::openxr {

enum class Action : std::uint8_t { Walk, Turn, Grab, Ahead, Aim, NextOverlay };

enum class PerHandAction : bool { No, Yes };
struct ActionFacts {
  Action action;
  const char* name;         ///< for the runtime's files
  const char* description;  ///< for people
  XrActionType type;
  PerHandAction per_hand;  ///< it has a state for each hand
};
/// In the order of the enumeration.
[[nodiscard]] std::span<const ActionFacts> action_facts();

struct Binding {
  Action action;
  const char* input;  ///< the path of an input of a hand
};
struct ControllerProfile {
  const char* path;
  std::span<const Binding> bindings;
};
[[nodiscard]] std::span<const ControllerProfile> controller_profiles();

/// A call of OpenXR that has been made: the first that failed, or the last.
struct Called {
  XrResult result = XR_SUCCESS;
  const char* name = "";
};

class Actions {
 public:
  /// Makes the actions and suggests their bindings. Controllers that the runtime does not know are left out.
  [[nodiscard]] static Expected<std::unique_ptr<Actions>> create(XrInstance instance);
  Actions(const Actions&) = delete;
  Actions& operator=(const Actions&) = delete;
  ~Actions();
  /// Leaves the actions to the end of the program: a call that blocks still uses the instance.
  void abandon() { set_ = XR_NULL_HANDLE; }

  /// Must be called once for each session, before its first frame. A new session replaces the last one.
  [[nodiscard]] Expected<void> attach(XrSession session);

  /// The state of the controllers; their poses are in `space` at `time`. For the frames of a focused session.
  /// Empty `hands`: the session has lost its focus. An action whose controller is off is at rest.
  [[nodiscard]] Called read(XrSpace space, XrTime time, std::optional<Hands>& hands) const;

 private:
  explicit Actions(XrInstance instance) : instance_(instance) {}
  [[nodiscard]] Expected<void> create_actions();
  [[nodiscard]] Expected<void> suggest_bindings() const;
  [[nodiscard]] Expected<XrPath> path(const char* text) const;
  [[nodiscard]] XrAction action(Action one) const { return actions_[static_cast<std::size_t>(one)]; }

  XrInstance instance_;
  XrActionSet set_ = XR_NULL_HANDLE;
  std::array<XrAction, 6> actions_{};  ///< by Action; they end with the set
  PerHand<XrPath> hands_{};
  XrSession session_ = XR_NULL_HANDLE;
  PerHand<XrSpace> aims_{};  ///< they end with the session
};

}  // namespace farshade::openxr
