// G-buffers and coded pictures are packed and assembled: lost, duplicated, reordered and unrequested
// messages.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>

#include "stereo/answers/assembler.h"
#include "stereo/answers/frame_packer.h"
#include "stereo/codec/mask_block.h"
#include "tests/support/largest_word.h"

namespace farshade {
namespace {

using Datagrams = std::vector<std::vector<std::byte>>;

FrameRequest request(std::uint32_t frame, Answer answer) {
  FrameRequest requested;
  requested.frame = {frame};
  for (View& view : requested.views) view = {{}, {-0.7, 0.8, 0.6, -0.5}, {70, 50}};
  requested.answer.kind = answer;
  return requested;
}

GBufferPlanes noisy_gbuffer(Extent size) {
  GBufferPlanes gbuffer;
  std::mt19937 random(7);
  for (const PlaneKind kind : kGBufferKinds)
    for (PixelPlane& plane : planes_of(gbuffer, kind)) {
      plane = PixelPlane(size, kind == PlaneKind::BaseColor ? 3 : 4);
      for (std::uint32_t& word : plane.words)
        word = static_cast<std::uint32_t>(random()) & largest_word(plane.word_bytes);
    }
  return gbuffer;
}

std::vector<std::byte> noise(std::size_t bytes) {
  std::mt19937 random(9);
  std::vector<std::byte> made(bytes);
  for (std::byte& byte : made) byte = static_cast<std::byte>(random());
  return made;
}

Datagrams finished(FramePacker& packer, std::uint32_t frame) {
  return packer.finish({.frame = {frame}});
}

Datagrams video_datagrams(std::uint32_t frame, std::uint32_t after, std::span<const std::byte> unit) {
  FramePacker packer;
  packer.begin();
  packer.add(FrameId{frame}, FrameId{after}, video_parts(unit));
  return finished(packer, frame);
}

void deliver(Assembler& assembler, const std::vector<std::byte>& datagram) {
  const auto message = decode_server(datagram);
  ASSERT_TRUE(message.has_value());
  if (const auto* slice = std::get_if<Slice>(&*message)) assembler.accept(*slice);
  if (const auto* plane = std::get_if<PlaneSlice>(&*message)) assembler.accept(*plane);
  if (const auto* part = std::get_if<VideoPart>(&*message)) assembler.accept(*part);
  if (const auto* report = std::get_if<FrameReport>(&*message)) assembler.accept(*report);
}

TEST(PictureAssembly, GivesBackAGBufferWithItsMasksInAnyOrder) {
  const FrameRequest requested = request(1, Answer::GBuffer);
  const GBufferPlanes gbuffer = noisy_gbuffer(requested.views[0].size);
  ShadowFrame frame{requested.frame, kFirstLightSet, requested.views, {}};
  for (EyeMask& mask : frame.masks) mask = EyeMask(requested.views[0].size, 3);
  FramePacker packer;
  packer.begin();
  packer.add(frame);
  packer.add(requested.frame, gbuffer);
  Datagrams datagrams = finished(packer, 1);
  std::ranges::shuffle(datagrams, std::mt19937(3));

  Assembler assembler;
  assembler.expect(requested, {3}, kFirstLightSet);
  for (const auto& datagram : datagrams) {
    EXPECT_FALSE(assembler.find({1})->complete() && assembler.find({1})->report);
    deliver(assembler, datagram);
    deliver(assembler, datagram);  // doubled
  }
  const RequestRecord& received = *assembler.find({1});
  EXPECT_TRUE(received.complete());
  EXPECT_EQ(received.gbuffer.planes, gbuffer);
  EXPECT_EQ(received.masks, frame.masks);
  EXPECT_EQ(assembler.counters().duplicates, datagrams.size() - 1);
  EXPECT_EQ(assembler.counters().refused.total(), 0u);
}

TEST(PictureAssembly, ALostPlaneSliceLeavesItsTilesUnknown) {
  const FrameRequest requested = request(1, Answer::GBuffer);
  FramePacker packer;
  packer.begin();
  packer.add(requested.frame, noisy_gbuffer(requested.views[0].size));
  const Datagrams datagrams = finished(packer, 1);
  Assembler assembler;
  assembler.expect(requested, {3}, kFirstLightSet);
  for (std::size_t i = 1; i < datagrams.size(); ++i) deliver(assembler, datagrams[i]);
  const RequestRecord& received = *assembler.find({1});
  EXPECT_FALSE(received.complete());
  EXPECT_LT(received.gbuffer.tiles_known, received.gbuffer.tiles);
  EXPECT_EQ(received.gbuffer.received_tiles[0][0][0], 0) << "the first tile of the left eye's colours";
  EXPECT_EQ(received.gbuffer.planes.base_color[0].words[0], 0u);
}

TEST(PictureAssembly, GivesBackACodedPictureOfAnySizeInAnyOrder) {
  for (const std::size_t bytes : {std::size_t{1}, kVideoPart_bytes - 1, kVideoPart_bytes,
                                  kVideoPart_bytes + 1, 5 * kVideoPart_bytes + 77}) {
    const std::vector<std::byte> unit = noise(bytes);
    Datagrams datagrams = video_datagrams(8, 7, unit);
    std::ranges::reverse(datagrams);
    Assembler assembler;
    assembler.expect(request(8, Answer::Video), {3}, kFirstLightSet);
    for (const auto& datagram : datagrams) deliver(assembler, datagram);
    const RequestRecord& received = *assembler.find({8});
    EXPECT_TRUE(received.complete()) << bytes;
    EXPECT_EQ(received.video.unit, unit);
    EXPECT_EQ(received.video.after, FrameId{7});
    EXPECT_EQ(received.masks[0].size(), Extent{}) << "no masks were requested";
  }
}

/// A unit of NAL units with these lengths, each a start code and its number.
std::vector<std::byte> nal_units(std::initializer_list<std::size_t> lengths) {
  std::vector<std::byte> unit;
  std::uint8_t number = 1;
  for (const std::size_t length : lengths) {
    unit.insert(unit.end(), {std::byte{0}, std::byte{0}, std::byte{1}});
    unit.insert(unit.end(), length - 3, static_cast<std::byte>(++number));
  }
  return unit;
}

std::vector<std::size_t> part_sizes(std::span<const std::byte> unit) {
  std::vector<std::size_t> sizes;
  for (const auto& part : video_parts(unit)) sizes.push_back(part.size());
  return sizes;
}

TEST(VideoParts, HoldWholeNalUnits) {
  using Sizes = std::vector<std::size_t>;
  EXPECT_EQ(part_sizes({}), Sizes{});
  EXPECT_EQ(part_sizes(nal_units({10, 20})), Sizes{30}) << "as many as fit";
  EXPECT_EQ(part_sizes(nal_units({1000, 140, 10, 900})), (Sizes{1140, 910}));
  EXPECT_EQ(part_sizes(nal_units({kVideoPart_bytes, 10})), (Sizes{kVideoPart_bytes, 10})) << "exactly full";
  EXPECT_EQ(part_sizes(nal_units({kVideoPart_bytes - 1, 10})), (Sizes{kVideoPart_bytes - 1, 10}));
  EXPECT_EQ(part_sizes(nal_units({kVideoPart_bytes + 1, 10})), (Sizes{kVideoPart_bytes, 11}))
      << "one that fits into no part is cut";
  EXPECT_EQ(part_sizes(nal_units({10, 3000, 20})),
            (Sizes{10, kVideoPart_bytes, kVideoPart_bytes, 3020 - 2 * kVideoPart_bytes}));
}

TEST(PictureAssembly, ZerosFillUpAPartAndReplaceALostOne) {
  const std::vector<std::byte> unit = nal_units({700, 800, 900, 50});
  const Datagrams datagrams = video_datagrams(8, 8, unit);
  ASSERT_EQ(datagrams.size(), 4u) << "three parts and the report";
  Assembler assembler(Assembler::kKept + 1);
  const auto received = [&](std::uint32_t lost) {
    static std::uint32_t frame = 8;
    ++frame;
    assembler.expect(request(frame, Answer::Difference), {3}, kFirstLightSet);
    const Datagrams sent = video_datagrams(frame, frame, unit);
    for (std::size_t i = 0; i < sent.size(); ++i)
      if (i != lost) deliver(assembler, sent[i]);
    return *assembler.find({frame});
  };
  const auto with = [&](std::initializer_list<std::size_t> nals) {
    std::vector<std::byte> expected(2 * kVideoPart_bytes + 950);
    std::size_t at = 0;
    for (const std::size_t part : {0u, 1u, 2u}) {
      const std::size_t bytes = std::array{700u, 800u, 950u}.at(part);
      if (std::ranges::count(nals, part) > 0)
        std::copy_n(unit.begin() + static_cast<std::ptrdiff_t>(at), bytes,
                    expected.begin() + static_cast<std::ptrdiff_t>(part * kVideoPart_bytes));
      at += bytes;
    }
    return expected;
  };
  EXPECT_TRUE(received(99).complete());
  EXPECT_EQ(received(99).video.unit, with({0, 1, 2}));
  for (int round = 0; round < 8; ++round) {  // slots are used again
    const RequestRecord lacking = received(1);
    EXPECT_TRUE(lacking.anything_known());
    EXPECT_FALSE(lacking.complete());
    EXPECT_EQ(lacking.video.unit, with({0, 2}));
  }
  const RequestRecord without_end = received(2);
  EXPECT_EQ(without_end.video.unit.size(), 3 * kVideoPart_bytes)
      << "the length of the last part is not known";
}

TEST(PictureAssembly, RefusesUnrequestedPieces) {
  Assembler assembler;
  assembler.expect(request(1, Answer::Masks), {3}, kFirstLightSet);
  for (const auto& datagram : video_datagrams(1, 1, noise(10))) deliver(assembler, datagram);
  FramePacker packer;
  packer.begin();
  packer.add(FrameId{1}, noisy_gbuffer({70, 50}));
  const Datagrams planes = finished(packer, 1);
  for (const auto& datagram : planes) deliver(assembler, datagram);
  EXPECT_FALSE(assembler.find({1})->anything_known());
  EXPECT_EQ(assembler.counters().refused[WireRefusal::AnswerSpec], planes.size());
}

TEST(PictureAssembly, RefusesPositionsInAGBuffer) {
  const FrameRequest requested = request(1, Answer::GBuffer);
  PixelPlane plane(requested.views[0].size, 4);
  PlanePacker packer;
  for (const PlaneKind kind : {PlaneKind::PositionX, PlaneKind::PositionZ}) {
    Assembler assembler;
    assembler.expect(requested, {3}, kFirstLightSet);
    packer.start({1}, Side::Left, kind, plane);
    EXPECT_EQ(assembler.accept(*packer.next()), nullptr);
    EXPECT_EQ(assembler.counters().refused[WireRefusal::AnswerSpec], 1u);
  }
}

TEST(PictureAssembly, RefusesAPartOfAnotherCut) {
  Assembler assembler;
  assembler.expect(request(8, Answer::Video), {3}, kFirstLightSet);
  deliver(assembler, video_datagrams(8, 7, noise(2 * kVideoPart_bytes))[0]);
  deliver(assembler, video_datagrams(8, 7, noise(3 * kVideoPart_bytes))[1]);
  deliver(assembler, video_datagrams(8, 8, noise(2 * kVideoPart_bytes))[1]);
  EXPECT_EQ(assembler.counters().refused[WireRefusal::Part], 2u);
  EXPECT_EQ(assembler.find({8})->video.parts_known, 1u);
}

FrameRequest block_request(std::uint32_t frame) {
  FrameRequest requested = request(frame, Answer::Masks);
  requested.answer.coding = Coding::Lz4;
  return requested;
}

/// Noise, so that the block has several parts.
ShadowFrame noisy_masks(const FrameRequest& requested) {
  ShadowFrame frame{requested.frame, kFirstLightSet, requested.views, {}};
  std::mt19937 random(5);
  for (std::size_t eye = 0; eye < kEyes; ++eye) {
    frame.masks[eye] = EyeMask(requested.views[eye].size, 40);
    for (std::uint32_t plane = 0; plane < 2; ++plane)
      for (std::uint32_t i = 0; i < frame.masks[eye].size().pixels(); ++i)
        frame.masks[eye].set_word(
            i % 70, i / 70, plane,
            static_cast<std::uint32_t>(random()) & frame.masks[eye].layout().used_bits(plane));
  }
  return frame;
}

Datagrams block_datagrams(const ShadowFrame& frame) {
  const std::vector<std::byte> block = pack_mask_block(frame);
  FramePacker packer;
  packer.begin();
  packer.add(frame.frame, frame.frame, full_parts(block));
  return finished(packer, frame.frame.value);
}

TEST(MaskBlockParts, AreFull) {
  const std::vector<std::byte> bytes = nal_units({700, 800, 900});
  const VideoUnitParts parts = full_parts(bytes);
  ASSERT_EQ(parts.size(), 3u);
  EXPECT_EQ(parts[0].size(), kVideoPart_bytes) << "whatever looks like the start of a NAL unit";
  EXPECT_EQ(parts[1].size(), kVideoPart_bytes);
  EXPECT_EQ(parts[2].size(), 2400 - 2 * kVideoPart_bytes);
  EXPECT_TRUE(full_parts({}).empty());
}

TEST(MaskBlockAssembly, GivesBackTheMasksInAnyOrder) {
  const FrameRequest requested = block_request(1);
  const ShadowFrame frame = noisy_masks(requested);
  Datagrams datagrams = block_datagrams(frame);
  ASSERT_GT(datagrams.size(), 10u);
  std::ranges::shuffle(datagrams, std::mt19937(3));
  Assembler assembler;
  assembler.expect(requested, {40}, kFirstLightSet);
  for (const auto& datagram : datagrams) {
    EXPECT_FALSE(assembler.find({1})->complete() && assembler.find({1})->report);
    deliver(assembler, datagram);
    deliver(assembler, datagram);  // doubled
  }
  const RequestRecord& received = *assembler.find({1});
  EXPECT_TRUE(received.complete());
  EXPECT_EQ(received.masks, frame.masks);
  for (const ReceivedTiles& known : received.received_tiles)
    EXPECT_EQ(std::ranges::count(known, 3), static_cast<std::ptrdiff_t>(known.size())) << "both planes";
  EXPECT_EQ(assembler.counters().duplicates, datagrams.size() - 1);
  EXPECT_EQ(assembler.counters().refused.total(), 0u);
}

TEST(MaskBlockAssembly, NothingIsKnownBeforeAllPartsHaveCome) {
  const FrameRequest requested = block_request(1);
  const Datagrams datagrams = block_datagrams(noisy_masks(requested));
  Assembler assembler;
  assembler.expect(requested, {40}, kFirstLightSet);
  for (std::size_t i = 0; i < datagrams.size(); ++i)
    if (i != 3) deliver(assembler, datagrams[i]);
  const RequestRecord& received = *assembler.find({1});
  EXPECT_FALSE(received.anything_known());
  EXPECT_EQ(received.pieces_known(), datagrams.size() - 2) << "but the client sees that more comes";
  EXPECT_EQ(received.tiles_known, PerEye<std::uint32_t>{});
  EXPECT_EQ(assembler.newest_known(), nullptr);
  deliver(assembler, datagrams[3]);
  EXPECT_TRUE(received.complete() && received.anything_known());
}

TEST(MaskBlockAssembly, RefusesWhatWasNotAskedFor) {
  const FrameRequest requested = block_request(1);
  const ShadowFrame frame = noisy_masks(requested);
  const auto refused = [&](const Datagrams& datagrams) {
    Assembler assembler;
    assembler.expect(requested, {40}, kFirstLightSet);
    for (const auto& datagram : datagrams) deliver(assembler, datagram);
    EXPECT_FALSE(assembler.find({1})->anything_known());
    EXPECT_EQ(assembler.find({1})->masks[0], EyeMask({70, 50}, 40)) << "no bit is set";
    return assembler.counters().refused;
  };
  ShadowFrame other_lights = frame, smaller = frame;
  other_lights.light_set_revision = {9};
  smaller.masks[1] = EyeMask({70, 49}, 40);
  EXPECT_EQ(refused(block_datagrams(other_lights))[WireRefusal::OtherMask], 1u);
  EXPECT_EQ(refused(block_datagrams(smaller))[WireRefusal::Block], 1u);
  EXPECT_EQ(refused(video_datagrams(1, 1, noise(3)))[WireRefusal::Truncated], 1u);
  FramePacker packer;
  packer.begin();
  packer.add(frame);
  const Datagrams slices = finished(packer, 1);
  EXPECT_EQ(refused(slices)[WireRefusal::AnswerSpec], slices.size() - 1);
}

TEST(MaskBlockAssembly, ARefusedBlockIsOpenedOnce) {
  const FrameRequest requested = block_request(1);
  ShadowFrame other_lights = noisy_masks(requested);
  other_lights.light_set_revision = {9};
  const Datagrams datagrams = block_datagrams(other_lights);
  Assembler assembler;
  assembler.expect(requested, {40}, kFirstLightSet);
  for (const auto& datagram : datagrams) deliver(assembler, datagram);
  deliver(assembler, datagrams[datagrams.size() - 2]);  // the last part; the report comes after it
  EXPECT_EQ(assembler.counters().refused.total(), 1u);
  EXPECT_EQ(assembler.counters().duplicates, 1u);
}

TEST(MaskBlockAssembly, RefusesMorePartsThanItsMasksCanHave) {
  const FrameRequest requested = block_request(1);
  const std::size_t most = most_mask_block_bytes(noisy_masks(requested).masks);
  Assembler assembler;
  assembler.expect(requested, {40}, kFirstLightSet);
  const auto with_bytes = [](std::size_t bytes) {
    FramePacker packer;
    packer.begin();
    packer.add({1}, {1}, full_parts(noise(bytes)));
    return finished(packer, 1)[0];
  };
  deliver(assembler, with_bytes(most + kVideoPart_bytes));
  EXPECT_EQ(assembler.counters().refused[WireRefusal::Part], 1u);
  deliver(assembler, with_bytes(most));
  EXPECT_EQ(assembler.counters().refused.total(), 1u);
  EXPECT_EQ(assembler.find({1})->pieces_known(), 1u);
}

TEST(MaskBlockAssembly, PartsOfABlockDoNotReplaceWholeMasks) {
  Assembler assembler(Assembler::kKept + 1);
  const FrameRequest whole = block_request(1);
  assembler.expect(whole, {40}, kFirstLightSet);
  for (const auto& datagram : block_datagrams(noisy_masks(whole))) deliver(assembler, datagram);
  for (std::uint32_t frame = 2; frame <= 20; ++frame) {
    assembler.expect(block_request(frame), {40}, kFirstLightSet);
    deliver(assembler, block_datagrams(noisy_masks(block_request(frame)))[0]);
  }
  ASSERT_NE(assembler.newest_known(), nullptr);
  EXPECT_EQ(assembler.newest_known()->request.frame, FrameId{1});
}

TEST(PictureAssembly, AReusedSlotRemembersNoPicture) {
  Assembler assembler(Assembler::kKept + 1);
  for (std::uint32_t frame = 1; frame <= 20; ++frame) {
    assembler.expect(request(frame, frame % 2 == 0 ? Answer::Video : Answer::GBuffer), {3}, kFirstLightSet);
    EXPECT_FALSE(assembler.find({frame})->anything_known()) << frame;
    EXPECT_FALSE(assembler.find({frame})->complete()) << frame;
    if (frame % 2 == 0) deliver(assembler, video_datagrams(frame, frame, noise(40))[0]);
  }
}

}  // namespace
}  // namespace farshade
