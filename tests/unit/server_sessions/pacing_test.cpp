// The times at which the server answers a client's next request and sends the datagrams of a frame.
#include <gtest/gtest.h>

#include "tests/unit/server_sessions/sessions_bench.h"

namespace farshade {
namespace {

using namespace std::chrono_literals;
using namespace sessions_bench;

/// The time from the first to the last of a frame's eight datagrams, after 100 requests.
Duration spread_of_frame(Duration between_displays, Duration between_arrivals) {
  SessionsBench bench;
  LinkClient client = bench.join(1);
  const std::vector<Bytes> messages(8, Bytes(100, std::byte{1}));
  Duration spread{};
  Time now{};
  for (std::uint32_t frame = 1; frame <= 100; ++frame) {
    now += between_arrivals;
    FrameRequest request = request_of(frame, kSize);
    request.display_time = Time(frame * between_displays);
    bench.talk(client, 1, client.seal({.request = request, .arrivals = client.arrivals.report()}), now);
    const auto job = bench.sessions.next_job(now);
    if (!job) continue;
    bench.sessions.put(job->session, messages, {}, now);
    Peer to;
    Bytes datagram;
    while (const auto due = bench.sessions.due_at()) {
      spread = *due - now;
      EXPECT_TRUE(bench.sessions.seal_due(*due, to, datagram));
      client.arrivals.add(std::get<Sealed>(*open_server_envelope(datagram)).counter, *due);
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
struct SlowPath : SessionsBench {
  SlowPath() : SessionsBench({.bytes_per_second = 100e3}) {
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

/// A client that requests and receives frames of 20 messages. It reports arrivals only while `reports`.
struct Listener : SessionsBench {
  /// Returns the bytes per second that were sent to it in `time`.
  double run(Duration time, bool reports) {
    std::size_t bytes = 0;
    for (const Time until = now + time; now < until; now += 2ms) {
      RequestMessage message{.request = request_of(++frame, kSize)};
      if (reports) message.arrivals = client.arrivals.report();
      talk(client, 1, client.seal(message), now);
      if (const auto job = sessions.next_job(now)) {
        sessions.put(job->session, std::vector<Bytes>(20, Bytes(1000, std::byte{1})), {}, now);
        put_at = now;
      }
      Peer to;
      for (Bytes datagram; sessions.seal_due(now, to, datagram); bytes += datagram.size()) {
        oldest = std::max(oldest, now - put_at);
        if (reports)
          client.arrivals.add(std::get<Sealed>(*open_server_envelope(datagram)).counter, now + 5ms);
      }
    }
    return static_cast<double>(bytes) / seconds_of(time);
  }
  LinkClient client = join(1);
  Time now{}, put_at{};
  Duration oldest{};  ///< greatest time from the making of a frame to the leaving of one of its datagrams
  std::uint32_t frame = 0;
};

TEST(SessionPacing, SlowsDownWithinASecondWhenReportsStopAndIsBackAtOnce) {
  Listener listener;
  const double before = listener.run(3s, true);
  listener.run(1s, false);
  const double after_a_second = listener.run(200ms, false), later = listener.run(2s, false);
  listener.run(20ms, true);
  const double again = listener.run(500ms, true);
  std::printf("kB/s: %.0f; a second after the last report %.0f, then %.0f; with reports again %.0f\n",
              before / 1e3, after_a_second / 1e3, later / 1e3, again / 1e3);
  EXPECT_LT(after_a_second, before / 8);
  EXPECT_LT(later, 40e3) << "the least rate is 25 kB/s";
  EXPECT_GT(again, 0.7 * before);
}

/// The greatest age of a frame's datagram when it leaves, in the second after reports have stopped.
TEST(SessionPacing, ANewerFrameOvertakesOneThatHasBecomeSlow) {
  Listener listener;
  listener.run(3s, true);
  EXPECT_EQ(listener.sessions.counters().overtaken, 0u);
  listener.oldest = {};
  listener.run(1500ms, false);
  std::printf("the oldest datagram left %.0f ms after its frame was made\n", ms_of(listener.oldest));
  EXPECT_LT(listener.oldest, 200ms);
  EXPECT_GE(listener.sessions.counters().overtaken, 1u);
}

TEST(SessionKeepAlive, IsSentToAClientThatAsksAndGetsNothing) {
  SessionsBench bench;
  LinkClient client = bench.join(1);
  bench.ask(client, 1, 1, Time(100ms));
  EXPECT_EQ(client.probes, 0u);
  bench.ask(client, 1, 2, Time(101ms));
  EXPECT_EQ(client.probes, 1u);
  bench.ask(client, 1, 3, Time(201ms));
  EXPECT_EQ(client.probes, 1u) << "100 ms since the last one";
  bench.ask(client, 1, 4, Time(202ms));
  EXPECT_EQ(client.probes, 2u);
}

TEST(SessionKeepAlive, IsNotReplacedByAProbeOfThePath) {
  SessionsBench bench;
  LinkClient client = bench.join(1);
  bench.ask(client, 1, 1, Time(101ms));
  ASSERT_EQ(client.probes, 1u);
  const auto answer_to = [&](std::uint32_t frame, Time now) {
    RequestMessage message{.request = request_of(frame, kSize), .arrivals = client.arrivals.report()};
    const Bytes answer = bench.say(1, client.seal(message), now);
    client.take(answer, now);
    return answer;
  };
  // The report tells of the first arrival, so that the first probe of the path is due, too.
  EXPECT_LT(answer_to(2, Time(202ms)).size(), kBaseDatagram_bytes);
  EXPECT_EQ(client.probes, 2u);
  EXPECT_EQ(answer_to(3, Time(203ms)).size(), PathMtu::kSizes[1]);
  EXPECT_EQ(client.probes, 2u);
}

TEST(Sessions, SealsTheDatagramThatIsDueFirst) {
  SessionsBench bench;
  LinkClient late = bench.join(1), early = bench.join(2, {}, kRing[1]);
  for (auto [client, port] : {std::pair{&late, std::uint16_t{1}}, {&early, std::uint16_t{2}}})
    bench.ask(*client, port, 1);
  const std::vector<Bytes> one{Bytes(100, std::byte{1})};
  bench.sessions.put(late.session.value(), one, {}, Time(2ms));
  bench.sessions.put(early.session.value(), one, {}, Time(1ms));
  Peer to;
  Bytes datagram;
  EXPECT_EQ(bench.sessions.due_at(), Time(1ms));
  EXPECT_FALSE(bench.sessions.seal_due(Time(999us), to, datagram));
  ASSERT_TRUE(bench.sessions.seal_due(Time(5ms), to, datagram));
  EXPECT_EQ(to, peer(2));
  ASSERT_TRUE(bench.sessions.seal_due(Time(5ms), to, datagram));
  EXPECT_EQ(to, peer(1));
}

}  // namespace
}  // namespace farshade
