/// Tile codec: codes one plane (up to 32 lights) of one 16x16 tile of a mask.
///
/// Most tiles have the same value in all pixels. If a light varies within a tile, it mostly has one shadow
/// edge, which moves little from row to row. So the coder writes only the rows that differ from the row
/// above, and for each of them the runs of pixels that flip. That takes about one byte for each row of an
/// edge, and LZ4 shortens it further. PROTOCOL.md has the bytes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "stereo/frame/eye_mask.h"
#include "stereo/frame/tiles.h"
#include "stereo/wire/bytes.h"
#include "stereo/wire/refusal.h"

namespace farshade {

/// First byte of a coded tile. A new coding gets a new number; these numbers keep their meaning.
enum class TileCoding : std::uint8_t { NotSent = 0, OneValue = 1, BitPlanes = 2 };

/// One light in one tile: bit x of row y is pixel (x, y). Pixels outside of the mask repeat its last column
/// and row.
using PlaneRows = std::array<std::uint16_t, kTileSide_px>;

/// One plane of a tile. Bit i of the words is light 32 * plane + i.
struct TileBits {
  std::uint32_t varies = 0;        ///< lights that differ between pixels
  std::uint32_t value = 0;         ///< value of the other lights; 0 for lights that vary
  std::array<PlaneRows, 32> rows;  ///< of the lights that vary; others are not initialised
};

/// Turns all `lights` into lights that vary, with a bit for each pixel.
void spell_out(std::uint32_t lights, TileBits& bits);

/// Reads a tile's bits from a mask, or writes them to it. `rect` is a tile of the mask's TileGrid.
[[nodiscard]] TileBits split_tile(const EyeMask& mask, TileRect rect, std::uint32_t plane);
void merge_tile(const TileBits& bits, TileRect rect, std::uint32_t plane, EyeMask& mask);

/// The longest tile: coding, varying and raw lights, and raw rows of 32 lights.
inline constexpr std::size_t kMaxTile_bytes = 1 + 4 + 4 + 32 * 32;

/// Appends the tile in its shortest coding. `lights` is the number of lights in the plane.
void write_tile(const TileBits& bits, std::uint32_t lights, std::vector<std::byte>& out);
void write_not_sent(std::vector<std::byte>& out);

/// Reads one tile from `in`. NotSent leaves `bits` unchanged.
/// Refuses unknown codings, tiles that end early, and set bits at or above `lights`.
[[nodiscard]] Decoded<TileCoding> read_tile(ByteReader& in, std::uint32_t lights, TileBits& bits);

}  // namespace farshade
