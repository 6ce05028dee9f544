// Every call of the client to the OpenXR runtime returns every error once. The client ends with a sentence,
// or goes on as docs/openxr.md says.
#include <fmt/format.h>
#include <openxr/openxr_reflection.h>

#include "tests/unit/client_openxr/fake_headset.h"
#include "vr_client/openxr/result.h"

namespace farshade::openxr {
namespace {

constexpr std::size_t kFrames = 4;
/// After this number of frames, a case may lose the session.
constexpr std::size_t kFramesBeforeLoss = 2;

std::vector<XrResult> all_errors() {
  std::vector<XrResult> errors;
#define FARSHADE_ERROR(name, value) errors.push_back(name);
  XR_LIST_ENUM_XrResult(FARSHADE_ERROR)
#undef FARSHADE_ERROR
      std::erase_if(errors, [](XrResult result) { return result >= 0 || result == XR_RESULT_MAX_ENUM; });
  return errors;
}

/// What the client does when a call fails.
enum class Then : std::uint8_t {
  EndsWithASentence,
  GoesOn,              ///< the call does not matter
  FollowsTheLoader,    ///< the OpenXR loader hides or changes the error
  ReplacesTheSession,  ///< after XR_ERROR_SESSION_LOST; otherwise it ends with a sentence
  HasEnded,            ///< after XR_ERROR_SESSION_LOST without a sentence, otherwise with one
  WaitsForTheHeadset   ///< if the headset has gone; otherwise it ends with a sentence
};

struct FailingCall {
  std::string call;
  std::uint32_t number;
  Then then;
};

std::string name_of_case(const testing::TestParamInfo<FailingCall>& info) {
  return fmt::format("{}{}", info.param.call, info.param.number);
}

class HeadsetErrors : public FakeHeadset, public testing::WithParamInterface<FailingCall> {
 protected:
  void fail_once(XrResult result) {
    fake = &restart_fake();
    fake->answers = {{GetParam().call, GetParam().number, result}};
    fake->extensions.insert(fake->extensions.end(), {XR_KHR_VISIBILITY_MASK_EXTENSION_NAME,
                                                     XR_FB_DISPLAY_REFRESH_RATE_EXTENSION_NAME});
    fake->poses = {{"aim /user/hand/left", {{0, 0, 0, 1}, {0, 0, 0}}}};
    shown.clear();
    error.clear();
  }

  /// Uses the controllers, too.
  [[nodiscard]] HeadsetSetup whole_setup() const {
    HeadsetSetup whole = setup();
    whole.follow_hands = [](const ViewerInput& viewer) { return viewer.stage_from_tracked; };
    return whole;
  }

  /// What the specification lets a runtime answer: it has no STAGE space, or does not know a controller.
  [[nodiscard]] bool is_allowed(XrResult result) const {
    const std::string& call = GetParam().call;
    return (call == "xrCreateReferenceSpace" && result == XR_ERROR_REFERENCE_SPACE_UNSUPPORTED) ||
           (call == "xrSuggestInteractionProfileBindings" && result == XR_ERROR_PATH_UNSUPPORTED);
  }

  /// Opens a session, shows frames and ends. `loses`: the session is lost in between.
  void play(bool loses) {
    if (open(whole_setup())) {
      if (loses) {
        show_until(kFramesBeforeLoss);
        fake->push(XR_SESSION_STATE_LOSS_PENDING);
        fake->system = 2;
      }
      show_until(kFrames);
      finish();
    }
    runtime.reset();
    system.reset();
    EXPECT_EQ(fake->living, fake_openxr::Living{});
    EXPECT_EQ(fake->misuses, std::vector<std::string>{});
  }

  void expect_sentence(XrResult result) const {
    const std::string& call = GetParam().call;
    EXPECT_NE(error.find(call), std::string::npos) << "the call is named in: " << error;
    EXPECT_NE(error.find(name_of(result)), std::string::npos) << "the result is named in: " << error;
    EXPECT_GT(error.size(), call.size() + name_of(result).size() + 20) << "a cure is in: " << error;
  }

  void expect_all_frames(std::uint32_t sessions) const {
    EXPECT_EQ(error, "");
    EXPECT_EQ(shown.size(), kFrames);
    EXPECT_EQ(fake->counts["xrCreateSession"], sessions);
  }

  void expect(Then then, XrResult result) const {
    const bool is_lost = result == XR_ERROR_SESSION_LOST;
    switch (then) {
      case Then::EndsWithASentence:
        return expect_sentence(result);
      case Then::GoesOn:
        return expect_all_frames(1);
      case Then::FollowsTheLoader:
        EXPECT_TRUE(error.empty() ? shown.size() == kFrames : error.find("XR_ERROR_") != std::string::npos)
            << error;
        return;
      case Then::ReplacesTheSession:
        return is_lost ? expect_all_frames(2) : expect_sentence(result);
      case Then::HasEnded:
        return is_lost ? expect_all_frames(1) : expect_sentence(result);
      case Then::WaitsForTheHeadset:
        if (error_of(result, "").fault != Fault::Missing) return expect_sentence(result);
        EXPECT_EQ(error, "");
        EXPECT_EQ(shown.size(), kFrames);
    }
  }
};

TEST_P(HeadsetErrors, EndOrAreSurvived) {
  for (const XrResult result : all_errors()) {
    SCOPED_TRACE(name_of(result));
    fail_once(result);
    play(false);
    ASSERT_GE(fake->counts[GetParam().call], GetParam().number) << "the call is made";
    expect(is_allowed(result) ? Then::GoesOn : GetParam().then, result);
  }
}

INSTANTIATE_TEST_SUITE_P(
    EveryCall, HeadsetErrors,
    testing::Values(FailingCall{"xrNegotiateLoaderRuntimeInterface", 1, Then::FollowsTheLoader},
                    FailingCall{"xrEnumerateInstanceExtensionProperties", 1, Then::FollowsTheLoader},
                    FailingCall{"xrCreateInstance", 1, Then::EndsWithASentence},
                    FailingCall{"xrGetSystem", 1, Then::EndsWithASentence},
                    FailingCall{"xrEnumerateViewConfigurationViews", 1, Then::EndsWithASentence},
                    FailingCall{"xrGetVulkanGraphicsRequirements2KHR", 1, Then::EndsWithASentence},
                    FailingCall{"xrCreateSession", 1, Then::EndsWithASentence},
                    FailingCall{"xrCreateReferenceSpace", 1, Then::EndsWithASentence},
                    FailingCall{"xrEnumerateSwapchainFormats", 1, Then::EndsWithASentence},
                    FailingCall{"xrEnumerateSwapchainFormats", 2, Then::EndsWithASentence},
                    FailingCall{"xrCreateSwapchain", 1, Then::EndsWithASentence},
                    FailingCall{"xrCreateSwapchain", 2, Then::EndsWithASentence},
                    FailingCall{"xrEnumerateSwapchainImages", 1, Then::EndsWithASentence},
                    FailingCall{"xrEnumerateSwapchainImages", 4, Then::EndsWithASentence},
                    FailingCall{"xrStringToPath", 1, Then::EndsWithASentence},
                    FailingCall{"xrStringToPath", 3, Then::EndsWithASentence},
                    FailingCall{"xrCreateActionSet", 1, Then::EndsWithASentence},
                    FailingCall{"xrCreateAction", 6, Then::EndsWithASentence},
                    FailingCall{"xrSuggestInteractionProfileBindings", 1, Then::EndsWithASentence},
                    FailingCall{"xrCreateActionSpace", 2, Then::EndsWithASentence},
                    FailingCall{"xrAttachSessionActionSets", 1, Then::EndsWithASentence},
                    FailingCall{"xrSyncActions", 1, Then::ReplacesTheSession},
                    FailingCall{"xrGetActionStatePose", 2, Then::ReplacesTheSession},
                    FailingCall{"xrLocateSpace", 1, Then::ReplacesTheSession},
                    FailingCall{"xrGetActionStateFloat", 3, Then::ReplacesTheSession},
                    FailingCall{"xrGetActionStateBoolean", 1, Then::ReplacesTheSession},
                    FailingCall{"xrGetActionStateVector2f", 1, Then::ReplacesTheSession},
                    FailingCall{"xrDestroyActionSet", 1, Then::GoesOn},
                    FailingCall{"xrPollEvent", 1, Then::ReplacesTheSession},
                    FailingCall{"xrPollEvent", 4, Then::ReplacesTheSession},
                    FailingCall{"xrBeginSession", 1, Then::ReplacesTheSession},
                    FailingCall{"xrWaitFrame", 1, Then::ReplacesTheSession},
                    FailingCall{"xrWaitFrame", 3, Then::ReplacesTheSession},
                    FailingCall{"xrBeginFrame", 2, Then::ReplacesTheSession},
                    FailingCall{"xrLocateViews", 1, Then::ReplacesTheSession},
                    FailingCall{"xrLocateViews", 2, Then::ReplacesTheSession},
                    FailingCall{"xrAcquireSwapchainImage", 3, Then::ReplacesTheSession},
                    FailingCall{"xrAcquireSwapchainImage", 4, Then::ReplacesTheSession},
                    FailingCall{"xrWaitSwapchainImage", 3, Then::ReplacesTheSession},
                    FailingCall{"xrWaitSwapchainImage", 4, Then::ReplacesTheSession},
                    FailingCall{"xrReleaseSwapchainImage", 3, Then::ReplacesTheSession},
                    FailingCall{"xrReleaseSwapchainImage", 4, Then::ReplacesTheSession},
                    FailingCall{"xrEndFrame", 2, Then::ReplacesTheSession},
                    FailingCall{"xrRequestExitSession", 1, Then::HasEnded},
                    FailingCall{"xrEndSession", 1, Then::HasEnded},
                    FailingCall{"xrDestroySession", 1, Then::GoesOn},
                    FailingCall{"xrDestroyInstance", 1, Then::GoesOn}),
    name_of_case);

/// The runtime's name is only for people. What the lenses hide saves work.
class HeadsetExtras : public HeadsetErrors {};

TEST_P(HeadsetExtras, AreNotNeeded) {
  for (const XrResult result : all_errors()) {
    if (result == XR_ERROR_INSTANCE_LOST) continue;  // the next call returns it again
    SCOPED_TRACE(name_of(result));
    fail_once(result);
    play(false);
    ASSERT_GE(fake->counts[GetParam().call], GetParam().number) << "the call is made";
    const bool is_lost = GetParam().then == Then::ReplacesTheSession && result == XR_ERROR_SESSION_LOST;
    expect_all_frames(is_lost ? 2 : 1);
  }
}

INSTANTIATE_TEST_SUITE_P(EveryCall, HeadsetExtras,
                         testing::Values(FailingCall{"xrGetInstanceProperties", 1, Then::GoesOn},
                                         FailingCall{"xrGetSystemProperties", 1, Then::GoesOn},
                                         FailingCall{"xrGetVisibilityMaskKHR", 1, Then::ReplacesTheSession},
                                         FailingCall{"xrGetVisibilityMaskKHR", 2, Then::ReplacesTheSession},
                                         FailingCall{"xrGetDisplayRefreshRateFB", 1,
                                                     Then::ReplacesTheSession}),
                         name_of_case);

/// The session is lost and the headset gets a new id. Then a call for the next session fails.
class HeadsetErrorsAfterALoss : public HeadsetErrors {};

TEST_P(HeadsetErrorsAfterALoss, EndOrAreSurvived) {
  for (const XrResult result : all_errors()) {
    SCOPED_TRACE(name_of(result));
    fail_once(result);
    play(true);
    ASSERT_GE(fake->counts[GetParam().call], GetParam().number) << "the call is made";
    if (is_allowed(result))
      expect_all_frames(2);
    else
      expect(GetParam().then, result);
  }
}

INSTANTIATE_TEST_SUITE_P(
    EveryCall, HeadsetErrorsAfterALoss,
    testing::Values(FailingCall{"xrGetSystem", 2, Then::WaitsForTheHeadset},
                    FailingCall{"xrGetVulkanGraphicsRequirements2KHR", 2, Then::WaitsForTheHeadset},
                    FailingCall{"xrGetVulkanGraphicsDevice2KHR", 1, Then::WaitsForTheHeadset},
                    FailingCall{"xrCreateSession", 2, Then::WaitsForTheHeadset},
                    FailingCall{"xrCreateReferenceSpace", 2, Then::WaitsForTheHeadset},
                    FailingCall{"xrEnumerateSwapchainFormats", 3, Then::WaitsForTheHeadset},
                    FailingCall{"xrCreateSwapchain", 3, Then::WaitsForTheHeadset},
                    FailingCall{"xrEnumerateSwapchainImages", 8, Then::WaitsForTheHeadset},
                    FailingCall{"xrCreateActionSpace", 4, Then::WaitsForTheHeadset},
                    FailingCall{"xrAttachSessionActionSets", 2, Then::WaitsForTheHeadset}),
    name_of_case);

/// The calls that make Vulkan's instance and device. Their sentences are those of the device.
class HeadsetVulkanErrors : public HeadsetErrors {};

TEST_P(HeadsetVulkanErrors, AreThoseOfTheDevice) {
  for (const XrResult result : all_errors()) {
    SCOPED_TRACE(name_of(result));
    fail_once(result);
    const Expected<ShownPictures> made = make_pictures();
    ASSERT_FALSE(made.has_value());
    error = made.error().what;
    expect_sentence(result);
    EXPECT_EQ(fake->living, fake_openxr::Living{});
  }
}

INSTANTIATE_TEST_SUITE_P(EveryCall, HeadsetVulkanErrors,
                         testing::Values(FailingCall{"xrCreateVulkanInstanceKHR", 1, Then::EndsWithASentence},
                                         FailingCall{"xrGetVulkanGraphicsDevice2KHR", 1,
                                                     Then::EndsWithASentence},
                                         FailingCall{"xrCreateVulkanDeviceKHR", 1, Then::EndsWithASentence}),
                         name_of_case);

}  // namespace
}  // namespace farshade::openxr
