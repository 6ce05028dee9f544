#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <thread>
#include <vector>

#include "stereo/base/pausable_clock.h"
#include "stereo/net/impaired_port.h"
#include "stereo/net/udp.h"
#include "tests/support/manual_clock.h"
#include "tests/support/virtual_link.h"

namespace farshade {
namespace {

using namespace std::chrono_literals;
constexpr Duration kPatience = 60s;  // not reached if datagrams arrive
const std::array kOne{std::byte{1}}, kTwo{std::byte{2}};

/// A port that owns nothing and forwards to the virtual link's port `inner`.
class Borrowed final : public DatagramPort {
 public:
  explicit Borrowed(DatagramPort& inner) : inner_(inner) {}
  [[nodiscard]] Peer local() const override { return inner_.local(); }
  bool send(const Peer& to, std::span<const std::byte> bytes) override { return inner_.send(to, bytes); }
  [[nodiscard]] std::optional<Datagram> receive(std::span<std::byte> into, Duration wait) override {
    return inner_.receive(into, wait);
  }
  void wake() override { inner_.wake(); }
  [[nodiscard]] PortCounters counters() const override { return inner_.counters(); }

 private:
  DatagramPort& inner_;
};

struct Bench {
  explicit Bench(const LinkModel& model)
      : port(impaired(std::make_unique<Borrowed>(link.server()), model, clock)) {}
  bool send(std::span<const std::byte> bytes) { return link.client().send(link.server().local(), bytes); }

  ManualClock clock;
  VirtualLink link{clock, {.to_server = {.delay = 2ms}, .to_client = {.delay = 2ms}}};
  std::unique_ptr<ImpairedPort> port;
  std::array<std::byte, 1500> buffer;
};

TEST(ImpairedPort, ReturnsADatagramWhenItIsDue) {
  Bench bench({.delay = 5ms});
  bench.send(kOne);
  EXPECT_FALSE(bench.port->receive(bench.buffer, 6999us).has_value());
  EXPECT_EQ(bench.clock.now(), Time(6999us));
  const auto received = bench.port->receive(bench.buffer, kPatience);
  ASSERT_TRUE(received.has_value());
  EXPECT_EQ(bench.clock.now(), Time(7ms));
  EXPECT_EQ(received->arrived, Time(7ms));
  EXPECT_EQ(received->from, bench.link.client().local());
  EXPECT_TRUE(std::ranges::equal(received->bytes, kOne));
}

TEST(ImpairedPort, LateReaderSeesWhenItWasDue) {
  Bench bench({.delay = 5ms});
  bench.send(kOne);
  bench.clock.advance_to(Time(1s));
  const auto received = bench.port->receive(bench.buffer, 0s);
  ASSERT_TRUE(received.has_value());
  EXPECT_EQ(received->arrived, Time(7ms));
}

/// A reader whose clock stood still from 1 s to 5 s.
TEST(ImpairedPort, DelaysOnAClockOfItsOwn) {
  ManualClock wire_clock;
  VirtualLink link{wire_clock, {.to_server = {.delay = 2ms}, .to_client = {.delay = 2ms}}};
  PausableClock clock(wire_clock);
  const auto port = impaired(std::make_unique<Borrowed>(link.server()), {.delay = 5ms}, clock,
                             [&](Time time) { return clock.at(time); });
  std::array<std::byte, 1500> buffer;
  wire_clock.advance_to(Time(1s));
  clock.stop();
  link.client().send(link.server().local(), kOne);
  wire_clock.advance_to(Time(5s));
  EXPECT_FALSE(port->receive(buffer, 0s).has_value()) << "it came when the clock stood still";
  clock.resume();
  const auto received = port->receive(buffer, kPatience);
  ASSERT_TRUE(received.has_value());
  EXPECT_EQ(received->arrived, Time(1s + 5ms));
  EXPECT_EQ(clock.now(), Time(1s + 5ms));
}

TEST(ImpairedPort, FollowsAnotherModelFromThenOn) {
  Bench bench({.delay = 5ms});
  bench.send(kOne);
  EXPECT_FALSE(bench.port->receive(bench.buffer, 4ms).has_value()) << "the first model holds it";
  bench.port->follow({.delay = 1ms});
  bench.send(kOne);
  EXPECT_TRUE(bench.port->receive(bench.buffer, kPatience).has_value());
  EXPECT_EQ(bench.clock.now(), Time(7ms)) << "delayed by both models: 2 + 5 and 4 + 2 + 1 ms";
  EXPECT_TRUE(bench.port->receive(bench.buffer, kPatience).has_value());
  EXPECT_EQ(bench.clock.now(), Time(7ms));
  bench.port->follow({.loss = 1});
  bench.send(kOne);
  EXPECT_FALSE(bench.port->receive(bench.buffer, kPatience).has_value());
}

TEST(ImpairedPort, LosesReceivedDatagramsAndNoSentOnes) {
  Bench bench({.loss = 1});
  bench.send(kOne);
  EXPECT_FALSE(bench.port->receive(bench.buffer, 1s).has_value());
  EXPECT_EQ(bench.clock.now(), Time(1s));
  EXPECT_TRUE(bench.port->send(bench.link.client().local(), kTwo));
  EXPECT_TRUE(bench.link.client().receive(bench.buffer, 1s).has_value());
}

TEST(ImpairedPort, CountsReturnedDatagrams) {
  Bench bench({.duplicate = 1});
  for (int i = 0; i < 3; ++i) bench.send(kOne);
  for (int i = 0; i < 5; ++i) EXPECT_TRUE(bench.port->receive(bench.buffer, 1s).has_value());
  std::array<std::byte, 0> none;
  EXPECT_FALSE(bench.port->receive(none, 0s).has_value());
  EXPECT_EQ(bench.port->counters(), (PortCounters{.received = 5, .received_bytes = 5, .oversized = 1}));
}

TEST(ImpairedPort, WakeEndsOneWait) {
  Bench bench({.delay = 5ms});
  bench.send(kOne);
  bench.port->wake();
  EXPECT_FALSE(bench.port->receive(bench.buffer, kPatience).has_value());
  EXPECT_EQ(bench.clock.now(), Time{});
  EXPECT_TRUE(bench.port->receive(bench.buffer, kPatience).has_value());
}

struct LiveBench {
  explicit LiveBench(const LinkModel& model) {
    auto listening = listen_udp("127.0.0.1:0");
    EXPECT_TRUE(listening.has_value());
    address = (*listening)->local();
    port = impaired(std::move(*listening), model, clock);
    auto connected = connect_udp(to_string(address));
    EXPECT_TRUE(connected.has_value());
    sender = std::move(connected->port);
  }

  SteadyClock clock;
  Peer address;
  std::unique_ptr<DatagramPort> port, sender;
  std::array<std::byte, 1500> buffer;
};

TEST(ImpairedPort, DelaysAndLosesOnLoopback) {
  constexpr LinkModel kModel{.delay = 20ms, .jitter = 10ms, .loss = 0.3, .seed = 5};
  constexpr std::uint8_t kCount = 200;
  LiveBench bench(kModel);
  std::vector<Time> sent;
  Impairment same(kModel, Time{});
  std::vector<int> expected, received;
  for (std::uint8_t i = 0; i < kCount; ++i) {
    const std::array bytes{std::byte{i}};
    sent.push_back(bench.clock.now());
    ASSERT_TRUE(bench.sender->send(bench.address, bytes));
    same.push(Time(i * 1h), {}, bytes);  // the arrival times do not decide which datagrams are lost
  }
  for (; same.front() != nullptr; same.pop())
    expected.push_back(std::to_integer<int>(same.front()->bytes()[0]));
  while (received.size() < expected.size()) {
    const auto datagram = bench.port->receive(bench.buffer, kPatience);
    ASSERT_TRUE(datagram.has_value());
    const Time now = bench.clock.now();
    received.push_back(std::to_integer<int>(datagram->bytes[0]));
    EXPECT_GE(now, datagram->arrived);
    EXPECT_GE(datagram->arrived - sent[static_cast<std::size_t>(received.back())], 20ms);
  }
  EXPECT_FALSE(bench.port->receive(bench.buffer, 0s).has_value());
  std::ranges::sort(received);
  EXPECT_EQ(received, expected);
}

TEST(ImpairedPort, AnotherThreadWakesAndSends) {
  LiveBench bench({.delay = kPatience});
  ASSERT_TRUE(bench.sender->send(bench.address, kOne));
  const Stopwatch waited;
  std::jthread other([&] {
    bench.port->send(bench.address, kTwo);
    EXPECT_EQ(bench.port->counters().sent, 1u);
    bench.port->wake();
  });
  EXPECT_FALSE(bench.port->receive(bench.buffer, kPatience).has_value());
  EXPECT_LT(waited.elapsed(), kPatience);
}

}  // namespace
}  // namespace farshade
