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

std::size_t content_bytes(const PerEye<EyeMask>& masks) {
  return content_bytes(masks[0]) + content_bytes(masks[1]);
}

void write(const EyeMask& mask, std::vector<std::byte>& content) {
  const std::size_t first = content.size();
  content.resize(first + content_bytes(mask));
  each_bit(mask, [&](std::size_t bit, std::uint32_t x, std::uint32_t y, std::uint32_t light) {
    if (mask.lit(x, y, light)) content[first + bit / 8] |= std::byte{1} << bit % 8;
  });
}

bool is_set(std::span<const std::byte> content, std::size_t bit) {
  return (content[bit / 8] >> bit % 8 & std::byte{1}) != std::byte{0};
}

/// Whether no bit after the last one is set.
bool ends_in_zeros(std::span<const std::byte> content, const EyeMask& mask) {
  for (std::size_t bit = mask.size().pixels() * mask.lights(); bit < 8 * content.size(); ++bit)
    if (is_set(content, bit)) return false;
  return true;
}

/// The mask of the bits that write() wrote, like `mask`.
EyeMask read(std::span<const std::byte> content, const EyeMask& mask) {
  EyeMask result(mask.size(), mask.layout());
  each_bit(result, [&](std::size_t bit, std::uint32_t x, std::uint32_t y, std::uint32_t light) {
    if (is_set(content, bit))
      result.set_word(x, y, light / 32, result.word(x, y, light / 32) | 1u << light % 32);
  });
  return result;
}

}  // namespace

std::vector<std::byte> pack_mask_block(const ShadowFrame& frame) {
  std::vector<std::byte> content, bytes;
  content.reserve(content_bytes(frame.masks));
  for (const EyeMask& mask : frame.masks) write(mask, content);
  ByteWriter(bytes).u32(frame.light_set_revision.value);
  bytes.resize(most_mask_block_bytes(frame.masks));
  const std::size_t packed = pack_block(content, std::span(bytes).subspan(kRevision_bytes));
  bytes.resize(packed == 0 ? 0 : kRevision_bytes + packed);
  return bytes;
}

std::size_t most_mask_block_bytes(const PerEye<EyeMask>& masks) {
  return std::min(kRevision_bytes + most_packed_bytes(content_bytes(masks)), kMostMaskBlock_bytes);
}

Decoded<void> decode_mask_block(std::span<const std::byte> bytes, LightSetRevision expected,
                                PerEye<EyeMask>& masks) {
  ByteReader io(bytes);
  LightSetRevision revision;
  if (!io.u32(revision.value)) return refuse(WireRefusal::Truncated);
  if (revision != expected) return refuse(WireRefusal::OtherMask);
  const std::size_t left_bytes = content_bytes(masks[0]);
  std::vector<std::byte> content(content_bytes(masks));
  if (!open_whole_block(bytes.subspan(kRevision_bytes), content)) return refuse(WireRefusal::Block);
  const std::span left = std::span(content).first(left_bytes), right = std::span(content).subspan(left_bytes);
  if (!ends_in_zeros(left, masks[0]) || !ends_in_zeros(right, masks[1])) return refuse(WireRefusal::TileBits);
  masks = {read(left, masks[0]), read(right, masks[1])};
  return {};
}

}  // namespace farshade
