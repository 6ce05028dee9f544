/// Tile codec: one plane (up to 32 lights) of one 16x16 tile of a mask, as bits and as bytes.
///
/// Most tiles hold one value; a light that differs within a tile mostly does so along one shadow edge, which
/// moves little from row to row. So a light's plane is told by the rows that differ from the row above, and a
/// row's difference by the runs of pixels that flip: about one byte a row of edge, which LZ4 then shortens
/// further. PROTOCOL.md has the bytes.
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

/// First byte of a tile on the wire. New ways to code a tile get new numbers; these stay.
enum class TileCoding : std::uint8_t { NotSent = 0, OneValue = 1, BitPlanes = 2 };

/// One light in one tile: bit x of row y. Pixels outside of the mask repeat the last column and row.
using PlaneRows = std::array<std::uint16_t, kTileSide_px>;

/// One plane of a tile. Bit i of the words is light 32 * plane + i.
struct TileBits {
  std::uint32_t varies = 0;        ///< lights that are not the same at all pixels
  std::uint32_t value = 0;         ///< what the others are everywhere; 0 for those that vary
  std::array<PlaneRows, 32> rows;  ///< of the lights that vary; the rest is not initialised
};

/// Says of all `lights` how they are at each pixel, even of those that are the same everywhere.
void spell_out(std::uint32_t lights, TileBits& bits);

/// Masks to bits and back. `rect` is a tile of the mask's TileGrid, `plane` one of its layout's.
[[nodiscard]] TileBits split_tile(const EyeMask& mask, TileRect rect, std::uint32_t plane);
void merge_tile(const TileBits& bits, TileRect rect, std::uint32_t plane, EyeMask& mask);

/// Coding, varying and raw lights, and 32 lights' rows as they are: no tile is longer.
inline constexpr std::size_t kMaxTile_bytes = 1 + 4 + 4 + 32 * 32;

/// Appends the shortest of the codings. `lights` is the number of lights in the plane.
void write_tile(const TileBits& bits, std::uint32_t lights, std::vector<std::byte>& out);
void write_not_sent(std::vector<std::byte>& out);

/// Takes one tile from `in`; NotSent leaves `bits` as it is.
/// Refuses unknown codings, tiles that end too early and bits at or above `lights`.
[[nodiscard]] Decoded<TileCoding> read_tile(ByteReader& in, std::uint32_t lights, TileBits& bits);

}  // namespace farshade
