#include "stereo/base/check.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <limits>

namespace farshade {
namespace {

TEST(Check, PassesWhatHolds) {
  check(true, "holds");
  check_eq(2 + 2, 4, "sums");
}

TEST(CheckDeathTest, NamesFileAndInvariant) {
  EXPECT_DEATH(check(false, "pigs fly"), "check_test.cpp:[0-9]+: check failed: pigs fly");
}

TEST(CheckDeathTest, PrintsBothValues) {
  EXPECT_DEATH(check_eq(3, 4, "sides agree"), "sides agree: is 3, should be 4");
}

TEST(Narrow, KeepsValuesThatFit) {
  EXPECT_EQ(narrow<std::uint8_t>(255), 255);
  EXPECT_EQ(narrow<std::int8_t>(-128), -128);
  EXPECT_EQ(narrow<std::uint32_t>(std::int64_t{0xffffffff}), 0xffffffffu);
  EXPECT_EQ(narrow<std::int64_t>(std::uint32_t{0xffffffff}), 0xffffffff);
}

TEST(NarrowDeathTest, AbortsWhereTheValueWouldChange) {
  EXPECT_DEATH((void)narrow<std::uint8_t>(256), "narrowing keeps the value: 256");
  EXPECT_DEATH((void)narrow<std::uint32_t>(-1), "narrowing keeps the value: -1");
  EXPECT_DEATH((void)narrow<std::uint64_t>(std::int32_t{-1}), "narrowing");
  EXPECT_DEATH((void)narrow<std::int32_t>(0x80000000u), "narrowing");
  EXPECT_DEATH((void)narrow<std::int64_t>(std::numeric_limits<std::uint64_t>::max()), "narrowing");
}

}  // namespace
}  // namespace farshade
