// Slices and tiles: a block is refused and changes nothing, or fills tiles that, packed again, decode to the
// same mask. An input is six choices - mask, place in it, form - and then a block or, so that the fuzzer need
// not write LZ4, the tiles that a block opens to.
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

/// Any slice that decode_server lets through, of a mask of up to 72 x 40 pixels.
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

/// What `packer` makes of both, decoded into masks that held something else.
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
    check(learned && *learned == slice->tile_count, "our own slices are whole and new");
  }
  check(is_whole(known, mask.layout()), "all tiles came");
  return back;
}

void decode(const Slice& slice) {
  EyeMask mask(slice.size, slice.lights);
  KnownTiles known(TileGrid{slice.size}.count(), 0);
  const EyeMask blank = mask;
  const auto learned = decode_slice_tiles(slice, mask, known);
  if (!learned) {
    check(mask == blank &&
              std::count(known.begin(), known.end(), 0) == static_cast<std::ptrdiff_t>(known.size()),
          "a refused slice changes nothing");
    return;
  }
  check(*learned <= slice.tile_count, "no more tiles than claimed");
  const EyeMask once = mask;
  check_eq(decode_slice_tiles(slice, mask, known).value(), 0u, "tiles learned from a duplicate");
  check(mask == once, "a duplicate changes nothing");
  check(travelled(mask) == mask, "packed again, it decodes to the same");
}

/// Tiles one by one: read, written and read again they are the same bits.
void read_tiles(std::span<const std::byte> bytes, std::uint32_t lights) {
  ByteReader in(bytes);
  TileBits bits, again;
  std::vector<std::byte> written;
  while (in.remaining() > 0) {
    const auto coding = read_tile(in, lights, bits);
    if (!coding) return;
    if (*coding == TileCoding::NotSent) continue;
    written.clear();
    write_tile(bits, lights, written);
    check(written.size() <= kMaxTile_bytes, "no tile is longer than stated");
    ByteReader back(written);
    check(read_tile(back, lights, again).has_value() && back.remaining() == 0, "a written tile is read");
    check(again.varies == bits.varies && again.value == bits.value, "lights come back");
    for (std::uint32_t light = 0; light < 32; ++light)
      check((bits.varies >> light & 1) == 0 || again.rows[light] == bits.rows[light], "rows come back");
  }
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Input input = input_from({data, size});
  std::vector<char> block;
  if (input.form == Form::Tiles) {
    read_tiles(input.bytes, MaskLayout{input.slice.lights}.lights_in(input.slice.plane));
    block.resize(static_cast<std::size_t>(LZ4_compressBound(static_cast<int>(input.bytes.size()))));
    const int filled =
        LZ4_compress_default(reinterpret_cast<const char*>(input.bytes.data()), block.data(),
                             static_cast<int>(input.bytes.size()), static_cast<int>(block.size()));
    // In an allocation of its own length, as a datagram is.
    block = std::vector<char>(block.begin(), block.begin() + filled);
    input.bytes = std::as_bytes(std::span(block));
  }
  input.slice.block = input.bytes;
  decode(input.slice);
  return 0;
}
