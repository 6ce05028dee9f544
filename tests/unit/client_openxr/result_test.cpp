#include "vr_client/openxr/result.h"

#include <gtest/gtest.h>
#include <openxr/openxr_reflection.h>

#include <array>

namespace farshade::openxr {
namespace {

struct NamedResult {
  XrResult result;
  const char* name;
};
#define FARSHADE_RESULT(name, value) NamedResult{name, #name},
constexpr std::array kResults{XR_LIST_ENUM_XrResult(FARSHADE_RESULT)};
#undef FARSHADE_RESULT

TEST(XrResults, EveryErrorNamesItselfAndItsCall) {
  std::size_t errors = 0;
  for (const NamedResult& one : kResults) {
    EXPECT_EQ(name_of(one.result), one.name);
    const Expected<void> done = succeeded(one.result, "xrSomething");
    ASSERT_EQ(done.has_value(), one.result >= 0) << one.name;
    if (done) continue;
    ++errors;
    EXPECT_NE(done.error().what.find(one.name), std::string::npos) << done.error().what;
    EXPECT_NE(done.error().what.find("xrSomething"), std::string::npos) << done.error().what;
  }
  EXPECT_GT(errors, 40u);
}

TEST(XrResults, UnknownErrorsHaveTheirNumber) {
  const Expected<void> done = succeeded(static_cast<XrResult>(-1234567), "xrSomething");
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().what,
            "xrSomething returned XrResult -1234567; the log of the OpenXR runtime may say why");
}

TEST(XrResults, WhatIsMissingCanBeToldFromWhatFails) {
  EXPECT_EQ(succeeded(XR_ERROR_RUNTIME_UNAVAILABLE, "x").error().fault, Fault::Missing);
  EXPECT_EQ(succeeded(XR_ERROR_FORM_FACTOR_UNAVAILABLE, "x").error().fault, Fault::Missing);
  EXPECT_EQ(succeeded(XR_ERROR_EXTENSION_NOT_PRESENT, "x").error().fault, Fault::Unsupported);
  EXPECT_EQ(succeeded(XR_ERROR_SYSTEM_INVALID, "x").error().fault, Fault::Missing);
  EXPECT_EQ(succeeded(XR_ERROR_SESSION_LOST, "x").error().fault, Fault::Missing);
  EXPECT_EQ(succeeded(XR_ERROR_INSTANCE_LOST, "x").error().fault, Fault::Unavailable);
}

/// A runtime whose service does not run fails to make an instance. Later the same result means something
/// else.
TEST(XrResults, ARuntimeThatDoesNotRunCanBeToldFromOneThatFails) {
  const std::string made = error_of(XR_ERROR_RUNTIME_FAILURE, "xrCreateInstance").what,
                    later = error_of(XR_ERROR_RUNTIME_FAILURE, "xrEndFrame").what;
  EXPECT_NE(made.find("no OpenXR runtime runs here"), std::string::npos) << made;
  EXPECT_EQ(later,
            "the OpenXR runtime has failed: start it again (xrEndFrame returned XR_ERROR_RUNTIME_FAILURE)");
}

TEST(XrResults, APictureThatIsHeldIsToldAsItself) {
  EXPECT_EQ(error_of(XR_TIMEOUT_EXPIRED, "xrWaitSwapchainImage").what,
            "the compositor of the OpenXR runtime gives no picture back: start the runtime again "
            "(xrWaitSwapchainImage returned XR_TIMEOUT_EXPIRED)");
}

}  // namespace
}  // namespace farshade::openxr
