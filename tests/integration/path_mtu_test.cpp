// A real server and a real client on machines of their own, joined by cables that carry packets of some
// length. A virtual cable drops longer packets without an error, as a router without ICMP does.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <optional>
#include <regex>

#include "stereo/base/clock.h"
#include "tests/integration/client_program.h"
#include "tests/integration/machine.h"
#include "tests/integration/test_keys.h"
#include "tests/unit/scratch_folder.h"

namespace farshade {
namespace {

/// Ethernet packets may be 4 bytes longer than the interface's mtu, since a VLAN's tag could be among them.
struct Cable {
  int at_server = 1500, at_client = 1500;
};

/// For what the server counts sooner or later. With sanitizers and beside other tests, the client draws some
/// 2 frames a second.
constexpr Duration kPatience = std::chrono::seconds(200);
const std::string kEndless = "1000000";  ///< frames: a test ends its client

class PathMtuPrograms : public testing::Test {
 protected:
  void SetUp() override {
    if (const std::string why = missing_for_machines(); !why.empty()) GTEST_SKIP() << why;
    join(desk_.emplace(), head_.emplace());
    server_.emplace(desk_->here({RT_SERVER, "--scene", kRoom, "--listen", "192.0.2.2:7447", "--keys",
                                 test_keys().ring, "--no-announce"}));
    ASSERT_TRUE(server_->line_after("rt_server: listening on ")) << server_->errors();
  }
  void set(const Cable& cable) {
    desk_->shell("ip link set cable mtu " + std::to_string(cable.at_server));
    head_->shell("ip link set cable mtu " + std::to_string(cable.at_client));
  }
  std::unique_ptr<ChildProgram> start_client(std::map<std::string, std::string> options) {
    options.insert({{"--server", "192.0.2.2:7447"},
                    {"--ask", "whole"},
                    {"--reference-every", "0"},
                    {"--pictures", "0"},
                    {"--out", (folder_.path() / "out").string()}});
    return std::make_unique<ChildProgram>(head_->here(client_arguments(options)));
  }
  /// The server's line of counters.
  std::string counters() {
    server_->send(SIGUSR1);
    auto line = server_->line_after("rt_server: ");
    while (line && line->find(" clients, ") == line->npos) line = server_->line_after("rt_server: ");
    return line.value_or("");
  }
  static long number_before(const std::string& words, const std::string& line) {
    std::smatch found;
    return std::regex_search(line, found, std::regex("(\\d+) " + words)) ? std::stol(found[1]) : 0;
  }
  /// Waits until the number before `words` is `least` or more. False: it is not after kPatience.
  bool counts_to(const std::string& words, long least) {
    const Stopwatch waited;
    while (number_before(words, counters()) < least) {
      if (waited.elapsed() > kPatience) return false;
      usleep(50'000);
    }
    return true;
  }
  /// The number of datagrams for a kilobyte of answers, in those 20 successive answers of a run in which it
  /// is least: on a busy machine the server may take datagrams that are late for lost, and send shorter ones
  /// for some seconds. The run ends 30 frames after the server has counted `more` of `words`.
  double datagrams_over(const Cable& cable, const std::string& words = "frames", long more = 1) {
    constexpr std::size_t kJudged = 20;
    set(cable);
    const long before = number_before(words, counters());
    const auto client = start_client({{"--size", "256x256"}, {"--frames", kEndless}});
    EXPECT_TRUE(counts_to(words, before + more)) << counters();
    EXPECT_TRUE(counts_to("frames", number_before("frames", counters()) + long{kJudged} + 30)) << counters();
    client->send(SIGINT);
    const std::string errors = client->errors();
    EXPECT_EQ(client->wait(), 130) << errors;
    const Csv frames = read_csv(folder_.path() / "out" / "frames.csv");
    const std::vector<std::string>& sent = frames.at("wire datagrams of an answer [datagrams]");
    const std::vector<std::string>& bytes = frames.at("wire bytes of an answer [B]");
    std::vector<double> datagrams, kB;
    for (std::size_t i = 0; i < sent.size(); ++i) {
      if (sent[i].empty() || bytes[i].empty()) continue;
      datagrams.push_back(std::stod(sent[i]));
      kB.push_back(std::stod(bytes[i]) / 1e3);
    }
    EXPECT_GE(kB.size(), kJudged);
    double least = std::numeric_limits<double>::infinity();
    const auto sum = [](const std::vector<double>& of, std::size_t first) {
      const auto begin = of.begin() + static_cast<std::ptrdiff_t>(first);
      return std::accumulate(begin, begin + std::ptrdiff_t{kJudged}, 0.0);
    };
    for (std::size_t first = 0; first + kJudged <= kB.size(); ++first)
      least = std::min(least, sum(datagrams, first) / sum(kB, first));
    return least;
  }

  std::optional<Machine> desk_, head_;
  ScratchFolder folder_;
  std::optional<ChildProgram> server_;
};

TEST_F(PathMtuPrograms, TheServerSendsFewerDatagramsOverACableForLongerPackets) {
  const std::string found = "found to carry larger datagrams";
  const double least = datagrams_over({.at_client = 1280}),
               tunnel = datagrams_over({.at_client = 1400}, found, 1),
               ethernet = datagrams_over({}, found, 3);
  std::printf("datagrams for a kilobyte over packets of 1,280, 1,400 and 1,500 bytes: %.3f, %.3f, %.3f\n",
              least, tunnel, ethernet);
  EXPECT_LT(tunnel, 0.95 * least);
  EXPECT_LT(ethernet, 0.95 * tunnel);
  EXPECT_EQ(number_before("unsent", counters()), 0);
}

TEST_F(PathMtuPrograms, ProbesThatTheOwnInterfaceDoesNotTakeAreUnsent) {
  EXPECT_GT(datagrams_over({.at_server = 1400}, "unsent", 3), 0);
  EXPECT_EQ(number_before("unsent", counters()), 3) << "MAX_PROBES of 1,444 bytes: no packet is split";
  EXPECT_EQ(number_before("stopped to carry large datagrams", counters()), 0);
}

TEST_F(PathMtuPrograms, ACableThatShrinksInMidSessionBecomesABlackHoleAndIsLeft) {
  const auto client = start_client({{"--size", "96x96"}, {"--clock", "real"}, {"--frames", kEndless}});
  ASSERT_TRUE(counts_to("found to carry larger datagrams", 3)) << counters();
  set({.at_client = 1300});
  ASSERT_TRUE(counts_to("stopped to carry large datagrams", 1)) << counters();
  ASSERT_TRUE(counts_to("frames", number_before("frames", counters()) + 20)) << "the session continues";
  EXPECT_EQ(number_before("stopped to carry large datagrams", counters()), 1) << counters();
}

}  // namespace
}  // namespace farshade
