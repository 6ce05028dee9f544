// The times at which the server answers a client's next request and sends the datagrams of a frame.
#include <gtest/gtest.h>

#include "tests/unit/server_core/house.h"

namespace farshade {
namespace {

using namespace std::chrono_literals;
using namespace house_test;

/// The time from the first to the last of a frame's eight datagrams, after 100 requests.
Duration spread_of_frame(Duration between_displays, Duration between_arrivals) {
  House house;
  LinkClient client = house.join(1);
  const std::vector<Bytes> messages(8, Bytes(100, std::byte{1}));
  Duration spread{};
  Time now{};
  for (std::uint32_t frame = 1; frame <= 100; ++frame) {
    now += between_arrivals;
    FrameRequest request = request_of(frame, kSize);
    request.display_time = Time(frame * between_displays);
    house.talk(client, 1, client.seal({.request = request}), now);
    const auto job = house.sessions.next_job(now);
    if (!job) continue;
    house.sessions.put(job->session, messages, {}, now);
    Peer to;
    Bytes datagram;
    while (const auto due = house.sessions.due_at()) {
      spread = *due - now;
      EXPECT_TRUE(house.sessions.seal_due(*due, to, datagram));
    }
  }
  return spread;
}

TEST(SessionPacing, FollowsTheShorterOfDisplayAndArrivalIntervals) {
  const auto expected_ms = [](double interval_ms) { return interval_ms * 0.5 * 7 / 8; };
  EXPECT_NEAR(ms_of(spread_of_frame(14ms, 14ms)), expected_ms(14), 0.01);
  EXPECT_NEAR(ms_of(spread_of_frame(14ms, 40ms)), expected_ms(14), 0.01) << "virtual time";
  EXPECT_NEAR(ms_of(spread_of_frame(40ms, 14ms)), expected_ms(14), 0.01) << "requests that bunch up";
  EXPECT_NEAR(ms_of(spread_of_frame(80ms, 90ms)), expected_ms(50), 0.01) << "the upper limit";
}

/// A path of 100 kB/s that has taken 20 messages of the first answer, and a client that requests masks of
/// positions.
struct SlowPath : House {
  SlowPath() : House({.bytes_per_second = 100e3}) {
    Welcome served = kServed;
    served.answers = kTracedAnswers;
    sessions = Sessions(served, kRing, {.bytes_per_second = 100e3});
    client = join(1);
    ask(client, 1, 1);
    sessions.put(sessions.next_job({})->session, std::vector<Bytes>(20, Bytes(1000, std::byte{1})), {}, {});
    Peer to;
    for (Bytes datagram; sessions.seal_due(Time(1s), to, datagram);) {
    }
  }
  LinkClient client{kRing[0], kServed};
};

TEST(SessionPacing, NextRequestWaitsUntilThePathHasDrained) {
  SlowPath path;
  path.ask(path.client, 1, 2, Time(5ms));
  EXPECT_EQ(path.sessions.job_at(), Time(200ms));
}

TEST(SessionPacing, ARequestWithoutItsPositionsWaitsForThePathToo) {
  SlowPath path;
  FrameRequest request = request_of(2, kSize);
  request.answer = {.kind = Answer::MasksOfPositions, .position_bits = 16, .slices = 3};
  path.talk(path.client, 1, path.client.seal({.request = request}), Time(5ms));
  EXPECT_EQ(path.sessions.job_at(), Time(200ms));
  request.frame = {3};
  path.talk(path.client, 1, path.client.seal({.request = request}), Time(195ms));
  EXPECT_EQ(path.sessions.job_at(), Time(195ms) + kPartsTimeout);
}

TEST(SessionKeepAlive, IsSentToAClientThatAsksAndGetsNothing) {
  House house;
  LinkClient client = house.join(1);
  house.ask(client, 1, 1, Time(100ms));
  EXPECT_EQ(client.probes, 0u);
  house.ask(client, 1, 2, Time(101ms));
  EXPECT_EQ(client.probes, 1u);
  house.ask(client, 1, 3, Time(201ms));
  EXPECT_EQ(client.probes, 1u) << "100 ms since the last one";
  house.ask(client, 1, 4, Time(202ms));
  EXPECT_EQ(client.probes, 2u);
}

TEST(Sessions, SealsTheDatagramThatIsDueFirst) {
  House house;
  LinkClient late = house.join(1), early = house.join(2, {}, kRing[1]);
  for (auto [client, port] : {std::pair{&late, std::uint16_t{1}}, {&early, std::uint16_t{2}}})
    house.ask(*client, port, 1);
  const std::vector<Bytes> one{Bytes(100, std::byte{1})};
  house.sessions.put(late.session.value(), one, {}, Time(2ms));
  house.sessions.put(early.session.value(), one, {}, Time(1ms));
  Peer to;
  Bytes datagram;
  EXPECT_EQ(house.sessions.due_at(), Time(1ms));
  EXPECT_FALSE(house.sessions.seal_due(Time(999us), to, datagram));
  ASSERT_TRUE(house.sessions.seal_due(Time(5ms), to, datagram));
  EXPECT_EQ(to, peer(2));
  ASSERT_TRUE(house.sessions.seal_due(Time(5ms), to, datagram));
  EXPECT_EQ(to, peer(1));
}

}  // namespace
}  // namespace farshade
