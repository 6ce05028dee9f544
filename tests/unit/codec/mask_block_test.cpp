#include "stereo/codec/mask_block.h"

#include <gtest/gtest.h>

#include "tests/unit/messages/samples.h"

namespace farshade {
namespace {

using namespace wire_samples;

constexpr LightSetRevision kRevision{2};  // of frame_of()

/// Masks of the same sizes and lights, all bits 0.
PerEye<EyeMask> blank(const ShadowFrame& frame, std::uint32_t least_word_bytes = 1) {
  PerEye<EyeMask> masks;
  for (std::size_t eye = 0; eye < kEyes; ++eye)
    masks[eye] = EyeMask(frame.masks[eye].size(), {frame.masks[eye].lights(), least_word_bytes});
  return masks;
}

/// Decodes a copy of its own, so that a sanitizer sees its end.
Decoded<void> decode(std::span<const std::byte> bytes, PerEye<EyeMask>& masks) {
  return decode_mask_block(Bytes(bytes.begin(), bytes.end()), kRevision, masks);
}

class MaskBlockRoundTrip : public testing::TestWithParam<std::uint32_t> {};

TEST_P(MaskBlockRoundTrip, GivesBothMasksBack) {
  std::mt19937 random(GetParam());
  for (const Extent size : {Extent{1, 1}, Extent{17, 15}, Extent{83, 50}})
    for (const ShadowFrame& frame :
         {frame_of(EyeMask(size, GetParam()), EyeMask(size, GetParam())),
          frame_of(edge_mask(size, GetParam(), random), noise_mask({20, 18}, GetParam(), random))}) {
      PerEye<EyeMask> masks = blank(frame);
      ASSERT_TRUE(decode(pack_mask_block(frame), masks));
      EXPECT_EQ(masks, frame.masks) << size.width << " x " << size.height;
    }
}

INSTANTIATE_TEST_SUITE_P(Lights, MaskBlockRoundTrip,
                         testing::Values(0u, 1u, 3u, 8u, 9u, 16u, 17u, 32u, 33u, 256u));

/// As with `--plan everything` on one side only.
TEST(MaskBlock, DoesNotDependOnTheWordsInMemory) {
  std::mt19937 random(1);
  ShadowFrame frame = frame_of(noise_mask({33, 20}, 3, random), noise_mask({33, 20}, 3, random));
  const Bytes bytes = pack_mask_block(frame);
  PerEye<EyeMask> wide = blank(frame, 4);
  ASSERT_TRUE(decode(bytes, wide));
  for (std::size_t eye = 0; eye < kEyes; ++eye)
    for (std::uint32_t y = 0; y < 20; ++y)
      for (std::uint32_t x = 0; x < 33; ++x)
        ASSERT_EQ(wide[eye].word(x, y), frame.masks[eye].word(x, y)) << x << ' ' << y;
  frame.masks = wide;
  EXPECT_EQ(pack_mask_block(frame), bytes);
}

TEST(MaskBlock, RefusesEveryTruncation) {
  const ShadowFrame frame = small_frame();
  const Bytes bytes = pack_mask_block(frame);
  const PerEye<EyeMask> before = blank(frame);
  PerEye<EyeMask> masks = before;
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    const Decoded<void> decoded =
        decode_mask_block(Bytes(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size)),
                          frame.light_set_revision, masks);
    ASSERT_FALSE(decoded) << size;
    EXPECT_EQ(decoded.error(), size < 4 ? WireRefusal::Truncated : WireRefusal::Block) << size;
    EXPECT_EQ(masks, before) << size;
  }
  ASSERT_TRUE(decode_mask_block(bytes, frame.light_set_revision, masks));
  EXPECT_EQ(masks, frame.masks);
}

TEST(MaskBlock, RefusesOtherContent) {
  std::mt19937 random(3);
  const ShadowFrame frame = frame_of(noise_mask({20, 18}, 3, random), noise_mask({20, 18}, 3, random));
  const Bytes bytes = pack_mask_block(frame);
  const auto refusal = [&](const Bytes& received, LightSetRevision expected, Extent size,
                           std::uint32_t lights) {
    PerEye<EyeMask> masks{EyeMask({20, 18}, lights), EyeMask(size, lights)};
    const PerEye<EyeMask> before = masks;
    const Decoded<void> decoded = decode_mask_block(received, expected, masks);
    EXPECT_TRUE(decoded || masks == before) << "a refusal changes nothing";
    return decoded ? std::nullopt : std::optional(decoded.error());
  };
  EXPECT_EQ(refusal(bytes, kRevision, {20, 18}, 3), std::nullopt);
  EXPECT_EQ(refusal(bytes, {3}, {20, 18}, 3), WireRefusal::OtherMask);
  EXPECT_EQ(refusal(bytes, kRevision, {20, 17}, 3), WireRefusal::Block) << "too much content";
  EXPECT_EQ(refusal(bytes, kRevision, {20, 19}, 3), WireRefusal::Block) << "too little";
  EXPECT_EQ(refusal(bytes, kRevision, {20, 18}, 9), WireRefusal::Block) << "more lights";
  EXPECT_EQ(refusal(bytes, kRevision, {20, 18}, 2), WireRefusal::Block) << "fewer";
  Bytes longer = bytes;
  longer.push_back(std::byte{0});
  EXPECT_EQ(refusal(longer, kRevision, {20, 18}, 3), WireRefusal::Block);
}

TEST(MaskBlock, RefusesBitsAfterTheLast) {
  for (const unsigned byte : {1u, 2u, 0x80u}) {
    PerEye<EyeMask> masks{EyeMask({1, 1}, 1), EyeMask({1, 1}, 1)};
    const PerEye<EyeMask> before = masks;
    Bytes bytes = bytes_of({2, 0, 0, 0});
    const Bytes block = literal_block(bytes_of({0, byte}));
    bytes.insert(bytes.end(), block.begin(), block.end());
    const Decoded<void> decoded = decode(bytes, masks);
    EXPECT_EQ(decoded.has_value(), byte == 1) << byte;
    EXPECT_TRUE(decoded || (decoded.error() == WireRefusal::TileBits && masks == before)) << byte;
  }
}

TEST(MaskBlock, IsEmptyIfTheMasksAreTooLargeToSend) {
  std::mt19937 random(5);
  const ShadowFrame frame = frame_of(noise_mask({1024, 1024}, 32, random), EyeMask({1024, 1024}, 32));
  EXPECT_LE(pack_mask_block(frame).size(), kMostMaskBlock_bytes);
  EXPECT_FALSE(pack_mask_block(frame).empty()) << "4 MiB of noise fit";
  EXPECT_TRUE(pack_mask_block(frame_of(frame.masks[0], frame.masks[0])).empty());
}

}  // namespace
}  // namespace farshade
