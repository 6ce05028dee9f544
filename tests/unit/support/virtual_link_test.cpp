#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "stereo/messages/messages.h"
#include "tests/support/manual_clock.h"
#include "tests/support/virtual_link.h"

namespace farshade {
namespace {

using namespace std::chrono_literals;

struct Arrival {
  Time time;
  int number;
  friend bool operator==(const Arrival&, const Arrival&) = default;
};

bool send_number(DatagramPort& from, const Peer& to, int number) {
  const std::array<std::byte, 2> bytes{static_cast<std::byte>(number >> 8), static_cast<std::byte>(number)};
  return from.send(to, bytes);
}

std::optional<int> receive_number(DatagramPort& at, Duration wait) {
  std::array<std::byte, kMaxDatagram_bytes> buffer;
  const auto datagram = at.receive(buffer, wait);
  if (!datagram) return std::nullopt;
  return std::to_integer<int>(datagram->bytes[0]) << 8 | std::to_integer<int>(datagram->bytes[1]);
}

/// Sends `count` numbers to the server, 1 ms apart, and receives them.
std::vector<Arrival> run(const LinkModels& models, int count) {
  ManualClock clock;
  VirtualLink link(clock, models);
  std::vector<Arrival> received;
  const auto hear_until = [&](Time deadline) {
    while (clock.now() < deadline)
      if (const auto number = receive_number(link.server(), deadline - clock.now()))
        received.push_back({clock.now(), *number});
  };
  for (int i = 0; i < count; ++i) {
    send_number(link.client(), link.server().local(), i);
    hear_until(clock.now() + 1ms);
  }
  hear_until(clock.now() + 1s);
  return received;
}

TEST(VirtualLink, DelaysExactly) {
  ManualClock clock;
  VirtualLink link(clock, {.to_server = {.delay = 5ms}, .to_client = {.delay = 7ms}});
  send_number(link.client(), link.server().local(), 1);
  EXPECT_EQ(receive_number(link.server(), 4999us), std::nullopt);
  EXPECT_EQ(clock.now(), Time(4999us));
  EXPECT_EQ(receive_number(link.server(), 1s), 1);
  EXPECT_EQ(clock.now(), Time(5ms));
  send_number(link.server(), link.client().local(), 2);
  EXPECT_EQ(receive_number(link.client(), 1s), 2);
  EXPECT_EQ(clock.now(), Time(12ms));
}

TEST(VirtualLink, PollPassesNoTime) {
  ManualClock clock;
  VirtualLink link(clock, {});
  send_number(link.client(), link.server().local(), 1);
  EXPECT_EQ(receive_number(link.server(), 0s), 1);
  EXPECT_EQ(receive_number(link.server(), 0s), std::nullopt);
  EXPECT_EQ(clock.now(), Time{});
}

TEST(VirtualLink, SameSeedSameRun) {
  const LinkModels models{
      .to_server = {.delay = 3ms, .jitter = 9ms, .loss = 0.2}, .to_client = {}, .seed = 42};
  const auto first = run(models, 500);
  EXPECT_EQ(first, run(models, 500));
  LinkModels other = models;
  other.seed = 43;
  EXPECT_NE(first, run(other, 500));
}

TEST(VirtualLink, ThisRunIsTheSameOnEveryMachine) {
  const auto received =
      run({.to_server = {.delay = 3ms, .jitter = 9ms, .loss = 0.5}, .to_client = {}, .seed = 1}, 12);
  std::vector<int> numbers;
  for (const Arrival& arrival : received) numbers.push_back(arrival.number);
  EXPECT_EQ(numbers, (std::vector<int>{0, 3, 11, 4}));
}

TEST(VirtualLink, LosesTheGivenShare) {
  const auto received = run({.to_server = {.loss = 0.25}, .to_client = {}, .seed = 7}, 4000);
  const double deviation = std::sqrt(0.25 * 0.75 / 4000);
  EXPECT_NEAR(static_cast<double>(received.size()) / 4000, 0.75, 4 * deviation);
}

TEST(VirtualLink, LossLeavesTheDelaysOfTheOthersAlone) {
  LinkModels models{.to_server = {.delay = 1ms, .jitter = 20ms}, .to_client = {}, .seed = 5};
  const auto all = run(models, 200);
  ASSERT_EQ(all.size(), 200u);
  models.to_server.loss = 0.5;
  for (const Arrival& arrival : run(models, 200)) EXPECT_NE(std::ranges::find(all, arrival), all.end());
}

TEST(VirtualLink, JitterStaysInItsBoundsAndReorders) {
  const auto received = run({.to_server = {.delay = 4ms, .jitter = 10ms}, .to_client = {}, .seed = 3}, 300);
  ASSERT_EQ(received.size(), 300u);
  int overtaken = 0;
  for (std::size_t i = 0; i < received.size(); ++i) {
    const Duration travelled = received[i].time - Time(std::chrono::milliseconds(received[i].number));
    EXPECT_GE(travelled, 4ms);
    EXPECT_LT(travelled, 14ms);
    if (i > 0 && received[i].number < received[i - 1].number) ++overtaken;
  }
  EXPECT_GT(overtaken, 50);
}

TEST(VirtualLink, DirectionsDoNotDisturbEachOther) {
  const auto numbers_up = [](bool talk_back) {
    ManualClock clock;
    VirtualLink link(clock, {.to_server = {.loss = 0.5}, .to_client = {.loss = 0.5}, .seed = 9});
    std::vector<int> received;
    for (int i = 0; i < 64; ++i) {
      send_number(link.client(), link.server().local(), i);
      if (talk_back) send_number(link.server(), link.client().local(), i);
      if (const auto number = receive_number(link.server(), 0s)) received.push_back(*number);
    }
    return received;
  };
  EXPECT_EQ(numbers_up(false), numbers_up(true));
}

TEST(VirtualLink, FarEndAnswersWithinTheWait) {
  ManualClock clock;
  VirtualLink link(clock, {.to_server = {.delay = 2ms}, .to_client = {.delay = 3ms}});
  link.while_waiting([&] {
    while (const auto number = receive_number(link.server(), 0s))
      send_number(link.server(), link.client().local(), *number + 100);
  });
  // Two datagrams arrive at the same time. The other side is called for both.
  send_number(link.client(), link.server().local(), 1);
  EXPECT_EQ(receive_number(link.client(), 10ms), 101);
  EXPECT_EQ(clock.now(), Time(5ms));
  send_number(link.client(), link.server().local(), 2);
  EXPECT_EQ(receive_number(link.client(), 4ms), std::nullopt);
  EXPECT_EQ(receive_number(link.client(), 1ms), 102);
}

TEST(VirtualLink, AnEndThatDoesNotReadBlocksNobody) {
  ManualClock clock;
  VirtualLink link(clock, {});
  link.while_waiting([] {});
  send_number(link.client(), link.server().local(), 1);
  EXPECT_EQ(receive_number(link.client(), 10ms), std::nullopt);
  EXPECT_EQ(clock.now(), Time(10ms));
}

TEST(VirtualLink, WakeEndsOneWait) {
  ManualClock clock;
  VirtualLink link(clock, {});
  link.client().wake();
  EXPECT_EQ(receive_number(link.client(), 10ms), std::nullopt);
  EXPECT_EQ(clock.now(), Time{});
  EXPECT_EQ(receive_number(link.client(), 10ms), std::nullopt);
  EXPECT_EQ(clock.now(), Time(10ms));
}

TEST(VirtualLink, CountsWhatItCannotCarry) {
  ManualClock clock;
  VirtualLink link(clock, {});
  EXPECT_FALSE(send_number(link.client(), link.client().local(), 1));
  for (std::size_t i = 0; i < kLinkCapacity; ++i)
    EXPECT_TRUE(send_number(link.client(), link.server().local(), 1));
  EXPECT_FALSE(send_number(link.client(), link.server().local(), 1));
  EXPECT_EQ(link.client().counters(),
            (PortCounters{.sent = kLinkCapacity, .sent_bytes = 2 * kLinkCapacity, .unsent = 2}));
  std::array<std::byte, 1> small;
  EXPECT_FALSE(link.server().receive(small, 0s).has_value());
  EXPECT_EQ(link.server().counters().oversized, kLinkCapacity);
}

TEST(VirtualLink, TellsWhenTheNextDatagramArrives) {
  ManualClock clock;
  VirtualLink link(clock, {.to_server = {.delay = 9ms}, .to_client = {.delay = 4ms}});
  EXPECT_EQ(link.next_arrival(), std::nullopt);
  send_number(link.client(), link.server().local(), 1);
  EXPECT_EQ(link.next_arrival(), Time(9ms));
  send_number(link.server(), link.client().local(), 1);
  EXPECT_EQ(link.next_arrival(), Time(4ms));
}

TEST(VirtualLink, LateReaderSeesWhenADatagramCame) {
  ManualClock clock;
  VirtualLink link(clock, {.to_server = {.delay = 5ms}, .to_client = {}});
  send_number(link.client(), link.server().local(), 1);
  clock.advance_to(Time(1s));
  std::array<std::byte, kMaxDatagram_bytes> buffer;
  const auto late = link.server().receive(buffer, 0s);
  ASSERT_TRUE(late.has_value());
  EXPECT_EQ(late->arrived, Time(5ms));
}

TEST(VirtualLink, ServerHearsAllClientsInOrderOfArrival) {
  ManualClock clock;
  VirtualLink link(clock, {.to_server = {.jitter = 50ms}, .to_client = {.delay = 1ms}, .seed = 11}, 64);
  for (std::size_t i = 0; i < 64; ++i)
    send_number(link.client(i), link.server().local(), static_cast<int>(i));
  std::vector<int> received;
  std::array<std::byte, kMaxDatagram_bytes> buffer;
  Time last{};
  while (const auto datagram = link.server().receive(buffer, 50ms)) {
    const int number = std::to_integer<int>(datagram->bytes[1]);
    EXPECT_EQ(datagram->from, link.client(static_cast<std::size_t>(number)).local());
    EXPECT_EQ(datagram->arrived, clock.now());
    EXPECT_GE(datagram->arrived, last);
    last = datagram->arrived;
    received.push_back(number);
    send_number(link.server(), datagram->from, 100 + number);
    if (received.size() == 64) break;
  }
  EXPECT_FALSE(std::ranges::is_sorted(received)) << "each client has its own delays";
  for (std::size_t i = 0; i < 64; ++i) {
    EXPECT_EQ(receive_number(link.client(i), 1ms), static_cast<int>(100 + i));
    EXPECT_EQ(receive_number(link.client(i), 0s), std::nullopt);
  }
  EXPECT_EQ(link.next_arrival(), std::nullopt);
}

TEST(VirtualLink, ClientsDoNotDisturbEachOther) {
  const auto numbers_up = [](std::size_t clients) {
    ManualClock clock;
    VirtualLink link(clock, {.to_server = {.loss = 0.5}, .to_client = {}, .seed = 9}, clients);
    std::vector<int> received;
    for (int i = 0; i < 64; ++i)
      for (std::size_t c = 0; c < clients; ++c) {
        send_number(link.client(c), link.server().local(), i);
        if (const auto number = receive_number(link.server(), 0s); number && c == 0)
          received.push_back(*number);
      }
    return received;
  };
  EXPECT_EQ(numbers_up(1), numbers_up(5));
}

TEST(VirtualLink, AllOthersAnswerWithinTheWait) {
  ManualClock clock;
  VirtualLink link(clock, {.to_server = {.delay = 2ms}, .to_client = {.delay = 3ms}}, 2);
  std::vector<int> second_heard;
  link.while_waiting([&] {
    while (const auto number = receive_number(link.server(), 0s))
      for (std::size_t c = 0; c < 2; ++c) send_number(link.server(), link.client(c).local(), *number + 100);
    while (const auto number = receive_number(link.client(1), 0s)) second_heard.push_back(*number);
  });
  send_number(link.client(0), link.server().local(), 1);
  EXPECT_EQ(receive_number(link.client(0), 10ms), 101);
  EXPECT_EQ(receive_number(link.client(0), 10ms), std::nullopt);
  EXPECT_EQ(second_heard, std::vector<int>{101});
}

TEST(VirtualLink, MovedClientIsReachedOnlyAtItsNewAddress) {
  ManualClock clock;
  VirtualLink link(clock, {.to_server = {.delay = 2ms}, .to_client = {.delay = 3ms}}, 2);
  const Peer old = link.client(1).local();
  send_number(link.client(1), link.server().local(), 1);
  send_number(link.server(), old, 2);
  link.move_client(1);
  EXPECT_NE(link.client(1).local(), old);
  EXPECT_NE(link.client(1).local(), link.client(0).local());
  EXPECT_TRUE(send_number(link.server(), old, 3)) << "the sender does not learn of it";
  EXPECT_EQ(link.lost_to_old_addresses(), 2u);
  send_number(link.client(1), link.server().local(), 4);
  std::array<std::byte, kMaxDatagram_bytes> buffer;
  const auto before = link.server().receive(buffer, 1s);
  ASSERT_TRUE(before.has_value());
  EXPECT_EQ(before->from, old);
  const auto after = link.server().receive(buffer, 1s);
  ASSERT_TRUE(after.has_value());
  EXPECT_EQ(after->from, link.client(1).local());
  send_number(link.server(), after->from, 5);
  EXPECT_EQ(receive_number(link.client(1), 1s), 5);
  EXPECT_EQ(receive_number(link.client(1), 1s), std::nullopt);
}

TEST(VirtualLinkWait, RunsTheOthersWhenTheyAreDueAlthoughNothingArrives) {
  ManualClock clock;
  VirtualLink link(clock, {.to_server = {.delay = 5ms}, .to_client = {.delay = 5ms}});
  std::vector<Time> ran;
  Time due(3ms);
  const std::array<std::byte, 1> byte{};
  link.while_waiting(
      [&] {
        ran.push_back(clock.now());
        due += 10ms;
        if (ran.size() == 2) link.server().send(link.client().local(), byte);
      },
      [&]() -> std::optional<Time> { return due; });
  std::array<std::byte, 8> buffer;
  ASSERT_TRUE(link.client().receive(buffer, 100ms).has_value());
  EXPECT_EQ(ran, (std::vector{Time(3ms), Time(13ms)}));
  EXPECT_EQ(clock.now(), Time(18ms));
}

}  // namespace
}  // namespace farshade
