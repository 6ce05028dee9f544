#include "stereo/codec/tile_bits.h"

#include <algorithm>
#include <bit>
#include <cstring>

namespace farshade {
namespace {

static_assert(std::endian::native == std::endian::little, "pixel i of eight is byte i of a 64-bit word");

constexpr std::uint32_t kSide = kTileSide_px;
constexpr std::uint64_t kEachByte = 0x0101010101010101;

/// Eight lights of a mask word in all pixels of a tile: one byte for each pixel, two words for each row.
using ByteBlock = std::array<std::array<std::uint64_t, 2>, kSide>;

/// The place of the bytes of lights from 8 * group on, of a tile's plane, in a mask.
struct BlockPlace {
  std::size_t offset, row_bytes, pixel_bytes;
  std::uint32_t width, height;  ///< pixels

  BlockPlace(const EyeMask& mask, TileRect rect, std::uint32_t plane, std::uint32_t group)
      : row_bytes(std::size_t{mask.size().width} * mask.layout().word_bytes()),
        pixel_bytes(mask.layout().word_bytes()),
        width(rect.x1 - rect.x0),
        height(rect.y1 - rect.y0) {
    const std::size_t row = std::size_t{plane} * mask.size().height + rect.y0;
    offset = row * row_bytes + rect.x0 * pixel_bytes + group;
  }
  [[nodiscard]] bool is_row_of_bytes() const { return width == kSide && pixel_bytes == 1; }
};

ByteBlock load_block(std::span<const std::byte> mask, const BlockPlace& place) {
  ByteBlock block;
  for (std::uint32_t y = 0; y < kSide; ++y) {
    const std::byte* row = &mask[place.offset + std::min(y, place.height - 1) * place.row_bytes];
    std::array<std::byte, kSide> line;
    if (place.is_row_of_bytes())
      std::memcpy(line.data(), row, kSide);
    else
      for (std::uint32_t x = 0; x < kSide; ++x)
        line[x] = row[std::min(x, place.width - 1) * place.pixel_bytes];
    block[y] = std::bit_cast<std::array<std::uint64_t, 2>>(line);
  }
  return block;
}

void store_block(const ByteBlock& block, const BlockPlace& place, std::span<std::byte> mask) {
  for (std::uint32_t y = 0; y < place.height; ++y) {
    std::byte* row = &mask[place.offset + y * place.row_bytes];
    const auto line = std::bit_cast<std::array<std::byte, kSide>>(block[y]);
    if (place.is_row_of_bytes())
      std::memcpy(row, line.data(), kSide);
    else
      for (std::uint32_t x = 0; x < place.width; ++x) row[x * place.pixel_bytes] = line[x];
  }
}

/// Bit `light` of eight pixels as a byte. The product moves bit 8 i to bit 56 + i. No two terms overlap, so
/// there is no carry.
std::uint32_t gather_bits(std::uint64_t pixels, std::uint32_t light) {
  return static_cast<std::uint32_t>(((pixels >> light & kEachByte) * 0x0102040810204080) >> 56);
}

/// Inverse of gather_bits for light 0: eight pixels, bit 0 of each.
std::uint64_t scatter_bits(std::uint32_t byte) {
  const std::uint64_t own_bit = byte * kEachByte & 0x8040201008040201;
  return (own_bit + 0x7f7f7f7f7f7f7f7f) >> 7 & kEachByte;
}

/// Four rows of a tile, 16 bits each, from the top.
using FourRows = std::uint64_t;

/// The four cells of four rows, column by column, and back.
Cell cell_in(FourRows rows, std::uint32_t column) {
  const FourRows nibbles = rows >> (4 * column) & 0x000f000f000f000f;
  return static_cast<Cell>(nibbles | nibbles >> 12 | nibbles >> 24 | nibbles >> 36);
}
FourRows rows_of(Cell cell, std::uint32_t column) {
  const FourRows bits = cell;
  return ((bits & 15) | (bits & 0xf0) << 12 | (bits & 0xf00) << 24 | (bits & 0xf000) << 36) << (4 * column);
}

TileCells cells_of(const ByteBlock& block, std::uint32_t light) {
  TileCells cells;
  for (std::uint32_t row = 0; row < kTileBlocks; ++row) {
    FourRows rows = 0;
    for (std::uint32_t y = 0; y < 4; ++y) {
      const auto& [left, right] = block[4 * row + y];
      rows |= FourRows{gather_bits(left, light) | gather_bits(right, light) << 8} << (16 * y);
    }
    for (std::uint32_t column = 0; column < kTileBlocks; ++column)
      cells[kTileBlocks * row + column] = cell_in(rows, column);
  }
  return cells;
}

/// Adds a light that has the value 0 in `block`.
void add_cells(const TileCells& cells, std::uint32_t light, ByteBlock& block) {
  for (std::uint32_t row = 0; row < kTileBlocks; ++row) {
    FourRows rows = 0;
    for (std::uint32_t column = 0; column < kTileBlocks; ++column)
      rows |= rows_of(cells[kTileBlocks * row + column], column);
    for (std::uint32_t y = 0; y < 4; ++y) {
      const auto bits = static_cast<std::uint32_t>(rows >> (16 * y));
      block[4 * row + y][0] |= scatter_bits(bits & 0xff) << light;
      block[4 * row + y][1] |= scatter_bits(bits >> 8 & 0xff) << light;
    }
  }
}

/// AND of the eight bytes of `word`.
std::uint32_t and_of_bytes(std::uint64_t word) {
  word &= word >> 32;
  word &= word >> 16;
  word &= word >> 8;
  return static_cast<std::uint32_t>(word & 0xff);
}

/// Calls act(i) for each bit i of `word`, lowest first.
template <class Act>
void for_each_bit(std::uint32_t word, Act act) {
  for (; word != 0; word &= word - 1) act(static_cast<std::uint32_t>(std::countr_zero(word)));
}

/// Makes a light that differs only between pixels that are not asked for one that does not vary.
void narrow_light(std::uint32_t light, BlockBits requested, TileBits& bits) {
  std::uint32_t any = 0, every = 0xffff;
  for (std::uint32_t block = 0; block < 16; ++block)
    if ((requested >> block & 1) != 0) {
      any |= bits.cells[light][block];
      every &= bits.cells[light][block];
    }
  if (any != 0 && every != 0xffff) return;
  bits.varies &= ~(1u << light);
  if (any != 0) bits.value |= 1u << light;
}

/// Replaces the bits of `before` that are asked for by those of `block`.
void replace_requested(const ByteBlock& block, const RequestedTile& requested, ByteBlock& before) {
  for (std::uint32_t row = 0; row < kTileBlocks; ++row)
    for (std::uint32_t half = 0; half < 2; ++half) {
      const std::uint32_t at = kTileBlocks * row + 2 * half;
      const std::uint64_t bits = requested.at(at) * 0x01010101ull | (requested.at(at + 1) * 0x01010101ull)
                                                                        << 32;
      for (std::uint32_t y = kBlockSide_px * row; y < kBlockSide_px * (row + 1); ++y)
        before[y][half] = (before[y][half] & ~bits) | (block[y][half] & bits);
    }
}

/// Everything in the picture is asked for, in all lights of the mask.
bool asks_for_all(const RequestedTile& requested, TileRect rect, std::uint32_t lights) {
  const BlockBits inside = blocks_in(rect);
  BlockBits everywhere = kAllBlocks;
  for (std::uint32_t share = 0; share < shares_of(lights); ++share) everywhere &= requested.shares[share];
  return (everywhere & inside) == inside;
}

}  // namespace

BlockBits blocks_in(TileRect rect) {
  const auto blocks = [](std::uint32_t pixels) { return (pixels + kBlockSide_px - 1) / kBlockSide_px; };
  const std::uint32_t row = (1u << blocks(rect.x1 - rect.x0)) - 1;
  const std::uint32_t rows = (1u << (kTileBlocks * blocks(rect.y1 - rect.y0))) - 1;
  return static_cast<BlockBits>(row * 0x1111 & rows);
}

void split_tile(const EyeMask& mask, TileRect rect, std::uint32_t plane, const RequestedTile& requested,
                TileBits& bits) {
  bits.varies = bits.value = 0;
  const std::uint32_t lights = lights_requested(requested, mask.layout().lights_in(plane));
  for (std::uint32_t group = 0; 8 * group < mask.layout().lights_in(plane); ++group) {
    const std::uint32_t here = lights >> 8 * group & 0xff;
    if (here == 0) continue;
    const ByteBlock block = load_block(mask.bytes(), BlockPlace(mask, rect, plane, group));
    std::uint64_t all_set = ~std::uint64_t{0}, all_clear = ~std::uint64_t{0};
    for (const auto& [left, right] : block) {
      all_set &= left & right;
      all_clear &= ~left & ~right;
    }
    const std::uint32_t set = and_of_bytes(all_set), varies = ~(set | and_of_bytes(all_clear)) & here;
    for_each_bit(varies,
                 [&](std::uint32_t light) { bits.cells[8 * group + light] = cells_of(block, light); });
    bits.value |= (set & here) << 8 * group;
    bits.varies |= varies << 8 * group;
  }
  if (!asks_for_all(requested, rect, mask.lights()))
    for_each_bit(bits.varies, [&](std::uint32_t light) { narrow_light(light, requested.of(light), bits); });
}

void merge_tile(const TileBits& bits, TileRect rect, std::uint32_t plane, const RequestedTile& requested,
                EyeMask& mask) {
  const bool all = asks_for_all(requested, rect, mask.lights());
  for (std::uint32_t group = 0; group < mask.layout().word_bytes(); ++group) {
    const BlockPlace place(mask, rect, plane, group);
    const std::uint64_t everywhere = (bits.value >> 8 * group & 0xff) * kEachByte;
    ByteBlock block;
    block.fill({everywhere, everywhere});
    for_each_bit(bits.varies >> 8 * group & 0xff,
                 [&](std::uint32_t light) { add_cells(bits.cells[8 * group + light], light, block); });
    if (all) {
      store_block(block, place, mask.bytes());
      continue;
    }
    ByteBlock before = load_block(mask.bytes(), place);
    replace_requested(block, requested, before);
    store_block(before, place, mask.bytes());
  }
}

}  // namespace farshade
