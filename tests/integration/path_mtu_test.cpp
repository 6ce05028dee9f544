// A real server and a real client on machines of their own, joined by cables that carry packets of some
// length. A virtual cable drops longer packets without an error, as a router without ICMP does.
#include <gtest/gtest.h>

#include <optional>
#include <regex>

#include "stereo/base/clock.h"
#include "tests/integration/client_program.h"
#include "tests/integration/machine.h"
#include "tests/integration/test_keys.h"
#include "tests/support/sanitized.h"
#include "tests/unit/scratch_folder.h"

namespace farshade {
namespace {

/// Ethernet packets may be 4 bytes longer than the interface's mtu, since a VLAN's tag could be among them.
struct Cable {
  int at_server = 1500, at_client = 1500;
};

/// With sanitizers and beside other tests, the client draws some 2 frames a second.
constexpr Duration kPatience = std::chrono::seconds(kSanitized ? 90 : 30);

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
  /// The mean number of datagrams of an answer, in the last quarter of a run of 80 frames: then the search is
  /// over, also on a loaded machine. The masks are the same in each run.
  double datagrams_over(const Cable& cable) {
    set(cable);
    const auto client = start_client({{"--size", "256x256"}, {"--frames", "80"}});
    const std::string errors = client->errors();
    EXPECT_EQ(client->wait(), 0) << errors;
    const Csv frames = read_csv(folder_.path() / "out" / "frames.csv");
    const std::vector<std::string>& sent = frames.at("wire datagrams of an answer [datagrams]");
    double sum = 0, answers = 0;
    for (std::size_t i = sent.size() * 3 / 4; i < sent.size(); ++i) {
      if (sent[i].empty()) continue;
      sum += std::stod(sent[i]);
      ++answers;
    }
    EXPECT_GT(answers, 10);
    return sum / answers;
  }

  std::optional<Machine> desk_, head_;
  ScratchFolder folder_;
  std::optional<ChildProgram> server_;
};

TEST_F(PathMtuPrograms, TheServerSendsFewerDatagramsOverACableForLongerPackets) {
  const double least = datagrams_over({.at_client = 1280}), tunnel = datagrams_over({.at_client = 1400}),
               ethernet = datagrams_over({});
  std::printf("datagrams of an answer over packets of 1,280, 1,400 and 1,500 bytes: %.2f, %.2f, %.2f\n",
              least, tunnel, ethernet);
  EXPECT_LT(tunnel, 0.95 * least);
  EXPECT_LT(ethernet, 0.95 * tunnel);
  EXPECT_EQ(number_before("unsent", counters()), 0);
}

TEST_F(PathMtuPrograms, ProbesThatTheOwnInterfaceDoesNotTakeAreUnsent) {
  EXPECT_GT(datagrams_over({.at_server = 1400}), 0);
  EXPECT_EQ(number_before("unsent", counters()), 3) << "MAX_PROBES of 1,444 bytes: no packet is split";
  EXPECT_EQ(number_before("stopped to carry large datagrams", counters()), 0);
}

TEST_F(PathMtuPrograms, ACableThatShrinksInMidSessionBecomesABlackHoleAndIsLeft) {
  const auto client = start_client({{"--size", "96x96"}, {"--clock", "real"}, {"--frames", "4000"}});
  ASSERT_TRUE(counts_to("found to carry larger datagrams", 3)) << counters();
  set({.at_client = 1300});
  ASSERT_TRUE(counts_to("stopped to carry large datagrams", 1)) << counters();
  ASSERT_TRUE(counts_to("frames", number_before("frames", counters()) + 20)) << "the session continues";
  EXPECT_EQ(number_before("stopped to carry large datagrams", counters()), 1) << counters();
}

}  // namespace
}  // namespace farshade
