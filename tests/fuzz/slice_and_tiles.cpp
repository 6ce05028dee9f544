// Slices of masks and of requested blocks: a block is refused and changes nothing, or it fills tiles; packing
// and decoding them gives the same. The input is seven numbers (kind, mask, position in it), 16-bit words
// with the requested blocks of each share of the tiles, and then the slice's block.
#include <algorithm>
#include <vector>

#include "stereo/codec/ask_coder.h"
#include "stereo/codec/slice.h"
#include "tests/fuzz/target.h"

using namespace farshade;

namespace {

enum class Kind { Whole, SomeBlocks, AskSlice };

struct Input {
  Slice slice;
  Kind kind = Kind::Whole;
  std::vector<RequestedTile> requested;  ///< of SomeBlocks
};

/// Any slice that decode_server accepts, of a mask of up to 72 x 40 pixels.
Input input_from(fuzz::Choices choices) {
  Input input;
  Slice& slice = input.slice;
  input.kind = static_cast<Kind>(choices.up_to(2));
  slice.lights = choices.up_to(kMaxLights);
  slice.size = {choices.up_to(71) + 1, choices.up_to(39) + 1};
  slice.plane = choices.up_to(MaskLayout{slice.lights}.planes() - 1);
  const std::uint32_t tiles = TileGrid{slice.size}.count();
  slice.first_tile = choices.up_to(tiles - 1);
  slice.tile_count = choices.up_to(tiles - slice.first_tile - 1) + 1;
  if (input.kind == Kind::SomeBlocks)
    for (std::uint32_t tile = 0; tile < tiles; ++tile) {
      RequestedTile& requested = input.requested.emplace_back();
      for (std::uint32_t share = 0; share < shares_of(slice.lights); ++share)
        requested.shares[share] = static_cast<BlockBits>(choices.up_to(0xffff));
    }
  slice.block = choices.rest();
  return input;
}

/// The mask after packing and decoding the requested blocks into a mask with other content.
EyeMask travelled(const EyeMask& mask, std::span<const RequestedTile> requested) {
  ShadowFrame frame;
  frame.masks[index_of(Side::Left)] = mask;
  SlicePacker packer;
  packer.start(frame, Side::Left, requested);
  EyeMask back(mask.size(), mask.lights());
  ReceivedTiles known(TileGrid{mask.size()}.count(), 0);
  std::uint32_t learned = 0;
  while (const std::optional<Slice> slice = packer.next()) {
    check(slice->block.size() <= kMaxBlock_bytes, "a block fits its datagram");
    const auto news = decode_slice_tiles(*slice, requested, back, known);
    check(news.has_value(), "a slice of our packer is accepted");
    learned += *news;
  }
  check_eq(learned, RequestedTiles(mask.size(), mask.lights(), requested).count() * mask.layout().planes(),
           "all requested tiles are known");
  return back;
}

void check_no_bits_without_light(const EyeMask& mask) {
  for (std::uint32_t plane = 0; plane < mask.layout().planes(); ++plane)
    for (std::uint32_t y = 0; y < mask.size().height; ++y)
      for (std::uint32_t x = 0; x < mask.size().width; ++x)
        check((mask.word(x, y, plane) & ~mask.layout().used_bits(plane)) == 0,
              "no bit is set without a light");
}

void decode(const Slice& slice, std::span<const RequestedTile> requested) {
  EyeMask mask(slice.size, slice.lights);
  ReceivedTiles known(TileGrid{slice.size}.count(), 0);
  const EyeMask blank = mask;
  const ReceivedTiles unknown = known;
  const auto learned = decode_slice_tiles(slice, requested, mask, known);
  if (!learned) return check(mask == blank && known == unknown, "a refused slice changes nothing");
  check(*learned <= slice.tile_count, "no more tiles than claimed");
  check_no_bits_without_light(mask);
  const EyeMask once = mask;
  check_eq(decode_slice_tiles(slice, requested, mask, known).value(), 0u, "tiles learned from a duplicate");
  check(mask == once, "a duplicate changes nothing");
  check(travelled(mask, requested) == mask, "packing and decoding gives the same mask");
}

void decode(const AskSlice& slice) {
  std::vector<RequestedTile> requested(TileGrid{slice.size}.count());
  ReceivedTiles known(requested.size(), 0);
  const ReceivedTiles unknown = known;
  const auto learned = decode_ask_slice(slice, requested, known);
  if (!learned) {
    check(known == unknown, "a refused slice changes nothing");
    check(std::ranges::count(requested, RequestedTile{}) == static_cast<std::ptrdiff_t>(requested.size()),
          "a refused slice changes nothing");
    return;
  }
  for (const RequestedTile& tile : requested)
    for (std::uint32_t share = shares_of(slice.lights); share < kMostShares; ++share)
      check(tile.shares[share] == kNoBlocks, "only shares that the mask has");
  check_eq(*learned, slice.tile_count, "as many tiles as claimed");
  AskPacker packer;
  packer.start(slice.frame, slice.eye, slice.size, slice.lights, requested);
  std::vector<RequestedTile> back(requested.size());
  check_eq(decode_ask_slice(slice, back, known).value(), 0u, "tiles learned from a duplicate");
  known = unknown;
  while (const std::optional<AskSlice> again = packer.next())
    check(decode_ask_slice(*again, back, known).has_value(), "a slice of our packer is accepted");
  check(back == requested, "packing and decoding gives the same blocks");
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const Input input = input_from({data, size});
  const Slice& slice = input.slice;
  if (input.kind == Kind::AskSlice)
    decode(AskSlice{.size = slice.size,
                    .lights = slice.lights,
                    .first_tile = slice.first_tile,
                    .tile_count = slice.tile_count,
                    .block = slice.block});
  else
    decode(slice, input.requested);
  return 0;
}
