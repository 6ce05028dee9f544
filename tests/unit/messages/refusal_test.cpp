// Causes each refusal by the smallest change to valid bytes. Together the cases increment every counter once.
#include "stereo/messages/refusal.h"

#include <gtest/gtest.h>

#include "stereo/codec/plane_codec.h"
#include "stereo/sealing/seal.h"
#include "tests/unit/messages/samples.h"

namespace farshade {
namespace {

using namespace wire_samples;

struct Case {
  const char* what;
  Bytes bytes;
  WireRefusal why;
};

Bytes patched(Bytes bytes, std::size_t at, std::initializer_list<unsigned> values) {
  for (const unsigned value : values) bytes.at(at++) = static_cast<std::byte>(value);
  return bytes;
}

Bytes and_more(Bytes bytes, std::size_t count) {
  bytes.resize(bytes.size() + count);
  return bytes;
}

/// A slice of the first tile: light 0 and light 2 reach all of it.
Bytes slice_of_one_tile() {
  EyeMask mask({48, 48}, 3);
  for (std::uint32_t i = 0; i < 256; ++i) mask.set_word(i % 16, i / 16, 0, 5);
  std::vector<RequestedTile> requested(9);
  requested[0] = all_lights_in(kAllBlocks, 3);
  return packed(frame_of(mask, {}), Side::Left, requested).at(0);
}

Bytes with_block(const Bytes& block) {
  return encoded(ServerMessage(PlaneSlice{
      .kind = PlaneKind::Depth, .size = {48, 48}, .word_bytes = 4, .tile_count = 1, .block = block}));
}
Bytes with_tile(std::initializer_list<unsigned> tile) {
  return with_block(literal_block(bytes_of(tile)));
}

/// An endless LZ4 block of zeros: one literal, then a match of 255 n bytes at distance one.
Bytes bomb() {
  Bytes block = bytes_of({0x1f, 0, 1, 0});
  block.resize(block.size() + 100, std::byte{255});
  for (const unsigned byte : {0u, 0x50u, 0u, 0u, 0u, 0u, 0u}) block.push_back(static_cast<std::byte>(byte));
  return block;
}

std::vector<Case> envelopes_to_server() {
  const Bytes greeting = enveloped(hello());
  const Bytes sealed = enveloped(Sealed{SessionId{7}, 0, Bytes(20)});
  return {
      {"longer than a datagram", and_more(greeting, 1), WireRefusal::TooLong},
      {"nothing", {}, WireRefusal::Truncated},
      {"another program's magic", patched(greeting, 0, {'X'}), WireRefusal::Magic},
      {"sealed by another version", patched(sealed, 4, {(kProtocolVersion & 0xff) ^ 1}),
       WireRefusal::Version},
      {"a type that is not", patched(greeting, 6, {7}), WireRefusal::Type},
      {"a server's type", enveloped(retry()), WireRefusal::Type},
      {"a short hello", Bytes(greeting.begin(), greeting.end() - 1), WireRefusal::Padding},
      {"a hello with more to say", patched(greeting, 127, {1}), WireRefusal::Padding},
      {"a tag cut short", Bytes(sealed.begin(), sealed.end() - 5), WireRefusal::Truncated},
  };
}

std::vector<Case> envelopes_to_client() {
  const Bytes tag(kTag_bytes), no = enveloped(open_refusal());
  const Bytes accept_bytes = enveloped(accept_sample(tag));
  return {
      {"longer than a datagram", Bytes(1473), WireRefusal::TooLong},
      {"a client's type", enveloped(hello()), WireRefusal::Type},
      {"another version's retry", patched(enveloped(retry()), 4, {(kProtocolVersion & 0xff) ^ 1}),
       WireRefusal::Version},
      {"a reason that only keys may say", patched(no, 7, {3}), WireRefusal::Code},
      {"a reason that is none", patched(no, 7, {0}), WireRefusal::Code},
      {"a retry with more to say", and_more(enveloped(retry()), 1), WireRefusal::TrailingBytes},
      {"a refusal with more to say", and_more(no, 1), WireRefusal::TrailingBytes},
      {"no session, and more", and_more(enveloped(no_session()), 1), WireRefusal::TrailingBytes},
      {"a tag cut short", Bytes(accept_bytes.begin(), accept_bytes.end() - 1), WireRefusal::Truncated},
  };
}

std::vector<Case> messages_to_server() {
  const Bytes requested = encoded(ClientMessage(request()));
  return {
      {"longer than a message", and_more(requested, kBaseMessage_bytes + 1 - requested.size()),
       WireRefusal::TooLong},
      {"nothing", {}, WireRefusal::Truncated},
      {"a type that is not", patched(requested, 0, {15}), WireRefusal::Type},
      {"asks for a third eye's blocks", patched(ask_sample(), 5, {2}), WireRefusal::Code},
      {"asks for blocks of 0 columns", patched(ask_sample(), 6, {0, 0}), WireRefusal::MaskSize},
      {"asks for blocks in 257 lights", patched(ask_sample(), 10, {1, 1}), WireRefusal::Lights},
      {"asks for tiles beyond the grid", patched(ask_sample(), 16, {5}), WireRefusal::TileRange},
      {"a server's type", patched(requested, 0, {16}), WireRefusal::Type},
      {"holding a newer frame than asked for", patched(requested, 5, {0xff, 0xff, 0xff, 0xff}),
       WireRefusal::FrameOrder},
      {"display time beyond 73 years", patched(requested, 9 + 7, {0x40}), WireRefusal::TimeRange},
      {"scene time before -73 years", patched(requested, 17 + 7, {0x80}), WireRefusal::TimeRange},
      {"left fov beyond right", patched(requested, 25 + 56 + 7, {0x3f}), WireRefusal::ViewRange},
      {"picture 0 pixels wide", patched(requested, 25 + 88, {0, 0}), WireRefusal::ViewRange},
      {"picture 8193 pixels high", patched(requested, 117 + 90, {0x01, 0x20}), WireRefusal::ViewRange},
      {"an answer that is none", patched(requested, 209, {kAnswers}), WireRefusal::Code},
      {"video at no rate", patched(requested, 210, {0, 0, 0, 0}), WireRefusal::AnswerSpec},
      {"a 257th light", patched(requested, 239, {0, 1}), WireRefusal::Lights},
      {"a counter that none will reach", patched(requested, 301 + 7, {0x80}), WireRefusal::Arrivals},
      {"arrivals beyond 73 years", patched(requested, 309 + 7, {0x40}), WireRefusal::TimeRange},
      {"one byte too many", and_more(requested, 1), WireRefusal::TrailingBytes},
  };
}

/// Sends to a client that waits for a 48 x 48 mask of three lights.
std::vector<Case> messages_to_client() {
  const Bytes slice = slice_of_one_tile(), greeting = encoded(ServerMessage(welcome()));
  const Bytes account = encoded(ServerMessage(report())), no = encoded(ServerMessage(refusal()));
  const Bytes where = encoded(ServerMessage(probe()));
  return {
      {"a client's type", patched(greeting, 0, {1}), WireRefusal::Type},
      {"a welcome with 257 lights", patched(greeting, 33, {1, 1}), WireRefusal::Lights},
      {"a reason that is none", patched(no, 1, {5}), WireRefusal::Code},
      {"a reason for the open", patched(no, 1, {2}), WireRefusal::Code},
      {"a negative duration", patched(account, 37 + 7, {0xff}), WireRefusal::TimeRange},
      {"views of 0 eighths", patched(account, 93, {0}), WireRefusal::Code},
      {"views of 9 eighths", patched(account, 93, {9}), WireRefusal::Code},
      {"an answer that is none", patched(greeting, 39, {1u << kAnswers}), WireRefusal::Code},
      {"a part of none", patched(encoded(ServerMessage(video_part())), 11, {0, 0}), WireRefusal::Part},
      {"a probe for nothing", patched(where, 1, {0, 0, 0, 0, 0, 0, 0, 0}), WireRefusal::Code},
      {"a third eye", patched(slice, 9, {2}), WireRefusal::Code},
      {"width 0", patched(slice, 10, {0, 0}), WireRefusal::MaskSize},
      {"height 8193", patched(slice, 12, {0x01, 0x20}), WireRefusal::MaskSize},
      {"257 lights", patched(slice, 14, {1, 1}), WireRefusal::Lights},
      {"a second plane of three lights", patched(slice, 16, {1}), WireRefusal::Lights},
      {"first tile beyond the grid", patched(slice, 17, {9}), WireRefusal::TileRange},
      {"first tile far beyond", patched(slice, 17, {0xff, 0xff, 0xff, 0xff}), WireRefusal::TileRange},
      {"no tiles", patched(slice, 21, {0, 0}), WireRefusal::TileRange},
      {"more tiles than there are", patched(slice, 21, {10}), WireRefusal::TileRange},
      {"no block", Bytes(slice.begin(), slice.begin() + kSliceHeader_bytes), WireRefusal::Block},
      {"a block cut short", Bytes(slice.begin(), slice.end() - 1), WireRefusal::Block},
      {"a byte after the last tile", and_more(slice, 1), WireRefusal::Block},
      {"a plane's block that is not LZ4", with_block(bytes_of({0x20, 1})), WireRefusal::Block},
      {"a plane's block that opens to more than may be", with_block(bomb()), WireRefusal::Block},
      {"a coding that is not yet", with_tile({0xff, 1, 2, 3, 4}), WireRefusal::TileCoding},
      {"a tile too many", with_tile({0, 1, 2, 3, 4, 0, 1, 2, 3, 4}), WireRefusal::TileLength},
      {"half a tile", with_tile({0, 1, 2}), WireRefusal::TileLength},
      {"residuals of more bits than a word", with_tile({33, 1, 2, 3, 4}), WireRefusal::TileBits},
      {"another mask's size", patched(slice, 10, {49}), WireRefusal::OtherMask},
      {"another mask's lights", patched(slice, 14, {2}), WireRefusal::OtherMask},
  };
}

/// A session in which counter 5000 has been opened, and the datagram that it receives next.
std::vector<Case> sealed() {
  const Secret key(counting<32>(0)), other(counting<32>(1));
  Sealer sealer(SessionId{7}, key, Sealing::On), stranger(SessionId{7}, other, Sealing::On);
  Opener opener(key, Sealing::On);
  const auto answer = [&](const Bytes& datagram) {
    Bytes opened;
    const auto envelope = open_client_envelope(datagram);
    const auto message = opener.open(std::get<Sealed>(*envelope), datagram, opened);
    return message ? decode_client(*message).error() : message.error();
  };
  const Bytes requested = encoded(ClientMessage(request()));
  Bytes early, datagram;
  sealer.seal(requested, early);
  for (int i = 0; i < 5000; ++i) sealer.seal(requested, datagram);
  Bytes opened;
  EXPECT_TRUE(opener.open(std::get<Sealed>(*open_client_envelope(datagram)), datagram, opened));
  std::vector<Case> cases;
  const auto expect = [&](const char* what, const Bytes& sent, WireRefusal why) {
    EXPECT_EQ(answer(sent), why) << what;
    cases.push_back({what, sent, why});
  };
  expect("once more", datagram, WireRefusal::Replayed);
  expect("with a counter that none will reach", patched(datagram, 15 + 7, {0x80}), WireRefusal::CounterJump);
  expect("long ago", early, WireRefusal::Replayed);
  for (int i = 0; i < 6000; ++i) stranger.seal(requested, datagram);
  expect("under another key", datagram, WireRefusal::Forged);
  sealer.seal(bytes_of({1, 2}), datagram);
  expect("sealed, and too short a request", datagram, WireRefusal::Truncated);
  return cases;
}

template <class Any>
WireRefusal answer_of(const Decoded<Any>& decoded) {
  EXPECT_FALSE(decoded);
  return decoded ? WireRefusal{} : decoded.error();
}

WireRefusal answer_to_plane(const PlaneSlice& slice) {
  PixelPlane plane({48, 48}, 4);
  ReceivedTiles known(9);
  const auto tiles = decode_plane_tiles(slice, plane, known);
  EXPECT_EQ(known, ReceivedTiles(9));
  return tiles.error();
}

/// Also expects that nothing has changed.
WireRefusal answer_of_client(const Bytes& bytes) {
  const Decoded<ServerMessage> message = decode_server(bytes);
  if (!message) return message.error();
  if (const auto* plane = std::get_if<PlaneSlice>(&*message)) return answer_to_plane(*plane);
  EyeMask mask({48, 48}, 3);
  ReceivedTiles known(9);
  const auto tiles = decode_slice_tiles(std::get<Slice>(*message), {}, mask, known);
  EXPECT_EQ(mask, EyeMask({48, 48}, 3));
  EXPECT_EQ(known, ReceivedTiles(9));
  return tiles.error();
}

TEST(WireRefusals, EachFaultHasItsOwnCounter) {
  RefusalCounts counts;
  const auto expect = [&counts](const Case& fault, WireRefusal why) {
    EXPECT_EQ(why, fault.why) << fault.what << " counts as '" << name_of(why) << "'";
    const std::uint64_t before = counts[why], total = counts.total();
    counts.count(why);
    EXPECT_EQ(counts[why], before + 1);
    EXPECT_EQ(counts.total(), total + 1);
  };
  for (const Case& c : envelopes_to_server()) expect(c, answer_of(open_client_envelope(c.bytes)));
  for (const Case& c : envelopes_to_client()) expect(c, answer_of(open_server_envelope(c.bytes)));
  for (const Case& c : messages_to_server()) expect(c, answer_of(decode_client(c.bytes)));
  for (const Case& c : messages_to_client()) expect(c, answer_of_client(c.bytes));
  for (const Case& c : sealed()) expect(c, c.why);
  counts.count(WireRefusal::UnknownSession);  // counted by Sessions, because no bytes are wrong
  for (std::size_t i = 0; i < kWireRefusals; ++i)
    EXPECT_GT(counts.of[i], 0u) << "no case for '" << name_of(static_cast<WireRefusal>(i)) << "'";
}

TEST(WireRefusals, TheUnchangedBytesAreAccepted) {
  EXPECT_TRUE(open_client_envelope(enveloped(hello())));
  EXPECT_TRUE(open_client_envelope(enveloped(Sealed{SessionId{7}, 0, Bytes(20)})));
  EXPECT_TRUE(open_server_envelope(enveloped(retry())));
  EXPECT_TRUE(open_server_envelope(enveloped(open_refusal())));
  EXPECT_TRUE(open_server_envelope(enveloped(no_session())));
  EXPECT_TRUE(open_server_envelope(enveloped(accept_sample(Bytes(kTag_bytes)))));
  EXPECT_TRUE(decode_client(encoded(ClientMessage(request()))));
  EXPECT_TRUE(decode_server(encoded(ServerMessage(welcome()))));
  EXPECT_TRUE(decode_server(encoded(ServerMessage(refusal()))));
  EXPECT_TRUE(decode_server(encoded(ServerMessage(report()))));
  EXPECT_TRUE(decode_server(encoded(ServerMessage(probe()))));
  EXPECT_TRUE(decode_client(ask_sample()));
  const Bytes bytes = slice_of_one_tile();
  EyeMask mask({48, 48}, 3);
  ReceivedTiles known(9);
  std::vector<RequestedTile> requested(9);
  requested[0] = all_lights_in(kAllBlocks, 3);
  EXPECT_EQ(decode_slice_tiles(std::get<Slice>(*decode_server(bytes)), requested, mask, known).value(), 1u);
  EXPECT_EQ(mask.word(15, 15), 5u);
  EXPECT_EQ(mask.word(16, 15), 0u);
}

TEST(WireRefusals, HaveDifferentNames) {
  for (std::size_t a = 0; a < kWireRefusals; ++a)
    for (std::size_t b = 0; b < a; ++b)
      EXPECT_NE(name_of(static_cast<WireRefusal>(a)), name_of(static_cast<WireRefusal>(b)));
  EXPECT_EQ(name_of(WireRefusal::OtherMask), "other mask");
  static_assert(kWireRefusals == static_cast<std::size_t>(WireRefusal::OtherMask) + 1);
}

}  // namespace
}  // namespace farshade
