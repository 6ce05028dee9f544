// Slices and tiles: a block is refused and changes nothing, or it fills tiles; packing and decoding them
// gives the same mask. The input is six numbers (mask, position in it, form) and then a block or, so that the
// fuzzer does not need to write LZ4, the tiles that a block decompresses to.
#include <lz4.h>

#include <algorithm>
#include <vector>

#include "stereo/wire/slice.h"
#include "stereo/wire/tile_codec.h"
#include "tests/fuzz/target.h"

using namespace farshade;

namespace {

enum class Form { Block, Tiles };

struct Input {
  Slice slice;
  Form form = Form::Block;
  std::span<const std::byte> bytes;
};

/// Any slice that decode_server accepts, of a mask of up to 72 x 40 pixels.
Input input_from(fuzz::Choices choices) {
  Input input;
  Slice& slice = input.slice;
  input.form = static_cast<Form>(choices.up_to(1));
  slice.lights = choices.up_to(kMaxLights);
  slice.size = {choices.up_to(71) + 1, choices.up_to(39) + 1};
  slice.plane = choices.up_to(MaskLayout{slice.lights}.planes() - 1);
  const std::uint32_t tiles = TileGrid{slice.size}.count();
  slice.first_tile = choices.up_to(tiles - 1);
  slice.tile_count = choices.up_to(tiles - slice.first_tile - 1) + 1;
  input.bytes = choices.rest();
  return input;
}

/// The mask after packing and decoding into a mask with other content.
EyeMask travelled(const EyeMask& mask) {
  ShadowFrame frame;
  frame.masks[index_of(Side::Left)] = mask;
  SlicePacker packer;
  packer.start(frame, Side::Left);
  EyeMask back(mask.size(), mask.lights());
  KnownTiles known(TileGrid{mask.size()}.count(), 0);
  while (const std::optional<Slice> slice = packer.next()) {
    check(slice->block.size() <= kMaxBlock_bytes, "a block fits its datagram");
    const auto learned = decode_slice_tiles(*slice, back, known);
    check(learned && *learned == slice->tile_count, "a slice of our packer teaches all its tiles");
  }
  check(is_whole(known, mask.layout()), "all tiles are known");
  return back;
}

void check_no_bits_without_light(const EyeMask& mask) {
  for (std::uint32_t plane = 0; plane < mask.layout().planes(); ++plane)
    for (std::uint32_t y = 0; y < mask.size().height; ++y)
      for (std::uint32_t x = 0; x < mask.size().width; ++x)
        check((mask.word(x, y, plane) & ~mask.layout().used_bits(plane)) == 0,
              "no bit is set without a light");
}

/// Whether the slice was accepted.
bool decode(const Slice& slice) {
  EyeMask mask(slice.size, slice.lights);
  KnownTiles known(TileGrid{slice.size}.count(), 0);
  const EyeMask blank = mask;
  const KnownTiles unknown = known;
  const auto learned = decode_slice_tiles(slice, mask, known);
  if (!learned) {
    check(mask == blank && known == unknown, "a refused slice changes nothing");
    return false;
  }
  check(*learned <= slice.tile_count, "no more tiles than claimed");
  check_no_bits_without_light(mask);
  const EyeMask once = mask;
  check_eq(decode_slice_tiles(slice, mask, known).value(), 0u, "tiles learned from a duplicate");
  check(mask == once, "a duplicate changes nothing");
  check(travelled(mask) == mask, "packing and decoding gives the same mask");
  return true;
}

void check_comes_back(const TileBits& bits, std::uint32_t lights) {
  std::vector<std::byte> written;
  write_tile(bits, lights, written);
  check(written.size() <= kMaxTile_bytes, "no tile is longer than stated");
  ByteReader in(written);
  TileBits again;
  check(read_tile(in, lights, again).has_value() && in.remaining() == 0, "a written tile is read");
  check(again.varies == bits.varies && again.value == bits.value, "the lights are the same");
  for (std::uint32_t light = 0; light < 32; ++light)
    check((bits.varies >> light & 1) == 0 || again.rows[light] == bits.rows[light], "the rows are the same");
}

/// The number of tiles that `bytes` consist of; 0 if they are not a sequence of tiles. Checks that writing
/// and reading each tile gives the same tile.
std::uint32_t count_tiles(std::span<const std::byte> bytes, std::uint32_t lights) {
  ByteReader in(bytes);
  TileBits bits;
  std::uint32_t count = 0;
  for (; in.remaining() > 0; ++count) {
    const auto coding = read_tile(in, lights, bits);
    if (!coding) return 0;
    if (*coding != TileCoding::NotSent) check_comes_back(bits, lights);
  }
  return count;
}

/// An LZ4 block of `bytes` in an allocation of exactly its size.
std::vector<char> compressed(std::span<const std::byte> bytes) {
  const int size = static_cast<int>(bytes.size());
  std::vector<char> block(static_cast<std::size_t>(LZ4_compressBound(size)));
  const int filled = LZ4_compress_default(reinterpret_cast<const char*>(bytes.data()), block.data(), size,
                                          static_cast<int>(block.size()));
  return {block.begin(), block.begin() + filled};
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  auto [slice, form, bytes] = input_from({data, size});
  slice.block = bytes;
  if (form == Form::Block || bytes.size() > kMaxOpened_bytes) return decode(slice), 0;
  const std::vector<char> block = compressed(bytes);
  slice.block = std::as_bytes(std::span(block));
  const std::uint32_t tiles = count_tiles(bytes, MaskLayout{slice.lights}.lights_in(slice.plane));
  check_eq(decode(slice), tiles == slice.tile_count,
           "accepted only if it contains exactly the claimed tiles");
  return 0;
}
