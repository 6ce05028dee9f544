// Each refusal by the smallest change to a good datagram that earns it. Together they reach every counter
// once.
#include "stereo/wire/refusal.h"

#include <gtest/gtest.h>

#include "wire_samples.h"

namespace farshade {
namespace {

using namespace wire_samples;

struct Case {
  const char* what;
  Bytes datagram;  ///< to the server, or to a client that waits for a 48 x 48 mask of three lights
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

Bytes with_block(const Bytes& block) {
  return encoded(ServerMessage(Slice{.size = {48, 48}, .lights = 3, .tile_count = 1, .block = block}));
}
Bytes with_tile(std::initializer_list<unsigned> tile) {
  return with_block(literal_block(bytes_of(tile)));
}

/// An LZ4 block of zeros without end: one literal, then a match of 255 n bytes one byte back.
Bytes bomb() {
  Bytes block = bytes_of({0x1f, 0, 1, 0});
  block.resize(block.size() + 100, std::byte{255});
  for (const unsigned byte : {0u, 0x50u, 0u, 0u, 0u, 0u, 0u}) block.push_back(static_cast<std::byte>(byte));
  return block;
}

std::vector<Case> server_side() {
  const Bytes hello_bytes = encoded(ClientMessage(hello())), asked = encoded(ClientMessage(request()));
  return {
      {"longer than a datagram", and_more(hello_bytes, kMaxDatagram_bytes), WireRefusal::TooLong},
      {"nothing", {}, WireRefusal::Truncated},
      {"another program's magic", patched(hello_bytes, 0, {'X'}), WireRefusal::Magic},
      {"a request of another version", patched(asked, 4, {2}), WireRefusal::Version},
      {"a type that is not", patched(asked, 6, {3}), WireRefusal::Type},
      {"a server's type", patched(asked, 6, {16}), WireRefusal::Type},
      {"holding a newer frame than asked for", patched(asked, 11, {0xff, 0xff, 0xff, 0xff}),
       WireRefusal::FrameOrder},
      {"display time beyond 73 years", patched(asked, 15 + 7, {0x40}), WireRefusal::TimeRange},
      {"scene time before -73 years", patched(asked, 23 + 7, {0x80}), WireRefusal::TimeRange},
      {"left fov beyond right", patched(asked, 31 + 56 + 7, {0x3f}), WireRefusal::ViewRange},
      {"picture 0 pixels wide", patched(asked, 31 + 88, {0, 0}), WireRefusal::ViewRange},
      {"picture 8193 pixels high", patched(asked, 31 + 90, {0x01, 0x20}), WireRefusal::ViewRange},
      {"reserved bytes in use", patched(hello_bytes, hello_bytes.size() - 1, {1}), WireRefusal::Code},
      {"one byte too many", and_more(asked, 1), WireRefusal::TrailingBytes},
  };
}

std::vector<Case> client_side() {
  const Bytes slice = with_tile({1, 5}), greeting = encoded(ServerMessage(welcome()));
  const Bytes account = encoded(ServerMessage(report())), no = encoded(ServerMessage(refusal()));
  return {
      {"a welcome with 257 lights", patched(greeting, 39, {1, 1}), WireRefusal::Lights},
      {"a reason that is none", patched(no, 7, {5}), WireRefusal::Code},
      {"a negative duration", patched(account, 7 + 36 + 7, {0xff}), WireRefusal::TimeRange},
      {"a third eye", patched(slice, 15, {2}), WireRefusal::Code},
      {"width 0", patched(slice, 16, {0, 0}), WireRefusal::MaskSize},
      {"height 8193", patched(slice, 18, {0x01, 0x20}), WireRefusal::MaskSize},
      {"257 lights", patched(slice, 20, {1, 1}), WireRefusal::Lights},
      {"a second plane of three lights", patched(slice, 22, {1}), WireRefusal::Lights},
      {"first tile beyond the grid", patched(slice, 23, {9}), WireRefusal::TileRange},
      {"first tile far beyond", patched(slice, 23, {0xff, 0xff, 0xff, 0xff}), WireRefusal::TileRange},
      {"no tiles", patched(slice, 27, {0, 0}), WireRefusal::TileRange},
      {"more tiles than there are", patched(slice, 27, {10}), WireRefusal::TileRange},
      {"no block", with_block({}), WireRefusal::Block},
      {"a block cut short", with_block(bytes_of({0x20, 1})), WireRefusal::Block},
      {"a block that opens to more than may be", with_block(bomb()), WireRefusal::Block},
      {"a coding that is not yet", with_tile({3, 5}), WireRefusal::TileCoding},
      {"a tile too few", patched(slice, 27, {2}), WireRefusal::TileLength},
      {"a tile too many", with_tile({1, 5, 1, 5}), WireRefusal::TileLength},
      {"half a plane", with_tile({2, 1, 0, 1}), WireRefusal::TileLength},
      {"a run that promises another", with_tile({2, 1, 0, 1, 0, 0x12}), WireRefusal::TileLength},
      {"a fourth light's value", with_tile({1, 8}), WireRefusal::TileBits},
      {"a fourth light that varies", with_tile({2, 8, 0, 1, 0, 0}), WireRefusal::TileBits},
      {"another mask's size", patched(slice, 16, {49}), WireRefusal::OtherMask},
      {"another mask's lights", patched(slice, 20, {2}), WireRefusal::OtherMask},
  };
}

WireRefusal answer_of_server(const Bytes& datagram) {
  return decode_client(datagram).error();
}

/// Also expects that nothing was touched.
WireRefusal answer_of_client(const Bytes& datagram) {
  const Decoded<ServerMessage> message = decode_server(datagram);
  if (!message) return message.error();
  EyeMask mask({48, 48}, 3);
  KnownTiles known(9);
  const auto tiles = decode_slice_tiles(std::get<Slice>(*message), mask, known);
  EXPECT_EQ(mask, EyeMask({48, 48}, 3));
  EXPECT_EQ(known, KnownTiles(9));
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
  for (const Case& fault : server_side()) expect(fault, answer_of_server(fault.datagram));
  for (const Case& fault : client_side()) expect(fault, answer_of_client(fault.datagram));
  for (std::size_t i = 0; i < kWireRefusals; ++i)
    EXPECT_GT(counts.of[i], 0u) << "no case for '" << name_of(static_cast<WireRefusal>(i)) << "'";
}

TEST(WireRefusals, TheGoodDatagramsTheseWereMadeFromAreTaken) {
  EXPECT_TRUE(decode_client(encoded(ClientMessage(hello()))));
  EXPECT_TRUE(decode_client(encoded(ClientMessage(request()))));
  const Bytes datagram = with_tile({1, 5});
  EyeMask mask({48, 48}, 3);
  KnownTiles known(9);
  EXPECT_EQ(decode_slice_tiles(std::get<Slice>(*decode_server(datagram)), mask, known).value(), 1u);
  EXPECT_EQ(mask.word(15, 15), 5u);
  EXPECT_EQ(mask.word(16, 15), 0u);
}

TEST(WireRefusals, HaveDifferentNames) {
  for (std::size_t a = 0; a < kWireRefusals; ++a)
    for (std::size_t b = 0; b < a; ++b)
      EXPECT_NE(name_of(static_cast<WireRefusal>(a)), name_of(static_cast<WireRefusal>(b)));
}

}  // namespace
}  // namespace farshade
