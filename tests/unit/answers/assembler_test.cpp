#include "stereo/answers/assembler.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <random>

#include "stereo/frame/tiles.h"
#include "tests/support/packed.h"

namespace farshade {
namespace {

constexpr LightSetRevision kRevision{4};

FrameRequest request(std::uint32_t frame, Extent size = {200, 120}) {
  FrameRequest requested;
  requested.frame = {frame};
  for (View& view : requested.views) view.size = size;
  return requested;
}

/// Noise, so that the frame takes many slices.
ShadowFrame noisy_frame(const FrameRequest& requested, std::uint32_t lights, std::uint32_t seed = 1) {
  ShadowFrame frame{requested.frame, kRevision, requested.views, {}};
  std::mt19937 random(seed + requested.frame.value);
  for (const Side side : kSides) {
    const Extent size = requested.views[index_of(side)].size;
    EyeMask& mask = frame.masks[index_of(side)] = EyeMask(size, lights);
    for (std::uint32_t plane = 0; plane < mask.layout().planes(); ++plane)
      for (std::uint32_t y = 0; y < size.height; ++y)
        for (std::uint32_t x = 0; x < size.width; ++x)
          mask.set_word(x, y, plane, static_cast<std::uint32_t>(random()) & mask.layout().used_bits(plane));
  }
  return frame;
}

/// A frame's datagrams, each in its own allocation.
std::vector<std::vector<std::byte>> datagrams_of(const ShadowFrame& frame) {
  FramePacker packer;
  return pack(packer, frame, {.frame = frame.frame});
}

const RequestRecord* accept(Assembler& assembler, const std::vector<std::byte>& datagram) {
  const auto message = decode_server(datagram);
  EXPECT_TRUE(message.has_value());
  if (const auto* report = std::get_if<FrameReport>(&*message)) return assembler.accept(*report);
  return assembler.accept(std::get<Slice>(*message));
}

Slice slice_in(const std::vector<std::byte>& datagram) {
  return std::get<Slice>(*decode_server(datagram));
}

struct Prepared {
  explicit Prepared(std::uint32_t lights = 3, std::uint32_t number = 1)
      : frame(noisy_frame(request(number), lights)), datagrams(datagrams_of(frame)) {
    assembler.expect(request(number), {lights}, kRevision);
  }
  ShadowFrame frame;
  std::vector<std::vector<std::byte>> datagrams;
  Assembler assembler;
};

TEST(FramePacker, SendsTheMiddleOfTheViewsFirstAndBothEyesInTurn) {
  ShadowFrame frame{{1}, kFirstLightSet, {}, {}};
  std::mt19937 random(3);
  for (std::size_t eye = 0; eye < kEyes; ++eye) {
    frame.views[eye].size = {256, 256};
    frame.masks[eye] = EyeMask({256, 256}, 3);
    for (std::byte& byte : frame.masks[eye].bytes()) byte = static_cast<std::byte>(random() & 7u);
  }
  FramePacker packer;
  std::vector<std::uint32_t> from_middle;
  std::vector<Side> sides;
  for (const std::vector<std::byte>& message : pack(packer, frame, {.frame = {1}})) {
    const Decoded<ServerMessage> decoded = decode_server(message);
    const auto* const slice = std::get_if<Slice>(&*decoded);
    if (slice == nullptr) continue;
    const std::uint32_t first = slice->first_tile / 16,
                        last = (slice->first_tile + slice->tile_count - 1) / 16;
    from_middle.push_back(8 < first ? first - 8 : 8 > last ? 8 - last : 0);
    sides.push_back(slice->eye);
  }
  ASSERT_GT(from_middle.size(), 8u);
  EXPECT_TRUE(std::ranges::is_sorted(from_middle));
  EXPECT_NE(sides[0], sides[1]);
}

TEST(FramePacker, FillsWhatThePathCarries) {
  const FrameRequest requested = request(1);
  const ShadowFrame frame = noisy_frame(requested, 3);
  GBufferPlanes planes;
  for (const PlaneKind kind : kGBufferKinds)
    for (const Side side : kSides) {
      PixelPlane& plane = planes_of(planes, kind)[index_of(side)] = PixelPlane({200, 120}, 4);
      std::mt19937 random(index_of(side));
      for (std::uint32_t& word : plane.words) word = static_cast<std::uint32_t>(random());
    }
  FramePacker packer;
  std::vector<std::size_t> counts;
  for (const std::size_t most : {kBaseMessage_bytes, kMaxMessage_bytes}) {
    packer.begin(most);
    packer.add(frame);
    packer.add(requested.frame, planes);
    const auto messages = packer.finish({});
    for (const auto& message : messages) EXPECT_LE(message.size(), most);
    counts.push_back(messages.size());
  }
  EXPECT_LT(counts[1], counts[0]);
}

TEST(FramePacker, KeepsDatagramsSmallAndCountsThem) {
  const ShadowFrame frame = noisy_frame(request(1), 3);
  const auto datagrams = datagrams_of(frame);
  ASSERT_GT(datagrams.size(), 10u);
  std::size_t bytes = 0;
  for (std::size_t i = 0; i + 1 < datagrams.size(); ++i) {
    EXPECT_LE(datagrams[i].size(), kBaseMessage_bytes);
    bytes += datagrams[i].size();
  }
  const auto report = std::get<FrameReport>(*decode_server(datagrams.back()));
  EXPECT_EQ(report.slices, datagrams.size() - 1);
  EXPECT_EQ(report.payload_bytes, bytes);
}

TEST(FramePacker, EyesTakeTurns) {
  const auto datagrams = datagrams_of(noisy_frame(request(1), 3));
  for (std::size_t i = 0; i < 8; ++i) EXPECT_EQ(slice_in(datagrams[i]).eye, kSides[i % 2]);
}

TEST(FramePacker, ASmallFrameAfterALargeOneLeavesNothingBehind) {
  FramePacker packer;
  pack(packer, noisy_frame(request(1), 3), {});
  const ShadowFrame small = noisy_frame(request(2, {16, 16}), 3);
  EXPECT_EQ(pack(packer, small, {.frame = {2}}).size(), 3u);
}

class AssemblerOfLights : public testing::TestWithParam<std::uint32_t> {};

TEST_P(AssemblerOfLights, GivesBackEveryMaskInAnyOrder) {
  Prepared made(GetParam());
  std::shuffle(made.datagrams.begin(), made.datagrams.end(), std::mt19937(5));
  for (const auto& datagram : made.datagrams) accept(made.assembler, datagram);
  const RequestRecord* received = made.assembler.find({1});
  ASSERT_NE(received, nullptr);
  EXPECT_TRUE(received->complete());
  EXPECT_TRUE(received->report.has_value());
  EXPECT_EQ(received->masks, made.frame.masks);
  EXPECT_EQ(made.assembler.counters().slices, made.datagrams.size() - 1);
}

INSTANTIATE_TEST_SUITE_P(LightCounts, AssemblerOfLights, testing::Values(1, 8, 9, 16, 17, 32, 33, 40, 256));

TEST(Assembler, LostSliceLeavesItsTilesUnknownAndNothingElse) {
  Prepared made;
  const Slice lost = slice_in(made.datagrams[5]);
  for (std::size_t i = 0; i < made.datagrams.size(); ++i)
    if (i != 5) accept(made.assembler, made.datagrams[i]);
  const RequestRecord& received = *made.assembler.find({1});
  EXPECT_FALSE(received.complete());
  EXPECT_TRUE(received.anything_known());
  for (const Side side : kSides) {
    const std::size_t eye = index_of(side);
    const TileGrid grid{made.frame.masks[eye].size()};
    std::uint32_t known = 0;
    for (std::uint32_t tile = 0; tile < grid.count(); ++tile) {
      const bool missing =
          side == lost.eye && tile >= lost.first_tile && tile < lost.first_tile + lost.tile_count;
      EXPECT_EQ(received.received_tiles[eye][tile], missing ? 0 : 1);
      known += received.received_tiles[eye][tile];
      const TileRect rect = grid.rect(tile);
      for (std::uint32_t y = rect.y0; y < rect.y1; ++y)
        for (std::uint32_t x = rect.x0; x < rect.x1; ++x)
          EXPECT_EQ(received.masks[eye].word(x, y), missing ? 0 : made.frame.masks[eye].word(x, y));
    }
    EXPECT_EQ(received.tiles_known[eye], known);
  }
}

TEST(Assembler, DuplicatesChangeOnlyACounter) {
  Prepared made;
  for (const auto& datagram : made.datagrams) EXPECT_NE(accept(made.assembler, datagram), nullptr);
  const std::size_t slices = made.datagrams.size() - 1;
  for (std::size_t i = 0; i < slices; ++i) EXPECT_EQ(accept(made.assembler, made.datagrams[i]), nullptr);
  EXPECT_EQ(made.assembler.find({1})->masks, made.frame.masks);
  EXPECT_TRUE(made.assembler.find({1})->complete());
  EXPECT_EQ(made.assembler.counters(), (AssemblerCounters{.slices = slices, .duplicates = slices}));
}

TEST(Assembler, SlicesOfSeveralFramesInTurnFindTheirOwn) {
  Assembler assembler;
  std::vector<ShadowFrame> frames;
  std::vector<std::vector<std::vector<std::byte>>> datagrams;
  for (std::uint32_t number = 1; number <= 3; ++number) {
    assembler.expect(request(number), {3}, kRevision);
    frames.push_back(noisy_frame(request(number), 3));
    datagrams.push_back(datagrams_of(frames.back()));
  }
  // The newest frame arrives first. An older one that arrives later is still reported, in its own place.
  for (std::size_t number : {2u, 0u, 1u})
    for (const auto& datagram : datagrams[number]) accept(assembler, datagram);
  for (std::uint32_t number = 1; number <= 3; ++number)
    EXPECT_EQ(assembler.find({number})->masks, frames[number - 1].masks);
  EXPECT_EQ(assembler.newest_known()->request.frame, FrameId{3});
}

TEST(Assembler, NewestKnownIsTheNewestThatKnowsAnything) {
  Prepared made(3, 7);
  EXPECT_EQ(made.assembler.newest_known(), nullptr);
  accept(made.assembler, made.datagrams[0]);
  made.assembler.expect(request(8), {3}, kRevision);
  ASSERT_NE(made.assembler.newest_known(), nullptr);
  EXPECT_EQ(made.assembler.newest_known()->request.frame, FrameId{7});
}

TEST(Assembler, IgnoresSliceOfFrameNeverAskedFor) {
  Prepared made;
  for (const auto& datagram : datagrams_of(noisy_frame(request(2), 3)))
    EXPECT_EQ(accept(made.assembler, datagram), nullptr);
  EXPECT_FALSE(made.assembler.find({1})->anything_known());
  EXPECT_EQ(made.assembler.find({2}), nullptr);
  EXPECT_EQ(made.assembler.counters().slices, 0u);
  EXPECT_GT(made.assembler.counters().unexpected, 0u);
}

/// The smallest possible assembler.
constexpr std::size_t kFew = Assembler::kKept + 1;

TEST(Assembler, IgnoresSliceOfFrameThatIsForgotten) {
  Assembler assembler(kFew);
  for (std::uint32_t number = 1; number <= kFew + 1; ++number)
    assembler.expect(request(number), {3}, kRevision);
  EXPECT_EQ(assembler.find({1}), nullptr);
  EXPECT_NE(assembler.find({2}), nullptr);
  EXPECT_EQ(accept(assembler, datagrams_of(noisy_frame(request(1), 3))[0]), nullptr);
  EXPECT_EQ(assembler.counters(), AssemblerCounters{.unexpected = 1});
}

TEST(Assembler, KeepsTheLastMasksThroughAnySilence) {
  Assembler assembler(kFew + 3);
  std::uint32_t number = 1;
  for (; number <= 6; ++number) {
    assembler.expect(request(number), {3}, kRevision);
    accept(assembler, datagrams_of(noisy_frame(request(number), 3))[0]);
  }
  for (; number <= 1000; ++number) assembler.expect(request(number), {3}, kRevision);
  EXPECT_EQ(assembler.find({2}), nullptr);
  for (const std::uint32_t kept : {3u, 4u, 5u, 6u, 997u, 1000u})
    EXPECT_NE(assembler.find({kept}), nullptr) << kept;
  EXPECT_EQ(assembler.newest_known()->request.frame, FrameId{6});
}

TEST(Assembler, AReusedSlotRemembersNothing) {
  Assembler assembler(kFew);
  std::uint32_t number = 1;
  for (; number <= kFew; ++number) {
    assembler.expect(request(number), {3}, kRevision);
    for (const auto& datagram : datagrams_of(noisy_frame(request(number), 3))) accept(assembler, datagram);
    ASSERT_TRUE(assembler.find({number})->complete());
  }
  assembler.expect(request(number), {3}, kRevision);
  EXPECT_EQ(assembler.find({1}), nullptr);
  const RequestRecord& received = *assembler.find({number});
  EXPECT_FALSE(received.anything_known());
  EXPECT_FALSE(received.report.has_value());
  EXPECT_TRUE(std::ranges::all_of(received.masks[0].bytes(), [](std::byte b) { return b == std::byte{0}; }));
}

TEST(Assembler, SizesMayChangeFromFrameToFrame) {
  Assembler assembler(kFew);
  for (std::uint32_t number = 1; number <= 2 * kFew; ++number) {
    const FrameRequest requested = request(number, {number * 40, 90 / number});
    assembler.expect(requested, {3}, kRevision);
    const ShadowFrame frame = noisy_frame(requested, 3);
    for (const auto& datagram : datagrams_of(frame)) accept(assembler, datagram);
    EXPECT_EQ(assembler.find({number})->masks, frame.masks);
    EXPECT_TRUE(assembler.find({number})->complete());
  }
}

TEST(Assembler, FrameOrderSurvivesWraparound) {
  Assembler assembler(kFew);
  for (const std::uint32_t number : {0xfffffffcu, 0xfffffffdu, 0xfffffffeu, 0xffffffffu, 0u, 1u})
    assembler.expect(request(number), {3}, kRevision);
  EXPECT_EQ(assembler.find({0xfffffffc}), nullptr);
  for (const std::uint32_t number : {0xffffffffu, 1u, 0u})
    for (const auto& datagram : datagrams_of(noisy_frame(request(number), 3))) accept(assembler, datagram);
  EXPECT_EQ(assembler.newest_known()->request.frame, FrameId{1});
}

TEST(Assembler, RefusesSlicesThatDoNotFit) {
  Prepared made;
  const Slice good = slice_in(made.datagrams[0]);
  Slice revision = good, lights = good, size = good, block = good, no_block = good;
  revision.light_set_revision.value += 1;
  lights.lights += 1;
  size.size.width -= 1;
  block.block = block.block.first(block.block.size() / 2);
  no_block.block = {};
  for (const Slice& bad : {revision, lights, size, block, no_block})
    EXPECT_EQ(made.assembler.accept(bad), nullptr);
  EXPECT_FALSE(made.assembler.find({1})->anything_known());
  EXPECT_TRUE(std::ranges::all_of(made.assembler.find({1})->masks[0].bytes(),
                                  [](std::byte b) { return b == std::byte{0}; }));
  const AssemblerCounters& counters = made.assembler.counters();
  EXPECT_EQ(counters.other_light_set, 1u);
  EXPECT_EQ(counters.refused[WireRefusal::OtherMask], 2u);
  EXPECT_EQ(counters.refused.total(), 4u);
}

TEST(Assembler, IsCompleteWithTheRequestedTiles) {
  FrameRequest requested = request(1);
  const std::size_t tiles = TileGrid{requested.views[0].size}.count();
  for (std::vector<RequestedTile>& eye : requested.requested.tiles) eye.assign(tiles, {});
  requested.requested.tiles[0][3] = requested.requested.tiles[0][40] = {{0x0660, 0x0060}};
  const ShadowFrame frame = noisy_frame(requested, 40);
  FramePacker packer;
  packer.begin();
  packer.add(frame, requested.requested);
  Assembler assembler;
  assembler.expect(requested, {40}, kRevision);
  EXPECT_TRUE(assembler.find({1})->complete(Side::Right));
  EXPECT_FALSE(assembler.find({1})->complete(Side::Left));
  for (const auto& datagram : packer.finish({.frame = {1}})) accept(assembler, datagram);
  const RequestRecord& record = *assembler.find({1});
  EXPECT_TRUE(record.complete());
  EXPECT_EQ(record.tiles_known[0], 4u);
  EXPECT_EQ(record.received_tiles[0][3], 3);
  EXPECT_EQ(record.received_tiles[0][4], 0);
  for (std::uint32_t plane = 0; plane < 2; ++plane) {
    const std::uint32_t first_two_shares = frame.masks[0].word(48 + 4, 4, plane) & 0x03030303;
    EXPECT_EQ(record.masks[0].word(48 + 4, 4, plane), first_two_shares);
  }
  EXPECT_EQ(record.masks[0].word(48, 0), 0u);
  EXPECT_EQ(record.masks[0].word(48 + 4, 8), frame.masks[0].word(48 + 4, 8) & 0x01010101);
}

TEST(Assembler, SurvivesEveryFlippedBitOfASlice) {
  Prepared made;
  const std::vector<std::byte>& good = made.datagrams[0];
  for (std::size_t bit = 0; bit < good.size() * 8; ++bit) {
    std::vector<std::byte> bad = good;
    bad[bit / 8] ^= static_cast<std::byte>(1 << bit % 8);
    const auto message = decode_server(bad);
    if (!message) continue;
    Assembler assembler;
    assembler.expect(request(1), {3}, kRevision);
    if (const auto* slice = std::get_if<Slice>(&*message)) assembler.accept(*slice);
    for (const EyeMask& mask : assembler.find({1})->masks) {
      std::vector<std::uint64_t> words(mask.bytes().size() /
                                       8);  // whole words: without optimisation bytes take a minute
      std::memcpy(words.data(), mask.bytes().data(), words.size() * 8);
      std::uint64_t any = 0;
      for (const std::uint64_t word : words) any |= word;
      ASSERT_EQ(any & ~0x0707070707070707u, 0u) << "bit " << bit;
    }
  }
}

}  // namespace
}  // namespace farshade
