#include "vr_client/link/answer_inbox.h"

#include <gtest/gtest.h>

#include "tests/support/packed.h"

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

/// An eye's whole mask: a single tile that is lit everywhere.
Slice slice_of(std::uint32_t frame, Side eye = Side::Left) {
  static std::vector<std::byte> block;
  ShadowFrame made{{frame}, kFirstLightSet, request_of(frame).views, {}};
  for (EyeMask& mask : made.masks) mask = EyeMask({16, 16}, 1);
  static FramePacker packer;
  for (const std::vector<std::byte>& datagram : pack(packer, made, {.frame = {frame}})) {
    const Decoded<ServerMessage> message = decode_server(datagram);
    const auto* const slice = std::get_if<Slice>(&*message);
    if (slice == nullptr || slice->eye != eye) continue;
    Slice found = *slice;
    block.assign(slice->block.begin(), slice->block.end());
    found.block = block;
    return found;
  }
  return {};
}

TEST(AnswerInbox, RecordsWhenARequestWasMadeAndItsAnswerCame) {
  AnswerInbox inbox(8, {1});
  inbox.begin({});
  (void)inbox.ask(request_of(1), Time(10ms), Time(1s));
  const RequestRecord* const record = inbox.find({1});
  ASSERT_NE(record, nullptr);
  EXPECT_EQ(record->origin.requested_at, Time(10ms));
  EXPECT_EQ(record->origin.sent, Time(1s));
  EXPECT_EQ(record->report_arrived, std::nullopt);
  inbox.take(slice_of(1), Time(1s + 15ms));
  inbox.take(report_of(1), Time(1s + 20ms));
  EXPECT_EQ(record->first_piece, Time(1s + 15ms));
  EXPECT_EQ(record->report_arrived, Time(1s + 20ms));
  inbox.take(report_of(2), Time(2s));
  EXPECT_EQ(inbox.find({2}), nullptr);
}

TEST(AnswerInbox, ANewRequestsRecordRemembersNothingOfItsSlot) {
  AnswerInbox inbox(Assembler::kKept + 1, {1});
  inbox.begin({});
  for (std::uint32_t frame = 1; frame <= 20; ++frame) {
    const std::size_t slot = inbox.next_slot();
    (void)inbox.ask(request_of(frame), Time(10ms * frame), Time(1s));
    const RequestRecord& record = *inbox.find({frame});
    EXPECT_EQ(record.slot, slot);
    EXPECT_FALSE(record.first_piece || record.report_arrived || record.anything_known()) << frame;
    inbox.take(slice_of(frame), Time(1s));
    inbox.take(report_of(frame), Time(1s));
  }
}

TEST(AnswerInbox, ListsWhatHasComeNewestFirst) {
  AnswerInbox inbox(8, {1});
  inbox.begin({});
  for (std::uint32_t frame = 1; frame <= 5; ++frame)
    (void)inbox.ask(request_of(frame), Time(10ms * frame), {});
  for (const std::uint32_t frame : {2u, 5u, 3u}) inbox.take(slice_of(frame), {});
  const auto frames = [&](Time until) {
    std::vector<std::uint32_t> found;
    for (const RequestRecord* record : inbox.received(until)) found.push_back(record->request.frame.value);
    return found;
  };
  EXPECT_EQ(frames(Time::max()), (std::vector<std::uint32_t>{5, 3, 2}));
  EXPECT_EQ(frames(Time(30ms)), (std::vector<std::uint32_t>{3, 2}));
  EXPECT_EQ(frames(Time(30ms - 1ns)), (std::vector<std::uint32_t>{2}));
}

TEST(AnswerInboxSettled, MeansCompleteOrReportedOrOvertaken) {
  AnswerInbox inbox(8, {1});
  inbox.begin({});
  for (std::uint32_t frame = 1; frame <= 4; ++frame) (void)inbox.ask(request_of(frame), {}, {});
  const auto settled = [&](std::uint32_t frame) { return inbox.is_settled(*inbox.find({frame})); };
  inbox.take(slice_of(1), {});
  EXPECT_FALSE(settled(1)) << "one eye is missing";
  inbox.take(slice_of(1, Side::Right), {});
  EXPECT_TRUE(settled(1)) << "complete";
  inbox.take(slice_of(2), {});
  EXPECT_FALSE(settled(2));
  inbox.take(report_of(2), {});
  EXPECT_TRUE(settled(2)) << "the report is sent last";
  inbox.take(slice_of(3), {});
  EXPECT_FALSE(settled(3));
  inbox.take(slice_of(4), {});
  EXPECT_TRUE(settled(3)) << "the next answer is arriving";
  EXPECT_FALSE(settled(4));
}

FrameRequest surround_of(std::uint32_t number) {
  FrameRequest request = request_of(kFirstSurroundFrame.value + number);
  request.answer = {.kind = Answer::Surround};
  return request;
}

TEST(AnswerInboxSurround, HasTheNewestSettledMaskOfEachPairApartFromTheOthers) {
  AnswerInbox inbox(8, {1});
  inbox.begin({});
  const std::uint32_t first = kFirstSurroundFrame.value;
  for (std::uint32_t number = 0; number < 6; ++number)
    (void)inbox.ask(surround_of(number), Time(number * 10ms), {});
  (void)inbox.ask(request_of(1), Time(0ms), {});
  EXPECT_TRUE(inbox.surround(Time(1s)).empty());
  const auto frames_until = [&](Time until) {
    std::vector<std::uint32_t> numbers;
    for (const RequestRecord* record : inbox.surround(until))
      numbers.push_back(record->request.frame.value - first);
    return numbers;
  };
  for (const std::uint32_t number : {0u, 1u}) {
    inbox.take(slice_of(first + number), {});
    inbox.take(slice_of(first + number, Side::Right), {});
  }
  EXPECT_EQ(frames_until(Time(1s)), (std::vector<std::uint32_t>{0, 1}));
  EXPECT_EQ(frames_until(Time(5ms)), (std::vector<std::uint32_t>{0})) << "requested until then";
  inbox.take(slice_of(first + 3), {});
  EXPECT_EQ(frames_until(Time(1s)), (std::vector<std::uint32_t>{0, 1}))
      << "only a part of the newer one has come";
  inbox.take(report_of(first + 3), {});
  EXPECT_EQ(frames_until(Time(1s)), (std::vector<std::uint32_t>{0, 1})) << "the rest is lost";
  inbox.take(slice_of(first + 3, Side::Right), {});
  EXPECT_EQ(frames_until(Time(1s)), (std::vector<std::uint32_t>{3, 1}));
  inbox.take(slice_of(first + 2), {});
  EXPECT_EQ(frames_until(Time(1s)), (std::vector<std::uint32_t>{3, 1})) << "more of pair 2 may come";
  inbox.take(report_of(first + 2), {});
  EXPECT_EQ(frames_until(Time(1s)), (std::vector<std::uint32_t>{3, 1, 2})) << "better than nothing";
  EXPECT_EQ(inbox.newest_known(), nullptr) << "the surround is not the newest mask of the views";
  EXPECT_FALSE(inbox.is_settled(*inbox.find({1})));
  EXPECT_TRUE(inbox.received(Time(1s)).empty());
  EXPECT_EQ(inbox.counters().slices, 7u);
  inbox.take(report_of(first + 4, ViewScale{3}), {});
  EXPECT_EQ(inbox.view_scale(), kFullViewScale) << "the scale is that of the views";
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

TEST(AnswerInbox, LearnsTheExposureOfEachSession) {
  AnswerInbox inbox(8, {1});
  EXPECT_EQ(inbox.exposure(), std::nullopt);
  inbox.begin({.exposure = {-9}});
  EXPECT_EQ(inbox.exposure(), Exposure{-9});
  inbox.begin({});
  EXPECT_EQ(inbox.exposure(), Exposure{});
}

}  // namespace
}  // namespace farshade
