// A real server whose address space is limited, and a client that makes it hold as much as it can.
#include <gtest/gtest.h>

#include <fstream>

#include "stereo/base/check.h"
#include "stereo/codec/plane_codec.h"
#include "stereo/gltf/gltf.h"
#include "stereo/net/udp.h"
#include "tests/integration/child_program.h"
#include "tests/integration/test_keys.h"
#include "tests/support/sanitized.h"
#include "tests/unit/link_client.h"

namespace farshade {
namespace {

using namespace std::chrono_literals;
using namespace link_test;

const std::string kScene = FARSHADE_ASSETS "/box_over_plane.gltf";
constexpr std::size_t kMemory_MiB = 64;
constexpr Duration kPatience = 30s;  ///< not reached if the server answers

/// rt_server with `prefix` before its name.
std::vector<std::string> server(std::vector<std::string> prefix) {
  for (const std::string& argument :
       {std::string(RT_SERVER), std::string("--scene"), kScene, std::string("--listen"),
        std::string("127.0.0.1:0"), std::string("--keys"), test_keys().ring, std::string("--memory"),
        std::to_string(kMemory_MiB), std::string("--handshakes-per-second"), std::string("1000")})
    prefix.push_back(argument);
  return prefix;
}

/// A figure of /proc/PID/status in KiB.
std::size_t status_KiB(pid_t process, const std::string& name) {
  std::ifstream status("/proc/" + std::to_string(process) + "/status");
  for (std::string word; status >> word;)
    if (std::size_t figure = 0; word == name + ":" && status >> figure) return figure;
  return 0;
}

/// A client with a key at a port of its own.
struct Client {
  Client(const std::string& address, const SharedKey& key, const Welcome& served)
      : connected(connect_udp(address)), link(*connected->port, connected->server, key, served) {}
  Expected<UdpClient> connected;
  PortClient link;
};

/// Waits until the server has handled everything that was sent before. It handles datagrams in order, and
/// answers a hello without a cookie.
void catch_up(Client& pacer, const Welcome& served) {
  pacer.connected->port->send(pacer.connected->server, LinkClient(test_keys().key, served).hello());
  std::array<std::byte, kMaxDatagram_bytes> buffer;
  ASSERT_TRUE(pacer.connected->port->receive(buffer, kPatience)) << "the socket's buffer was full";
}

/// Each client requests masks of positions and brings `parts` of its 65,535 messages; all clients in turn, so
/// that no request is answered before the last has come.
void bring_positions(const std::vector<std::unique_ptr<Client>>& clients, std::uint32_t parts, Client& pacer,
                     const Welcome& served) {
  constexpr Extent kSize{1024, 1024};
  FrameRequest request = request_of(1, kSize);
  request.answer = {.kind = Answer::MasksOfPositions, .position_bits = 16, .slices = 65535};
  for (const auto& client : clients) client->link.say(client->link.ask(request));
  const Bytes full(kBaseMessage_bytes - kPlaneSliceHeader_bytes, std::byte{1});
  Bytes message, datagram;
  for (std::uint32_t tile = 0; tile < parts; ++tile) {
    encode(ClientMessage(PlaneSlice{.frame = {1},
                                    .kind = PlaneKind::PositionX,
                                    .size = kSize,
                                    .first_tile = tile,
                                    .tile_count = 1,
                                    .block = full}),
           message);
    for (const auto& client : clients) {
      client->link.sealer->seal(message, datagram);
      client->link.say(datagram);
    }
    // The socket's buffer holds some hundred datagrams.
    if (tile % 2 == 1) {
      ASSERT_NO_FATAL_FAILURE(catch_up(pacer, served));
    }
  }
}

TEST(ServerMemory, HoldsUnderALimitedAddressSpaceAndAGoodClientIsStillAnswered) {
  if (kSanitized) GTEST_SKIP() << "a sanitizer needs terabytes of address space";
  const SharedKey evil = new_key("evil").value();
  ASSERT_TRUE(append_to_ring(test_keys().ring, evil).has_value());
  std::size_t before_KiB = 0;
  {
    ChildProgram program(server({}));
    ASSERT_TRUE(program.line_after("rt_server: listening on ").has_value());
    before_KiB = status_KiB(program.id(), "VmPeak");
  }
  // Beyond what it takes with no client: its limit, and half as much for what the heap cannot use.
  const std::size_t limit_KiB = before_KiB + (kMemory_MiB << 10) * 3 / 2;
  ChildProgram program(
      server({"/bin/bash", "-c", "ulimit -v " + std::to_string(limit_KiB) + "; exec \"$0\" \"$@\""}));
  const auto address = program.line_after("rt_server: listening on ");
  ASSERT_TRUE(address.has_value()) << program.errors();
  const Expected<Scene> scene = load_scene(kScene);
  const Welcome served{scene->hash, narrow<std::uint32_t>(scene->lights.size())};
  const std::size_t resident_KiB = status_KiB(program.id(), "VmRSS");

  std::vector<std::unique_ptr<Client>> attackers;
  for (int i = 0; i < 40; ++i) {
    attackers.push_back(std::make_unique<Client>(*address, evil, served));
    ASSERT_TRUE(attackers.back()->link.connect(kPatience)) << i;
  }
  Client pacer(*address, test_keys().key, served);
  bring_positions(attackers, 3000, pacer, served);
  ASSERT_FALSE(HasFatalFailure());
  Client good(*address, test_keys().key, served);
  ASSERT_TRUE(good.link.connect(kPatience));
  std::uint32_t complete = 0;
  for (std::uint32_t frame = 1; frame <= 20; ++frame) {
    good.link.say(good.link.ask(request_of(frame, {64, 64})));
    const RequestRecord& received = *good.link.assembler.find({frame});
    while (!(received.report && received.complete()) && good.link.hear(kPatience)) {
    }
    complete += received.complete() ? 1 : 0;
  }
  const std::size_t grown_KiB = status_KiB(program.id(), "VmRSS") - resident_KiB;
  std::printf("limit %zu MiB: the server grew by %zu MiB, a good client had %u of 20 frames\n", kMemory_MiB,
              grown_KiB >> 10, complete);
  EXPECT_GE(complete, 19u) << "loopback may lose a datagram if the machine is busy";
  EXPECT_LE(grown_KiB, kMemory_MiB << 10);
  program.send(SIGTERM);
  EXPECT_EQ(program.wait(), 0);
  const std::string output = program.output();
  EXPECT_NE(output.find("refused by --memory"), std::string::npos) << output;
}

}  // namespace
}  // namespace farshade
