#include "stereo/base/quantile.h"

#include <gtest/gtest.h>

#include <numeric>

namespace farshade {
namespace {

TEST(Quantile, InterpolatesBetweenClosestRanks) {
  EXPECT_DOUBLE_EQ(quantile({4, 1, 3, 2}, 0.5), 2.5);
  EXPECT_DOUBLE_EQ(quantile({1, 2, 3, 4, 5}, 0.25), 2.0);
  EXPECT_DOUBLE_EQ(quantile({10, 20}, 0.9), 19.0);
}

TEST(Quantile, ReachesBothEnds) {
  EXPECT_EQ(quantile({3, 1, 2}, 0.0), 1);
  EXPECT_EQ(quantile({3, 1, 2}, 1.0), 3);
  EXPECT_EQ(quantile({7}, 0.99), 7);
}

TEST(Quantile, IsZeroOfNoValues) {
  EXPECT_EQ(quantile({}, 0.5), 0);
}

TEST(Spread, IsMedianP95AndP99) {
  std::vector<double> values(101);
  std::iota(values.rbegin(), values.rend(), 0.0);
  const Spread spread = spread_of(values);
  EXPECT_EQ(spread.count, 101u);
  EXPECT_DOUBLE_EQ(spread.median, 50);
  EXPECT_DOUBLE_EQ(spread.p95, 95);
  EXPECT_DOUBLE_EQ(spread.p99, 99);
}

}  // namespace
}  // namespace farshade
