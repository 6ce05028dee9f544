/// Plane tile: the words of one 16x16 tile of a plane, as numbers and as bytes.
///
/// A word is cut into lanes that have nothing to do with each other: a colour's channels, a normal's two
/// numbers. A lane is predicted pixel by pixel from its left, upper and upper-left neighbours within the
/// tile; what is left over, small almost everywhere, is told as bit planes, and of those only the rows that
/// hold anything: in front of LZ4 a fifth to a half less than the rests byte by byte.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "stereo/frame/pixel_plane.h"
#include "stereo/frame/tiles.h"
#include "stereo/wire/bytes.h"
#include "stereo/wire/refusal.h"

namespace farshade {

inline constexpr std::size_t kTilePixelCount = std::size_t{kTileSide_px} * kTileSide_px;

/// Row by row. Pixels outside of the plane repeat its last column and row.
using TileWords = std::array<std::uint32_t, kTilePixelCount>;

/// How a plane's words fall apart: `count` lanes of `bits` (8, 16, 24 or 32), the first lowest.
struct PlaneLanes {
  std::uint32_t count = 1, bits = 32;
};
[[nodiscard]] constexpr PlaneLanes lanes_of(PlaneKind kind, std::uint32_t word_bytes) {
  if (kind == PlaneKind::BaseColor) return {word_bytes, 8};
  if (kind == PlaneKind::Normal && word_bytes == 4) return {2, 16};
  return {1, 8 * word_bytes};
}

/// How a pixel is predicted of its neighbours left, up and upper left (l, u, c).
enum class Prediction : std::uint8_t {
  Gradient = 0,  ///< l + u - c: no rest on planes; along the first row and column, as the last step went
  Median = 1,  ///< the same, but between l and u: the median edge detector of JPEG-LS (Weinberger, Seroussi,
               ///< Sapiro, "The LOCO-I lossless image compression algorithm", IEEE Trans. Image Proc. 2000)
};

/// Four lanes of 8 bits; or one of 32: coding, first value, a mask of rows a bit plane, rows.
inline constexpr std::size_t kMaxPlaneTile_bytes = 4 * (1 + 1 + 8 * (2 + 2 * kTileSide_px));
static_assert(kMaxPlaneTile_bytes >= 1 + 4 + 32 * (2 + 2 * kTileSide_px));

/// Words and planes. `rect` is a tile of the plane's TileGrid.
void load_tile(const PixelPlane& plane, TileRect rect, TileWords& words);
void store_tile(const TileWords& words, TileRect rect, PixelPlane& plane);

/// Appends lane after lane, each with the prediction that makes it shorter:
///  - a byte: bits of the largest rest in its low six, Prediction above them;
///  - the first pixel's value, as many bytes as the lane has;
///  - for each bit of the rests, highest first: two bytes with a bit for each row in which some rest has it,
///    then two bytes a row of these, bit x = pixel x has it.
/// Rests are differences modulo 2^bits, folded: 0, -1, 1, -2 are 0, 1, 2, 3. The first pixel has none.
void write_plane_tile(const TileWords& words, PlaneLanes lanes, std::vector<std::byte>& out);

/// Takes one tile from `in`; refuses unknown codings and tiles that end too early. After a refusal `words`
/// are anything.
[[nodiscard]] Decoded<void> read_plane_tile(ByteReader& in, PlaneLanes lanes, TileWords& words);
/// The same, but for the words.
[[nodiscard]] Decoded<void> skip_plane_tile(ByteReader& in, PlaneLanes lanes);

}  // namespace farshade
