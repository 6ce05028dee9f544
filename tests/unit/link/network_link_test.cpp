#include "stereo/link/network_link.h"

#include <gtest/gtest.h>

#include "stereo/frame/tiles.h"
#include "tests/support/packed.h"
#include "tests/unit/link/link_bench.h"

namespace farshade {
namespace {

using namespace link_test;

TEST(ShadowLinkConnect, IsWelcomedAfterTwoRoundTrips) {
  LinkBench bench;
  bench.start_server();
  EXPECT_TRUE(bench.link.connect(3s).has_value());
  EXPECT_TRUE(bench.link.last_received().has_value());
  EXPECT_EQ(bench.clock.now(), Time(4 * kWay));
  EXPECT_EQ(bench.link.counters().port.sent, 2u);
}

TEST(ShadowLinkConnect, SaysWhichSceneEachSideHasAndStopsAsking) {
  LinkBench bench;
  Welcome other = kServed;
  other.scene_hash = {0xAB, 0xCD};
  bench.start_server(other);
  const Expected<void> connected = bench.link.connect(3s);
  ASSERT_FALSE(connected.has_value());
  EXPECT_EQ(connected.error().fault, Fault::Mismatch);
  EXPECT_NE(connected.error().what.find("abcd0000"), std::string::npos) << connected.error().what;
  EXPECT_NE(connected.error().what.find("01020300"), std::string::npos) << connected.error().what;
  EXPECT_EQ(bench.clock.now(), Time(4 * kWay)) << "waiting longer would not help";
  bench.clock.advance_to(Time(5s));
  bench.ask(request(1));
  EXPECT_EQ(bench.link.counters().port.sent, 2u);
  EXPECT_TRUE(bench.link.refused().has_value());
}

TEST(ShadowLinkConnect, RefusesAServerWithAnotherNumberOfLights) {
  LinkBench bench;
  Welcome other = kServed;
  other.light_count = kLights + 1;
  bench.start_server(other);
  const Expected<void> connected = bench.link.connect(3s);
  ASSERT_FALSE(connected.has_value());
  EXPECT_EQ(connected.error().fault, Fault::Mismatch);
  EXPECT_FALSE(bench.link.last_received().has_value());
}

TEST(ShadowLinkConnect, GivesUpOnAServerThatIsNotThereAfterItsPatience) {
  LinkBench bench;
  const Expected<void> connected = bench.link.connect(3s);
  ASSERT_FALSE(connected.has_value());
  EXPECT_EQ(connected.error().fault, Fault::Missing);
  EXPECT_NE(connected.error().what.find(to_string(bench.wire.server().local())), std::string::npos);
  EXPECT_EQ(bench.clock.now(), Time(3s));
  EXPECT_EQ(bench.link.counters().port.sent, 12u) << "a hello each 250 ms";
}

TEST(ShadowLinkConnect, SaysThatAServerIsFull) {
  LinkBench bench;
  bench.start_server(kServed, {.sessions = 0});
  const Expected<void> connected = bench.link.connect(1s);
  ASSERT_FALSE(connected.has_value());
  EXPECT_EQ(connected.error().fault, Fault::Unavailable);
  EXPECT_NE(connected.error().what.find("no room"), std::string::npos);
  EXPECT_FALSE(bench.link.refused().has_value()) << "the server may have room later";
}

TEST(NetworkLink, ServesMasksBitForBit) {
  ConnectedBench bench;
  bench.ask(request(1));
  EXPECT_TRUE(bench.link.wait_for({1}, 1s));
  ASSERT_NE(bench.link.receiver().find({1}), nullptr);
  EXPECT_EQ(bench.link.receiver().find({1})->masks, painted(1));
}

TEST(NetworkLink, GoesOnTryingAServerThatComesLate) {
  LinkBench bench;
  EXPECT_FALSE(bench.link.connect(1s).has_value());
  bench.start_server();
  bench.clock.advance_to(Time(2s));
  bench.ask(request(1));
  bench.pass(4 * kWay);
  EXPECT_TRUE(bench.link.last_received().has_value());
  bench.ask(request(2));
  EXPECT_TRUE(bench.link.wait_for({2}, 1s));
}

TEST(NetworkLink, LostSlicesLeaveTheirTilesUnknownAndNothingElse) {
  LinkBench lossy({.to_server = {}, .to_client = {.loss = 0.4}, .seed = 3});
  lossy.start_server();
  ASSERT_TRUE(lossy.link.connect(10s).has_value());
  std::size_t known = 0, unknown = 0;
  for (std::uint32_t frame = 1; frame <= 20; ++frame) {
    lossy.ask(request(frame));
    lossy.pass(10ms);
    const RequestRecord& received = *lossy.link.receiver().find({frame});
    const PerEye<EyeMask> truth = painted(frame);
    for (std::size_t eye = 0; eye < kEyes; ++eye)
      for (std::uint32_t tile = 0; tile < TileGrid{kSize}.count(); ++tile) {
        ++(received.received_tiles[eye][tile] ? known : unknown);
        const TileRect rect = TileGrid{kSize}.rect(tile);
        for (std::uint32_t y = rect.y0; y < rect.y1; ++y)
          for (std::uint32_t x = rect.x0; x < rect.x1; ++x)
            ASSERT_EQ(received.masks[eye].word(x, y),
                      received.received_tiles[eye][tile] ? truth[eye].word(x, y) : 0u);
      }
  }
  EXPECT_GT(known, unknown);
  EXPECT_GT(unknown, 20u);
}

TEST(NetworkLink, MasksComeNewestFirstAndNotBeyondUntil) {
  ConnectedBench bench;
  for (std::uint32_t frame = 1; frame <= 4; ++frame) {
    bench.ask(request(frame, frame * 10ms));
    if (frame != 3) bench.pass(5 * kWay);
  }
  const auto frames = [&](Time until) {
    std::vector<std::uint32_t> values;
    for (const RequestRecord* mask : bench.link.receiver().received(until))
      values.push_back(mask->request.frame.value);
    return values;
  };
  EXPECT_EQ(frames(Time::max()), (std::vector<std::uint32_t>{4, 2, 1})) << "4 evicted 3";
  EXPECT_EQ(frames(Time(40ms)), (std::vector<std::uint32_t>{4, 2, 1}));
  EXPECT_EQ(frames(Time(40ms - 1ns)), (std::vector<std::uint32_t>{2, 1}));
  EXPECT_EQ(frames(Time(9ms)), (std::vector<std::uint32_t>{}));
}

TEST(NetworkLink, OrdersFramesByRequestTimeAndNotByDisplayTime) {
  ConnectedBench bench;
  for (std::uint32_t frame = 1; frame <= 3; ++frame) {
    bench.link.request(request(frame, 500ms - frame * 10ms),
                       Time(frame * 10ms));  // the display times decrease
    ASSERT_TRUE(bench.link.wait_for({frame}, 1s));
  }
  ASSERT_EQ(bench.link.receiver().received(Time(20ms)).size(), 2u);
  EXPECT_EQ(bench.link.receiver().received(Time(20ms)).front()->request.frame, FrameId{2});
  EXPECT_TRUE(bench.link.receiver().received(Time(10ms - 1ns)).empty());
  EXPECT_EQ(bench.link.receiver().find({3})->origin.requested_at, Time(30ms));
  EXPECT_EQ(bench.link.receiver().find({3})->request.display_time, Time(470ms));
  EXPECT_EQ(bench.link.receiver().find({5}), nullptr);
}

TEST(NetworkLink, KeepsTheNewestRequestsOnly) {
  ConnectedBench bench;
  for (std::uint32_t frame = 1; frame <= 20; ++frame) {
    bench.ask(request(frame, frame * 10ms));
    ASSERT_TRUE(bench.link.wait_for({frame}, 1s));
  }
  const auto masks = bench.link.receiver().received(Time::max());
  ASSERT_EQ(masks.size(), kFrames);
  EXPECT_EQ(masks.front()->request.frame, FrameId{20});
  EXPECT_EQ(masks.back()->request.frame, FrameId{15});
  EXPECT_EQ(bench.link.receiver().find({14}), nullptr);
  EXPECT_EQ(bench.link.receiver().find({15})->origin.requested_at, Time(150ms));
}

/// Datagrams come steadily, wait in order without limit, and each takes the reader some time.
class BusyPort final : public DatagramPort {
 public:
  static constexpr Duration kApart = 500us, kReading = 28us;
  explicit BusyPort(ManualClock& clock) : clock_(clock) {}
  [[nodiscard]] Peer local() const override { return {}; }
  bool send(const Peer&, std::span<const std::byte>) override { return true; }
  std::optional<Datagram> receive(std::span<std::byte> into, Duration) override {
    if (next_ > clock_.now()) return std::nullopt;
    const Time arrived = next_;
    next_ += kApart;
    clock_.advance_to(clock_.now() + kReading);
    return Datagram{.from = {}, .bytes = into.first(kMaxDatagram_bytes), .arrived = arrived};
  }
  void wake() override {}
  [[nodiscard]] PortCounters counters() const override { return {}; }
  /// How long the next datagram has waited.
  [[nodiscard]] Duration behind() const { return std::max(clock_.now() - next_, Duration::zero()); }

 private:
  ManualClock& clock_;
  Time next_{};
};

/// A preview on lavapipe shows ten frames a second, and saw what had come seconds before.
TEST(NetworkLink, SlowFramesDoNotFallBehindWhatArrives) {
  for (const Duration frame : {14ms, 50ms, 100ms, 300ms}) {
    ManualClock clock;
    BusyPort port(clock);
    NetworkLink link(port, clock, {{}, kKey, kServed.scene_hash, {kLights}}, kFrames);
    for (int i = 0; i < 100; ++i) {
      clock.advance_to(clock.now() + frame);
      const Time begun = clock.now();
      link.poll();
      EXPECT_LE(clock.now() - begun, std::max<Duration>(kMostPolling, frame / 3) + BusyPort::kReading);
    }
    EXPECT_LE(port.behind(), frame) << ms_of(frame);
    EXPECT_LE(link.counters().cut_short, 1u) << ms_of(frame);
  }
}

TEST(ShadowLinkWait, EndsWhenTheFrameIsWhole) {
  ConnectedBench bench;
  const Time begun = bench.clock.now();
  bench.ask(request(1));
  EXPECT_TRUE(bench.link.wait_for({1}, 1s));
  EXPECT_GT(bench.clock.now() - begun, 2 * kWay);
  EXPECT_LT(bench.clock.now() - begun, 2 * kWay + 3ms) << "as fast as the path is taken to be";
  EXPECT_TRUE(bench.link.receiver().find({1})->report.has_value());
}

TEST(ShadowLinkWait, LastsAsLongAsItsPatience) {
  ConnectedBench bench;
  const Time begun = bench.clock.now();
  bench.ask(request(1));
  EXPECT_FALSE(bench.link.wait_for({1}, 0ms));
  EXPECT_EQ(bench.clock.now(), begun);
  EXPECT_FALSE(bench.link.wait_for({1}, 7ms));
  EXPECT_EQ(bench.clock.now() - begun, 7ms);
  bench.server.reset();
  bench.ask(request(2));
  EXPECT_FALSE(bench.link.wait_for({2}, 100ms));
  EXPECT_EQ(bench.clock.now() - begun, 107ms);
  EXPECT_TRUE(bench.link.receiver().find({1})->complete()) << "pieces that arrived meanwhile were accepted";
}

TEST(ShadowLinkWait, DoesNotWaitForAServerThatHasNotWelcomedIt) {
  LinkBench bench;
  bench.ask(request(1));
  EXPECT_FALSE(bench.link.wait_for({1}, 10s));
  EXPECT_EQ(bench.clock.now(), Time{});
}

/// A server that has the key and sends any messages.
struct WildServer : LinkBench {
  WildServer() : LinkBench(each_way(0ms)) {
    on_send = [this](std::span<const std::byte> datagram) {
      const auto envelope = open_client_envelope(datagram);
      const auto* hello = envelope ? std::get_if<Hello>(&*envelope) : nullptr;
      if (hello == nullptr || sealer) return false;
      const auto accepted = accept(*hello, datagram, kKey, kServed);
      sealer.emplace(accepted->keys.session, accepted->keys.to_client, accepted->keys.sealing);
      send(accepted->datagram);
      return false;
    };
  }
  void send(const Bytes& datagram) { wire.server().send(wire.client().local(), datagram); }
  Bytes sealed(const ServerMessage& message) {
    Bytes bytes, datagram;
    encode(message, bytes);
    sealer->seal(bytes, datagram);
    return datagram;
  }

  std::optional<Sealer> sealer;
};

TEST(NetworkLink, HostileBytesChangeNothingButCounters) {
  WildServer bench;
  ASSERT_TRUE(bench.link.connect(1s).has_value());
  bench.ask(request(1));
  ShadowFrame frame;
  paint(request(1), frame);
  FramePacker packer;
  Bytes copy;
  for (const Bytes& message : pack(packer, frame, {.frame = {1}})) {
    bench.sealer->seal(message, copy);
    bench.send(copy);
  }
  bench.link.poll();
  ASSERT_TRUE(bench.link.receiver().find({1})->complete());

  bench.send(Bytes(40, std::byte{0x5A}));
  bench.send(copy);
  Bytes cut = bench.sealed(Probe{7});
  cut.pop_back();
  bench.send(cut);
  const std::array block{std::byte{0xF0}, std::byte{0xFF}, std::byte{0xFF}};
  Slice slice{.frame = {1},
              .light_set_revision = kFirstLightSet,
              .size = kSize,
              .lights = kLights,
              .tile_count = 1,
              .block = block};
  bench.send(bench.sealed(slice));  // its tile is known
  slice.size = {kSize.width, kSize.height + 1};
  bench.send(bench.sealed(slice));
  slice.size = kSize;
  slice.frame = {77};
  bench.send(bench.sealed(slice));
  slice.frame = {1};
  slice.light_set_revision = {9};
  bench.send(bench.sealed(slice));
  bench.send(bench.sealed(FrameReport{.frame = {78}}));
  bench.send(bench.sealed(Refusal{}));
  bench.link.poll();

  const NetworkLink::Counters counters = bench.link.counters();
  EXPECT_EQ(counters.undecodable[WireRefusal::Magic], 1u);
  EXPECT_EQ(counters.undecodable[WireRefusal::Replayed], 1u);
  EXPECT_EQ(counters.undecodable[WireRefusal::Forged], 1u);
  EXPECT_EQ(counters.undecodable.total(), 3u);
  EXPECT_EQ(counters.assembler.duplicates, 1u);
  EXPECT_EQ(counters.assembler.refused.total(), 1u);
  EXPECT_EQ(counters.assembler.unexpected, 2u);
  EXPECT_EQ(counters.assembler.other_light_set, 1u);
  EXPECT_TRUE(bench.link.last_received().has_value());
  EXPECT_FALSE(bench.link.refused().has_value());
  EXPECT_EQ(bench.link.receiver().find({1})->masks, painted(1));
}

TEST(NetworkLink, SurvivesFrameIdWraparound) {
  ConnectedBench bench;
  for (std::uint32_t i = 0; i < 6; ++i) {
    const std::uint32_t frame = 0xFFFF'FFFDu + i;
    bench.ask(request(frame, (i + 1) * 10ms));
    ASSERT_TRUE(bench.link.wait_for({frame}, 1s)) << frame;
    EXPECT_EQ(bench.link.receiver().find({frame})->masks, painted(frame));
    EXPECT_EQ(bench.link.receiver().received(Time::max()).front()->request.frame, FrameId{frame});
  }
  EXPECT_EQ(bench.link.receiver().received(Time::max()).size(), kFrames);
}

}  // namespace
}  // namespace farshade
