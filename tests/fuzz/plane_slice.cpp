// Planes: a block is refused and changes nothing, or it fills tiles; packing and decoding them gives the same
// words. The input is seven numbers (form, plane, position in it) and then a block or, so that the fuzzer
// does not need to write LZ4, the tiles that a block decompresses to.
#include <lz4.h>

#include <vector>

#include "stereo/codec/plane_codec.h"
#include "stereo/codec/plane_tile.h"
#include "stereo/frame/tiles.h"
#include "tests/fuzz/target.h"
#include "tests/support/largest_word.h"

using namespace farshade;

namespace {

enum class Form { Block, Tiles };

struct Input {
  PlaneSlice slice;
  Form form = Form::Block;
  std::span<const std::byte> bytes;
};

/// Any slice that decode_client or decode_server accepts, of a plane of up to 72 x 40 pixels.
Input input_from(fuzz::Choices choices) {
  Input input;
  PlaneSlice& slice = input.slice;
  input.form = static_cast<Form>(choices.up_to(1));
  slice.kind = static_cast<PlaneKind>(choices.up_to(static_cast<std::uint32_t>(PlaneKind::PositionZ)));
  slice.word_bytes = choices.up_to(kMaxPlaneWord_bytes - 1) + 1;
  slice.size = {choices.up_to(71) + 1, choices.up_to(39) + 1};
  const std::uint32_t tiles = TileGrid{slice.size}.count();
  slice.first_tile = choices.up_to(tiles - 1);
  slice.tile_count = choices.up_to(tiles - slice.first_tile - 1) + 1;
  input.bytes = choices.rest();
  return input;
}

/// The plane after packing and decoding.
PixelPlane travelled(const PixelPlane& plane, PlaneKind kind) {
  PlanePacker packer;
  packer.start(FrameId{}, Side::Left, kind, plane);
  PixelPlane back(plane.size, plane.word_bytes);
  ReceivedTiles known(TileGrid{plane.size}.count(), 0);
  while (const std::optional<PlaneSlice> slice = packer.next()) {
    check(slice->block.size() <= kMaxPlaneBlock_bytes, "a block fits its datagram");
    const auto learned = decode_plane_tiles(*slice, back, known);
    check(learned && *learned == slice->tile_count, "a slice of our packer teaches all its tiles");
  }
  check(known == ReceivedTiles(known.size(), 1), "all tiles are known");
  return back;
}

/// Whether the slice was accepted.
bool decode(const PlaneSlice& slice) {
  PixelPlane plane(slice.size, slice.word_bytes);
  ReceivedTiles known(TileGrid{slice.size}.count(), 0);
  const PixelPlane blank = plane;
  const ReceivedTiles unknown = known;
  const auto learned = decode_plane_tiles(slice, plane, known);
  if (!learned) {
    check(plane == blank && known == unknown, "a refused slice changes nothing");
    return false;
  }
  check_eq(*learned, slice.tile_count, "tiles learned are those claimed");
  for (const std::uint32_t word : plane.words)
    check(word <= largest_word(slice.word_bytes), "no word is larger than its bytes hold");
  const PixelPlane once = plane;
  check_eq(decode_plane_tiles(slice, plane, known).value(), 0u, "tiles learned from a duplicate");
  check(plane == once, "a duplicate changes nothing");
  check(travelled(plane, slice.kind) == plane, "packing and decoding gives the same plane");
  return true;
}

/// The number of tiles that `bytes` consist of; 0 if they are not a sequence of tiles.
std::uint32_t count_tiles(std::span<const std::byte> bytes, PlaneLanes lanes) {
  ByteReader in(bytes);
  std::uint32_t count = 0;
  for (; in.remaining() > 0; ++count) {
    ByteReader skipped = in;
    TileWords words;
    const bool whole = read_plane_tile(in, lanes, words).has_value();
    check_eq(skip_plane_tile(skipped, lanes).has_value(), whole, "reading and skipping refuse the same");
    if (!whole) return 0;
    check_eq(skipped.remaining(), in.remaining(), "and both end at the same byte");
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
  const std::uint32_t tiles = count_tiles(bytes, lanes_of(slice.kind, slice.word_bytes));
  check_eq(decode(slice), tiles == slice.tile_count,
           "accepted only if it contains exactly the claimed tiles");
  return 0;
}
