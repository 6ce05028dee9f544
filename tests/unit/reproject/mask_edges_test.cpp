/// Compares masks on the device with their definition: unchanged bits, and four edge bits that say whether
/// the 2x2 pixels around each corner of a pixel differ, or for edge rays, a line of one pixel's width is
/// near. A corner on the border does not have four pixels and is no edge.
#include "stereo/reproject/mask_edges.h"

#include <gtest/gtest.h>

#include <cstring>
#include <glm/vec2.hpp>
#include <glm/vector_relational.hpp>
#include <random>

namespace farshade {
namespace {

/// A word of a mask in `layout`.
std::uint32_t word_at(std::span<const std::byte> bytes, MaskLayout layout, Extent size, std::uint32_t x,
                      std::uint32_t y, std::uint32_t plane) {
  const std::size_t at = (plane * size.pixels() + std::size_t{y} * size.width + x) * layout.word_bytes();
  std::uint32_t word = 0;
  std::memcpy(&word, bytes.data() + at, layout.word_bytes());  // little-endian
  return word;
}

/// Whether two pixels differ in some light.
bool differ(const EyeMask& mask, glm::uvec2 a, glm::uvec2 b) {
  for (std::uint32_t i = 0; i < mask.lights(); ++i)
    if (mask.lit(a.x, a.y, i) != mask.lit(b.x, b.y, i)) return true;
  return false;
}

/// The edge bit of a quarter of pixel (x, y), by its definition.
bool is_edge(const EyeMask& mask, std::uint32_t x, std::uint32_t y, std::uint32_t quarter) {
  const std::uint32_t right = x + quarter % 2,
                      lower = y + quarter / 2;  // the last of the corner's four pixels
  if (right == 0 || lower == 0 || right >= mask.size().width || lower >= mask.size().height) return false;
  const glm::uvec2 first(right - 1, lower - 1);
  return differ(mask, first, {right, lower - 1}) || differ(mask, first, {right - 1, lower}) ||
         differ(mask, first, {right, lower});
}

/// Compares the device's copy of `mask` with the definition. Returns the number of edge bits that are set.
std::size_t check_against_definition(const EyeMask& mask) {
  const MaskLayout layout = with_edge_bits(mask.layout());
  const std::uint32_t lights = mask.lights(), first = first_edge_bit(lights);
  std::vector<std::byte> out(mask_bytes(mask.size(), layout), std::byte{0xA5});
  copy_with_edges(mask, WriteOnly(std::span(out)));
  std::size_t edges = 0, wrong = 0;
  for (std::uint32_t y = 0; y < mask.size().height; ++y)
    for (std::uint32_t x = 0; x < mask.size().width; ++x)
      for (std::uint32_t plane = 0; plane < layout.planes(); ++plane) {
        std::uint32_t right = plane < mask.layout().planes() ? mask.word(x, y, plane) : 0;
        for (std::uint32_t quarter = 0; quarter < 4 && first / 32 == plane; ++quarter) {
          const bool edge = is_edge(mask, x, y, quarter);
          right |= std::uint32_t{edge} << (first + quarter) % 32;
          edges += edge;
        }
        wrong += word_at(out, layout, mask.size(), x, y, plane) != right;
      }
  EXPECT_EQ(wrong, 0u) << "words";
  return edges;
}

/// Whether pixel (x, y) differs in `light` from both neighbours at `step`.
bool is_thin(const EyeMask& mask, glm::ivec2 at, glm::ivec2 step, std::uint32_t light) {
  const glm::ivec2 size(mask.size().width, mask.size().height);
  const auto lit = [&](glm::uvec2 pixel) { return mask.lit(pixel.x, pixel.y, light); };
  for (const glm::ivec2 end : {at - step, at + step})
    if (glm::any(glm::lessThan(end, glm::ivec2(0))) || glm::any(glm::greaterThanEqual(end, size)) ||
        lit(end) == lit(at))
      return false;
  return true;
}

/// Whether the cell of pixel (x, y) has an edge in a light, by its definition. Beyond the picture there is
/// nothing.
bool cell_has_edge(const EyeMask& mask, glm::ivec2 cell, std::uint32_t light, bool thin) {
  const glm::ivec2 size(mask.size().width, mask.size().height);
  if (cell.x + 1 >= size.x || cell.y + 1 >= size.y) return false;
  const auto lit = [&](int dx, int dy) {
    return mask.lit(static_cast<std::uint32_t>(cell.x + dx), static_cast<std::uint32_t>(cell.y + dy), light);
  };
  if (lit(0, 0) != lit(1, 0) || lit(0, 0) != lit(0, 1) || lit(0, 0) != lit(1, 1)) return true;
  for (int along = -2; along <= 3 && thin; ++along)
    for (int across = 0; across <= 1; ++across) {
      const glm::ivec2 upright = cell + glm::ivec2(across, along), level = cell + glm::ivec2(along, across);
      if (upright.y >= 0 && upright.y < size.y && is_thin(mask, upright, {1, 0}, light)) return true;
      if (level.x >= 0 && level.x < size.x && is_thin(mask, level, {0, 1}, light)) return true;
    }
  return false;
}

/// Compares the words of the cells, and the edge bits, of the device's copy for edge rays with the
/// definition. Returns the number of pixel-lights that only a thin line marks.
std::size_t check_cells(const EyeMask& mask, const LightBits& thin) {
  const MaskLayout layout = with_edge_bits(mask.layout());
  const Extent size = mask.size();
  std::vector<std::byte> out(mask_and_cell_bytes(size, mask.layout()), std::byte{0xA5});
  copy_with_cells(mask, thin, WriteOnly(std::span(out)));
  std::size_t by_lines = 0, wrong = 0;
  std::vector<bool> any(size.pixels());
  for (std::uint32_t y = 0; y < size.height; ++y)
    for (std::uint32_t x = 0; x < size.width; ++x)
      for (std::uint32_t plane = 0; plane < mask.layout().planes(); ++plane) {
        std::uint32_t right = 0;
        for (std::uint32_t i = 0; i < mask.layout().lights_in(plane); ++i) {
          const std::uint32_t light = plane * 32 + i;
          const bool lines = (thin[plane] >> i & 1u) != 0, edge = cell_has_edge(mask, {x, y}, light, lines);
          right |= std::uint32_t{edge} << i;
          by_lines += edge && !cell_has_edge(mask, {x, y}, light, false);
        }
        wrong += word_at(out, layout, size, x, y, layout.planes() + plane) != right;
        if (right != 0) any[std::size_t{y} * size.width + x] = true;
      }
  EXPECT_EQ(wrong, 0u) << "words of cells";
  const std::uint32_t first = first_edge_bit(mask.lights());
  for (std::uint32_t y = 0; y < size.height; ++y)
    for (std::uint32_t x = 0; x < size.width; ++x)
      for (std::uint32_t quarter = 0; quarter < 4; ++quarter) {
        const std::uint32_t right = x + quarter % 2, lower = y + quarter / 2;
        const bool edge = right > 0 && lower > 0 && any[std::size_t{lower - 1} * size.width + right - 1];
        wrong += (word_at(out, layout, size, x, y, first / 32) >> (first + quarter) % 32 & 1u) != edge;
      }
  EXPECT_EQ(wrong, 0u) << "edge bits";
  return by_lines;
}

TEST(MaskEdges, HaveTheirFourBitsInOnePlaneAboveTheLights) {
  for (std::uint32_t lights = 1; lights <= kMaxLights; ++lights) {
    const std::uint32_t first = first_edge_bit(lights);
    ASSERT_GE(first, lights);
    ASSERT_EQ(first / 32, (first + 3) / 32);
    ASSERT_GE(with_edge_bits({lights}).lights_in(first / 32), (first + 4) - first / 32 * 32);
  }
  EXPECT_EQ(with_edge_bits({4}).word_bytes(), 1u) << "with up to four lights, one byte holds everything";
  EXPECT_EQ(with_edge_bits({12}).word_bytes(), 2u);
}

class MaskEdgesOf : public testing::TestWithParam<Extent> {
 protected:
  std::mt19937 random_{42};  // the seed
};

TEST_P(MaskEdgesOf, AreThoseOfTheDefinitionForAnyNumberOfLights) {
  const Extent size = GetParam();
  for (std::uint32_t lights = 1; lights <= 40; ++lights) {
    SCOPED_TRACE(std::to_string(lights) + " lights");
    EyeMask mask(size, lights);
    check_against_definition(mask);
    // A few pixels differ, each in one light, so that some corners are edges and others are not.
    for (std::size_t i = 0; i < 1 + size.pixels() / 40; ++i) {
      const std::uint32_t light = static_cast<std::uint32_t>(random_()) % lights;
      mask.set_word(static_cast<std::uint32_t>(random_()) % size.width,
                    static_cast<std::uint32_t>(random_()) % size.height, light / 32, 1u << light % 32);
    }
    const std::size_t edges = check_against_definition(mask);
    if (size.pixels() > 100) {
      EXPECT_GT(edges, 0u);
      EXPECT_LT(edges, 3 * size.pixels());
    }
  }
}

TEST_P(MaskEdgesOf, HaveCellsByTheDefinitionForAnyNumberOfLights) {
  const Extent size = GetParam();
  std::size_t by_lines = 0;
  for (const std::uint32_t lights : {1u, 3u, 4u, 5u, 12u, 13u, 32u, 33u, 40u}) {
    SCOPED_TRACE(std::to_string(lights) + " lights");
    EyeMask mask(size, lights);
    for (std::size_t i = 0; i < 1 + size.pixels() / 20; ++i) {
      const std::uint32_t light = static_cast<std::uint32_t>(random_()) % lights;
      mask.set_word(static_cast<std::uint32_t>(random_()) % size.width,
                    static_cast<std::uint32_t>(random_()) % size.height, light / 32, 1u << light % 32);
    }
    LightBits every{}, none{}, some{};
    every.fill(~0u);
    some.fill(0x55555555u);
    by_lines += check_cells(mask, every) + check_cells(mask, some);
    check_cells(mask, none);
  }
  if (size.pixels() > 100) {
    EXPECT_GT(by_lines, 100u);
  }
}

INSTANTIATE_TEST_SUITE_P(Size, MaskEdgesOf,
                         testing::Values(Extent{1, 1}, Extent{1, 7}, Extent{7, 1}, Extent{2, 2}, Extent{3, 3},
                                         Extent{17, 5}, Extent{33, 31}),
                         [](const auto& tested) {
                           return std::to_string(tested.param.width) + "x" +
                                  std::to_string(tested.param.height);
                         });

TEST(MaskEdges, OfOnePixelAreTheSixteenQuartersAboutItsCorners) {
  EyeMask mask({7, 6}, 40);
  mask.set_word(3, 2, 1, 1u << 7);  // the last light
  EXPECT_EQ(check_against_definition(mask), 16u);
  mask = EyeMask({7, 6}, 40);
  mask.set_word(0, 5, 0, 1);
  EXPECT_EQ(check_against_definition(mask), 4u) << "in a corner of the picture";
}

/// A wire whose shadow is thinner than a pixel has samples in some pixels only. It goes on between them.
TEST(MaskEdges, OfAThinLineReachTwoPixelsBeyondItsEnd) {
  EyeMask mask({16, 9}, 3);
  for (std::uint32_t x = 4; x <= 6; ++x) mask.set_word(x, 4, 0, 4u);
  LightBits every{};
  every.fill(~0u);
  std::vector<std::byte> out(mask_and_cell_bytes(mask.size(), mask.layout()));
  copy_with_cells(mask, every, WriteOnly(std::span(out)));
  std::string rows;
  for (std::uint32_t y = 2; y <= 5; ++y) {
    for (std::uint32_t x = 0; x < 12; ++x)
      rows += word_at(out, with_edge_bits(mask.layout()), mask.size(), x, y, 1) == 4u ? '#' : '.';
    rows += '\n';
  }
  // The cells of x = 3 and x = 6 lie at its ends.
  EXPECT_EQ(rows,
            "............\n"
            ".########...\n"
            ".########...\n"
            "............\n");
}

TEST(MaskEdges, AreNoneInAWholeMaskNorInNothing) {
  EyeMask mask({9, 9}, 16);
  for (std::uint32_t y = 0; y < 9; ++y)
    for (std::uint32_t x = 0; x < 9; ++x) mask.set_word(x, y, 0, 0xFFFF);
  EXPECT_EQ(check_against_definition(mask), 0u)
      << "all pixels are lit, and there is no shadow beyond the border";
  EXPECT_EQ(check_against_definition(EyeMask({0, 0}, 3)), 0u);
}

}  // namespace
}  // namespace farshade
