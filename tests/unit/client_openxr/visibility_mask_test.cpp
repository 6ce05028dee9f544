// What the lenses hide, and the refresh rate of the display, as the runtime states them.
#include "vr_client/openxr/visibility_mask.h"

#include <cmath>
#include <limits>

#include "tests/unit/client_openxr/fake_headset.h"
#include "vr_client/openxr/session.h"

namespace farshade::openxr {
namespace {

namespace fake = fake_openxr;

const std::vector<XrVector2f> kVertices{{-1, 1}, {-0.5f, 1}, {-1, 0.5f}, {1, -1}};

TEST(HiddenAreaOf, HasTheCornersOfTheTriangles) {
  const std::vector<std::uint32_t> indices{2, 1, 0, 1, 2, 3};
  const HiddenArea area = hidden_area_of(kVertices, indices).value();
  const std::vector<glm::vec2> corners{{-1, 0.5f}, {-0.5f, 1}, {-1, 1}, {-0.5f, 1}, {-1, 0.5f}, {1, -1}};
  EXPECT_EQ(area.corners, corners);
}

TEST(HiddenAreaOf, LeavesOutTrianglesWithoutAnArea) {
  const std::vector<std::uint32_t> indices{0, 0, 0, 2, 1, 0, 3, 3, 1};
  EXPECT_EQ(hidden_area_of(kVertices, indices).value(),
            hidden_area_of(kVertices, std::vector<std::uint32_t>{2, 1, 0}).value());
}

TEST(HiddenAreaOf, RefusesWhatIsNoMesh) {
  using Indices = std::vector<std::uint32_t>;
  EXPECT_FALSE(hidden_area_of(kVertices, Indices{0, 1}));
  EXPECT_FALSE(hidden_area_of(kVertices, Indices{0, 1, 2, 3}));
  EXPECT_FALSE(hidden_area_of(kVertices, Indices{0, 1, 4}));
  EXPECT_FALSE(hidden_area_of(kVertices, Indices(kMostMaskIndices + 3, 0)));
  EXPECT_FALSE(hidden_area_of(std::vector<XrVector2f>(kMostMaskVertices + 1), Indices{0, 1, 2}));
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()})
    for (const XrVector2f vertex : {XrVector2f{bad, 0}, XrVector2f{0, -bad}}) {
      std::vector<XrVector2f> vertices = kVertices;
      vertices[3] = vertex;
      EXPECT_FALSE(hidden_area_of(vertices, Indices{0, 1, 2}));
    }
  EXPECT_FALSE(hidden_area_of(std::vector<XrVector2f>{{0, 0}, {1, 0}, {0, -1e30f}}, Indices{0, 1, 2}));
  EXPECT_TRUE(hidden_area_of({}, {}).value().corners.empty());
}

/// One triangle of another width for each eye.
fake::VisibilityMask mask_of(std::uint32_t view, XrVisibilityMaskTypeKHR kind, float width) {
  if (kind != XR_VISIBILITY_MASK_TYPE_HIDDEN_TRIANGLE_MESH_KHR) return {};
  const float x = width * (1 + static_cast<float>(view));
  return {{{0.5f, 0.5f}, {x, 0.5f}, {0.5f, x}}, {0, 1, 2}};
}

PerEye<HiddenArea> areas_of(float width) {
  PerEye<HiddenArea> areas;
  for (std::uint32_t eye = 0; eye < kEyes; ++eye) {
    const float x = width * (1 + static_cast<float>(eye));
    areas[eye].corners = {{0.5f, 0.5f}, {x, 0.5f}, {0.5f, x}};
  }
  return areas;
}

class HeadsetLens : public FakeHeadset {
 protected:
  void SetUp() override {
    FakeHeadset::SetUp();
    if (!fake) return;
    fake->extensions.emplace_back(XR_KHR_VISIBILITY_MASK_EXTENSION_NAME);
    fake->mask = [](std::uint32_t view, XrVisibilityMaskTypeKHR kind) { return mask_of(view, kind, 1); };
  }
  void change(XrSession session) {
    fake->mask = [](std::uint32_t view, XrVisibilityMaskTypeKHR kind) { return mask_of(view, kind, 2); };
    fake->push(XrEventDataVisibilityMaskChangedKHR{XR_TYPE_EVENT_DATA_VISIBILITY_MASK_CHANGED_KHR, nullptr,
                                                   session, XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO, 1});
  }
  void expect_hidden(const PerEye<HiddenArea>& areas) const {
    ASSERT_NE(runtime->hidden(), nullptr);
    EXPECT_EQ(*runtime->hidden(), areas);
  }
};

TEST_F(HeadsetLens, HidesWhatTheRuntimeStatesAndFollowsItsChanges) {
  ASSERT_TRUE(open(setup())) << error;
  ASSERT_TRUE(show());
  expect_hidden(areas_of(1));
  change(nullptr);  // of a session that was lost
  ASSERT_TRUE(show());
  expect_hidden(areas_of(1));
  change(fake->session);
  ASSERT_TRUE(show());
  expect_hidden(areas_of(2));
}

TEST_F(HeadsetLens, HidesNothingWithoutAMask) {
  fake->mask = {};
  ASSERT_TRUE(open(setup())) << error;
  ASSERT_TRUE(show());
  EXPECT_EQ(runtime->hidden(), nullptr);
}

TEST_F(HeadsetLens, IsNotAskedForWithoutTheExtensionOrIfAllPixelsAreWanted) {
  HeadsetSetup all = setup();
  all.hides = false;
  ASSERT_TRUE(open(std::move(all))) << error;
  ASSERT_TRUE(show());
  EXPECT_EQ(runtime->hidden(), nullptr);
  runtime.reset();
  system.reset();
  fake = &restart_fake();
  fake->mask = [](std::uint32_t view, XrVisibilityMaskTypeKHR kind) { return mask_of(view, kind, 1); };
  ASSERT_TRUE(open(setup())) << error;
  ASSERT_TRUE(show());
  EXPECT_EQ(runtime->hidden(), nullptr);
  EXPECT_EQ(fake->counts["xrGetVisibilityMaskKHR"], 0u);
}

TEST_F(HeadsetLens, HidesNothingOfAnEyeWhoseMaskIsBad) {
  fake->mask = [](std::uint32_t view, XrVisibilityMaskTypeKHR kind) {
    fake::VisibilityMask mask = mask_of(view, kind, 1);
    if (view == 0) mask.indices[1] = 7;
    return mask;
  };
  ASSERT_TRUE(open(setup())) << error;
  ASSERT_TRUE(show());
  expect_hidden({HiddenArea{}, areas_of(1)[1]});
}

class HeadsetRefresh : public FakeHeadset {
 protected:
  void change(float to) {
    fake->push(XrEventDataDisplayRefreshRateChangedFB{XR_TYPE_EVENT_DATA_DISPLAY_REFRESH_RATE_CHANGED_FB,
                                                      nullptr, 72, to});
  }
};

TEST_F(HeadsetRefresh, IsWhatTheRuntimeStates) {
  fake->extensions.emplace_back(XR_FB_DISPLAY_REFRESH_RATE_EXTENSION_NAME);
  ASSERT_TRUE(open(setup())) << error;
  ASSERT_TRUE(show());
  EXPECT_EQ(runtime->refresh_hz(), 72);
  change(90);
  ASSERT_TRUE(show());
  EXPECT_EQ(runtime->refresh_hz(), 90);
  for (const float bad : {0.0f, -1.0f, std::numeric_limits<float>::quiet_NaN()}) change(bad);
  ASSERT_TRUE(show());
  EXPECT_EQ(runtime->refresh_hz(), 90);
}

TEST_F(HeadsetRefresh, FollowsThePeriodOtherwise) {
  ASSERT_TRUE(open(setup())) << error;
  ASSERT_TRUE(show());
  EXPECT_DOUBLE_EQ(runtime->refresh_hz(), 100);
}

/// A capture that stated such a rate could not be read.
TEST_F(HeadsetRefresh, IsNeverOneThatADisplayCannotHave) {
  for (const XrDuration period : {XrDuration{0}, XrDuration{-1}, XrDuration{1}, XrDuration{2'000'000'000}}) {
    fake->period = period;
    ASSERT_TRUE(open(setup())) << error;
    const std::optional<FrameTiming> timing = runtime->wait_frame();
    ASSERT_TRUE(timing);
    EXPECT_EQ(timing->period, duration_from_ms(1e3 / 72)) << period;
    EXPECT_DOUBLE_EQ(runtime->refresh_hz(), 1 / seconds_of(timing->period)) << period;
    runtime.reset();
    system.reset();
    fake = &restart_fake();
  }
  EXPECT_FALSE(is_rate(1e9f));
}

TEST_F(HeadsetRefresh, FollowsThePeriodIfTheRuntimeStatesNonsense) {
  fake->extensions.emplace_back(XR_FB_DISPLAY_REFRESH_RATE_EXTENSION_NAME);
  fake->refresh_rate = 0;
  ASSERT_TRUE(open(setup())) << error;
  ASSERT_TRUE(show());
  EXPECT_DOUBLE_EQ(runtime->refresh_hz(), 100);
}

}  // namespace
}  // namespace farshade::openxr
