#include "vr_client/link/answer_inbox.h"

#include <gtest/gtest.h>

namespace farshade {
namespace {

using namespace std::chrono_literals;

FrameRequest request_of(std::uint32_t frame) {
  FrameRequest request;
  request.frame = {frame};
  for (View& view : request.views) view = {{}, {-0.7, 0.8, 0.6, -0.5}, {16, 16}};
  return request;
}

FrameReport report_of(std::uint32_t frame, ViewScale scale = kFullViewScale) {
  return {.frame = {frame}, .view_scale = scale};
}

TEST(AnswerInbox, TellsWhenARequestWentOutAndItsAnswerCame) {
  AnswerInbox inbox(8, {1});
  inbox.begin({});
  (void)inbox.ask(request_of(1), Time(10ms), Time(1s));
  ASSERT_NE(inbox.exchange({1}), nullptr);
  EXPECT_EQ(inbox.exchange({1})->sent, Time(1s));
  EXPECT_EQ(inbox.exchange({1})->last, std::nullopt);
  inbox.take(report_of(1), Time(1s + 20ms));
  EXPECT_EQ(inbox.exchange({1})->last, Time(1s + 20ms));
  EXPECT_EQ(inbox.asked_at({1}), Time(10ms));
  EXPECT_EQ(inbox.exchange({2}), nullptr);
}

TEST(AnswerInbox, ExpectsNothingOfAnEarlierSession) {
  AnswerInbox inbox(8, {1});
  inbox.begin({});
  (void)inbox.ask(request_of(1), {}, {});
  EXPECT_TRUE(inbox.may_come({1}));
  inbox.begin({});
  EXPECT_FALSE(inbox.may_come({1}));
  EXPECT_FALSE(inbox.may_come({2}));
}

TEST(AnswerInbox, SendsAllLightChangesAgainToANewSession) {
  AnswerInbox inbox(8, {1});
  inbox.begin({});
  FrameRequest request = request_of(1);
  change(request.lights, 0, false, std::nullopt);
  EXPECT_EQ(inbox.ask(request, {}, {}).lights.lights.size(), 1u);
  request.frame = {2};
  inbox.begin({});
  EXPECT_EQ(inbox.ask(request, {}, {}).lights.lights.size(), 1u);
}

TEST(AnswerInbox, FollowsTheNewestReportsScaleAlone) {
  AnswerInbox inbox(8, {1});
  inbox.begin({});
  for (const std::uint32_t frame : {1u, 2u}) (void)inbox.ask(request_of(frame), {}, {});
  inbox.take(report_of(2, {5}), {});
  inbox.take(report_of(1, {3}), {});
  EXPECT_EQ(inbox.view_scale(), ViewScale{5});
}

TEST(AnswerInbox, LearnsHowManyPixelsTheServerTraces) {
  AnswerInbox inbox(8, {1});
  inbox.begin({.most_pixels = 4096});
  EXPECT_EQ(inbox.most_pixels(), 4096u);
}

}  // namespace
}  // namespace farshade
