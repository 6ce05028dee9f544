// The calls for controllers, against the fake runtime.
#include <fmt/format.h>

#include "tests/unit/client_openxr/fake_headset.h"
#include "vr_client/openxr/actions.h"

namespace farshade::openxr {
namespace {

constexpr const char* kLeft = " /user/hand/left";

/// Frames with controllers. `moves` moves the viewer by 1 m in each frame with hands.
class HeadsetHands : public FakeHeadset {
 protected:
  void SetUp() override {
    FakeHeadset::SetUp();
    if (!fake) return;
    fake->inputs = {{"walk", {0.25f, -0.5f}},
                    {"turn", {-0.75f, 0}},
                    {std::string("grab") + kLeft, {0.5f, 0}},
                    {"ahead /user/hand/right", {1, 0}},
                    {"next-overlay", {1, 0}}};
    fake->poses = {{std::string("aim") + kLeft, {{0, 1, 0, 0}, {-0.25f, 1.25f, -0.5f}}}};
  }
  [[nodiscard]] HeadsetSetup setup_with_hands() {
    HeadsetSetup all = setup();
    all.follow_hands = [this](const ViewerInput& viewer) {
      viewers.push_back(viewer);
      return moves && viewer.hands
                 ? Rigid<Stage, Tracked>{viewer.stage_from_tracked.rotation,
                                         viewer.stage_from_tracked.translation + glm::dvec3(1, 0, 0)}
                 : viewer.stage_from_tracked;
    };
    return all;
  }
  /// Whether the newest frame had hands.
  bool shows_hands() {
    EXPECT_TRUE(show());
    return viewers.back().hands.has_value();
  }

  std::vector<ViewerInput> viewers;
  bool moves = false;
};

TEST_F(HeadsetHands, HaveTheStateThatTheRuntimeGivesThem) {
  ASSERT_TRUE(open(setup_with_hands())) << error;
  show_until(3);
  ASSERT_EQ(viewers.size(), 3u);
  const ViewerInput& viewer = viewers.back();
  EXPECT_EQ(viewer.display_time, time_from_ns(fake->first_time + 2 * fake->period));
  EXPECT_LT(glm::length(viewer.tracked_from_head.translation - glm::dvec3(0, 1.6, 0)), 1e-6);
  ASSERT_TRUE(viewer.hands);
  const auto& [left, right] = viewer.hands->hand;
  ASSERT_TRUE(left.tracked_from_hand);
  EXPECT_EQ(left.tracked_from_hand->translation, glm::dvec3(-0.25, 1.25, -0.5));
  EXPECT_EQ(left.tracked_from_hand->rotation, glm::dquat(0, 0, 1, 0));
  EXPECT_FALSE(right.tracked_from_hand);
  EXPECT_EQ(left.grab, 0.5);
  EXPECT_EQ(right.grab, 0) << "its action is not active";
  EXPECT_FALSE(left.ahead);
  EXPECT_TRUE(right.ahead);
  EXPECT_EQ(viewer.hands->walk, glm::dvec2(0.25, -0.5));
  EXPECT_EQ(viewer.hands->turn, -0.75);
  EXPECT_TRUE(viewer.hands->next_overlay);
}

TEST_F(HeadsetHands, MoveTheViewer) {
  moves = true;
  ASSERT_TRUE(open(setup_with_hands())) << error;
  show_until(4);
  ASSERT_EQ(shown.size(), 4u);
  for (std::size_t frame = 2; frame < shown.size(); ++frame)
    EXPECT_NEAR(
        shown[frame][0].stage_from_eye.translation.x - shown[frame - 1][0].stage_from_eye.translation.x, 1,
        1e-9);
}

TEST_F(HeadsetHands, AreReadWhileTheSessionIsFocused) {
  ASSERT_TRUE(open(setup_with_hands())) << error;
  EXPECT_FALSE(shows_hands()) << "the first frame with the focus shows that it is new";
  EXPECT_TRUE(shows_hands());
  EXPECT_TRUE(shows_hands());
  fake->push(XR_SESSION_STATE_VISIBLE);
  const std::uint32_t read = fake->counts["xrSyncActions"];
  EXPECT_FALSE(shows_hands());
  EXPECT_FALSE(shows_hands());
  EXPECT_EQ(fake->counts["xrSyncActions"], read);
  fake->push(XR_SESSION_STATE_FOCUSED);
  EXPECT_FALSE(shows_hands());
  EXPECT_TRUE(shows_hands());
  // No frame is shown between two times with the focus.
  for (const XrSessionState state : {XR_SESSION_STATE_VISIBLE, XR_SESSION_STATE_SYNCHRONIZED,
                                     XR_SESSION_STATE_VISIBLE, XR_SESSION_STATE_FOCUSED})
    fake->push(state);
  EXPECT_FALSE(shows_hands());
  EXPECT_TRUE(shows_hands());
}

TEST_F(HeadsetHands, AreEmptyIfTheFocusIsLostInTheCall) {
  fake->answers = {{"xrSyncActions", 2, XR_SESSION_NOT_FOCUSED}};
  ASSERT_TRUE(open(setup_with_hands())) << error;
  static_cast<void>(show());
  EXPECT_TRUE(shows_hands());
  EXPECT_FALSE(shows_hands());
  EXPECT_TRUE(shows_hands());
}

TEST_F(HeadsetHands, PoseIsUnknownIfTheRuntimeSaysSo) {
  ASSERT_TRUE(open(setup_with_hands())) << error;
  fake->before = [this](const std::string& call) {
    if (call == "xrLocateSpace") fake->poses.clear();
  };
  show_until(2);
  ASSERT_TRUE(viewers.back().hands);
  EXPECT_FALSE(viewers.back().hands->hand[0].tracked_from_hand);
  EXPECT_EQ(fake->counts["xrLocateSpace"], 1u);
}

TEST_F(HeadsetHands, PoseIsUnknownIfItsQuaternionIsZero) {
  ASSERT_TRUE(open(setup_with_hands())) << error;
  fake->poses.begin()->second.orientation = {0, 0, 0, 0};
  show_until(2);
  ASSERT_TRUE(viewers.back().hands);
  EXPECT_FALSE(viewers.back().hands->hand[0].tracked_from_hand);
}

TEST_F(HeadsetHands, SuggestTheTableOfBindings) {
  ASSERT_TRUE(open(setup_with_hands())) << error;
  std::vector<std::string> table;
  for (const ControllerProfile& profile : controller_profiles())
    for (const Binding& binding : profile.bindings)
      table.push_back(fmt::format("{} {} {}", profile.path,
                                  action_facts()[static_cast<std::size_t>(binding.action)].name,
                                  binding.input));
  EXPECT_EQ(fake->suggested, table);
}

TEST_F(HeadsetHands, LeaveOutControllersThatTheRuntimeDoesNotKnow) {
  fake->answers = {{"xrSuggestInteractionProfileBindings", 2, XR_ERROR_PATH_UNSUPPORTED}};
  ASSERT_TRUE(open(setup_with_hands())) << error;
  static_cast<void>(show());
  EXPECT_TRUE(shows_hands());
  EXPECT_EQ(fake->counts["xrSuggestInteractionProfileBindings"], 3u);
}

TEST_F(HeadsetHands, AreAttachedToEverySession) {
  ASSERT_TRUE(open(setup_with_hands())) << error;
  show_until(2);
  fake->push(XR_SESSION_STATE_LOSS_PENDING);
  EXPECT_FALSE(shows_hands());
  EXPECT_TRUE(shows_hands());
  EXPECT_EQ(fake->counts["xrCreateSession"], 2u);
  EXPECT_EQ(fake->counts["xrAttachSessionActionSets"], 2u);
  EXPECT_EQ(fake->counts["xrCreateActionSpace"], 4u);
  EXPECT_EQ(fake->counts["xrCreateActionSet"], 1u);
}

TEST_F(HeadsetHands, AreNotAskedForByAClientThatDoesNotUseThem) {
  ASSERT_TRUE(open(setup())) << error;
  show_until(2);
  EXPECT_EQ(fake->counts["xrCreateActionSet"], 0u);
  EXPECT_EQ(fake->counts["xrSyncActions"], 0u);
}

}  // namespace
}  // namespace farshade::openxr
