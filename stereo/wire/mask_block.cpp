#include "stereo/wire/mask_block.h"

#include <algorithm>
#include <utility>

#include "stereo/wire/bytes.h"
#include "stereo/wire/tile_blocks.h"

namespace farshade {
namespace {

constexpr std::size_t kRevision_bytes = 4;

/// The bytes of a mask's words in the fewest bytes that hold its lights, whatever the layout in memory is.
std::size_t content_bytes(const EyeMask& mask) {
  const MaskLayout layout{mask.lights()};
  return mask.size().pixels() * layout.planes() * layout.word_bytes();
}

/// Calls `visit(x, y, plane)` for each word in the order of the content, as long as it returns true.
bool each_word(const EyeMask& mask, const auto& visit) {
  for (std::uint32_t plane = 0; plane < mask.layout().planes(); ++plane)
    for (std::uint32_t y = 0; y < mask.size().height; ++y)
      for (std::uint32_t x = 0; x < mask.size().width; ++x)
        if (!visit(x, y, plane)) return false;
  return true;
}

void write(const EyeMask& mask, std::vector<std::byte>& content) {
  const std::uint32_t word_bytes = MaskLayout{mask.lights()}.word_bytes();
  each_word(mask, [&](std::uint32_t x, std::uint32_t y, std::uint32_t plane) {
    const std::uint32_t word = mask.word(x, y, plane);
    for (std::uint32_t i = 0; i < word_bytes; ++i)
      content.push_back(static_cast<std::byte>(word >> 8 * i & 0xff));
    return true;
  });
}

/// Reads what write() wrote for such a mask. False if a bit of a light is set that does not exist.
bool read(std::span<const std::byte> content, EyeMask& mask) {
  const MaskLayout layout = mask.layout();
  const std::uint32_t word_bytes = MaskLayout{mask.lights()}.word_bytes();
  return each_word(mask, [&](std::uint32_t x, std::uint32_t y, std::uint32_t plane) {
    std::uint32_t word = 0;
    for (std::uint32_t i = 0; i < word_bytes; ++i) word |= std::to_integer<std::uint32_t>(content[i]) << 8 * i;
    if ((word & ~layout.used_bits(plane)) != 0) return false;
    mask.set_word(x, y, plane, word);
    content = content.subspan(word_bytes);
    return true;
  });
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
  PerEye<EyeMask> read_masks = masks;
  const bool fine = read(std::span(content).first(left_bytes), read_masks[0]) &&
                    read(std::span(content).subspan(left_bytes), read_masks[1]);
  if (!fine) return refuse(WireRefusal::TileBits);
  masks = std::move(read_masks);
  return {};
}

}  // namespace farshade
