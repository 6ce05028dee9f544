#include "stereo/messages/messages.h"

#include <gtest/gtest.h>

#include <limits>

#include "stereo/messages/bytes.h"
#include "tests/unit/messages/samples.h"

namespace farshade {
namespace {

using namespace wire_samples;

/// The byte positions of the fields of the sample request.
constexpr std::size_t kLeftView = 25, kRightView = 117, kWanted = 209, kLightCount = 238, kChanges = 239,
                      kArrivals = 301;

/// All messages, encoded. The slice belongs to a real mask.
std::vector<Bytes> client_messages() {
  return {encoded(ClientMessage(request())), encoded(ClientMessage(plane_slice()))};
}
std::vector<Bytes> server_messages() {
  return {encoded(ServerMessage(welcome())),          encoded(ServerMessage(refusal())),
          encoded(ServerMessage(report())),           encoded(ServerMessage(probe())),
          packed(small_frame(), Side::Right).front(), encoded(ServerMessage(plane_slice())),
          encoded(ServerMessage(video_part())),       encoded(ServerMessage(path_probe()))};
}

RequestMessage travelled(const RequestMessage& message) {
  return std::get<RequestMessage>(*decode_client(encoded(ClientMessage(message))));
}

Bytes patched(Bytes bytes, std::size_t at, std::initializer_list<unsigned> values) {
  for (const unsigned value : values) bytes.at(at++) = static_cast<std::byte>(value);
  return bytes;
}
Bytes with_f64(Bytes bytes, std::size_t at, double value) {
  Bytes eight;
  ByteWriter(eight).f64(value);
  std::ranges::copy(eight, bytes.begin() + static_cast<std::ptrdiff_t>(at));
  return bytes;
}

/// `count` lights are switched off, one per revision.
LightChanges changes_of(std::size_t count) {
  LightChanges changes;
  for (std::uint32_t i = 0; i < count; ++i) change(changes, i, false, std::nullopt);
  return changes;
}

TEST(Messages, ComeBackAsTheyWere) {
  const RequestMessage requested = travelled(request());
  EXPECT_EQ(requested.request.frame, request().request.frame);
  EXPECT_EQ(requested.request.display_time, request().request.display_time);
  EXPECT_EQ(requested.request.scene_time, request().request.scene_time);
  EXPECT_EQ(requested.request.views, request().request.views);
  EXPECT_EQ(requested.request.lights, request().request.lights);
  EXPECT_EQ(requested.newest_received, request().newest_received);
  EXPECT_EQ(requested.probe_echo, request().probe_echo);
  EXPECT_EQ(requested.arrivals.first, request().arrivals.first);
  EXPECT_EQ(requested.arrivals.base, request().arrivals.base);
  EXPECT_EQ(requested.arrivals.count, request().arrivals.count);
  EXPECT_EQ(requested.arrivals.ticks, request().arrivals.ticks);

  const auto server = server_messages();
  EXPECT_EQ(std::get<Welcome>(*decode_server(server[0])), welcome());
  EXPECT_EQ(std::get<Refusal>(*decode_server(server[1])), refusal());
  EXPECT_EQ(std::get<FrameReport>(*decode_server(server[2])), report());
  EXPECT_EQ(std::get<Probe>(*decode_server(server[3])), probe());
  const auto slice = std::get<Slice>(*decode_server(server[4]));
  EXPECT_EQ(slice.frame, FrameId{258});
  EXPECT_EQ(slice.light_set_revision, LightSetRevision{7});
  EXPECT_EQ(slice.eye, Side::Right);
  EXPECT_EQ(slice.size, (Extent{20, 18}));
  EXPECT_EQ(slice.lights, 2u);
  EXPECT_EQ(slice.plane, 0u);
  EXPECT_EQ(slice.first_tile, 0u);
  EXPECT_EQ(slice.tile_count, 4u);
}

TEST(Messages, SliceHeaderHasItsStatedSize) {
  const Bytes bytes = server_messages()[4];
  EXPECT_EQ(std::get<Slice>(*decode_server(bytes)).block.size(), bytes.size() - kSliceHeader_bytes);
}

/// The size of the message's fields, after which a block extends to the end.
std::size_t fixed_bytes(const Bytes& message) {
  switch (std::to_integer<unsigned>(message[0])) {
    case 18:
      return kSliceHeader_bytes;
    case 21:
      return kPlaneSliceHeader_bytes;
    case 22:
      return kVideoPartHeader_bytes;
    case 26:
      return 1;
    default:
      return message.size();
  }
}

TEST(Messages, RefuseEveryTruncation) {
  const auto cut = [](const Bytes& whole, std::size_t size) {
    return Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));  // its own allocation
  };
  for (const Bytes& whole : client_messages())
    for (std::size_t size = 0; size < fixed_bytes(whole); ++size)
      EXPECT_EQ(decode_client(cut(whole, size)).error(), WireRefusal::Truncated)
          << size << " of " << whole.size();
  for (const Bytes& whole : server_messages())
    for (std::size_t size = 0; size < fixed_bytes(whole); ++size)
      EXPECT_EQ(decode_server(cut(whole, size)).error(), WireRefusal::Truncated)
          << size << " of " << whole.size();
}

TEST(Messages, RefuseWhatFollowsTheLastField) {
  for (Bytes bytes : client_messages()) {
    if (fixed_bytes(bytes) < bytes.size()) continue;  // its block extends to the end of the message
    bytes.push_back(std::byte{0});
    EXPECT_EQ(decode_client(bytes).error(), WireRefusal::TrailingBytes);
  }
  for (Bytes bytes : server_messages()) {
    if (fixed_bytes(bytes) < bytes.size()) continue;
    bytes.push_back(std::byte{0});
    EXPECT_EQ(decode_server(bytes).error(), WireRefusal::TrailingBytes);
  }
}

TEST(Messages, OnlyTheServersMayBeLongerThanTheBase) {
  Bytes plane = encoded(ClientMessage(plane_slice()));
  plane.resize(kBaseMessage_bytes);
  EXPECT_TRUE(decode_client(plane));
  plane.push_back(std::byte{0});
  EXPECT_EQ(decode_client(plane).error(), WireRefusal::TooLong);
  plane.resize(kMaxMessage_bytes);
  EXPECT_TRUE(decode_server(plane));
  plane.push_back(std::byte{0});
  EXPECT_EQ(decode_server(plane).error(), WireRefusal::TooLong);
}

TEST(PathProbeDecode, RefusesWhatIsNotPadding) {
  const Bytes probe = encoded(ServerMessage(PathProbe{std::span(PathProbe::kZeros).first(1400)}));
  EXPECT_EQ(probe.size(), 1401u);
  EXPECT_TRUE(decode_server(probe));
  EXPECT_EQ(decode_server(patched(probe, 1400, {1})).error(), WireRefusal::Padding);
  EXPECT_EQ(decode_server(std::span(probe).first(1)).error(), WireRefusal::Padding) << "empty";
}

/// A message that is accepted keeps all information: encoding it again gives the same bytes.
TEST(Messages, EveryFlippedBitIsRefusedOrMeansWhatItSays) {
  for (const Bytes& whole : client_messages())
    for (std::size_t bit = 0; bit < 8 * whole.size(); ++bit) {
      Bytes flipped = whole;
      flipped[bit / 8] ^= std::byte{1} << bit % 8;
      const auto message = decode_client(flipped);
      EXPECT_EQ(message ? encoded(*message) : flipped, flipped) << "bit " << bit;
    }
  for (const Bytes& whole : server_messages())
    for (std::size_t bit = 0; bit < 8 * whole.size(); ++bit) {
      Bytes flipped = whole;
      flipped[bit / 8] ^= std::byte{1} << bit % 8;
      const auto message = decode_server(flipped);
      EXPECT_EQ(message ? encoded(*message) : flipped, flipped) << "bit " << bit;
    }
}

TEST(Messages, EachSideRefusesWhatOnlyTheOtherSays) {
  const auto goes_both_ways = [](const Bytes& bytes) { return bytes[0] == std::byte{21}; };
  for (const Bytes& bytes : client_messages()) {
    EXPECT_TRUE(goes_both_ways(bytes) || decode_server(bytes).error() == WireRefusal::Type);
  }
  for (const Bytes& bytes : server_messages()) {
    EXPECT_TRUE(goes_both_ways(bytes) || decode_client(bytes).error() == WireRefusal::Type);
  }
}

TEST(RequestDecode, KnowsNoNewestFrameFromFrameZero) {
  RequestMessage first = request();
  first.newest_received.reset();
  EXPECT_FALSE(travelled(first).newest_received);
  first.newest_received = FrameId{0};
  EXPECT_EQ(travelled(first).newest_received, FrameId{0});
}

TEST(RequestDecode, NewestFrameSurvivesWraparound) {
  RequestMessage wrapped = request();
  wrapped.request.frame = FrameId{1};
  wrapped.newest_received = FrameId{0xfffffffe};
  EXPECT_EQ(travelled(wrapped).newest_received, wrapped.newest_received);
}

/// Tests ranges: changes one number of a valid request and writes the bytes directly.
TEST(RequestDecode, RefusesViewsOutOfRange) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN(),
                   inf = std::numeric_limits<double>::infinity();
  const Bytes good = encoded(ClientMessage(request()));
  for (const std::size_t view : {kLeftView, kRightView})
    for (std::size_t number = 0; number < 11; ++number)
      for (const double bad : {nan, inf, -inf, 1e300, -1e300})
        EXPECT_EQ(decode_client(with_f64(good, view + 8 * number, bad)).error(), WireRefusal::ViewRange)
            << "number " << number << " = " << bad;
}

TEST(RequestDecode, TakesQuaternionsOffUnitByLessThanATenthOfAPercent) {
  RequestMessage message = request();
  message.request.views[1].stage_from_eye.rotation *= 1.0009;
  const Bytes close = encoded(ClientMessage(message));
  EXPECT_TRUE(decode_client(close));
  EXPECT_EQ(decode_client(with_f64(close, kRightView, 0.72)).error(), WireRefusal::ViewRange);
}

TEST(RequestDecode, RefusesPlacesOfLightsOutOfRange) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN(),
                   inf = std::numeric_limits<double>::infinity();
  constexpr std::size_t pose = kChanges + 7 + 7;
  const Bytes good = encoded(ClientMessage(request()));
  for (std::size_t number = 0; number < 6; ++number)
    for (const double bad : {nan, inf, -inf, 1.1e9, -1.1e9})
      EXPECT_EQ(decode_client(with_f64(good, pose + 8 * number, bad)).error(), WireRefusal::ViewRange)
          << "number " << number << " = " << bad;
  EXPECT_TRUE(decode_client(with_f64(good, pose, 1e9)));
  EXPECT_TRUE(decode_client(with_f64(good, pose + 32, -1.0009)));
  EXPECT_EQ(decode_client(with_f64(good, pose + 32, -1.0011)).error(), WireRefusal::ViewRange);
}

TEST(RequestDecode, TakesAsManyLightChangesAsStatedAndNoMore) {
  RequestMessage message = request();
  message.request.lights = changes_of(RequestMessage::kMostLightChanges);
  EXPECT_EQ(travelled(message).request.lights, message.request.lights);

  const Bytes full = encoded(ClientMessage(message));
  const auto seventh = full.begin() + static_cast<std::ptrdiff_t>(kChanges) + std::ptrdiff_t{6} * 7;
  Bytes more(full.begin(), seventh);
  const Bytes change = bytes_of({6, 0, 8, 0, 0, 0, 0});
  more.insert(more.end(), change.begin(), change.end());
  more.insert(more.end(), seventh, full.end());
  more = patched(patched(more, kLightCount, {7}), kLightCount - 4, {8, 0, 0, 0});
  EXPECT_EQ(decode_client(more).error(), WireRefusal::Lights);
  EXPECT_EQ(decode_client(patched(more, kLightCount, {255})).error(), WireRefusal::Lights);
}

TEST(RequestDecode, TakesRevisionsInTheirOrderOnly) {
  const Bytes good = encoded(ClientMessage(request()));  // revisions 3 and 5 of set 5
  constexpr std::size_t first = kChanges + 2, second = kChanges + 7 + 2;
  EXPECT_TRUE(decode_client(patched(good, first, {4})));
  for (const unsigned bad :
       {0u, 1u, 5u, 6u})  // not after the file's revision, or not before the second change
    EXPECT_EQ(decode_client(patched(good, first, {bad})).error(), WireRefusal::Lights) << bad;
  for (const unsigned bad : {2u, 3u, 6u})  // not after the first change, or after the set
    EXPECT_EQ(decode_client(patched(good, second, {bad})).error(), WireRefusal::Lights) << bad;
}

TEST(RequestDecode, TakesFlagsThatMeanSomethingOnly) {
  const Bytes good = encoded(ClientMessage(request()));
  const auto on = decode_client(patched(good, kChanges + 6, {1}));
  ASSERT_TRUE(on);
  EXPECT_TRUE(std::get<RequestMessage>(*on).request.lights.lights[0].on);
  for (unsigned bit = 2; bit < 8; ++bit)
    EXPECT_EQ(decode_client(patched(good, kChanges + 6, {1u << bit})).error(), WireRefusal::Lights) << bit;
}

TEST(RequestDecode, TakesTheLastLightAndNoneAfterIt) {
  const Bytes good = encoded(ClientMessage(request()));
  EXPECT_TRUE(decode_client(patched(good, kChanges, {255, 0})));
  EXPECT_EQ(decode_client(patched(good, kChanges, {0, 1})).error(), WireRefusal::Lights);
}

TEST(RequestDecode, TakesTheLongestArrivalReportAndNoLonger) {
  RequestMessage message = request();
  message.arrivals.count = ArrivalReport::kMost;
  message.arrivals.ticks.fill(0x1234);
  EXPECT_EQ(travelled(message).arrivals.ticks, message.arrivals.ticks);

  Bytes longer = patched(encoded(ClientMessage(message)), kArrivals + 16, {1, 1});
  longer.resize(longer.size() + 2);
  EXPECT_EQ(decode_client(longer).error(), WireRefusal::Arrivals);
  EXPECT_EQ(decode_client(patched(longer, kArrivals + 16, {255, 255})).error(), WireRefusal::Arrivals);
}

TEST(RequestDecode, TakesCountersAndTimesOfArrivalsInTheirRangesOnly) {
  const Bytes good = encoded(ClientMessage(request()));
  EXPECT_TRUE(decode_client(patched(good, kArrivals + 7, {0x7f})));
  EXPECT_EQ(decode_client(patched(good, kArrivals + 7, {0x80})).error(), WireRefusal::Arrivals);
  EXPECT_EQ(decode_client(patched(good, kArrivals + 15, {0x20})).error(), WireRefusal::TimeRange);
  EXPECT_EQ(decode_client(patched(good, kArrivals + 15, {0xdf})).error(), WireRefusal::TimeRange);
}

TEST(RequestDecode, TakesOnlyWhatGoesWithTheAnswer) {
  const auto refusal_of = [](const AnswerSpec& spec) {
    RequestMessage message = request();
    message.request.answer = {};
    Bytes bytes = encoded(ClientMessage(message)), fields;
    ByteWriter io(fields);
    io.code(spec.kind), io.u32(spec.bits_per_second), io.ns(spec.interval), io.code(spec.coding);
    io.u8(spec.position_bits), io.u16(spec.slices);
    std::ranges::copy(fields, bytes.begin() + kWanted);
    const Decoded<ClientMessage> read = decode_client(bytes);
    return read ? std::nullopt : std::optional(read.error());
  };
  using enum Answer;
  const Duration frame = std::chrono::milliseconds(14);
  for (const AnswerSpec& fine : std::initializer_list<AnswerSpec>{
           {},
           {.kind = GBuffer},
           {.kind = Video, .bits_per_second = 100'000, .interval = frame},
           {.kind = Difference, .bits_per_second = 1'000'000'000, .interval = std::chrono::seconds(10)},
           {.slices = 65535},
           {.coding = Coding::Lz4},
           {.kind = MasksOfPositions, .position_bits = 8, .slices = 65535},
           {.kind = MasksOfPositions, .position_bits = 24}})
    EXPECT_EQ(refusal_of(fine), std::nullopt);
  for (const AnswerSpec& wrong : std::initializer_list<AnswerSpec>{
           {.bits_per_second = 1},
           {.interval = frame},
           {.coding = Coding::Alone},
           {.coding = Coding::Lz4, .slices = 1},
           {.kind = MasksOfPositions, .coding = Coding::Lz4, .position_bits = 8},
           {.kind = GBuffer, .coding = Coding::Lz4},
           {.kind = Video, .bits_per_second = 100'000, .interval = frame, .coding = Coding::Lz4},
           {.kind = CubeMask, .coding = Coding::Lz4},
           {.position_bits = 8},
           {.kind = GBuffer, .slices = 1},
           {.kind = GBuffer, .position_bits = 16},
           {.kind = Video, .bits_per_second = 99'999, .interval = frame},
           {.kind = Video, .bits_per_second = 1'000'000'001, .interval = frame},
           {.kind = Video, .bits_per_second = 100'000},
           {.kind = Video, .bits_per_second = 100'000, .interval = -frame},
           {.kind = Video, .bits_per_second = 100'000, .interval = std::chrono::seconds(11)},
           {.kind = Video, .bits_per_second = 100'000, .interval = frame, .slices = 1},
           {.kind = MasksOfPositions, .position_bits = 7},
           {.kind = MasksOfPositions, .position_bits = 25}})
    EXPECT_EQ(refusal_of(wrong), WireRefusal::AnswerSpec);
  EXPECT_EQ(refusal_of({.kind = static_cast<Answer>(kAnswers)}), WireRefusal::Code);
  EXPECT_EQ(refusal_of({.coding = static_cast<Coding>(3)}), WireRefusal::Code);
}

TEST(WelcomeDecode, TakesExposuresInTheirRangeOnly) {
  Welcome message = welcome();
  for (const int quarter_stops : {-Exposure::kMostQuarterStops, -1, Exposure::kMostQuarterStops}) {
    message.exposure = {quarter_stops};
    EXPECT_EQ(std::get<Welcome>(*decode_server(encoded(ServerMessage(message)))), message);
  }
  Bytes beyond = encoded(ServerMessage(message));
  beyond[beyond.size() - 2] = std::byte{65};  // 321, one quarter stop too many
  EXPECT_EQ(decode_server(beyond).error(), WireRefusal::Code);
}

TEST(PlaneSliceDecode, RefusesWhatNoPlaneHas) {
  const Bytes good = encoded(ClientMessage(plane_slice()));
  const auto error = [&](std::size_t at, std::initializer_list<unsigned> values) {
    return decode_client(patched(good, at, values)).error();
  };
  EXPECT_EQ(error(5, {2}), WireRefusal::Code);
  EXPECT_EQ(error(6, {6}), WireRefusal::Code);
  EXPECT_EQ(error(7, {0, 0}), WireRefusal::MaskSize);
  EXPECT_EQ(error(7, {1, 0x20}), WireRefusal::MaskSize);
  EXPECT_EQ(error(11, {0}), WireRefusal::Code);
  EXPECT_EQ(error(11, {5}), WireRefusal::Code);
  EXPECT_EQ(error(12, {4}), WireRefusal::TileRange);
  EXPECT_EQ(error(16, {4}), WireRefusal::TileRange);
  EXPECT_EQ(error(16, {0}), WireRefusal::TileRange);
}

TEST(VideoPartDecode, RefusesPartsThatNoPictureHas) {
  const Bytes good = encoded(ServerMessage(video_part()));
  EXPECT_EQ(decode_server(patched(good, 9, {3})).error(), WireRefusal::Part);
  EXPECT_EQ(decode_server(patched(good, 9, {0, 0, 0})).error(), WireRefusal::Part);
  EXPECT_EQ(decode_server(patched(good, 11, {1, 0x10})).error(), WireRefusal::Part);  // 4,097 parts
  EXPECT_EQ(decode_server(patched(good, 9, {1})).error(), WireRefusal::Part) << "shorter than any part";
  EXPECT_EQ(decode_server(std::span(good).first(13)).error(), WireRefusal::Part) << "empty";
  EXPECT_EQ(decode_server(patched(good, 5, {3})).error(), WireRefusal::FrameOrder)
      << "depends on a newer picture";
  EXPECT_TRUE(decode_server(patched(good, 5, {2}))) << "a key frame";
  Bytes whole = patched(good, 9, {1});
  whole.resize(kBaseMessage_bytes);
  EXPECT_TRUE(decode_server(whole));
  Bytes last = good;
  last.resize(kBaseMessage_bytes);
  EXPECT_TRUE(decode_server(last));
  last.push_back(std::byte{0});
  EXPECT_EQ(decode_server(last).error(), WireRefusal::Part)
      << "a last part would be written past its picture";
}

TEST(RequestEncode, HasRoomForAllThatItMayCarry) {
  RequestMessage message = request();
  message.request.lights = changes_of(RequestMessage::kMostLightChanges);
  for (LightChange& light : message.request.lights.lights) light.pose = LightPose{};
  message.arrivals.count = ArrivalReport::kMost;
  EXPECT_EQ(encoded(ClientMessage(message)).size(), 1099u);
}

TEST(EncodeDeathTest, StopsAtAMessageOutOfItsRanges) {
  RequestMessage message = request();
  message.request.views[0].fov.left_rad = 1.0;
  Bytes bytes;
  EXPECT_DEATH(encode(ClientMessage(message), bytes), "within its ranges");
  message = request();
  message.request.lights = changes_of(RequestMessage::kMostLightChanges + 1);
  EXPECT_DEATH(encode(ClientMessage(message), bytes), "within its ranges");
  message = request();
  message.arrivals.count = ArrivalReport::kMost + 1;
  EXPECT_DEATH(encode(ClientMessage(message), bytes), "within its ranges");
}

}  // namespace
}  // namespace farshade
