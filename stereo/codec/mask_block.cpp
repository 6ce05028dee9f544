#include "stereo/codec/mask_block.h"

#include <algorithm>
#include <utility>

#include "stereo/codec/tile_blocks.h"
#include "stereo/messages/bytes.h"

namespace farshade {
namespace {

constexpr std::size_t kRevision_bytes = 4;

std::size_t content_bytes(const EyeMask& mask) {
  return (mask.size().pixels() * mask.lights() + 7) / 8;
}

/// Calls `visit(bit, x, y, light)` for each bit of the content. Returns the number of bits.
std::size_t each_bit(const EyeMask& mask, const auto& visit) {
  std::size_t bit = 0;
  for (std::uint32_t light = 0; light < mask.lights(); ++light)
    for (std::uint32_t y = 0; y < mask.size().height; ++y)
      for (std::uint32_t x = 0; x < mask.size().width; ++x) visit(bit++, x, y, light);
  return bit;
}

void write(const EyeMask& mask, std::vector<std::byte>& content) {
  const std::size_t first = content.size();
  content.resize(first + content_bytes(mask));
  each_bit(mask, [&](std::size_t bit, std::uint32_t x, std::uint32_t y, std::uint32_t light) {
    if (mask.lit(x, y, light)) content[first + bit / 8] |= std::byte{1} << bit % 8;
  });
}

/// Adds the bits that write() wrote to a mask without any. False if a bit after the last one is set.
bool read(std::span<const std::byte> content, EyeMask& mask) {
  const auto is_set = [&](std::size_t bit) {
    return (content[bit / 8] >> bit % 8 & std::byte{1}) != std::byte{0};
  };
  std::size_t end =
      each_bit(mask, [&](std::size_t bit, std::uint32_t x, std::uint32_t y, std::uint32_t light) {
        if (is_set(bit)) mask.set_word(x, y, light / 32, mask.word(x, y, light / 32) | 1u << light % 32);
      });
  while (end < 8 * content.size())
    if (is_set(end++)) return false;
  return true;
}

}  // namespace

std::vector<std::byte> pack_mask_block(const ShadowFrame& frame) {
  std::vector<std::byte> content, bytes;
  content.reserve(content_bytes(frame.masks[0]) + content_bytes(frame.masks[1]));
  for (const EyeMask& mask : frame.masks) write(mask, content);
  ByteWriter(bytes).u32(frame.light_set_revision.value);
  bytes.resize(std::min(kRevision_bytes + most_packed_bytes(content.size()), kMostMaskBlock_bytes));
  const std::size_t packed = pack_block(content, std::span(bytes).subspan(kRevision_bytes));
  bytes.resize(packed == 0 ? 0 : kRevision_bytes + packed);
  return bytes;
}

Decoded<void> decode_mask_block(std::span<const std::byte> bytes, LightSetRevision expected,
                                PerEye<EyeMask>& masks) {
  ByteReader io(bytes);
  LightSetRevision revision;
  if (!io.u32(revision.value)) return refuse(WireRefusal::Truncated);
  if (revision != expected) return refuse(WireRefusal::OtherMask);
  const std::size_t left_bytes = content_bytes(masks[0]);
  std::vector<std::byte> content(left_bytes + content_bytes(masks[1]));
  if (!open_whole_block(bytes.subspan(kRevision_bytes), content)) return refuse(WireRefusal::Block);
  PerEye<EyeMask> opened{EyeMask(masks[0].size(), masks[0].layout()),
                         EyeMask(masks[1].size(), masks[1].layout())};
  if (!read(std::span(content).first(left_bytes), opened[0]) ||
      !read(std::span(content).subspan(left_bytes), opened[1]))
    return refuse(WireRefusal::TileBits);
  masks = std::move(opened);
  return {};
}

}  // namespace farshade
