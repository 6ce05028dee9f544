#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <vector>

#include "stereo/net/impairment.h"

namespace farshade {
namespace {

using namespace std::chrono_literals;
constexpr int kCount = 20'000;
constexpr std::size_t kSize = 8;

struct Arrival {
  Time time;
  int number;
  std::array<std::byte, kSize> bytes;
  friend bool operator==(const Arrival&, const Arrival&) = default;
};

std::array<std::byte, kSize> numbered(int number) {
  std::array<std::byte, kSize> bytes{};
  for (std::size_t i = 0; i < 4; ++i) bytes[i] = static_cast<std::byte>(number >> (8 * i));
  return bytes;
}

struct Outcome {
  std::vector<Arrival> received;
  ImpairmentCounters counters;
  [[nodiscard]] std::vector<bool> came() const {
    std::vector<bool> result(kCount, false);
    for (const Arrival& arrival : received) result[static_cast<std::size_t>(arrival.number)] = true;
    return result;
  }
};

/// `count` numbered datagrams at intervals of `apart`.
Outcome run(const LinkModel& model, int count = kCount, Duration apart = 1ms) {
  Impairment path(model, Time{});
  Outcome result;
  const auto hear_until = [&](Time now) {
    for (const InTransit* item; (item = path.front()) != nullptr && item->arrival <= now; path.pop()) {
      Arrival arrival{item->arrival, 0, {}};
      std::ranges::copy(item->bytes(), arrival.bytes.begin());
      for (std::size_t i = 0; i < 4; ++i) arrival.number |= std::to_integer<int>(arrival.bytes[i]) << (8 * i);
      result.received.push_back(arrival);
    }
  };
  for (int i = 0; i < count; ++i) {
    hear_until(Time(i * apart));
    EXPECT_TRUE(path.push(Time(i * apart), {}, numbered(i)));
  }
  hear_until(Time::max());
  result.counters = path.counters();
  return result;
}

/// Expects a share of independent cases within four standard deviations.
void expect_share(std::uint64_t happened, double share) {
  const double deviation = std::sqrt(share * (1 - share) / kCount);
  EXPECT_NEAR(static_cast<double>(happened) / kCount, share, 4 * deviation);
}

TEST(Impairment, SameSeedSameRun) {
  LinkModel model = parse_link_model("hostile,burst=3,corrupt=5%,reorder=5%,rate=1Mbit,seed=42").value();
  const Outcome first = run(model), again = run(model);
  EXPECT_EQ(first.received, again.received);
  EXPECT_EQ(first.counters, again.counters);
  model.seed = 43;
  EXPECT_NE(run(model).received, first.received);
}

TEST(Impairment, StreamsOfOneSeedDiffer) {
  Impairment a({.jitter = 1s}, Time{}, 0), b({.jitter = 1s}, Time{}, 1);
  a.push(Time{}, {}, {});
  b.push(Time{}, {}, {});
  EXPECT_NE(a.front()->arrival, b.front()->arrival);
}

TEST(Impairment, NothingHappensWithoutAModel) {
  const Outcome sound = run({});
  ASSERT_EQ(sound.received.size(), std::size_t{kCount});
  for (int i = 0; i < kCount; ++i)
    ASSERT_EQ(sound.received[static_cast<std::size_t>(i)], (Arrival{Time(i * 1ms), i, numbered(i)}));
  EXPECT_EQ(sound.counters, ImpairmentCounters{});
}

TEST(Impairment, LosesItsShareIndependently) {
  const Outcome lossy = run({.loss = 0.05});
  expect_share(lossy.counters.lost, 0.05);
  EXPECT_EQ(lossy.received.size(), kCount - lossy.counters.lost);
  const std::vector<bool> came = lossy.came();
  std::uint64_t pairs = 0;
  for (std::size_t i = 1; i < came.size(); ++i) pairs += !came[i] && !came[i - 1] ? 1 : 0;
  expect_share(pairs, 0.05 * 0.05);
}

// A two-state chain in which one step correlates by c = 1 - p - r: the number of losses of n datagrams has
// variance n s (1 - s) (1 + c) / (1 - c). Burst lengths are geometric with variance (1 - r) / r^2 each; there
// are about n s r bursts.
TEST(Impairment, LosesInBurstsOfTheMeanLength) {
  for (const double burst : {3.0, 8.0}) {
    const double share = 0.05, r = 1 / burst, c = 1 - share * r / (1 - share) - r;
    const Outcome lossy = run({.loss = share, .burst = burst});
    const double deviation = std::sqrt(share * (1 - share) * (1 + c) / (1 - c) / kCount);
    EXPECT_NEAR(static_cast<double>(lossy.counters.lost) / kCount, share, 4 * deviation) << burst;
    const std::vector<bool> came = lossy.came();
    double bursts = 0;
    for (std::size_t i = 1; i < came.size(); ++i) bursts += !came[i] && came[i - 1] ? 1 : 0;
    const double mean = static_cast<double>(lossy.counters.lost) / bursts;
    EXPECT_NEAR(mean, burst, 4 * std::sqrt((1 - r) / (r * r) / (kCount * share * r)));
  }
}

TEST(Impairment, LosesAllWhereNothingGetsThrough) {
  for (const double burst : {1.0, 8.0}) EXPECT_TRUE(run({.loss = 1, .burst = burst}).received.empty());
}

TEST(Impairment, DelaysItsShare) {
  const Outcome held = run({.delay = 5ms, .reorder = 0.3, .reorder_by = 2500us});
  expect_share(held.counters.reordered, 0.3);
  std::uint64_t late = 0, overtaken = 0;
  for (std::size_t i = 0; i < held.received.size(); ++i) {
    const Duration travelled = held.received[i].time - Time(held.received[i].number * 1ms);
    EXPECT_TRUE(travelled == 5ms || travelled == 7500us);
    late += travelled == 7500us ? 1 : 0;
    overtaken += i > 0 && held.received[i].number < held.received[i - 1].number ? 1 : 0;
  }
  EXPECT_EQ(late, held.counters.reordered);
  EXPECT_GT(overtaken, late / 4) << "the next two datagrams were seldom late, too";
}

TEST(Impairment, DuplicatesItsShare) {
  const Outcome twice = run({.jitter = 500us, .duplicate = 0.25});
  expect_share(twice.counters.duplicated, 0.25);
  std::map<int, std::vector<Duration>> travelled;
  for (const Arrival& arrival : twice.received) {
    travelled[arrival.number].push_back(arrival.time - Time(arrival.number * 1ms));
    EXPECT_LT(travelled[arrival.number].back(), 500us);
    EXPECT_EQ(arrival.bytes, numbered(arrival.number));
  }
  EXPECT_EQ(travelled.size(), std::size_t{kCount});
  EXPECT_EQ(twice.received.size(), kCount + twice.counters.duplicated);
  std::uint64_t doubled = 0, apart = 0;
  for (const auto& [number, times] : travelled) {
    doubled += times.size() == 2 ? 1 : 0;
    apart += times.back() - times.front() > 100us ? 1 : 0;
  }
  EXPECT_EQ(doubled, twice.counters.duplicated);
  expect_share(apart, 0.25 * 0.8 * 0.8);  // the difference of two draws exceeds a fifth
}

TEST(Impairment, FlipsOneBitOfItsShare) {
  const Outcome corrupted = run({.corrupt = 0.3});
  expect_share(corrupted.counters.corrupted, 0.3);
  std::array<int, 8 * kSize> flipped{};
  std::uint64_t faulty = 0;
  for (std::size_t i = 0; i < corrupted.received.size(); ++i) {
    const auto sound = numbered(static_cast<int>(i));
    int bits = 0;
    for (std::size_t bit = 0; bit < 8 * kSize; ++bit) {
      const std::byte change = sound[bit / 8] ^ corrupted.received[i].bytes[bit / 8];
      if ((change >> (bit % 8) & std::byte{1}) == std::byte{0}) continue;
      ++bits;
      ++flipped[bit];
    }
    ASSERT_LE(bits, 1);
    faulty += bits == 1 ? 1 : 0;
  }
  EXPECT_EQ(faulty, corrupted.counters.corrupted);
  const double share = 0.3 / (8 * kSize);
  for (const int times : flipped) expect_share(static_cast<std::uint64_t>(times), share);
}

TEST(Impairment, DropsPacketsThatAreTooLongForItsFamily) {
  const Peer v6{{0x20, 0x01, 0x0d, 0xb8}, 0, 1},
      v4{{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xff, 0xff, 192, 0, 2, 1}, 0, 1};
  for (const auto& [peer, most] : {std::pair{v6, std::size_t{1352}}, std::pair{v4, std::size_t{1372}}}) {
    Impairment path({.mtu_bytes = 1400}, Time{});
    const std::vector<std::byte> longest(most), longer(most + 1);
    EXPECT_TRUE(path.push(Time{}, peer, longer)) << "no error tells the sender";
    EXPECT_EQ(path.front(), nullptr);
    EXPECT_TRUE(path.push(Time{}, peer, longest));
    ASSERT_NE(path.front(), nullptr);
    EXPECT_EQ(path.front()->size, most);
    EXPECT_EQ(path.counters().too_long, 1u);
  }
}

TEST(Impairment, OneRateLeavesTheOthersAlone) {
  const std::string base = "delay=1ms,jitter=20ms,loss=10%";
  const Outcome all = run(parse_link_model(base).value(), 2000);
  const auto with = [&](const char* more) { return run(parse_link_model(base + more).value(), 2000); };
  const auto unchanged = [&](const Outcome& other) {
    return static_cast<std::size_t>(std::ranges::count_if(all.received, [&](const Arrival& each) {
      return std::ranges::find(other.received, each) != other.received.end();
    }));
  };
  const Outcome lossy = with(",loss=50%"), silent = with(",silence=100ms/300ms"),
                twice = with(",duplicate=50%");
  const Outcome corrupted = with(",corrupt=50%"), held = with(",reorder=50%");
  EXPECT_LT(lossy.received.size(), all.received.size());
  EXPECT_EQ(unchanged(lossy), lossy.received.size());
  EXPECT_LT(silent.received.size(), all.received.size());
  EXPECT_EQ(unchanged(silent), silent.received.size());
  EXPECT_EQ(unchanged(twice), all.received.size());
  EXPECT_EQ(unchanged(corrupted), all.received.size() - corrupted.counters.corrupted);
  EXPECT_EQ(unchanged(held), all.received.size() - held.counters.reordered);
}

// 8 bytes at 1,000 bytes/s: a datagram leaves every 8 ms. A queue of 100 ms holds 12.5 datagrams.
TEST(Impairment, BottleneckPassesItsRateAndDropsBeyondItsQueue) {
  const Outcome narrow = run({.delay = 3ms, .rate_bytes_per_s = 1000, .queue = 100ms}, 1000);
  ASSERT_EQ(narrow.received.front().time, Time(8ms + 3ms));
  for (std::size_t i = 1; i < narrow.received.size(); ++i) {
    ASSERT_EQ(narrow.received[i].time - narrow.received[i - 1].time, 8ms);
    ASSERT_GT(narrow.received[i].number, narrow.received[i - 1].number);
    const Duration travelled = narrow.received[i].time - Time(narrow.received[i].number * 1ms);
    ASSERT_LE(travelled, 100ms + 8ms + 3ms);
  }
  EXPECT_EQ(narrow.received.size() + narrow.counters.overflowed, 1000u);
  EXPECT_NEAR(static_cast<double>(narrow.received.size()), 1000 / 8.0 + 100 / 8.0, 2);
}

// The model loses a datagram after the bottleneck, where it has already used time and queue space.
TEST(Impairment, LostDatagramsUseTheBottleneck) {
  const LinkModel narrow{.delay = 3ms, .rate_bytes_per_s = 4000, .queue = 100ms};
  LinkModel lossy = narrow;
  lossy.loss = 0.5;
  const Outcome all = run(narrow, 1000), some = run(lossy, 1000);
  EXPECT_EQ(some.counters.overflowed, all.counters.overflowed);
  EXPECT_LT(some.received.size(), all.received.size());
  for (const Arrival& each : some.received)
    EXPECT_NE(std::ranges::find(all.received, each), all.received.end());
}

TEST(Impairment, BottleneckWithinItsRateOnlyTakesItsTime) {
  const Outcome wide = run({.rate_bytes_per_s = 16'000}, 1000);
  EXPECT_EQ(wide.counters, ImpairmentCounters{});
  for (const Arrival& arrival : wide.received) EXPECT_EQ(arrival.time, Time(arrival.number * 1ms + 500us));
}

TEST(Impairment, SilenceIsTheEndOfEveryPeriod) {
  const Outcome silent = run({.silence = 2s, .silence_every = 5s});
  const std::vector<bool> came = silent.came();
  for (std::size_t i = 0; i < came.size(); ++i) ASSERT_EQ(came[i], i % 5000 < 3000) << i << " ms";
  EXPECT_EQ(silent.counters.lost, kCount * 2u / 5);
}

TEST(Impairment, SameInstantKeepsTheOrder) {
  const Outcome together = run({.delay = 4ms}, 1000, 0ms);
  for (int i = 0; i < 1000; ++i) EXPECT_EQ(together.received[static_cast<std::size_t>(i)].bytes, numbered(i));
}

TEST(Impairment, IsBounded) {
  Impairment path({.duplicate = 1}, Time{});
  for (std::size_t i = 0; i < kLinkCapacity / 2; ++i) EXPECT_TRUE(path.push(Time{}, {}, numbered(0)));
  EXPECT_FALSE(path.push(Time{}, {}, numbered(0)));
  EXPECT_EQ(path.counters().overflowed, 1u);
  std::size_t in_transit = 0;
  for (; path.front() != nullptr; path.pop()) ++in_transit;
  EXPECT_EQ(in_transit, kLinkCapacity);
  EXPECT_TRUE(path.push(Time{}, {}, numbered(0)));
}

TEST(LinkModelParse, ReadsEveryWord) {
  const Expected<LinkModel> model = parse_link_model(
      "loss=2%,burst=3,delay=25ms,jitter=500us,reorder=2%,reorder_by=0.01s,duplicate=1%,corrupt=0.5%,"
      "rate=10Mbit,queue=50ms,mtu=1400,silence=2s/5s,seed=7");
  ASSERT_TRUE(model.has_value()) << model.error().what;
  const LinkModel expected{.delay = 25ms,
                           .jitter = 500us,
                           .loss = 0.02,
                           .burst = 3,
                           .reorder = 0.02,
                           .reorder_by = 10ms,
                           .duplicate = 0.01,
                           .corrupt = 0.005,
                           .rate_bytes_per_s = 1.25e6,
                           .queue = 50ms,
                           .mtu_bytes = 1400,
                           .silence = 2s,
                           .silence_every = 5s,
                           .seed = 7};
  EXPECT_EQ(*model, expected);
}

TEST(LinkModelParse, KnowsNamesAndWhatOverridesThem) {
  for (const NamedNetwork& network : kNetworks) {
    const Expected<LinkModel> model = parse_link_model(network.name);
    ASSERT_TRUE(model.has_value()) << network.name;
    EXPECT_EQ(*model, network.model) << network.name;
  }
  LinkModel poor = parse_link_model("poor").value();
  EXPECT_EQ(poor.loss, 0.05);
  EXPECT_EQ(poor.delay + poor.jitter / 2, 50ms);
  poor.rate_bytes_per_s = 500e3;
  EXPECT_EQ(parse_link_model("poor,rate=4Mbit").value(), poor);
}

TEST(LinkModelParse, NamesTheBadWordAndWhatThereIs) {
  for (const char* word : {"los=2%",
                           "pour",
                           "loss",
                           "loss=",
                           "loss=2",
                           "loss=2%x",
                           "loss=%",
                           "delay=25",
                           "delay=25m",
                           "burst=3%",
                           "rate=10",
                           "rate=10mbit",
                           "silence=2s",
                           "silence=/",
                           "mtu=1400bytes",
                           "mtu=1400.5",
                           "seed=-1",
                           "seed=1.5",
                           "seed=18446744073709551616",
                           "wifi",
                           "=",
                           ""}) {
    const Expected<LinkModel> model = parse_link_model("delay=1ms," + std::string(word));
    ASSERT_FALSE(model.has_value()) << word;
    EXPECT_EQ(model.error().fault, Fault::Malformed) << word;
    for (const std::string& part :
         {"'" + std::string(word) + "'", std::string("wifi"), std::string("burst=3")})
      EXPECT_NE(model.error().what.find(part), std::string::npos) << word << ": " << model.error().what;
  }
  EXPECT_FALSE(parse_link_model("").has_value());
  EXPECT_FALSE(parse_link_model("poor,").has_value());
}

TEST(LinkModelParse, RefusesValuesThatMeanNothing) {
  for (const char* word :
       {"loss=101%", "loss=-1%", "loss=nan%", "loss=inf%", "burst=0.5", "burst=1e9", "delay=-1ms",
        "delay=61s", "jitter=1e300s", "rate=0kbit", "rate=1e9Gbit", "mtu=575", "mtu=65536",
        "mtu=99999999999999999999", "silence=5s/2s", "silence=0s/0s", "silence=1s/1e9s"}) {
    const Expected<LinkModel> model = parse_link_model(word);
    ASSERT_FALSE(model.has_value()) << word;
    EXPECT_EQ(model.error().fault, Fault::OutOfRange) << word;
    EXPECT_NE(model.error().what.find("'" + std::string(word) + "'"), std::string::npos)
        << model.error().what;
  }
}

}  // namespace
}  // namespace farshade
