#include "stereo/link/frame_receiver.h"

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

TEST(FrameReceiver, RecordsWhenARequestWasMadeAndItsAnswerCame) {
  FrameReceiver receiver(8, {1});
  receiver.begin({});
  (void)receiver.ask(request_of(1), Time(10ms), Time(1s));
  const RequestRecord* const record = receiver.find({1});
  ASSERT_NE(record, nullptr);
  EXPECT_EQ(record->origin.requested_at, Time(10ms));
  EXPECT_EQ(record->origin.sent, Time(1s));
  EXPECT_EQ(record->report_arrived, std::nullopt);
  receiver.take(slice_of(1), Time(1s + 15ms));
  receiver.take(report_of(1), Time(1s + 20ms));
  EXPECT_EQ(record->first_piece, Time(1s + 15ms));
  EXPECT_EQ(record->report_arrived, Time(1s + 20ms));
  receiver.take(report_of(2), Time(2s));
  EXPECT_EQ(receiver.find({2}), nullptr);
}

TEST(FrameReceiver, ANewRequestsRecordRemembersNothingOfItsSlot) {
  FrameReceiver receiver(Assembler::kKept + 1, {1});
  receiver.begin({});
  for (std::uint32_t frame = 1; frame <= 20; ++frame) {
    const std::size_t slot = receiver.next_slot();
    (void)receiver.ask(request_of(frame), Time(10ms * frame), Time(1s));
    const RequestRecord& record = *receiver.find({frame});
    EXPECT_EQ(record.slot, slot);
    EXPECT_FALSE(record.first_piece || record.report_arrived || record.anything_known()) << frame;
    receiver.take(slice_of(frame), Time(1s));
    receiver.take(report_of(frame), Time(1s));
  }
}

TEST(FrameReceiver, ListsWhatHasComeNewestFirst) {
  FrameReceiver receiver(8, {1});
  receiver.begin({});
  for (std::uint32_t frame = 1; frame <= 5; ++frame)
    (void)receiver.ask(request_of(frame), Time(10ms * frame), {});
  for (const std::uint32_t frame : {2u, 5u, 3u}) receiver.take(slice_of(frame), {});
  const auto frames = [&](Time until) {
    std::vector<std::uint32_t> found;
    for (const RequestRecord* record : receiver.received(until)) found.push_back(record->request.frame.value);
    return found;
  };
  EXPECT_EQ(frames(Time::max()), (std::vector<std::uint32_t>{5, 3, 2}));
  EXPECT_EQ(frames(Time(30ms)), (std::vector<std::uint32_t>{3, 2}));
  EXPECT_EQ(frames(Time(30ms - 1ns)), (std::vector<std::uint32_t>{2}));
}

TEST(FrameReceiverSettled, MeansCompleteOrReportedOrOvertaken) {
  FrameReceiver receiver(8, {1});
  receiver.begin({});
  for (std::uint32_t frame = 1; frame <= 4; ++frame) (void)receiver.ask(request_of(frame), {}, {});
  const auto settled = [&](std::uint32_t frame) { return receiver.is_settled(*receiver.find({frame})); };
  receiver.take(slice_of(1), {});
  EXPECT_FALSE(settled(1)) << "one eye is missing";
  receiver.take(slice_of(1, Side::Right), {});
  EXPECT_TRUE(settled(1)) << "complete";
  receiver.take(slice_of(2), {});
  EXPECT_FALSE(settled(2));
  receiver.take(report_of(2), {});
  EXPECT_TRUE(settled(2)) << "the report is sent last";
  receiver.take(slice_of(3), {});
  EXPECT_FALSE(settled(3));
  receiver.take(slice_of(4), {});
  EXPECT_TRUE(settled(3)) << "the next answer is arriving";
  EXPECT_FALSE(settled(4));
}

FrameRequest cube_mask_of(std::uint32_t number) {
  FrameRequest request = request_of(kFirstCubeMaskFrame.value + number);
  request.answer = {.kind = Answer::CubeMask};
  return request;
}

TEST(FrameReceiverCubeMask, HasTheNewestSettledMaskOfEachPairApartFromTheOthers) {
  FrameReceiver receiver(8, {1});
  receiver.begin({});
  const std::uint32_t first = kFirstCubeMaskFrame.value;
  for (std::uint32_t number = 0; number < 6; ++number)
    (void)receiver.ask(cube_mask_of(number), Time(number * 10ms), {});
  (void)receiver.ask(request_of(1), Time(0ms), {});
  EXPECT_TRUE(receiver.cube_mask(Time(1s)).empty());
  const auto frames_until = [&](Time until) {
    std::vector<std::uint32_t> numbers;
    for (const RequestRecord* record : receiver.cube_mask(until))
      numbers.push_back(record->request.frame.value - first);
    return numbers;
  };
  for (const std::uint32_t number : {0u, 1u}) {
    receiver.take(slice_of(first + number), {});
    receiver.take(slice_of(first + number, Side::Right), {});
  }
  EXPECT_EQ(frames_until(Time(1s)), (std::vector<std::uint32_t>{0, 1}));
  EXPECT_EQ(frames_until(Time(5ms)), (std::vector<std::uint32_t>{0})) << "requested until then";
  receiver.take(slice_of(first + 3), {});
  EXPECT_EQ(frames_until(Time(1s)), (std::vector<std::uint32_t>{0, 1}))
      << "only a part of the newer one has come";
  receiver.take(report_of(first + 3), {});
  EXPECT_EQ(frames_until(Time(1s)), (std::vector<std::uint32_t>{0, 1})) << "the rest is lost";
  receiver.take(slice_of(first + 3, Side::Right), {});
  EXPECT_EQ(frames_until(Time(1s)), (std::vector<std::uint32_t>{3, 1}));
  receiver.take(slice_of(first + 2), {});
  EXPECT_EQ(frames_until(Time(1s)), (std::vector<std::uint32_t>{3, 1})) << "more of pair 2 may come";
  receiver.take(report_of(first + 2), {});
  EXPECT_EQ(frames_until(Time(1s)), (std::vector<std::uint32_t>{3, 1, 2})) << "better than nothing";
  EXPECT_EQ(receiver.newest_known(), nullptr) << "the cube mask is not the newest mask of the views";
  EXPECT_FALSE(receiver.is_settled(*receiver.find({1})));
  EXPECT_TRUE(receiver.received(Time(1s)).empty());
  EXPECT_EQ(receiver.counters().slices, 7u);
  receiver.take(report_of(first + 4, ViewScale{3}), {});
  EXPECT_EQ(receiver.view_scale(), kFullViewScale) << "the scale is that of the views";
}

TEST(FrameReceiver, ExpectsNothingOfAnEarlierSession) {
  FrameReceiver receiver(8, {1});
  receiver.begin({});
  (void)receiver.ask(request_of(1), {}, {});
  EXPECT_TRUE(receiver.may_come({1}));
  receiver.begin({});
  EXPECT_FALSE(receiver.may_come({1}));
  EXPECT_FALSE(receiver.may_come({2}));
}

TEST(FrameReceiver, SendsAllLightChangesAgainToANewSession) {
  FrameReceiver receiver(8, {1});
  receiver.begin({});
  FrameRequest request = request_of(1);
  change(request.lights, 0, false, std::nullopt);
  EXPECT_EQ(receiver.ask(request, {}, {}).lights.lights.size(), 1u);
  request.frame = {2};
  receiver.begin({});
  EXPECT_EQ(receiver.ask(request, {}, {}).lights.lights.size(), 1u);
}

TEST(FrameReceiver, FollowsTheNewestReportsScaleAlone) {
  FrameReceiver receiver(8, {1});
  receiver.begin({});
  for (const std::uint32_t frame : {1u, 2u}) (void)receiver.ask(request_of(frame), {}, {});
  receiver.take(report_of(2, {5}), {});
  receiver.take(report_of(1, {3}), {});
  EXPECT_EQ(receiver.view_scale(), ViewScale{5});
}

TEST(FrameReceiver, LearnsHowManyPixelsTheServerTraces) {
  FrameReceiver receiver(8, {1});
  receiver.begin({.most_pixels = 4096});
  EXPECT_EQ(receiver.most_pixels(), 4096u);
}

TEST(FrameReceiver, LearnsTheExposureOfEachSession) {
  FrameReceiver receiver(8, {1});
  EXPECT_EQ(receiver.exposure(), std::nullopt);
  receiver.begin({.exposure = {-9}});
  EXPECT_EQ(receiver.exposure(), Exposure{-9});
  receiver.begin({});
  EXPECT_EQ(receiver.exposure(), Exposure{});
}

}  // namespace
}  // namespace farshade
