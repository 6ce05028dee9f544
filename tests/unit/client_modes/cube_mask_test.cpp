#include "vr_client/modes/cube_mask.h"

#include <gtest/gtest.h>

#include "tests/unit/client_modes/scripted_link.h"

namespace farshade {
namespace {

using namespace std::chrono_literals;
using modes_test::kEye;
using modes_test::ScriptedLink;

/// The ids that a client's requests of this frame have, counted from the first.
std::vector<std::uint32_t> ask(CubeMask& cube_mask, ScriptedLink& link, Duration at) {
  FrameMoment shown{.frame = {1}, .display_time = Time(at), .scene_time = {}, .views = {}};
  for (View& view : shown.views) view = {{}, {-0.7, 0.7, 0.6, -0.6}, kEye};
  const FrameSettings settings;
  const SceneState state;
  const FrameInputs inputs{shown, state, 10ms, settings};
  link.sent.clear();
  static_cast<void>(cube_mask.plan(inputs, 20ms));
  cube_mask.send(inputs);
  std::vector<std::uint32_t> ids;
  for (const FrameRequest& request : link.sent)
    ids.push_back(request.frame.value - kFirstCubeMaskFrame.value);
  return ids;
}

/// As after a loss of the device, which makes the pipeline of the mode anew in the same session.
TEST(CubeMask, OneAfterAnotherOnALinkUsesNoFrameIdTwice) {
  using Ids = std::vector<std::uint32_t>;
  ScriptedLink link;
  link.welcome({.answers = set_of(Answer::Masks) | set_of(Answer::CubeMask)});
  const MaskPolicy policy{.pace = Pace::Real, .round_trip = 20ms};
  CubeMask first(&link, policy, SceneMotion::Still);
  EXPECT_EQ(ask(first, link, 0ms), (Ids{0, 1, 2}));
  CubeMask second(&link, policy, SceneMotion::Still);
  EXPECT_EQ(ask(second, link, 10ms), (Ids{3, 4, 5}));
  EXPECT_EQ(ask(second, link, 10ms + CubeMaskPlan::kStillPeriod), (Ids{6}));
  CubeMask third(&link, policy, SceneMotion::Still);
  EXPECT_EQ(ask(third, link, 20ms + CubeMaskPlan::kStillPeriod), (Ids{9, 10, 11}))
      << "7 and 8 have pairs of their own";
}

}  // namespace
}  // namespace farshade
