#include "rt_server/scheduling/quality.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <random>

namespace farshade {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr Duration kInterval = std::chrono::nanoseconds(13'888'889);
constexpr double kFullBytes = 20'400;

/// A client that follows the advice, and a path that takes each frame before the next one is sent.
struct RatedClient {
  Quality quality;
  Time now{};
  double exponent = 1.5;  ///< true bytes of a frame grow with scale^exponent
  double swing = 0;       ///< relative change of the rate, down and up, every 3 s
  double noise = 0;       ///< relative noise of a frame's bytes
  ViewScale scale = kFullViewScale;
  int steps_down = 0, steps_up = 0;
  std::mt19937_64 random{5};  // the seed

  void run(double bytes_per_second, Duration span) {
    for (const Time end = now + span; now < end;) {
      const double phase = std::fmod(seconds_of(now.time_since_epoch()), 3.0) / 3;
      const double rate = bytes_per_second * (1 - swing + 1.6 * swing * phase);
      const double bytes = kFullBytes * std::pow(factor_of(scale), exponent) *
                           (1 + noise * std::uniform_real_distribution<>(-1, 1)(random));
      quality.packed(static_cast<std::size_t>(bytes), scale, rate, kInterval, now);
      steps_down += quality.view_scale() < scale;
      steps_up += quality.view_scale() > scale;
      EXPECT_LE(std::abs(static_cast<int>(quality.view_scale().eighths) - static_cast<int>(scale.eighths)),
                1);
      scale = quality.view_scale();
      now += std::max<Duration>(kInterval, duration_from_ms(1e3 * bytes / rate));
    }
  }
};

/// The rate that carries a full frame in four intervals.
const double kFourIntervals = kFullBytes / (4 * seconds_of(kInterval));

TEST(Quality, SlowerPathLowersTheMaskRateFirst) {
  RatedClient client;
  client.run(1.05 * kFourIntervals, seconds(60));
  EXPECT_EQ(client.scale, kFullViewScale);
}

TEST(Quality, SizeFollowsWhenTheMaskRateIsAtItsLeast) {
  RatedClient client;
  client.run(0.5 * kFourIntervals, seconds(20));
  EXPECT_EQ(client.scale, ViewScale{5});  // (5/8)^1.5 = 0.494
  EXPECT_EQ(client.steps_up, 0);
}

TEST(Quality, WorstPathEndsAtTheLeastSize) {
  RatedClient client;
  client.run(25e3, seconds(30));
  EXPECT_EQ(client.scale, Quality::kLeast);
}

TEST(Quality, ConstantPathNeverSwings) {
  for (const double exponent : {1.0, 1.5, 2.0})
    for (const double swing : {0.0, 0.15})
      for (double rate = 0.05; rate < 1.6; rate *= 1.03) {
        SCOPED_TRACE(testing::Message()
                     << "seed 5, exponent " << exponent << " swing " << swing << " rate " << rate);
        RatedClient client;
        client.exponent = exponent;
        client.swing = swing;
        client.noise = 0.1;
        client.run(rate * kFourIntervals, seconds(120));
        EXPECT_EQ(client.steps_up, 0);
      }
}

TEST(Quality, FullSizeIsBackSoonAfterThePath) {
  RatedClient client;
  client.run(25e3, seconds(30));
  ASSERT_EQ(client.scale, Quality::kLeast);
  const Time opened = client.now;
  while (client.scale < kFullViewScale && client.now - opened < seconds(20)) client.run(6.25e6, kInterval);
  std::printf("back at full size after %.2f s\n", seconds_of(client.now - opened));
  EXPECT_LT(client.now - opened, milliseconds(3500));
}

TEST(Quality, ShortDipChangesNothing) {
  RatedClient client;
  client.run(2 * kFourIntervals, seconds(5));
  client.run(0.7 * kFourIntervals, milliseconds(400));
  client.run(2 * kFourIntervals, seconds(5));
  EXPECT_EQ(client.steps_down, 0);
}

}  // namespace
}  // namespace farshade
