#include "stereo/wire/messages.h"

#include <gtest/gtest.h>

#include <limits>

#include "stereo/wire/bytes.h"
#include "wire_samples.h"

namespace farshade {
namespace {

using namespace wire_samples;

/// All messages, as datagrams. The slice is one of a real mask.
std::vector<Bytes> client_datagrams() {
  return {encoded(ClientMessage(hello())), encoded(ClientMessage(request()))};
}
std::vector<Bytes> server_datagrams() {
  return {encoded(ServerMessage(welcome())), encoded(ServerMessage(refusal())),
          encoded(ServerMessage(report())), packed(small_frame(), Side::Right).front()};
}

TEST(Messages, ComeBackAsTheyWere) {
  const auto client = client_datagrams();
  EXPECT_EQ(std::get<Hello>(*decode_client(client[0])), hello());
  const auto asked = std::get<RequestMessage>(*decode_client(client[1]));
  EXPECT_EQ(asked.request.frame, request().request.frame);
  EXPECT_EQ(asked.request.display_time, request().request.display_time);
  EXPECT_EQ(asked.request.scene_time, request().request.scene_time);
  EXPECT_EQ(asked.request.views, request().request.views);
  EXPECT_EQ(asked.newest_received, request().newest_received);

  const auto server = server_datagrams();
  EXPECT_EQ(std::get<Welcome>(*decode_server(server[0])), welcome());
  EXPECT_EQ(std::get<Refusal>(*decode_server(server[1])), refusal());
  EXPECT_EQ(std::get<FrameReport>(*decode_server(server[2])), report());
  const auto slice = std::get<Slice>(*decode_server(server[3]));
  EXPECT_EQ(slice.frame, FrameId{258});
  EXPECT_EQ(slice.light_set_revision, 7u);
  EXPECT_EQ(slice.eye, Side::Right);
  EXPECT_EQ(slice.size, (Extent{20, 18}));
  EXPECT_EQ(slice.lights, 2u);
  EXPECT_EQ(slice.plane, 0u);
  EXPECT_EQ(slice.first_tile, 0u);
  EXPECT_EQ(slice.tile_count, 4u);
}

TEST(Messages, SliceHeaderHasItsStatedSize) {
  const Bytes datagram = server_datagrams()[3];
  EXPECT_EQ(std::get<Slice>(*decode_server(datagram)).block.size(), datagram.size() - kSliceHeader_bytes);
}

TEST(Messages, RefuseEveryTruncation) {
  for (const Bytes& whole : client_datagrams())
    for (std::size_t size = 0; size < whole.size(); ++size) {
      const Bytes cut(whole.begin(),
                      whole.begin() + static_cast<std::ptrdiff_t>(size));  // its own allocation
      EXPECT_EQ(decode_client(cut).error(), WireRefusal::Truncated) << size << " of " << whole.size();
    }
  for (const Bytes& whole : server_datagrams()) {
    const bool is_slice = std::holds_alternative<Slice>(*decode_server(whole));
    const std::size_t fixed = is_slice ? kSliceHeader_bytes : whole.size();
    for (std::size_t size = 0; size < fixed; ++size) {
      const Bytes cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
      EXPECT_EQ(decode_server(cut).error(), WireRefusal::Truncated) << size << " of " << whole.size();
    }
  }
}

/// A message that is taken says all that its bytes say: encoded again it is the same.
TEST(Messages, EveryFlippedBitIsRefusedOrMeansWhatItSays) {
  for (const Bytes& whole : client_datagrams())
    for (std::size_t bit = 0; bit < 8 * whole.size(); ++bit) {
      Bytes flipped = whole;
      flipped[bit / 8] ^= std::byte{1} << bit % 8;
      const auto message = decode_client(flipped);
      EXPECT_EQ(message ? encoded(*message) : flipped, flipped) << "bit " << bit;
    }
  for (const Bytes& whole : server_datagrams())
    for (std::size_t bit = 0; bit < 8 * whole.size(); ++bit) {
      Bytes flipped = whole;
      flipped[bit / 8] ^= std::byte{1} << bit % 8;
      const auto message = decode_server(flipped);
      EXPECT_EQ(message ? encoded(*message) : flipped, flipped) << "bit " << bit;
    }
}

TEST(Messages, EachSideRefusesWhatOnlyTheOtherSays) {
  for (const Bytes& datagram : client_datagrams())
    EXPECT_EQ(decode_server(datagram).error(), WireRefusal::Type);
  for (const Bytes& datagram : server_datagrams())
    EXPECT_EQ(decode_client(datagram).error(), WireRefusal::Type);
}

TEST(Messages, NoAnswerIsLongerThanTheWordsThatAskedForIt) {
  const std::size_t asked = encoded(ClientMessage(hello())).size();
  EXPECT_LE(encoded(ServerMessage(welcome())).size(), asked);
  EXPECT_LE(encoded(ServerMessage(refusal())).size(), asked);
  EXPECT_LE(encoded(ServerMessage(refusal())).size(), encoded(ClientMessage(request())).size());
}

TEST(HelloDecode, TellsAnotherVersion) {
  Hello later = hello();
  later.version = kProtocolVersion + 1;
  EXPECT_EQ(std::get<Hello>(*decode_client(encoded(ClientMessage(later)))), later);
  Refusal answer = refusal();
  answer.version = kProtocolVersion + 1;
  EXPECT_EQ(std::get<Refusal>(*decode_server(encoded(ServerMessage(answer)))), answer);
}

TEST(RequestDecode, KnowsNoNewestFrameFromFrameZero) {
  RequestMessage first = request();
  first.newest_received.reset();
  EXPECT_FALSE(std::get<RequestMessage>(*decode_client(encoded(ClientMessage(first)))).newest_received);
  first.newest_received = FrameId{0};
  EXPECT_EQ(std::get<RequestMessage>(*decode_client(encoded(ClientMessage(first)))).newest_received,
            FrameId{0});
}

TEST(RequestDecode, NewestFrameSurvivesWraparound) {
  RequestMessage wrapped = request();
  wrapped.request.frame = FrameId{1};
  wrapped.newest_received = FrameId{0xfffffffe};
  EXPECT_EQ(std::get<RequestMessage>(*decode_client(encoded(ClientMessage(wrapped)))).newest_received,
            wrapped.newest_received);
}

/// Ranges by setting one number of a good request and writing its bytes by hand.
TEST(RequestDecode, RefusesViewsOutOfRange) {
  constexpr std::size_t left_view = 7 + 8 + 16, right_view = left_view + 92;
  constexpr double nan = std::numeric_limits<double>::quiet_NaN(),
                   inf = std::numeric_limits<double>::infinity();
  const Bytes good = encoded(ClientMessage(request()));
  for (const std::size_t view : {left_view, right_view})
    for (std::size_t number = 0; number < 11; ++number)
      for (const double bad : {nan, inf, -inf, 1e300, -1e300}) {
        Bytes bytes = good, eight;
        ByteWriter(eight).f64(bad);
        std::copy(eight.begin(), eight.end(), bytes.begin() + static_cast<std::ptrdiff_t>(view + 8 * number));
        EXPECT_EQ(decode_client(bytes).error(), WireRefusal::ViewRange)
            << "number " << number << " = " << bad;
      }
}

TEST(RequestDecode, TakesQuaternionsOffUnitByLessThanATenthOfAPercent) {
  RequestMessage message = request();
  message.request.views[1].stage_from_eye.rotation *= 1.0009;
  const Bytes close = encoded(ClientMessage(message));
  EXPECT_TRUE(decode_client(close));
  Bytes far = close, eight;
  ByteWriter(eight).f64(0.72);
  std::copy(eight.begin(), eight.end(), far.begin() + 7 + 8 + 16 + 92);
  EXPECT_EQ(decode_client(far).error(), WireRefusal::ViewRange);
}

TEST(EncodeDeathTest, StopsAtAMessageOutOfItsRanges) {
  RequestMessage message = request();
  message.request.views[0].fov.left = 1.0;
  Bytes bytes;
  EXPECT_DEATH(encode(ClientMessage(message), bytes), "within its ranges");
}

}  // namespace
}  // namespace farshade
