/// Compares the quads of a mask with their definition.
#include "stereo/reproject/mask_quads.h"

#include <gtest/gtest.h>

#include <cstring>
#include <random>

namespace farshade {
namespace {

struct Base {
  StereoView views;
  PerEye<EyeMask> masks;
  PerEye<ReceivedTiles> known;
  RequestedBlocks requested;

  [[nodiscard]] TracedMask traced() const {
    return {{1}, {}, {}, views, masks, known, 0, kFirstLightSet, &requested};
  }
};

/// Both eyes have random bits. Of the requested tiles, every third has not come.
Base random_base(Extent size, std::uint32_t lights, std::mt19937& random) {
  Base base;
  const std::uint32_t tiles = TileGrid{size}.count();
  for (std::size_t eye = 0; eye < kEyes; ++eye) {
    EyeMask& mask = base.masks[eye] = EyeMask(size, lights);
    for (std::uint32_t plane = 0; plane < mask.layout().planes(); ++plane)
      for (std::uint32_t y = 0; y < size.height; ++y)
        for (std::uint32_t x = 0; x < size.width; ++x) {
          const auto bits = static_cast<std::uint32_t>(random() & random() & random());
          mask.set_word(x, y, plane, bits & mask.layout().used_bits(plane));
        }
    base.known[eye].assign(tiles, 0);
    for (std::uint32_t tile = 0; tile < tiles; ++tile) {
      if (tile % 3 != 0) base.known[eye][tile] = all_planes_received(mask.layout());
      base.requested.tiles[eye].push_back(all_lights_in(static_cast<BlockBits>(random() & random()), lights));
    }
  }
  return base;
}

bool is_known(const Base& base, std::size_t eye, std::uint32_t x, std::uint32_t y) {
  const TileGrid grid{base.masks[eye].size()};
  const std::size_t tile = y / kTileSide_px * grid.columns() + x / kTileSide_px;
  return (known_blocks(base.traced(), eye, tile) & block_bit(x % kTileSide_px, y % kTileSide_px)) != 0;
}

/// Whether light `light` differs in the quad at (x, y), by the definition.
bool differs(const Base& base, std::size_t eye, std::uint32_t x, std::uint32_t y, std::uint32_t light) {
  const EyeMask& mask = base.masks[eye];
  if (x + 1 >= mask.size().width || y + 1 >= mask.size().height) return true;
  bool differ = false;
  for (std::uint32_t row = y; row < y + 2; ++row)
    for (std::uint32_t column = x; column < x + 2; ++column)
      differ |= !is_known(base, eye, column, row) || mask.lit(column, row, light) != mask.lit(x, y, light);
  return differ;
}

void expect_quads(const Base& base, std::size_t eye) {
  const EyeMask& mask = base.masks[eye];
  const std::size_t word_bytes = mask.layout().word_bytes();
  std::vector<std::byte> quads(quad_bytes(mask.size(), mask.layout()));
  write_quads(base.traced(), eye, WriteOnly(std::span(quads)));
  for (std::uint32_t light = 0; light < mask.lights(); ++light)
    for (std::uint32_t y = 0; y < mask.size().height; ++y)
      for (std::uint32_t x = 0; x < mask.size().width; ++x) {
        const std::size_t at = (light / 32 * mask.size().pixels() + y * mask.size().width + x) * 2;
        std::array<std::uint32_t, 2> words{};  // bits, differ
        for (std::size_t i = 0; i < 2; ++i)
          std::memcpy(&words[i], &quads[(at + i) * word_bytes], word_bytes);  // little-endian
        ASSERT_EQ((words[0] >> (light % 32) & 1) != 0, mask.lit(x, y, light)) << x << ", " << y;
        ASSERT_EQ((words[1] >> (light % 32) & 1) != 0, differs(base, eye, x, y, light)) << x << ", " << y;
      }
}

TEST(MaskQuads, HaveTheBitsOfThePixelAndWhatDiffers) {
  const unsigned seed = 20271123;
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  for (const std::uint32_t lights : {1u, 3u, 8u, 9u, 17u, 32u, 40u})
    for (const Extent size : {Extent{1, 1}, Extent{1, 40}, Extent{50, 1}, Extent{37, 41}, Extent{64, 48}}) {
      SCOPED_TRACE(lights);
      const Base base = random_base(size, lights, random);
      for (std::size_t eye = 0; eye < kEyes; ++eye) expect_quads(base, eye);
    }
}

}  // namespace
}  // namespace farshade
