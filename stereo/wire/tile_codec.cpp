#include "stereo/wire/tile_codec.h"

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

PlaneRows rows_of(const ByteBlock& block, std::uint32_t light) {
  PlaneRows rows;
  for (std::uint32_t y = 0; y < kSide; ++y)
    rows[y] =
        static_cast<std::uint16_t>(gather_bits(block[y][0], light) | gather_bits(block[y][1], light) << 8);
  return rows;
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

// ---- rows as flipped pixels

std::uint32_t run_of(std::uint32_t first, std::uint32_t last) {
  return (2u << last) - (1u << first);
}

/// Writes a row's flips as runs, the outermost first: from the first to the last flip, then the flips that
/// remain inside. A run is one byte with its first pixel in the low nibble and its last in the high nibble.
/// They are swapped if another run follows; such a run has at least two pixels, since the next one lies
/// inside.
std::byte* write_flips(std::uint32_t flips, std::byte* out) {
  for (;;) {
    const auto first = static_cast<std::uint32_t>(std::countr_zero(flips));
    const auto last = static_cast<std::uint32_t>(std::bit_width(flips)) - 1;
    flips ^= run_of(first, last);
    if (flips == 0) {
      *out++ = static_cast<std::byte>(first | last << 4);
      return out;
    }
    *out++ = static_cast<std::byte>(last | first << 4);
  }
}

bool read_flips(ByteReader& in, std::uint32_t& flips) {
  flips = 0;
  for (;;) {
    std::uint32_t run = 0;
    if (!in.u8(run)) return false;
    const std::uint32_t a = run & 15, b = run >> 4;
    flips ^= run_of(std::min(a, b), std::max(a, b));
    if (a <= b) return true;
  }
}

constexpr std::size_t kRawRows_bytes = 2 * std::size_t{kSide};

/// Writes row changes to `out` and returns their size, or 0 if they need more than kRawRows_bytes.
std::size_t write_changes(const PlaneRows& rows, std::array<std::byte, kRawRows_bytes + 8>& out) {
  std::byte* end = out.data() + 2;
  std::uint32_t changed = 0, above = 0;
  for (std::uint32_t y = 0; y < kSide; ++y) {
    if (rows[y] == above) continue;
    changed |= 1u << y;
    end = write_flips(rows[y] ^ above, end);  // a row has at most 8 runs
    if (end > out.data() + kRawRows_bytes) return 0;
    above = rows[y];
  }
  out[0] = static_cast<std::byte>(changed & 0xff);
  out[1] = static_cast<std::byte>(changed >> 8);
  return static_cast<std::size_t>(end - out.data());
}

bool read_changes(ByteReader& in, PlaneRows& rows) {
  std::uint32_t changed = 0, row = 0;
  if (!in.u16(changed)) return false;
  for (std::uint32_t y = 0; y < kSide; ++y) {
    std::uint32_t flips = 0;
    if ((changed >> y & 1) != 0 && !read_flips(in, flips)) return false;
    row ^= flips;
    rows[y] = static_cast<std::uint16_t>(row);
  }
  return true;
}

bool read_rows(ByteReader& in, PlaneRows& rows) {
  return std::all_of(rows.begin(), rows.end(), [&in](std::uint16_t& row) { return in.u16(row); });
}

// ---- words with one bit for each light, in as many bytes as the plane's lights need

void write_lights(ByteWriter out, std::uint32_t word, std::uint32_t lights) {
  for (std::uint32_t bit = 0; bit < lights; bit += 8) out.u8(word >> bit & 0xff);
}

bool read_lights(ByteReader& in, std::uint32_t& word, std::uint32_t lights) {
  word = 0;
  for (std::uint32_t bit = 0; bit < lights; bit += 8) {
    std::uint32_t byte = 0;
    if (!in.u8(byte)) return false;
    word |= byte << bit;
  }
  return true;
}

}  // namespace

TileBits split_tile(const EyeMask& mask, TileRect rect, std::uint32_t plane) {
  TileBits bits;
  for (std::uint32_t group = 0; 8 * group < mask.layout().lights_in(plane); ++group) {
    const ByteBlock block = load_block(mask.bytes(), BlockPlace(mask, rect, plane, group));
    std::uint64_t all_set = ~std::uint64_t{0}, all_clear = ~std::uint64_t{0};
    for (const auto& [left, right] : block) {
      all_set &= left & right;
      all_clear &= ~left & ~right;
    }
    const std::uint32_t set = and_of_bytes(all_set), varies = ~(set | and_of_bytes(all_clear)) & 0xff;
    for_each_bit(varies, [&](std::uint32_t light) { bits.rows[8 * group + light] = rows_of(block, light); });
    bits.value |= set << 8 * group;
    bits.varies |= varies << 8 * group;
  }
  return bits;
}

void spell_out(std::uint32_t lights, TileBits& bits) {
  const std::uint32_t all = MaskLayout{lights}.used_bits(0);
  for_each_bit(all & ~bits.varies, [&](std::uint32_t light) {
    bits.rows[light].fill((bits.value >> light & 1) != 0 ? 0xffff : 0);
  });
  bits.varies = all;
  bits.value = 0;
}

void merge_tile(const TileBits& bits, TileRect rect, std::uint32_t plane, EyeMask& mask) {
  for (std::uint32_t group = 0; group < mask.layout().word_bytes(); ++group) {
    const std::uint64_t everywhere = (bits.value >> 8 * group & 0xff) * kEachByte;
    ByteBlock block;
    block.fill({everywhere, everywhere});
    for_each_bit(bits.varies >> 8 * group & 0xff, [&](std::uint32_t light) {
      const PlaneRows& rows = bits.rows[8 * group + light];
      for (std::uint32_t y = 0; y < kSide; ++y) {
        block[y][0] |= scatter_bits(rows[y] & 0xff) << light;
        block[y][1] |= scatter_bits(rows[y] >> 8u) << light;
      }
    });
    store_block(block, BlockPlace(mask, rect, plane, group), mask.bytes());
  }
}

void write_tile(const TileBits& bits, std::uint32_t lights, std::vector<std::byte>& out) {
  ByteWriter io(out);
  if (bits.varies == 0) {
    io.code(TileCoding::OneValue);
    write_lights(io, bits.value, lights);
    return;
  }
  io.code(TileCoding::BitPlanes);
  write_lights(io, bits.varies, lights);
  const std::size_t words_end = out.size();
  write_lights(io, bits.value, lights);
  for_each_bit(bits.varies, [&](std::uint32_t light) {
    std::array<std::byte, kRawRows_bytes + 8> changes;
    const PlaneRows& rows = bits.rows[light];
    if (const std::size_t size = write_changes(rows, changes)) {
      io.rest(std::span(changes).first(size));
      return;
    }
    out[words_end + light / 8] |= std::byte{1} << light % 8;
    for (const std::uint16_t row : rows) io.u16(row);
  });
}

void write_not_sent(std::vector<std::byte>& out) {
  ByteWriter(out).code(TileCoding::NotSent);
}

Decoded<TileCoding> read_tile(ByteReader& in, std::uint32_t lights, TileBits& bits) {
  const std::uint32_t no_light = ~MaskLayout{lights}.used_bits(0);
  TileCoding coding{};
  if (!in.code(coding)) return refuse(WireRefusal::TileLength);
  if (coding == TileCoding::NotSent) return coding;
  if (coding != TileCoding::OneValue && coding != TileCoding::BitPlanes)
    return refuse(WireRefusal::TileCoding);
  bits.varies = 0;
  if (coding == TileCoding::BitPlanes && !read_lights(in, bits.varies, lights))
    return refuse(WireRefusal::TileLength);
  if (!read_lights(in, bits.value, lights)) return refuse(WireRefusal::TileLength);
  if (((bits.varies | bits.value) & no_light) != 0) return refuse(WireRefusal::TileBits);

  const std::uint32_t raw = bits.value & bits.varies;
  bits.value &= ~bits.varies;
  bool whole = true;
  for_each_bit(bits.varies, [&](std::uint32_t light) {
    whole = whole && ((raw >> light & 1) != 0 ? read_rows : read_changes)(in, bits.rows[light]);
  });
  if (!whole) return refuse(WireRefusal::TileLength);
  return coding;
}

}  // namespace farshade
