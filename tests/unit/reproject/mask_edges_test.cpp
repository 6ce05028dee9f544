/// Compares masks on the device with their definition: unchanged bits, and four edge bits that say whether
/// the 2x2 pixels around each corner of a pixel differ. A corner on the border does not have four pixels and
/// is no edge.
#include "stereo/reproject/mask_edges.h"

#include <gtest/gtest.h>

#include <cstring>
#include <glm/vec2.hpp>
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
