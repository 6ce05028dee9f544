#include "stereo/net/path_mtu.h"

#include <gtest/gtest.h>

#include <deque>
#include <map>
#include <random>

#include "stereo/net/arrivals.h"
#include "tests/support/sanitized.h"

namespace farshade {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t kSmall_bytes = 125;
constexpr Duration kFrameTime = 14ms;

/// A session at 72 Hz, unless `frame_time` says otherwise, over a path of 20 ms each way. A frame has 16
/// datagrams as large as they may be, and a small one. Every frame the client reports what has arrived.
struct ProbedPath {
  std::size_t most_bytes = kMaxDatagram_bytes;  ///< the path drops longer datagrams
  double loss = 0;
  std::size_t large_in_frame = 16;
  bool is_dead = false;
  Duration jitter{};  ///< delays are longer by up to this
  Duration frame_time = kFrameTime;

  void run(Duration span) {
    for (const Time until = now + span; now < until;) frame();
  }
  void frame() {
    for (auto at = arrived.begin(); at != arrived.end() && at->first <= now; at = arrived.erase(at))
      arrivals.add(at->second, at->first);
    reports.push_back({now + 20ms, arrivals.report()});
    while (!reports.empty() && reports.front().at <= now) {
      mtu.take(reports.front().report, now);
      reports.pop_front();
    }
    if (const auto size = mtu.next_probe(now)) {
      probes.push_back(*size);
      mtu.probed(counter, now);
      carry(*size);
    }
    for (std::size_t i = 0; i < large_in_frame; ++i) send(mtu.bytes() - i);
    send(kSmall_bytes);
    now += frame_time;
  }
  void send(std::size_t bytes) {
    mtu.sent(counter, bytes);
    carry(bytes);
  }
  void carry(std::size_t bytes) {
    const bool lost = is_dead || bytes > most_bytes || chance(random) < loss;
    if (!lost)
      arrived.emplace(
          now + 20ms + Duration(jitter.count() * static_cast<Duration::rep>(random() % 1000) / 1000),
          counter);
    ++counter;
  }

  struct Report {
    Time at;
    ArrivalReport report;
  };
  PathMtu mtu{};
  Time now{};
  std::uint64_t counter = 0;
  std::mt19937_64 random{7};
  std::uniform_real_distribution<double> chance{0, 1};
  Arrivals arrivals{};
  std::multimap<Time, std::uint64_t> arrived{};
  std::deque<Report> reports{};
  std::vector<std::size_t> probes{};  ///< their sizes
};

TEST(PathMtu, BeginsAtTheBaseAndProbesNothingBeforeAnArrival) {
  ProbedPath path;
  path.is_dead = true;
  path.run(30s);
  EXPECT_EQ(path.mtu.bytes(), 1200u);
  EXPECT_EQ(path.mtu.state(), PathMtu::State::Base);
  EXPECT_TRUE(path.probes.empty());
}

TEST(PathMtu, FindsTheLargestSizeThatThePathCarries) {
  for (std::size_t i = 0; i < PathMtu::kSizes.size(); ++i) {
    const std::size_t size = PathMtu::kSizes[i];
    for (const std::size_t most : {size, size + 7}) {
      ProbedPath path{.most_bytes = most};
      path.run(5s);
      EXPECT_EQ(path.mtu.bytes(), size) << most;
      EXPECT_EQ(path.mtu.state(), PathMtu::State::Complete) << most;
      const bool is_last = i + 1 == PathMtu::kSizes.size();
      EXPECT_EQ(path.probes.size(), i + (is_last ? 0 : PathMtu::kMostProbes)) << most;
    }
  }
}

TEST(PathMtu, ASizeIsUsedARoundTripAfterItsProbe) {
  ProbedPath path;
  path.run(10 * kFrameTime);
  EXPECT_GE(path.mtu.bytes(), PathMtu::kSizes[1]);
  path.run(250ms);
  EXPECT_EQ(path.mtu.bytes(), kMaxDatagram_bytes);
}

TEST(PathMtu, ALateArrivalOfAnEarlierProbeCounts) {
  PathMtu mtu;
  mtu.sent(0, 100);
  mtu.take({.count = 1}, Time(0s));
  ASSERT_EQ(mtu.next_probe(Time(0s)), 1372u);
  mtu.probed(1, Time(0s));
  EXPECT_EQ(mtu.next_probe(Time(999ms)), std::nullopt);
  ASSERT_EQ(mtu.next_probe(Time(1s)), 1372u);
  mtu.probed(2, Time(1s));
  mtu.take({.first = 1, .count = 1}, Time(1100ms));
  EXPECT_EQ(mtu.bytes(), 1372u);
}

TEST(PathMtu, AProbeThatARequestReportsAsMissingDoesNotCount) {
  PathMtu mtu;
  mtu.sent(0, 100);
  mtu.take({.count = 1}, Time(0s));
  ASSERT_TRUE(mtu.next_probe(Time(0s)));
  mtu.probed(1, Time(0s));
  mtu.sent(2, 100);
  ArrivalReport report{.first = 1, .count = 2};
  report.ticks[0] = ArrivalReport::kNotArrived;
  mtu.take(report, Time(50ms));
  EXPECT_EQ(mtu.bytes(), 1200u);
}

TEST(PathMtu, TriesALargerSizeAgainAfterTenMinutes) {
  ProbedPath path{.most_bytes = 1400};
  path.run(5s);
  ASSERT_EQ(path.mtu.bytes(), 1372u);
  const std::size_t before = path.probes.size();
  path.most_bytes = 1500;
  path.run(PathMtu::kRaiseTimer - 10s);
  EXPECT_EQ(path.probes.size(), before);
  path.run(10s);
  EXPECT_EQ(path.mtu.bytes(), kMaxDatagram_bytes);
}

TEST(PathMtu, ABlackHoleInMidSessionEndsLargeDatagrams) {
  for (const std::size_t large : {std::size_t{2}, std::size_t{16}, std::size_t{60}})
    for (const std::size_t most : {std::size_t{1200}, std::size_t{1400}, std::size_t{1460}}) {
      ProbedPath path{.most_bytes = 1500, .large_in_frame = large};
      path.run(5s);
      ASSERT_EQ(path.mtu.bytes(), kMaxDatagram_bytes);
      path.most_bytes = most;
      Duration took{};
      for (; path.mtu.bytes() != 1200 && took < 5s; took += kFrameTime) path.frame();
      std::printf("%zu large datagrams a frame, path of %zu bytes: back at 1,200 after %.0f ms\n", large,
                  most, ms_of(took));
      EXPECT_LE(took, 700ms) << large << " " << most;
      EXPECT_EQ(path.mtu.state(), PathMtu::State::Base);
      path.run(PathMtu::kAfterBlackHole - 100ms);
      EXPECT_EQ(path.mtu.bytes(), 1200u);
      path.run(5s);
      EXPECT_EQ(path.mtu.state(), PathMtu::State::Complete);
      EXPECT_EQ(path.mtu.bytes(), most < 1372 ? 1200u : most < 1444 ? 1372u : 1444u);
    }
}

/// A client that asks seldom: what was lost in the first black hole is among the datagrams that are examined
/// when the path is found to carry larger ones again.
TEST(PathMtu, ABlackHoleThatIsOverIsNotFoundAgain) {
  ProbedPath path{.large_in_frame = 3, .frame_time = 100ms};
  path.run(5s);
  ASSERT_EQ(path.mtu.bytes(), kMaxDatagram_bytes);
  path.most_bytes = 1300;
  path.run(3s);
  ASSERT_EQ(path.mtu.bytes(), 1200u);
  path.most_bytes = 1500;
  path.run(PathMtu::kAfterBlackHole);
  EXPECT_EQ(path.mtu.bytes(), kMaxDatagram_bytes);
  EXPECT_EQ(path.mtu.black_holes(), 1u);
}

TEST(PathMtu, APathThatOftenTurnsIntoABlackHoleIsSearchedLessOften) {
  ProbedPath path;
  for (int hole = 0; hole < 12; ++hole) {
    path.most_bytes = 1500;
    for (Duration waited{}; path.mtu.bytes() != kMaxDatagram_bytes && waited < 11min; waited += kFrameTime)
      path.frame();
    ASSERT_EQ(path.mtu.bytes(), kMaxDatagram_bytes);
    path.most_bytes = 1300;
    path.run(1s);
    ASSERT_EQ(path.mtu.bytes(), 1200u);
  }
  EXPECT_GT(path.now, Time(50min)) << "10 s, 20 s, 40 s, ... and 10 min from the seventh on";
  EXPECT_LT(path.now, Time(80min));
}

TEST(PathMtu, RandomLossIsNoBlackHole) {
  for (std::uint64_t seed = 1; seed <= (kSanitized ? 1 : 5); ++seed) {
    ProbedPath path;
    path.random.seed(seed);
    path.run(5s);
    path.loss = 0.25;
    path.run(30min);
    EXPECT_EQ(path.mtu.bytes(), kMaxDatagram_bytes) << seed;
    EXPECT_EQ(path.mtu.black_holes(), 0u) << seed;
  }
}

TEST(PathMtu, LateDatagramsAreNoBlackHole) {
  for (const Duration jitter : {30ms, 100ms, 200ms}) {
    ProbedPath path;
    path.run(5s);
    path.loss = 0.25;
    path.jitter = jitter;
    path.run(kSanitized ? 2min : 10min);
    EXPECT_EQ(path.mtu.black_holes(), 0u) << ms_of(jitter);
  }
}

TEST(PathMtu, AnOutageIsNoBlackHole) {
  ProbedPath path;
  path.run(5s);
  for (int i = 0; i < 20; ++i) {
    path.is_dead = true;
    path.run(2s);
    path.is_dead = false;
    path.run(3s);
    EXPECT_EQ(path.mtu.bytes(), kMaxDatagram_bytes);
  }
}

/// Whoever holds the key may report anything.
TEST(PathMtu, ReportsOfWhatWasNeverSentChangeNothing) {
  PathMtu mtu;
  std::mt19937_64 random(3);
  for (int i = 0; i < 2000; ++i) {
    ArrivalReport report{.first = random() >> (1 + random() % 63), .count = 256};
    mtu.take(report, Time(i * 10s));
    EXPECT_EQ(mtu.next_probe(Time(i * 10s)), std::nullopt);
  }
  EXPECT_EQ(mtu.bytes(), 1200u);
}

TEST(PathMtu, SkippedCountersAreNeitherLostNorArrived) {
  PathMtu mtu;
  std::uint64_t counter = 1'000'000;
  mtu.sent(counter, 100);
  mtu.take({.first = counter, .count = 1}, Time(0s));
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(mtu.next_probe(Time(0s)));
    mtu.probed(++counter, Time(0s));
    mtu.take({.first = counter, .count = 1}, Time(0s));
  }
  ASSERT_EQ(mtu.bytes(), kMaxDatagram_bytes);
  for (int i = 0; i < 200; ++i) {
    counter += 10;
    mtu.sent(counter, 100);
    mtu.take({.first = counter - 9, .count = 10}, Time(1s));
  }
  EXPECT_EQ(mtu.bytes(), kMaxDatagram_bytes);
}

}  // namespace
}  // namespace farshade
