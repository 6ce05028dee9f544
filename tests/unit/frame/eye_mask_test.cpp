#include "stereo/frame/eye_mask.h"

#include <gtest/gtest.h>

#include <bit>
#include <random>

namespace farshade {
namespace {

TEST(MaskLayout, TakesTheNarrowestWord) {
  struct Row {
    std::uint32_t lights, planes, word_bytes;
  };
  for (const Row row :
       {Row{0, 1, 1}, Row{1, 1, 1}, Row{8, 1, 1}, Row{9, 1, 2}, Row{16, 1, 2}, Row{17, 1, 4}, Row{32, 1, 4},
        Row{33, 2, 4}, Row{40, 2, 4}, Row{64, 2, 4}, Row{65, 3, 4}, Row{256, 8, 4}}) {
    const MaskLayout layout{row.lights};
    EXPECT_EQ(layout.planes(), row.planes) << row.lights << " lights";
    EXPECT_EQ(layout.word_bytes(), row.word_bytes) << row.lights << " lights";
  }
}

TEST(MaskLayout, UsesEachLightsBitOnce) {
  for (std::uint32_t lights = 0; lights <= kMaxLights; ++lights) {
    const MaskLayout layout{lights};
    std::uint32_t bits = 0;
    for (std::uint32_t plane = 0; plane < layout.planes(); ++plane)
      bits += static_cast<std::uint32_t>(std::popcount(layout.used_bits(plane)));
    EXPECT_EQ(bits, lights);
    EXPECT_EQ(layout.lights_in(layout.planes()), 0u);
  }
  EXPECT_EQ(MaskLayout{40}.used_bits(0), 0xffffffffu);
  EXPECT_EQ(MaskLayout{40}.used_bits(1), 0xffu);
}

constexpr Extent kSize{7, 5};

class EyeMaskOf : public testing::TestWithParam<std::uint32_t> {};

TEST_P(EyeMaskOf, KeepsEveryWordOfEveryPlane) {
  EyeMask mask(kSize, GetParam());
  const MaskLayout layout = mask.layout();
  EXPECT_EQ(mask.bytes().size(), kSize.pixels() * layout.planes() * layout.word_bytes());
  const auto visit = [&](auto visitor) {
    std::mt19937 random(GetParam());
    for (std::uint32_t plane = 0; plane < layout.planes(); ++plane)
      for (std::uint32_t y = 0; y < kSize.height; ++y)
        for (std::uint32_t x = 0; x < kSize.width; ++x)
          visitor(x, y, plane, static_cast<std::uint32_t>(random()) & layout.used_bits(plane));
  };
  visit([&](auto x, auto y, auto plane, auto bits) { mask.set_word(x, y, plane, bits); });
  visit([&](auto x, auto y, auto plane, auto bits) {
    EXPECT_EQ(mask.word(x, y, plane), bits);
    for (std::uint32_t i = 0; i < layout.lights_in(plane); ++i)
      EXPECT_EQ(mask.lit(x, y, plane * 32 + i), (bits >> i & 1) != 0);
  });
}

TEST_P(EyeMaskOf, IsDarkAtFirst) {
  const EyeMask mask({3, 2}, GetParam());
  for (const std::byte b : mask.bytes()) EXPECT_EQ(b, std::byte{0});
}

INSTANTIATE_TEST_SUITE_P(Lights, EyeMaskOf, testing::Values(1, 3, 8, 9, 16, 17, 31, 32, 33, 40, 64, 65, 256));

TEST(EyeMask, LiesRowByRowPlaneByPlane) {
  EyeMask mask({2, 2}, 40);
  mask.set_word(1, 0, 0, 0x04030201);
  mask.set_word(0, 1, 1, 0x5a);
  EXPECT_EQ(mask.bytes()[4], std::byte{1});      // little-endian machine: pixel 1 of plane 0
  EXPECT_EQ(mask.bytes()[24], std::byte{0x5a});  // plane 1 begins at 16; its pixel 2
}

TEST(EyeMaskDeathTest, RefusesMoreLightsThanMasksCarry) {
  EXPECT_DEATH(EyeMask({1, 1}, kMaxLights + 1), "kMaxLights");
}

}  // namespace
}  // namespace farshade
