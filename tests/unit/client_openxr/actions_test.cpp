#include "vr_client/openxr/actions.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>
#include <string>

namespace farshade::openxr {
namespace {

/// The inputs that the specification lists for each controller (OpenXR 1.0, section 6.4), of each hand.
struct SpecifiedInputs {
  std::set<std::string> both, left, right;
};
const std::map<std::string, SpecifiedInputs> kSpecified{
    {"/interaction_profiles/khr/simple_controller",
     {{"select/click", "menu/click", "grip/pose", "aim/pose"}, {}, {}}},
    {"/interaction_profiles/oculus/touch_controller",
     {{"squeeze/value", "trigger/value", "trigger/touch", "thumbstick", "thumbstick/x", "thumbstick/y",
       "thumbstick/click", "thumbstick/touch", "thumbrest/touch", "grip/pose", "aim/pose"},
      {"x/click", "x/touch", "y/click", "y/touch", "menu/click"},
      {"a/click", "a/touch", "b/click", "b/touch", "system/click"}}},
    {"/interaction_profiles/valve/index_controller",
     {{"system/click",     "system/touch",  "a/click",       "a/touch",       "b/click",
       "b/touch",          "squeeze/value", "squeeze/force", "trigger/click", "trigger/value",
       "trigger/touch",    "thumbstick",    "thumbstick/x",  "thumbstick/y",  "thumbstick/click",
       "thumbstick/touch", "trackpad",      "trackpad/x",    "trackpad/y",    "trackpad/force",
       "trackpad/touch",   "grip/pose",     "aim/pose"},
      {},
      {}}},
};

bool is_specified(const SpecifiedInputs& inputs, const std::string& path) {
  const std::string left = "/user/hand/left/input/", right = "/user/hand/right/input/";
  const bool is_left = path.starts_with(left);
  if (!is_left && !path.starts_with(right)) return false;
  const std::string input = path.substr((is_left ? left : right).size());
  return inputs.both.contains(input) || (is_left ? inputs.left : inputs.right).contains(input);
}

/// The type that an input has in the specification.
XrActionType type_of(const std::string& input) {
  const std::string component = input.substr(input.rfind('/') + 1);
  if (component == "pose") return XR_ACTION_TYPE_POSE_INPUT;
  if (component == "click" || component == "touch") return XR_ACTION_TYPE_BOOLEAN_INPUT;
  return component == "thumbstick" || component == "trackpad" ? XR_ACTION_TYPE_VECTOR2F_INPUT
                                                              : XR_ACTION_TYPE_FLOAT_INPUT;
}

const ActionFacts& facts_of(Action action) {
  return action_facts()[static_cast<std::size_t>(action)];
}

bool binds(const ControllerProfile& profile, Action action, const std::string& side) {
  return std::ranges::any_of(profile.bindings, [&](const Binding& binding) {
    return binding.action == action && std::string(binding.input).starts_with("/user/hand/" + side);
  });
}

TEST(ControllerActions, HaveNamesThatTheSpecificationAllows) {
  std::set<std::string> names, descriptions;
  for (std::size_t i = 0; i < action_facts().size(); ++i) {
    const ActionFacts& facts = action_facts()[i];
    EXPECT_EQ(static_cast<std::size_t>(facts.action), i);
    EXPECT_TRUE(names.insert(facts.name).second) << facts.name;
    EXPECT_TRUE(descriptions.insert(facts.description).second) << facts.description;
    EXPECT_LT(std::string(facts.name).size(), std::size_t{XR_MAX_ACTION_NAME_SIZE});
    EXPECT_LT(std::string(facts.description).size(), std::size_t{XR_MAX_LOCALIZED_ACTION_NAME_SIZE});
    EXPECT_EQ(std::string(facts.name).find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789-_."),
              std::string::npos)
        << facts.name;
  }
  EXPECT_EQ(names.size(), 6u);
}

TEST(ControllerProfiles, BindOnlyInputsThatTheControllerHas) {
  ASSERT_EQ(controller_profiles().size(), kSpecified.size());
  for (const ControllerProfile& profile : controller_profiles()) {
    const auto specified = kSpecified.find(profile.path);
    ASSERT_NE(specified, kSpecified.end()) << profile.path;
    std::set<std::pair<Action, std::string>> all;
    for (const Binding& binding : profile.bindings) {
      EXPECT_TRUE(is_specified(specified->second, binding.input)) << profile.path << " " << binding.input;
      EXPECT_TRUE(all.emplace(binding.action, binding.input).second) << "twice: " << binding.input;
    }
  }
}

/// A button may be bound to a float action, which is then 0 or 1 (section "Type conversions"). Other types
/// must agree.
TEST(ControllerProfiles, BindInputsOfTheRightType) {
  for (const ControllerProfile& profile : controller_profiles())
    for (const Binding& binding : profile.bindings) {
      const XrActionType input = type_of(binding.input), action = facts_of(binding.action).type;
      EXPECT_TRUE(input == action ||
                  (input == XR_ACTION_TYPE_BOOLEAN_INPUT && action == XR_ACTION_TYPE_FLOAT_INPUT))
          << profile.path << " " << binding.input;
    }
}

TEST(ControllerProfiles, OfferEverythingToTheViewer) {
  for (const ControllerProfile& profile : controller_profiles()) {
    for (const char* side : {"left", "right"}) {
      EXPECT_TRUE(binds(profile, Action::Aim, side)) << profile.path;
      EXPECT_TRUE(binds(profile, Action::Grab, side)) << profile.path;
      EXPECT_EQ(binds(profile, Action::Ahead, side), !binds(profile, Action::Walk, "left"))
          << profile.path << " walks with its stick or, without one, where a hand points";
    }
    EXPECT_TRUE(binds(profile, Action::Turn, "right")) << profile.path;
    EXPECT_TRUE(binds(profile, Action::NextOverlay, "left")) << profile.path;
  }
}

/// Only the button that takes a light also walks, where there is no light.
TEST(ControllerProfiles, GiveEachInputOneMeaning) {
  for (const ControllerProfile& profile : controller_profiles()) {
    std::map<std::string, std::set<Action>> meanings;
    for (const Binding& binding : profile.bindings) meanings[binding.input].insert(binding.action);
    for (const auto& [input, actions] : meanings)
      EXPECT_TRUE(actions.size() == 1 || actions == std::set({Action::Grab, Action::Ahead}))
          << profile.path << " " << input;
  }
}

}  // namespace
}  // namespace farshade::openxr
