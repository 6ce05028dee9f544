// The server's datagrams grow to what the path to the client carries, and shrink when the path does.
#include <gtest/gtest.h>

#include "stereo/net/path_mtu.h"
#include "tests/support/sanitized.h"
#include "tests/unit/link/link_bench.h"

namespace farshade {
namespace {

using namespace link_test;

/// Notes the server's longest datagram, and loses those longer than `most_bytes`.
struct PathBench : ConnectedBench {
  explicit PathBench(const LinkModel& to_client = {.delay = kWay})
      : ConnectedBench({.to_server = {.delay = kWay}, .to_client = to_client}) {
    on_answer = [this](std::span<const std::byte> bytes) {
      longest = std::max(longest, bytes.size());
      return bytes.size() > most_bytes;
    };
  }
  /// The share of masks that arrive whole, of those requested in `time`, and the longest datagram.
  double whole_in(Duration time) {
    longest = 0;
    int whole = 0, all = 0;
    for (const Time until = clock.now() + time; clock.now() < until; ++all) {
      run(kInterval);
      const Time patience = clock.now() + 200ms;
      while (!link.receiver().is_whole({frame}) && clock.now() < patience) pass(1ms);
      whole += link.receiver().is_whole({frame}) ? 1 : 0;
    }
    return static_cast<double>(whole) / all;
  }
  /// The rate that the newest report names, in bytes per second. The newest mask may have come without its
  /// report.
  [[nodiscard]] double newest_rate() const {
    for (std::uint32_t f = frame; f > 0; --f)
      if (const auto* got = link.receiver().find({f}); got != nullptr && got->report)
        return got->report->bytes_per_second;
    return 0;
  }
  std::size_t most_bytes = kMaxDatagram_bytes, longest = 0;
};

/// The virtual link's addresses are those of IPv6, whose headers with UDP's take 48 bytes.
TEST(LinkPathMtu, DatagramsGrowToWhatThePathCarries) {
  const std::vector<std::pair<std::size_t, std::size_t>> all{
      {1280, 1200}, {1419, 1200}, {1420, 1372}, {1500, 1444}, {1520, 1472}};
  for (const auto& [mtu, carried] : kSanitized ? std::vector{all[1], all[3]} : all) {
    PathBench bench({.delay = kWay, .mtu_bytes = mtu});
    bench.run(10s);
    EXPECT_EQ(bench.whole_in(1s), 1) << mtu;
    EXPECT_LE(bench.longest, carried) << mtu;
    EXPECT_GT(bench.longest, carried - 140) << mtu;
    const auto size = std::ranges::find(PathMtu::kSizes, carried);
    EXPECT_EQ(bench.server->counters().sessions.widened,
              static_cast<std::uint64_t>(size - PathMtu::kSizes.begin()));
  }
}

TEST(LinkPathMtu, MasksAreWholeAgainSoonAfterThePathHasShrunk) {
  PathBench bench;
  bench.run(5s);
  ASSERT_EQ(bench.whole_in(500ms), 1);
  ASSERT_GT(bench.longest, 1400u);
  bench.most_bytes = 1400;
  bench.run(1s);
  EXPECT_EQ(bench.server->counters().sessions.black_holes, 1u);
  EXPECT_EQ(bench.whole_in(5s), 1);
  EXPECT_LE(bench.longest, kBaseDatagram_bytes);
  bench.run(10s);
  EXPECT_EQ(bench.whole_in(1s), 1);
  EXPECT_LE(bench.longest, 1372u);
  EXPECT_GT(bench.longest, 1372u - 140);
}

/// The losses of probes are not those of a path that is too slow.
TEST(LinkPathMtu, LostProbesDoNotLowerTheRate) {
  PathBench bench({.delay = kWay, .mtu_bytes = 1280});
  bench.run(200ms);
  const double before = bench.newest_rate();
  bench.run(4s);
  EXPECT_GT(before, 0);
  EXPECT_GE(bench.newest_rate(), before);
}

}  // namespace
}  // namespace farshade
