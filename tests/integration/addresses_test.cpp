// A real server with several addresses, and clients at each of them.
#include <gtest/gtest.h>

#include "stereo/net/tcp.h"
#include "stereo/net/udp.h"
#include "tests/integration/good_client.h"
#include "tests/integration/machine.h"
#include "tests/integration/test_keys.h"
#include "tests/unit/scratch_folder.h"

namespace farshade {
namespace {

#define EXPECT_CONTAINS(text, words) EXPECT_NE((text).find(words), std::string::npos) << (text)

/// More than the first address of a server: another one of IPv4, and one of IPv6 if this machine has it.
std::vector<std::string> more_addresses() {
  std::vector<std::string> more{"--listen", "127.0.0.2:0"};
  if (listen_udp("[::1]:0")) more.insert(more.end(), {"--listen", "[::1]:0"});
  return more;
}

Ended vr_client(std::vector<std::string> arguments, const ScratchFolder& folder,
                const Machine* on = nullptr) {
  // The Vulkan loader unloads drivers at the end. A leak suppression cannot name a module that is unloaded.
  const std::vector<std::string> command{"/usr/bin/env", "LSAN_OPTIONS=detect_leaks=0",
                                         "XDG_CACHE_HOME=" + (folder.path() / "cache").string(), VR_CLIENT};
  arguments.insert(arguments.begin(), command.begin(), command.end());
  ChildProgram program(on != nullptr ? on->here(arguments) : arguments);
  const std::string errors = program.errors();
  return {program.wait(), errors + program.output()};
}

/// vr_client without --scene: it fetches the scene of `server` and ends, or plays two frames.
std::vector<std::string> fetch(const std::string& server) {
  return {"--server", server, "--key", test_keys().client, "--trace", kWalk, "--plan"};
}
std::vector<std::string> short_walk(const std::string& server, const ScratchFolder& folder) {
  return {"--server",
          server,
          "--key",
          test_keys().client,
          "--trace",
          kWalk,
          "--size",
          "48x32",
          "--frames",
          "2",
          "--pictures",
          "0",
          "--out",
          (folder.path() / "out").string(),
          "--reference-every",
          "0"};
}

class ServerAddresses : public testing::Test {
 protected:
  void SetUp() override {
    addresses_.push_back(server_.address());
    for (std::size_t more = more_addresses().size() / 2; more > 0; --more)
      addresses_.push_back(server_.program().line_after("rt_server: listening on ").value_or("no address"));
  }

  RunningServer server_{kRoom, "127.0.0.1:0", more_addresses()};
  std::vector<std::string> addresses_;  ///< in the order of the options
  ScratchFolder folder_;
};

TEST_F(ServerAddresses, EachSendsMasksAtOnceAndOnlyFromItself) {
  ASSERT_TRUE(addresses_[1].starts_with("127.0.0.2:")) << addresses_[1];
  std::vector<UdpClient> ports;
  std::vector<std::unique_ptr<Walker>> walkers;
  for (const std::string& address : addresses_) {
    ports.push_back(connect_udp(address).value());
    const UdpClient& udp = ports.back();
    walkers.push_back(std::make_unique<Walker>(*udp.port, target_of(udp.server, test_keys().key, kRoom)));
  }
  for (int pose = 0; pose < 6; ++pose) {
    const auto first = walkers[0]->next_masks();
    ASSERT_TRUE(first.has_value()) << pose;
    for (std::size_t i = 1; i < walkers.size(); ++i) {
      const auto masks = walkers[i]->next_masks();
      ASSERT_TRUE(masks.has_value()) << addresses_[i] << " " << pose;
      EXPECT_EQ(*masks, *first) << addresses_[i] << " " << pose;
    }
  }
  std::uint64_t sent = 0;
  for (std::size_t i = 0; i < ports.size(); ++i) {
    const PortCounters counters = ports[i].port->counters();
    EXPECT_GT(counters.received, 6u) << addresses_[i];
    EXPECT_EQ(counters.strangers, 0u) << "every answer comes from " << addresses_[i];
    sent += counters.sent;
  }
  const Counts counts = counts_of(server_);
  EXPECT_EQ(counts.of("clients"), addresses_.size()) << "in one list: " << counts.line;
  EXPECT_EQ(counts.of("datagrams received"), sent) << counts.line;
}

TEST_F(ServerAddresses, EachSendsTheScene) {
  for (const std::string& address : addresses_) {
    const ScratchFolder own;
    const Ended run = vr_client(fetch(address), own);
    EXPECT_EQ(run.status, 0) << address << ": " << run.errors;
    EXPECT_CONTAINS(run.errors, "fetched ");
    const Ended doctor = vr_client({"doctor", "--server", address, "--key", test_keys().client}, own);
    EXPECT_CONTAINS(doctor.errors, address + ": the server answers, knows the key");
    EXPECT_CONTAINS(doctor.errors, "ok    scene: the server sends it");
  }
  server_.program().send(SIGTERM);
  const std::string log = server_.program().errors();
  EXPECT_EQ(log.find("cannot fetch"), log.npos) << log;
}

TEST_F(ServerAddresses, OneWhoseTcpPortIsTakenLeavesTheSceneToTheOthers) {
  const TcpListener taken = TcpListener::listen(resolve_tcp("127.0.0.9:0").value().front()).value();
  const std::string address = to_string(taken.local());
  RunningServer server(kRoom, "127.0.0.1:0", {"--listen", address});
  const Ended run = vr_client(fetch(server.address()), folder_);
  EXPECT_EQ(run.status, 0) << run.errors;
  server.program().send(SIGTERM);
  EXPECT_CONTAINS(server.program().errors(), "clients of " + address + " cannot fetch the scene: " + address +
                                                 " (TCP) is in use by another program");
}

/// The name has an address at which nobody listens; the client must go on to the second.
TEST(ServerName, IsTriedWithAllItsAddresses) {
  if (const std::string why = missing_for_machines(); !why.empty()) GTEST_SKIP() << why;
  const Machine machine;
  machine.shell(
      "printf '127.0.0.9 desk\\n127.0.0.2 desk\\n' > /run/hosts; mount --bind /run/hosts /etc/hosts");
  ChildProgram found(machine.here({"/usr/bin/getent", "ahosts", "desk"}));
  const std::string order = found.output();
  ASSERT_LT(order.find("127.0.0.9 "), order.find("127.0.0.2 ")) << order;
  const ScratchFolder folder;
  const std::string ring = (folder.path() / "ring.keys").string(), key = (folder.path() / "a.key").string();
  ASSERT_TRUE(append_to_ring(ring, test_keys().key));
  ChildProgram pair(
      machine.here({RT_SERVER, "pair", "--listen", "127.0.0.2:7448", "--address", "desk", "--ring", ring}));
  const auto code = pair.line_after("  vr_client pair ");
  ASSERT_TRUE(code) << pair.errors();
  const Ended paired = vr_client({"pair", *code, "--key", key, "--name", "lab"}, folder, &machine);
  EXPECT_EQ(paired.status, 0) << paired.errors;

  ChildProgram server(machine.here({RT_SERVER, "--scene", kRoom, "--listen", "127.0.0.2", "--keys", ring}));
  ASSERT_TRUE(server.line_after("rt_server: listening on ")) << server.errors();
  const Ended run = vr_client(short_walk("desk", folder), folder, &machine);
  EXPECT_EQ(run.status, 0) << run.errors;
  EXPECT_CONTAINS(run.errors, "fetched ");
  EXPECT_CONTAINS(run.errors, "127.0.0.9:7447 does not answer; trying the next address of desk");
  const Ended doctor = vr_client({"doctor", "--server", "desk", "--key", key}, folder, &machine);
  EXPECT_CONTAINS(doctor.errors, "desk: the server answers, knows the key 'lab'");
  EXPECT_CONTAINS(doctor.errors, "ok    scene: the server sends it");
}

}  // namespace
}  // namespace farshade
