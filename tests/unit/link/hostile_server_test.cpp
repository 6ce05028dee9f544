// A server that holds the client's key cannot hang, crash or exhaust the client.
#include "tests/unit/hostile_server.h"

#include <gtest/gtest.h>

#include "tests/unit/link/link_bench.h"

namespace farshade {
namespace {

using namespace link_test;

struct HostileBench {
  HostileBench() {
    wire.while_waiting([this] { server.serve(); });
    EXPECT_TRUE(link.connect(1s).has_value());
  }
  /// Lets what is on the way arrive.
  void pass() {
    clock.advance_to(clock.now() + kWay);
    link.poll();
    server.serve();
  }
  void ask() {
    ++frame;
    link.request(request(frame, frame * kInterval), Time(frame * kInterval));
    pass();
  }

  ManualClock clock;
  VirtualLink wire{clock, kSlow};
  HostileServer server{wire.server(), kKey, kServed};
  NetworkLink link{
      wire.client(), clock, {wire.server().local(), kKey, kServed.scene_hash, {kLights}}, kFrames};
  std::uint32_t frame = 0;
};

TEST(HostileServer, ACounterThatJumpsNeitherHangsNorEndsTheClient) {
  for (const std::uint64_t jump : {~std::uint64_t{0}, (std::uint64_t{1} << 63) + 300, std::uint64_t{1} << 62,
                                   ReplayWindow::kMostJump + 2}) {
    SCOPED_TRACE(jump);
    HostileBench bench;
    bench.server.say(ServerMessage(Probe{1}));
    bench.pass();
    bench.server.say(ServerMessage(Probe{2}), jump);
    bench.pass();
    bench.ask();
    ASSERT_TRUE(bench.server.request().has_value());
    EXPECT_EQ(bench.server.request()->probe_echo, 1u) << "the datagram after the jump has no effect";
    EXPECT_EQ(bench.server.request()->arrivals.first, 0u);
    EXPECT_EQ(bench.link.counters().undecodable[WireRefusal::CounterJump], 1u);
  }
}

/// A port at which a datagram always waits. Each takes 20 us.
class FloodPort final : public DatagramPort {
 public:
  explicit FloodPort(ManualClock& clock) : clock_(clock) {}
  [[nodiscard]] Peer local() const override { return {}; }
  bool send(const Peer&, std::span<const std::byte>) override { return true; }
  std::optional<Datagram> receive(std::span<std::byte> into, Duration) override {
    if (counters_.received == kMost) return std::nullopt;
    ++counters_.received;
    clock_.advance_to(clock_.now() + 20us);
    return Datagram{.from = {}, .bytes = into.first(kMaxDatagram_bytes), .arrived = clock_.now()};
  }
  void wake() override {}
  [[nodiscard]] PortCounters counters() const override { return counters_; }

  static constexpr std::uint64_t kMost = 1'000'000;

 private:
  ManualClock& clock_;
  PortCounters counters_;
};

TEST(HostileServer, AFloodTakesAFrameNoMoreThanTheStatedTime) {
  ManualClock clock;
  FloodPort port(clock);
  NetworkLink link(port, clock, {{}, kKey, kServed.scene_hash, {kLights}}, kFrames);
  for (std::uint64_t frame = 1; frame <= 3; ++frame) {
    const Time begun = clock.now();
    link.poll();
    EXPECT_LE(clock.now() - begun, kMostPolling + 20us);
    EXPECT_EQ(link.counters().cut_short, frame);
  }
  EXPECT_FALSE(link.wait_for({1}, 5ms));
  EXPECT_LT(port.counters().received, FloodPort::kMost);
}

TEST(HostileServer, TilesThatWereReceivedAreNotDecodedAgain) {
  HostileBench bench;
  bench.ask();
  const auto say = [&](std::uint32_t value) {
    ShadowFrame painted;
    paint(request(1), painted);
    for (std::uint32_t y = 0; y < kSize.height; ++y)
      for (std::uint32_t x = 0; x < kSize.width; ++x) painted.masks[0].set_word(x, y, 0, value);
    SlicePacker packer;
    packer.start(painted, Side::Left);
    while (const std::optional<Slice> slice = packer.next()) bench.server.say(ServerMessage(*slice));
    bench.pass();
  };
  say(5);
  const std::uint32_t first = bench.link.receiver().find({1})->masks[0].word(0, 0);
  EXPECT_EQ(first, 5u);
  for (const std::uint32_t value : {2u, 3u, 4u}) say(value);
  EXPECT_EQ(bench.link.receiver().find({1})->masks[0].word(0, 0), 5u) << "the first came first";
  EXPECT_GT(bench.link.counters().assembler.duplicates, 2u);
}

}  // namespace
}  // namespace farshade
