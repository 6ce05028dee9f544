/// Plane tile: codes the words of one 16x16 tile of a plane.
///
/// A word is split into independent lanes, such as the channels of a colour or the two numbers of a normal.
/// Each pixel of a lane is predicted from its left, upper and upper-left neighbours within the tile. The
/// residuals are small almost everywhere. They are written as bit planes without their empty rows. LZ4 then
/// needs a fifth to a half less than for residuals in bytes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "stereo/frame/pixel_plane.h"
#include "stereo/frame/tiles.h"
#include "stereo/messages/bytes.h"
#include "stereo/messages/refusal.h"

namespace farshade {

inline constexpr std::size_t kTilePixelCount = std::size_t{kTileSide_px} * kTileSide_px;

/// The words of a tile, row by row. Pixels outside of the plane repeat its last column and row.
using TileWords = std::array<std::uint32_t, kTilePixelCount>;

/// The lanes of a plane's words: `count` lanes of `bits` (8, 16, 24 or 32) each, the first in the lowest
/// bits.
struct PlaneLanes {
  std::uint32_t count = 1, bits = 32;
};
[[nodiscard]] constexpr PlaneLanes lanes_of(PlaneKind kind, std::uint32_t word_bytes) {
  if (kind == PlaneKind::BaseColor) return {word_bytes, 8};
  if (kind == PlaneKind::Normal && word_bytes == 4) return {2, 16};
  return {1, 8 * word_bytes};
}

/// How a pixel is predicted from its left, upper and upper-left neighbours (l, u, c).
enum class Prediction : std::uint8_t {
  Gradient = 0,  ///< l + u - c: exact on planes; in the first row and column, linear extrapolation
  Median =
      1,  ///< the same, clamped between l and u: the median edge detector of JPEG-LS (Weinberger, Seroussi,
          ///< Sapiro, "The LOCO-I lossless image compression algorithm", IEEE Trans. Image Proc. 2000)
};

/// The longest tile: four lanes of 8 bits. A lane has coding, first value, and a row mask and rows for each
/// bit.
inline constexpr std::size_t kMaxPlaneTile_bytes = 4 * (1 + 1 + 8 * (2 + 2 * std::size_t{kTileSide_px}));
static_assert(kMaxPlaneTile_bytes >= 1 + 4 + 32 * (2 + 2 * kTileSide_px));

/// Copies words from or to a plane. `rect` is a tile of the plane's TileGrid.
void load_tile(const PixelPlane& plane, TileRect rect, TileWords& words);
void store_tile(const TileWords& words, TileRect rect, PixelPlane& plane);

/// Appends all lanes, each with the prediction that makes it shorter:
///  - one byte: the number of bits of the largest residual in the low six bits, Prediction above them;
///  - the first pixel's value, as many bytes as the lane has;
///  - for each bit of the residuals, highest first: two bytes with a bit for each row in which a residual
///    has this bit, then two bytes for each of those rows; bit x is pixel x.
/// A residual is a difference modulo 2^bits, zigzag-coded: 0, -1, 1, -2 become 0, 1, 2, 3. The first pixel
/// has none.
void write_plane_tile(const TileWords& words, PlaneLanes lanes, std::vector<std::byte>& out);

/// Reads one tile from `in`. Refuses unknown codings and tiles that end early. After a refusal `words` are
/// undefined.
[[nodiscard]] Decoded<void> read_plane_tile(ByteReader& in, PlaneLanes lanes, TileWords& words);
/// Checks and skips one tile.
[[nodiscard]] Decoded<void> skip_plane_tile(ByteReader& in, PlaneLanes lanes);

}  // namespace farshade
