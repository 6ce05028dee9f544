// A client that holds a valid key, and does with it what it likes, costs the clients of other keys nothing.
#include <gtest/gtest.h>

#include <functional>
#include <set>

#include "tests/unit/forged.h"
#include "tests/unit/server_sessions/sessions_bench.h"

namespace farshade {
namespace {

using namespace std::chrono_literals;
using namespace sessions_bench;

const SharedKey kGood = kRing[0], kEvil = kRing[2];
constexpr std::uint16_t kGoodPort = 1, kEvilPort = 100;
constexpr SessionLimits kOpen{.sessions = 65, .handshakes_per_second = 1e6};

/// The time of the worker that a good client gets which always wants more. Both sides' jobs take what the
/// arguments say. `reconnects`: each session of the other key begins anew after each job.
double good_share(Duration good_job, Duration evil_job, std::size_t evil_sessions, bool reconnects) {
  SessionsBench bench(kOpen);
  LinkClient good = bench.join(kGoodPort, {}, kGood);
  std::vector<LinkClient> evil;
  const auto port_of = [](std::size_t i) { return static_cast<std::uint16_t>(kEvilPort + i); };
  for (std::size_t i = 0; i < evil_sessions; ++i) evil.push_back(bench.join(port_of(i), {}, kEvil));
  Duration to_good{}, all{};
  std::uint32_t frame = 1;
  bench.ask(good, kGoodPort, frame);
  for (std::size_t i = 0; i < evil.size(); ++i) bench.ask(evil[i], port_of(i), frame);
  while (all < 20s) {
    ++frame;
    const auto job = bench.sessions.next_job({});
    const bool is_good = job->session == good.session;
    if (is_good) bench.ask(good, kGoodPort, frame);
    for (std::size_t i = 0; i < evil.size(); ++i) {
      if (evil[i].session != job->session) continue;
      if (reconnects) evil[i] = bench.join(port_of(i), {}, kEvil);
      bench.ask(evil[i], port_of(i), frame);  // of a new session: the one whose job is in work ends
    }
    const Duration work = is_good ? good_job : evil_job;
    bench.sessions.put(job->session, {}, work, {});
    all += work;
    if (is_good) to_good += work;
  }
  return seconds_of(to_good) / seconds_of(all);
}

TEST(Insider, OneKeyWithManySessionsLeavesHalfOfTheWorkerToAnother) {
  const double equal = good_share(5ms, 5ms, 63, false), long_jobs = good_share(5ms, 400ms, 63, false),
               anew = good_share(5ms, 5ms, 63, true), both = good_share(5ms, 400ms, 63, true);
  std::printf(
      "the good client's share of the worker: %.3f, against long jobs %.3f, against sessions that "
      "begin anew %.3f, both %.3f\n",
      equal, long_jobs, anew, both);
  EXPECT_GE(equal, 0.499);
  EXPECT_GE(long_jobs, 0.48) << "one job of 0.4 s of 20 s is the difference";
  EXPECT_GE(anew, 0.499);
  EXPECT_GE(both, 0.48);
}

TEST(Insider, DebtOutlivesTheSession) {
  SessionsBench bench(kOpen);
  LinkClient good = bench.join(kGoodPort, {}, kGood), evil = bench.join(kEvilPort, {}, kEvil);
  std::uint32_t frame = 1;
  bench.ask(evil, kEvilPort, frame);
  bench.sessions.put(bench.sessions.next_job({})->session, {}, 1s, {});
  const Time later = Time(SessionLimits{}.silence + 1s);
  bench.sessions.end_silent(later);
  ASSERT_EQ(bench.sessions.size(), 0u);
  good = bench.join(kGoodPort, later, kGood);
  evil = bench.join(kEvilPort, later, kEvil);
  for (int i = 0; i < 199; ++i) {
    bench.ask(evil, kEvilPort, ++frame, later);
    bench.ask(good, kGoodPort, frame, later);
    const auto job = bench.sessions.next_job(later);
    ASSERT_EQ(job->session, good.session) << i;
    bench.sessions.put(job->session, {}, 5ms, later);
  }
}

TEST(Insider, AFullServerTakesASessionFromTheKeyWithTheMost) {
  SessionsBench bench({.sessions = 4, .handshakes_per_second = 1e6});
  std::vector<LinkClient> evil;
  for (std::uint16_t i = 0; i < 4; ++i) {
    evil.push_back(bench.join(kEvilPort + i, Time(i * 1ms), kEvil));
    bench.ask(evil.back(), kEvilPort + i, 1, Time(i * 1ms));
  }
  LinkClient good = bench.join(kGoodPort, Time(10ms), kGood);
  ASSERT_TRUE(good.welcome.has_value());
  EXPECT_EQ(bench.sessions.size(), 4u);
  EXPECT_EQ(bench.sessions.counters().displaced, 1u);
  bench.ask(evil[3], kEvilPort + 3, 2, Time(11ms));
  EXPECT_EQ(evil[3].no_session, 1u) << "the newest";
  EXPECT_TRUE(bench.join(kEvilPort + 9, Time(12ms), kEvil).refusal.has_value()) << "it has the most already";
  EXPECT_TRUE(bench.join(kGoodPort + 1, Time(13ms), kGood).welcome.has_value());
  EXPECT_TRUE(bench.join(kGoodPort + 2, Time(14ms), kGood).refusal.has_value()) << "two each";
  EXPECT_EQ(bench.sessions.counters().displaced, 2u);
}

/// Otherwise the two keys would take the odd session from each other without end.
TEST(Insider, AFullServerTakesNoSessionFromAKeyWithOneMore) {
  SessionsBench bench({.sessions = 3, .handshakes_per_second = 1e6});
  bench.join(kEvilPort, {}, kEvil);
  bench.join(kEvilPort + 1, {}, kEvil);
  ASSERT_TRUE(bench.join(kGoodPort, {}, kGood).welcome.has_value());
  EXPECT_TRUE(bench.join(kGoodPort + 1, {}, kGood).refusal.has_value());
  EXPECT_EQ(bench.sessions.counters().displaced, 0u);
}

TEST(Insider, OneKeyCannotUseUpTheHandshakes) {
  SessionsBench bench({.sessions = 1000, .handshakes_per_second = 10});
  std::size_t evil = 0;
  for (std::uint16_t i = 0; i < 50; ++i)
    evil += bench.join(kEvilPort + i, {}, kEvil).welcome.has_value() ? 1 : 0;
  EXPECT_EQ(evil, 5u) << "half of the limit";
  EXPECT_EQ(bench.sessions.gate().too_many, 45u);
  EXPECT_TRUE(bench.join(kGoodPort, {}, kGood).welcome.has_value());
}

TEST(Insider, TwoKeysThatWorkTogetherLeaveANewcomerAHandshakeAndMemory) {
  SessionLimits limits{.sessions = 1000, .handshakes_per_second = 10};
  limits.memory.limit_bytes = 16 * kSession_bytes;  // eight sessions, of which each key has one in any case
  SessionsBench bench(limits);
  std::size_t evil = 0;
  for (int second = 0; second < 20; ++second)
    for (std::uint16_t i = 0; i < 20; ++i) {
      const auto port = static_cast<std::uint16_t>(kEvilPort + 20 * second + i);
      evil += bench.join(port, Time(std::chrono::seconds(second)), kRing[i % 2 + 1]).welcome.has_value();
    }
  EXPECT_GT(evil, 6u) << "sessions without a request end soon";
  EXPECT_EQ(bench.sessions.size(), 6u) << "what two keys can hold";
  const Time then(19s);
  EXPECT_TRUE(bench.join(kGoodPort, then, kGood).welcome.has_value());
  EXPECT_FALSE(bench.join(kGoodPort + 1, then, kGood).welcome.has_value()) << "its own handshake is used";
}

TEST(Insider, MemoryThatIsSharedComesBack) {
  SessionLimits limits{.sessions = 1000, .handshakes_per_second = 1e6};
  limits.memory.limit_bytes = 16 * kSession_bytes;
  SessionsBench bench(limits);
  const auto join_all = [&](Time now) {
    std::size_t joined = 0;
    for (std::uint16_t i = 0; i < 30; ++i)
      joined += bench.join(kEvilPort + i, now, kRing[i % 2 + 1]).welcome.has_value();
    return joined;
  };
  EXPECT_EQ(join_all({}), 6u);
  bench.sessions.end_silent(Time(SessionLimits{}.silence + 1s));
  EXPECT_EQ(bench.sessions.held_bytes(), 0u);
  EXPECT_EQ(join_all(Time(100s)), 6u);
  bench.sessions.set_ring({kRing[1]});
  EXPECT_LT(bench.sessions.size(), 6u);
  EXPECT_EQ(bench.sessions.size() + join_all(Time(101s)), 8u) << "a key that is alone has all";
  bench.sessions.set_ring(kRing);
  EXPECT_EQ(join_all(Time(102s)), 1u)
      << "another key has its own again, and the first one all that is shared";
}

TEST(Insider, AKeyThatIsNoLongerAloneHasHalfOfTheHandshakes) {
  SessionsBench bench({.sessions = 1000, .handshakes_per_second = 10});
  bench.sessions.set_ring({kEvil});
  EXPECT_TRUE(bench.join(kEvilPort, {}, kEvil).welcome.has_value());
  bench.sessions.set_ring(kRing);
  std::size_t evil = 0;
  for (std::uint16_t i = 0; i < 50; ++i)
    evil += bench.join(kEvilPort + i, Time(10s), kEvil).welcome.has_value() ? 1 : 0;
  EXPECT_EQ(evil, 5u);
}

/// A client that always wants answers of 20 kB and receives what it is sent. `lies`: it reports that all
/// datagrams up to the newest have arrived, whether they were sent or not.
struct Hungry {
  void step(SessionsBench& bench, Time now) {
    RequestMessage message{.request = request_of(++frame, kSize)};
    message.arrivals = client.arrivals.report();
    if (lies && message.arrivals.count > 0)
      for (std::uint32_t i = 0; i < message.arrivals.count; ++i)
        if (message.arrivals.ticks[i] == ArrivalReport::kNotArrived) message.arrivals.ticks[i] = 0;
    bench.talk(client, port, client.seal(message), now);
  }
  void take(const Bytes& datagram, Time now) {
    bytes += datagram.size();
    client.arrivals.add(std::get<Sealed>(*open_server_envelope(datagram)).counter, now + 5ms);
  }
  LinkClient client;
  std::uint16_t port;
  bool lies = false;
  std::uint32_t frame = 0;
  std::size_t bytes = 0;
};

/// Serves `clients` for `span`, in steps of a millisecond.
void serve(SessionsBench& bench, std::vector<Hungry>& clients, Time& now, Duration span) {
  for (const Time until = now + span; now < until; now += 1ms) {
    for (Hungry& each : clients)
      if (now.time_since_epoch() / 1ms % 10 == each.port % 10) each.step(bench, now);
    while (const auto job = bench.sessions.next_job(now))
      bench.sessions.put(job->session, std::vector<Bytes>(20, Bytes(1000, std::byte{1})), 1ms, now);
    Peer to;
    for (Bytes datagram; bench.sessions.seal_due(now, to, datagram);)
      for (Hungry& each : clients)
        if (peer(each.port) == to) each.take(datagram, now);
  }
}

TEST(Insider, AllSessionsTogetherHaveOneLimitAndEachKeyItsShare) {
  constexpr double kTotal = 1e6;
  SessionsBench bench({.sessions = 65, .handshakes_per_second = 1e6, .total_bytes_per_second = kTotal});
  Time now{};
  std::vector<Hungry> clients;
  clients.push_back({bench.join(kGoodPort, now, kGood), kGoodPort});
  for (std::uint16_t port = kEvilPort; port < kEvilPort + 32; ++port)
    clients.push_back({bench.join(port, now, kEvil), port});
  serve(bench, clients, now, 3s);
  std::size_t all = 0;
  for (const Hungry& each : clients) all += each.bytes;
  const double rate = static_cast<double>(all) / 3,
               share = static_cast<double>(clients[0].bytes) / static_cast<double>(all);
  std::printf("%.0f of %.0f kB/s; the good client's share %.3f\n", rate / 1e3, kTotal / 1e3, share);
  EXPECT_LE(rate, 1.01 * kTotal);
  EXPECT_GE(rate, 0.95 * kTotal);
  EXPECT_GE(share, 0.48);
}

TEST(Insider, WhoReportsArrivalsWithoutLookingGetsTheLeastRate) {
  SessionsBench bench;
  Time now{};
  std::vector<Hungry> clients;
  clients.push_back({bench.join(kGoodPort, now, kGood), kGoodPort});
  clients.push_back({bench.join(kEvilPort, now, kEvil), kEvilPort, true});
  serve(bench, clients, now, 5s);
  EXPECT_EQ(bench.sessions.counters().false_reports, 1u) << "and not the good one";
  const std::size_t good = clients[0].bytes, evil = clients[1].bytes;
  serve(bench, clients, now, 5s);
  std::printf("the second 5 s: %zu bytes to the good client, %zu to the other\n", clients[0].bytes - good,
              clients[1].bytes - evil);
  EXPECT_GT(clients[0].bytes - good, 1'000'000u);
  EXPECT_LT(clients[1].bytes - evil, 200'000u) << "25 kB/s";
}

TEST(Insider, AClientWithFalseReportsGetsNoRateBackByMoving) {
  SessionsBench bench;
  Time now{};
  std::vector<Hungry> clients;
  clients.push_back({bench.join(kEvilPort, now, kEvil), kEvilPort, true});
  serve(bench, clients, now, 5s);
  ASSERT_EQ(bench.sessions.counters().false_reports, 1u);
  Hungry& evil = clients[0];
  evil.port = kEvilPort + 1;
  evil.lies = false;
  const std::size_t before = evil.bytes;
  for (int i = 0; i < 3; ++i) {
    bench.talk(
        evil.client, evil.port,
        evil.client.seal({.request = request_of(++evil.frame, kSize), .probe_echo = evil.client.probe}), now);
    now += 14ms;
  }
  ASSERT_EQ(bench.sessions.counters().moved, 1u);
  serve(bench, clients, now, 5s);
  EXPECT_LT(evil.bytes - before, 200'000u) << "25 kB/s";
}

TEST(Insider, WhoSeesAHelloCannotRegisterItUnderItsOwnKey) {
  SessionsBench bench;
  LinkClient good(kGood, kServed);
  const Bytes first = good.hello();
  const PublicKey seen = std::get<Hello>(*open_client_envelope(first)).client;
  const Bytes retry = bench.say(kEvilPort, hello_with(seen, kEvil, kServed.scene_hash, {}));
  const Cookie cookie = std::get<Retry>(*open_server_envelope(retry)).cookie;
  const Bytes stolen = bench.say(kEvilPort, hello_with(seen, kEvil, kServed.scene_hash, cookie));
  ASSERT_TRUE(std::holds_alternative<Accept>(*open_server_envelope(stolen)));
  bench.talk(good, kGoodPort, first);
  EXPECT_TRUE(good.welcome.has_value()) << "the good client has its own session";
  EXPECT_EQ(bench.sessions.size(), 2u);
}

constexpr Extent kLarge{2048, 1024}, kUsual{640, 640};
static_assert(kUsual.pixels() == kUsualPixels);

void ask_for(SessionsBench& bench, LinkClient& client, std::uint16_t port, std::uint32_t frame, Extent size,
             Time now = {}) {
  bench.talk(client, port, client.seal({.request = request_of(frame, size)}), now);
}

TEST(Insider, ALongJobIsGivenUpOnlyWhileAnotherKeyWaits) {
  SessionsBench bench(kOpen);
  LinkClient evil = bench.join(kEvilPort, {}, kEvil), evil_too = bench.join(kEvilPort + 1, {}, kEvil),
             good = bench.join(kGoodPort, {}, kGood);
  ask_for(bench, evil, kEvilPort, 1, kLarge);
  ASSERT_TRUE(bench.sessions.next_job({}).has_value());
  EXPECT_FALSE(bench.sessions.gives_up(Time(1min))) << "nobody waits";
  ask_for(bench, evil_too, kEvilPort + 1, 1, kUsual);
  EXPECT_FALSE(bench.sessions.gives_up(Time(1min))) << "only its own key waits";
  ask_for(bench, good, kGoodPort, 1, kUsual);
  EXPECT_FALSE(bench.sessions.gives_up(Time(kMostTurn)));
  EXPECT_TRUE(bench.sessions.gives_up(Time(kMostTurn + 1ms)));
}

TEST(Insider, AJobOfTheUsualSizeIsNeverGivenUpForOthersNorRefused) {
  SessionsBench bench(kOpen);
  LinkClient slow = bench.join(kEvilPort, {}, kEvil), good = bench.join(kGoodPort, {}, kGood);
  Time now{};
  for (std::uint32_t frame = 1; frame <= 5; ++frame) {
    ask_for(bench, slow, kEvilPort, frame, kUsual, now);
    const auto job = bench.sessions.next_job(now);
    ASSERT_TRUE(job && !job->is_too_costly) << "its last took 800 ms, on slow hardware";
    if (frame == 1) ask_for(bench, good, kGoodPort, frame, kUsual, now);
    EXPECT_FALSE(bench.sessions.gives_up(now + 1min));
    now += 800ms;
    bench.sessions.put(job->session, {}, 800ms, now);
    if (frame == 1) bench.sessions.put(bench.sessions.next_job(now)->session, {}, 1ms, now);
    now += Turns::kActive;                            // so long the other client may ask again
    ask_for(bench, good, kGoodPort, 1, kUsual, now);  // not newer: it is heard, no more
  }
}

TEST(Insider, AJobIsGivenUpWhenItsSessionHasEnded) {
  SessionsBench bench(kOpen);
  LinkClient client = bench.join(kGoodPort, {}, kGood);
  ask_for(bench, client, kGoodPort, 1, kUsual);
  ASSERT_TRUE(bench.sessions.next_job({}).has_value());
  EXPECT_FALSE(bench.sessions.gives_up({}));
  bench.sessions.set_ring({kEvil});
  EXPECT_TRUE(bench.sessions.gives_up({}));
}

TEST(Insider, AJobThatWouldTakeTooLongIsNotBegunWhileAnotherKeyIsPresent) {
  SessionsBench bench(kOpen);
  LinkClient evil = bench.join(kEvilPort, {}, kEvil), good(kGood, kServed);
  std::uint32_t frame = 0;
  Time now{};
  const auto next = [&](Duration work, JobEnd end = JobEnd::Answered) {
    now += 14ms;
    if (good.welcome) ask_for(bench, good, kGoodPort, 1, kUsual, now);  // not newer: it is heard, no more
    ask_for(bench, evil, kEvilPort, ++frame, kLarge, now);
    const Job job = *bench.sessions.next_job(now);
    bench.sessions.put(job.session, {}, job.is_too_costly ? 0ms : work, now,
                       job.is_too_costly ? JobEnd::GivenUp : end);
    return job;
  };
  EXPECT_FALSE(next(2s).is_too_costly);
  EXPECT_FALSE(next(2s).is_too_costly) << "alone, it costs nobody anything";
  good = bench.join(kGoodPort, now, kGood);
  ask_for(bench, good, kGoodPort, 1, kUsual, now);
  bench.sessions.put(bench.sessions.next_job(now)->session, {}, 5ms, now);
  now += Turns::kActive;
  EXPECT_TRUE(next(2s).is_too_costly);
  const Job advised = next(2s);
  EXPECT_LT(advised.view_scale, kFullViewScale) << "smaller views are advised";
  EXPECT_EQ(bench.sessions.counters().too_costly, 2u);
  now += Turns::kActive + 1ms;
  ask_for(bench, evil, kEvilPort, ++frame, kUsual, now);
  EXPECT_FALSE(bench.sessions.next_job(now)->is_too_costly);
  ask_for(bench, good, kGoodPort, 2, kLarge, now);
  EXPECT_FALSE(bench.sessions.next_job(now)->is_too_costly) << "measured by key: nobody spoils another's";
  now += Turns::kActive;
  Duration spent{};
  for (int i = 0; i < 4286; ++i)
    if (!next(kMostTurn + 1ms, JobEnd::GivenUp).is_too_costly) spent += kMostTurn + 1ms;
  now += kPresent;
  good.welcome.reset();
  EXPECT_FALSE(next(2s).is_too_costly) << "the other client has fallen silent";
  std::printf("requests at 72 Hz, each of which takes 2 s: %.1f s of the worker in a minute\n",
              seconds_of(spent));
  EXPECT_GT(spent, 0s) << "an estimate that is wrong is tried again";
  EXPECT_LT(spent, 2s);
}

/// Whether a large job of a key is begun beside a client of another key, after one was given up because its
/// session had ended. That one had taken `work`.
bool is_begun_after_one_given_up(Duration work) {
  SessionsBench bench(kOpen);
  LinkClient gone = bench.join(kEvilPort, {}, kEvil), good = bench.join(kGoodPort, {}, kGood);
  ask_for(bench, gone, kEvilPort, 1, kLarge);
  const SessionId session = bench.sessions.next_job({})->session;
  LinkClient evil = bench.join(kEvilPort, {}, kEvil);
  ask_for(bench, evil, kEvilPort, 1, kLarge);  // it replaces the session whose job is in work
  EXPECT_TRUE(bench.sessions.gives_up({}));
  bench.sessions.put(session, {}, work, {}, JobEnd::GivenUp);
  return !bench.sessions.next_job({})->is_too_costly;
}

TEST(Insider, AJobThatWasGivenUpTellsItsCostOnlyIfItTookTooLong) {
  EXPECT_TRUE(is_begun_after_one_given_up(150ms)) << "its session ended, so nobody knows what it costs";
  EXPECT_TRUE(is_begun_after_one_given_up(kMostTurn));
  EXPECT_FALSE(is_begun_after_one_given_up(kMostTurn + 1ms));
}

/// Masks that a client gets in 20 s if it asks again 1 ms after the last ones came, beside eight sessions
/// of another key whose large views take `work` each.
int masks_beside_large_views(Duration work) {
  SessionsBench bench(kOpen);
  std::vector<LinkClient> evil;
  for (std::uint16_t i = 0; i < 8; ++i) evil.push_back(bench.join(kEvilPort + i, {}, kEvil));
  LinkClient good = bench.join(kGoodPort, {}, kGood);
  std::uint32_t frame = 0;
  int masks = 0;
  Time now{}, asks{};
  while (now < Time(20s)) {
    for (std::uint16_t i = 0; i < 8; ++i)
      bench.talk(evil[i], kEvilPort + i, evil[i].seal({.request = request_of(++frame, kLarge)}), now);
    if (now >= asks) bench.talk(good, kGoodPort, good.seal({.request = request_of(++frame, kUsual)}), now);
    const auto job = bench.sessions.next_job(now);
    if (!job) {
      now = std::min(asks, *bench.sessions.job_at());
      continue;
    }
    const bool is_good = job->session == good.session;
    const Duration spent = is_good ? 60ms : job->is_too_costly ? 1ms : std::min(work, kMostTurn + 10ms);
    now += spent;
    const bool is_given_up = job->is_too_costly || (!is_good && work > spent);
    bench.sessions.put(job->session, {}, spent, now, is_given_up ? JobEnd::GivenUp : JobEnd::Answered);
    if (is_good) asks = now + 1ms, ++masks;
  }
  return masks;
}

TEST(Insider, LargeViewsOfAnotherKeyDoNotHoldUpAClientThatAsksAgainAfterEachAnswer) {
  for (const Duration work : {190ms, 210ms, 450ms, 2000ms}) {
    const int masks = masks_beside_large_views(work);
    std::printf("beside large views that take %4.0f ms: %d masks in 20 s\n", ms_of(work), masks);
    EXPECT_GT(masks, 155) << "alone: about 327, with an equal share 163";
  }
}

/// A good client whose masks take `job` and which asks again `pause` after each, beside keys that always want
/// more, from four sessions a key. `work` is what the next of their answers takes.
struct Competition {
  Duration job, pause;
  std::size_t keys = 1;
  std::function<Duration()> work;
  bool is_asked_idly =
      false;  ///< one key more, with a client that asks for masks of positions and sends none
};

/// What it gets in 20 s.
struct Got {
  int masks = 0;
  Duration longest_wait{};  ///< from a request to its answer; before the first one nobody is ahead
  Duration of_others{};     ///< time of the worker
};

Got compete(const Competition& competition) {
  SessionsBench bench(kOpen);
  bench.sessions.offer(kTracedAnswers);
  std::vector<LinkClient> evil;
  const auto port_of = [](std::size_t i) { return static_cast<std::uint16_t>(kEvilPort + i); };
  for (std::size_t i = 0; i < 4 * competition.keys; ++i)
    evil.push_back(bench.join(port_of(i), {}, kRing[1 + i % competition.keys]));
  LinkClient good = bench.join(kGoodPort, {}, kGood), idle = bench.join(kGoodPort + 1, {}, kRing.back());
  std::uint32_t frame = 0;
  Got got;
  Time now{}, asks{}, requested{};
  const auto pass = [&](Duration span) {
    if (asks <= now + span) {
      ask_for(bench, good, kGoodPort, ++frame, kUsual, asks);
      requested = std::exchange(asks, Time::max());
    }
    now += span;
  };
  while (now < Time(20s)) {
    pass({});
    for (std::size_t i = 0; i < evil.size(); ++i) ask_for(bench, evil[i], port_of(i), ++frame, kUsual, now);
    if (competition.is_asked_idly) {
      FrameRequest request = request_of(++frame, kUsual);
      request.answer = {.kind = Answer::MasksOfPositions, .position_bits = 16, .slices = 100};
      bench.talk(idle, kGoodPort + 1, idle.seal({.request = request}), now);
    }
    const auto job = bench.sessions.next_job(now);
    if (!job) {
      const Time at = std::min(asks, *bench.sessions.job_at());
      EXPECT_GT(at, now) << "a worker that waits would spin";
      pass(at - now);
      continue;
    }
    const bool is_good = job->session == good.session;
    const Duration spent = is_good ? competition.job : competition.work();
    pass(spent);
    bench.sessions.put(job->session, {}, spent, now);
    if (!is_good) {
      got.of_others += spent;
      continue;
    }
    if (got.masks++ > 0) got.longest_wait = std::max(got.longest_wait, now - requested);
    asks = now + competition.pause;
  }
  return got;
}

TEST(Insider, LongAnswersOfOtherKeysLeaveAGoodClientItsShareAlthoughItPausesAfterEachAnswer) {
  for (const Duration job : {5ms, 20ms, 21ms, 60ms})
    for (const Duration pause : {5ms, 30ms})
      for (const std::size_t keys : {std::size_t{1}, std::size_t{2}})
        for (const Duration work : {50ms, 190ms, 1200ms}) {
          const Got got = compete({job, pause, keys, [&] { return work; }});
          const double share = 20.0 / seconds_of(job + pause) / static_cast<double>(keys + 1);
          std::printf(
              "masks of %2.0f ms and pauses of %2.0f ms, beside answers of %4.0f ms of %zu keys: %3d masks "
              "in "
              "20 s of %3.0f that its share has room for, the longest wait %.0f ms\n",
              ms_of(job), ms_of(pause), ms_of(work), keys, got.masks, share, ms_of(got.longest_wait));
          const double round = seconds_of(work) * static_cast<double>(keys) / 20;
          EXPECT_GT(got.masks, (1 - round) * share - 2) << "the last round of others may be without its own";
          // A key whose masks take longer than the others' answers is itself behind, and owes one to each.
          EXPECT_LE(got.longest_wait, keys * (job > work ? work + job : work) + job);
          EXPECT_GT(got.of_others, keys == 1 ? 9s : 12s) << "nor does it take more than its share";
        }
}

TEST(Insider, ShortAnswersBetweenLongOnesHideNothing) {
  int turn = 0;
  const Got got = compete({21ms, 30ms, 1, [&] { return ++turn % 20 == 0 ? 1200ms : 1ms; }});
  std::printf("%d masks in 20 s of %.0f\n", got.masks, 20 / 0.051 / 2);
  EXPECT_GT(got.masks, 0.9 * 20 / 0.051 / 2);
}

TEST(Insider, AKeyThatAsksAndNeverBringsWhatItAnnouncesTakesItsShareAndNoMore) {
  const Got got = compete({60ms, 30ms, 1, [&] { return 190ms; }, true});
  std::printf("%d masks in 20 s of %.0f, the longest wait %.0f ms\n", got.masks, 20 / 0.09 / 3,
              ms_of(got.longest_wait));
  EXPECT_GT(got.masks, 0.9 * 20 / 0.09 / 3);
}

/// A process that was stopped while it answered owes nobody so much.
TEST(Insider, AStallIsNotWork) {
  SessionsBench bench(kOpen);
  LinkClient one = bench.join(kGoodPort, {}, kGood), two = bench.join(kEvilPort, {}, kEvil);
  bench.ask(one, kGoodPort, 1);
  bench.ask(two, kEvilPort, 1);
  bench.sessions.put(bench.sessions.next_job({})->session, {}, 1h, {});
  std::uint32_t frame = 1;
  const SessionId second = bench.sessions.next_job({})->session;
  bench.sessions.put(second, {}, 5ms, {});
  int of_second = 0;
  for (; of_second < 1000; ++of_second) {
    bench.ask(one, kGoodPort, ++frame);
    bench.ask(two, kEvilPort, frame);
    const SessionId served = bench.sessions.next_job({})->session;
    bench.sessions.put(served, {}, 5ms, {});
    if (served != second) break;
  }
  EXPECT_LE(of_second, kMostCharged / 5ms);
}

/// Its older session makes room, and whose key was active is still known.
TEST(Insider, AClientThatIsStartedAgainIsTheOneThatIsActive) {
  SessionsBench bench(kOpen);
  bench.sessions.offer(kTracedAnswers);
  bench.join(kGoodPort, {}, kGood);
  LinkClient good(kGood, kServed);
  LinkClient evil = bench.join(kEvilPort, {}, kEvil);
  ask_for(bench, evil, kEvilPort, 1, kUsual);
  bench.sessions.put(bench.sessions.next_job({})->session, {}, 1s, Time(1s));
  good = bench.join(kGoodPort, Time(1s), kGood);
  LinkClient third = bench.join(kEvilPort + 1, Time(1s), kRing[1]);
  RequestMessage message{.request = request_of(1, kUsual)};
  message.request.answer = {.kind = Answer::MasksOfPositions, .position_bits = 16, .slices = 9};
  bench.talk(good, kGoodPort, good.seal(message), Time(1s));  // the first: it replaces the older session
  ASSERT_EQ(bench.sessions.counters().replaced, 1u);
  ask_for(bench, evil, kEvilPort, 2, kUsual, Time(1s));
  EXPECT_FALSE(bench.sessions.next_job(Time(1s))) << "the good client may bring what it has announced";
}

/// A request for masks of positions, and `parts` messages of the largest size that belong to it.
void bring_positions(SessionsBench& bench, LinkClient& client, std::uint16_t port, std::uint32_t parts) {
  FrameRequest request = request_of(1, {1024, 1024});
  request.answer = {.kind = Answer::MasksOfPositions, .position_bits = 16, .slices = 65535};
  bench.talk(client, port, client.seal({.request = request}));
  const Bytes full(kBaseMessage_bytes - kPlaneSliceHeader_bytes, std::byte{1});
  Bytes message, datagram;
  for (std::uint32_t tile = 0; tile < parts; ++tile) {
    encode(ClientMessage(PlaneSlice{.frame = {1},
                                    .kind = PlaneKind::PositionX,
                                    .size = {1024, 1024},
                                    .first_tile = tile,
                                    .tile_count = 1,
                                    .block = full}),
           message);
    client.sealer->seal(message, datagram);
    bench.say(port, datagram);
  }
}

TEST(Insider, OneKeyHasHalfOfTheMemoryAndAnotherIsStillServed) {
  constexpr std::size_t kMiB = std::size_t{1} << 20;
  SessionsBench bench({.sessions = 65, .handshakes_per_second = 1e6, .memory = {8 * kMiB}});
  bench.sessions.offer(kTracedAnswers);
  std::vector<LinkClient> evil;
  for (std::uint16_t i = 0; i < 3; ++i) evil.push_back(bench.join(kEvilPort + i, {}, kEvil));
  for (std::uint16_t i = 0; i < 3; ++i) bring_positions(bench, evil[i], kEvilPort + i, 1000);
  const KeyAccount& account = bench.sessions.account(id_of(kEvil));
  EXPECT_LE(account.held_bytes, 2 * kMiB);
  EXPECT_GT(account.held_bytes, 2 * kMiB - 2 * kBaseMessage_bytes);
  const std::uint64_t refused = bench.sessions.counters().over_memory;
  EXPECT_GT(refused, 1000u);
  EXPECT_TRUE(bench.join(kEvilPort + 9, {}, kEvil).refusal.has_value());
  EXPECT_EQ(bench.sessions.counters().over_memory, refused + 1) << "no memory for another session";

  LinkClient good = bench.join(kGoodPort, {}, kGood);
  ASSERT_TRUE(good.welcome.has_value());
  bring_positions(bench, good, kGoodPort, 1000);
  EXPECT_EQ(bench.sessions.counters().over_memory, refused + 1);
  EXPECT_LE(bench.sessions.held_bytes(), 4 * kMiB);
  bench.sessions.end_silent(Time(1h));
  EXPECT_EQ(bench.sessions.held_bytes(), 0u);
  EXPECT_EQ(account.held_bytes, 0u);
}

/// Makes the client's session hold an answer that takes all memory that its key has left of `share_bytes`.
void fill_share(SessionsBench& bench, LinkClient& client, std::uint16_t port, std::size_t share_bytes) {
  bench.ask(client, port, 1);
  const SessionId id = bench.sessions.next_job({})->session;
  const std::size_t held = bench.sessions.account(id_of(client.key)).held_bytes;
  bench.sessions.put(id, std::vector<Bytes>(1, Bytes(share_bytes - held - kMessage_bytes)), {}, {});
}

TEST(Insider, TwoKeysThatHoldAllMemoryLeaveAThirdItsOwn) {
  constexpr std::size_t kMiB = std::size_t{1} << 20, kOwn = 2 * kMiB / 3, kShared = 4 * kMiB - 3 * kOwn;
  for (const bool with_report : {false, true}) {
    SCOPED_TRACE(with_report ? "more is held than the limit" : "as much is held as the limit");
    SessionsBench bench({.memory = {8 * kMiB}});
    LinkClient one = bench.join(1, {}, kRing[0]), two = bench.join(2, {}, kRing[1]),
               two_too = bench.join(3, {}, kRing[1]);
    fill_share(bench, one, 1, 2 * kMiB);
    fill_share(bench, two, 2, kOwn + kShared - (2 * kMiB - kOwn));
    EXPECT_EQ(bench.sessions.held_bytes(), 2 * kOwn + kShared);
    EXPECT_EQ(bench.sessions.counters().over_memory, 0u);
    if (with_report) {  // a report is sent even if there is no memory for it
      bench.ask(two_too, 3, 1);
      bench.sessions.put(bench.sessions.next_job({})->session, std::vector<Bytes>(1, Bytes(50)), {}, {});
      EXPECT_GT(bench.sessions.held_bytes(), 2 * kOwn + kShared);
    }
    const std::uint64_t before = bench.sessions.counters().over_memory;
    for (std::uint16_t i = 0; i < kOwn / kSession_bytes; ++i)
      EXPECT_TRUE(bench.join(4 + i, {}, kRing[2]).welcome.has_value()) << i;
    const LinkClient last = bench.join(99, {}, kRing[2]);
    ASSERT_TRUE(last.refusal.has_value());
    EXPECT_EQ(last.refusal->reason, RefusalReason::Busy);
    EXPECT_EQ(bench.sessions.counters().over_memory, before + 1);
    const Time later(SessionLimits{}.silence + 1s);
    bench.sessions.end_silent(later);
    EXPECT_TRUE(bench.join(99, later, kRing[2]).welcome.has_value());
  }
}

TEST(Insider, AnAnswerThatWouldExceedTheMemoryIsItsReportAlone) {
  constexpr std::size_t kMiB = std::size_t{1} << 20;
  SessionsBench bench({.memory = {8 * kMiB}});
  LinkClient client = bench.join(kGoodPort, {}, kGood);
  bench.ask(client, kGoodPort, 1);
  std::vector<Bytes> answer(2000, Bytes(kMaxMessage_bytes, std::byte{7}));
  encode(FrameReport{.frame = {1}}, answer.back());
  bench.sessions.put(bench.sessions.next_job({})->session, answer, {}, {});
  EXPECT_EQ(bench.sessions.counters().over_memory, 1u);
  Peer to;
  Bytes datagram;
  ASSERT_TRUE(bench.sessions.seal_due({}, to, datagram));
  client.take(datagram, {});
  EXPECT_EQ(client.reports, 1u);
  EXPECT_FALSE(bench.sessions.seal_due(Time(1h), to, datagram));
  EXPECT_EQ(bench.sessions.account(id_of(kGood)).sent_bytes, datagram.size());
  EXPECT_EQ(bench.sessions.held_bytes(), kSession_bytes) << "what was sent is held no longer";
}

TEST(Insider, AnAnswerWhoseMakingNeedsTooMuchMemoryIsNotMade) {
  constexpr std::size_t kMiB = std::size_t{1} << 20;
  SessionsBench bench({.memory = {32 * kMiB}});
  LinkClient client = bench.join(kGoodPort, {}, kGood);
  ask_for(bench, client, kGoodPort, 1, {2048, 2048});
  const auto job = bench.sessions.next_job({});
  EXPECT_FALSE(job->is_too_costly) << "16 MiB";
  bench.sessions.put(job->session, {}, {}, {});
  ask_for(bench, client, kGoodPort, 2, {2049, 2048});
  EXPECT_TRUE(bench.sessions.next_job({})->is_too_costly);
  EXPECT_EQ(bench.sessions.counters().over_memory, 1u);
}

TEST(Insider, ACounterThatJumpsDoesNotCount) {
  SessionsBench bench;
  LinkClient client = bench.join(kGoodPort, {}, kGood);
  bench.ask(client, kGoodPort, 1);
  const Bytes honest = client.seal({.request = request_of(2, kSize)});
  Bytes far = honest;
  far[15 + 7] = std::byte{0xff};
  bench.say(kGoodPort, far);
  EXPECT_EQ(bench.taken.error(), WireRefusal::CounterJump);
  bench.say(kGoodPort, honest);
  EXPECT_TRUE(bench.taken.has_value());
}

/// A sealed Leave of this client.
Bytes leave_of(LinkClient& client) {
  Bytes bytes, datagram;
  encode(ClientMessage(Leave{}), bytes);
  client.sealer->seal(bytes, datagram);
  return datagram;
}

TEST(Goodbye, AClientThatLeavesFreesItsPlaceAtOnce) {
  SessionsBench bench({.sessions = 1});
  LinkClient client = bench.join(kGoodPort, {}, kGood);
  bench.ask(client, kGoodPort, 1);
  EXPECT_TRUE(bench.join(kEvilPort, {}, kEvil).refusal.has_value());
  static_cast<void>(bench.sessions.take_events());
  bench.say(kGoodPort, leave_of(client), Time(3s));
  EXPECT_EQ(bench.sessions.size(), 0u);
  EXPECT_EQ(bench.sessions.counters().left, 1u);
  EXPECT_EQ(bench.sessions.counters().forgotten, 0u);
  const auto events = bench.sessions.take_events();
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].kind, ClientEvent::Kind::Left);
  EXPECT_EQ(events[0].connected, 3s);
  EXPECT_TRUE(bench.join(kEvilPort, Time(3s), kEvil).welcome.has_value());
}

TEST(Goodbye, ALeaveThatIsReplayedOrForgedDoesNothing) {
  SessionsBench bench;
  LinkClient first = bench.join(kGoodPort, {}, kGood);
  bench.ask(first, kGoodPort, 1);
  const Bytes leave = leave_of(first);
  bench.say(kGoodPort, leave);
  LinkClient second = bench.join(kGoodPort, {}, kGood);
  bench.ask(second, kGoodPort, 1);
  bench.say(kGoodPort, leave);
  EXPECT_EQ(bench.taken.error(), WireRefusal::UnknownSession);
  Bytes moved = leave;
  const Bytes own = second.seal({.request = request_of(2, kSize)});
  std::copy_n(own.begin(), kSealedHeader_bytes, moved.begin());
  bench.say(kGoodPort, moved);
  EXPECT_EQ(bench.taken.error(), WireRefusal::Forged);
  EXPECT_EQ(bench.sessions.size(), 1u);
}

/// What the sessions send from now on, until nothing is left.
std::vector<std::pair<Peer, Bytes>> sent_by(Sessions& sessions, Time now = {}) {
  std::vector<std::pair<Peer, Bytes>> all;
  Peer to;
  Bytes datagram;
  for (std::optional<Time> at; (at = sessions.due_at());)
    while (sessions.seal_due(std::max(now, *at), to, datagram)) all.emplace_back(to, datagram);
  return all;
}

/// The message that opens for `client`.
std::optional<ServerMessage> opened(LinkClient& client, const Bytes& datagram) {
  Bytes bytes;
  const auto message =
      client.opener->open(std::get<Sealed>(*open_server_envelope(datagram)), datagram, bytes);
  if (!message) return std::nullopt;
  return *decode_server(*message);
}

TEST(Goodbye, AClientIsToldWhyItsSessionEnds) {
  SessionsBench bench;
  LinkClient good = bench.join(kGoodPort, {}, kGood), evil = bench.join(kEvilPort, {}, kEvil);
  bench.sessions.set_ring({kGood});
  ASSERT_TRUE(bench.sessions.due_at().has_value());
  const auto revoked = sent_by(bench.sessions);
  ASSERT_EQ(revoked.size(), std::size_t{kGoodbyes});
  for (const auto& [to, datagram] : revoked) {
    EXPECT_EQ(to, peer(kEvilPort));
    EXPECT_EQ(std::get<Goodbye>(*opened(evil, datagram)).reason, EndReason::Revoked);
  }
  EXPECT_FALSE(bench.sessions.due_at().has_value());
  bench.sessions.say_goodbye();
  const auto ends = sent_by(bench.sessions);
  ASSERT_EQ(ends.size(), std::size_t{kGoodbyes});
  EXPECT_EQ(std::get<Goodbye>(*opened(good, ends[0].second)).reason, EndReason::ServerEnds);
}

TEST(Goodbye, LeavesThreeTimesApart) {
  SessionsBench bench;
  LinkClient one = bench.join(kGoodPort, {}, kGood), two = bench.join(kEvilPort, {}, kEvil);
  bench.sessions.say_goodbye();
  Peer to;
  Bytes datagram;
  for (const Duration at : {0ms, 20ms, 40ms}) {
    EXPECT_EQ(bench.sessions.goodbye_at().has_value(), true) << ms_of(at);
    if (at > 0ms) {
      EXPECT_FALSE(bench.sessions.seal_due(Time(at - 1us), to, datagram)) << ms_of(at);
    }
    std::set<std::uint16_t> ports;
    while (bench.sessions.seal_due(Time(at), to, datagram)) ports.insert(to.port);
    EXPECT_EQ(ports, (std::set<std::uint16_t>{kGoodPort, kEvilPort})) << ms_of(at);
  }
  EXPECT_FALSE(bench.sessions.goodbye_at().has_value());
}

TEST(Sessions, AreForgivenWhatTheServerDidNotHear) {
  SessionsBench bench;
  LinkClient client = bench.join(kGoodPort, {}, kGood);
  bench.ask(client, kGoodPort, 1);
  const Duration stall = SessionLimits{}.silence + 5s;
  bench.sessions.forgive(stall, Time(stall));
  bench.sessions.end_silent(Time(stall));
  EXPECT_EQ(bench.sessions.size(), 1u);
  bench.sessions.end_silent(Time(stall + SessionLimits{}.silence - 1ms));
  EXPECT_EQ(bench.sessions.size(), 1u);
  ASSERT_TRUE(bench.sessions.silent_at().has_value());
  bench.sessions.end_silent(*bench.sessions.silent_at());
  EXPECT_EQ(bench.sessions.size(), 0u);
}

TEST(Goodbye, NothingFollowsIt) {
  SessionsBench bench;
  LinkClient client = bench.join(kGoodPort, {}, kGood);
  bench.ask(client, kGoodPort, 1);
  bench.sessions.put(bench.sessions.next_job({})->session, std::vector<Bytes>(8, Bytes(100, std::byte{1})),
                     {}, {});
  Peer to;
  Bytes datagram;
  ASSERT_TRUE(bench.sessions.seal_due({}, to, datagram));
  bench.sessions.say_goodbye();
  EXPECT_EQ(sent_by(bench.sessions, Time(1s)).size(), std::size_t{kGoodbyes}) << "not the rest of the answer";
}

TEST(Goodbye, AClientThatFellSilentIsToldNothing) {
  SessionsBench bench;
  LinkClient client = bench.join(kGoodPort, {}, kGood);
  bench.ask(client, kGoodPort, 1);
  static_cast<void>(bench.sessions.take_events());
  bench.sessions.end_silent(Time(SessionLimits{}.silence + 1s));
  EXPECT_EQ(bench.sessions.size(), 0u);
  EXPECT_TRUE(sent_by(bench.sessions).empty());
  EXPECT_EQ(bench.sessions.take_events().at(0).kind, ClientEvent::Kind::FellSilent);
}

SharedKey limited(SharedKey key, const KeyLimits& limits) {
  key.limits = limits;
  return key;
}

TEST(KeyLimits, AnExpiredKeyIsRefusedAndItsSessionsEnd) {
  SessionsBench bench;
  const auto last = parse_day("2027-01-31").value();
  const std::vector<SharedKey> ring{kGood, limited(kEvil, {.until = last})};
  bench.sessions.set_ring(ring, last);
  LinkClient good = bench.join(kGoodPort, {}, kGood), evil = bench.join(kEvilPort, {}, kEvil);
  ASSERT_TRUE(evil.welcome.has_value());
  static_cast<void>(bench.sessions.take_events());
  bench.sessions.set_ring(ring, last + std::chrono::days(1));
  EXPECT_EQ(bench.sessions.size(), 1u);
  EXPECT_EQ(bench.sessions.counters().expired, 1u);
  EXPECT_EQ(bench.sessions.counters().revoked, 0u);
  EXPECT_EQ(std::get<Goodbye>(*opened(evil, sent_by(bench.sessions).at(0).second)).reason,
            EndReason::Expired);
  EXPECT_EQ(bench.sessions.take_events().at(0).kind, ClientEvent::Kind::Expired);

  const LinkClient again = bench.join(kEvilPort, {}, kEvil);
  EXPECT_EQ(again.open_refusal->reason, RefusalReason::UnknownKey) << "no more than a stranger is told";
  EXPECT_EQ(bench.sessions.gate().expired_key, 1u);
  EXPECT_EQ(bench.sessions.gate().unknown_key, 0u);
  const auto events = bench.sessions.take_events();
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].kind, ClientEvent::Kind::KeyExpired);
  EXPECT_EQ(events[0].key, id_of(kEvil));
  SharedKey liar = kEvil;
  liar.secret[5] ^= 1;
  bench.join(kEvilPort, {}, liar);
  EXPECT_EQ(bench.sessions.gate().unknown_key, 1u);
}

/// Anybody can see the id of a key in a hello. The log must not say that its holder came.
TEST(KeyLimits, WhoNamesAnExpiredKeyWithoutProofIsAStranger) {
  SessionsBench bench;
  const auto last = parse_day("2027-01-31").value();
  bench.sessions.set_ring({kGood, limited(kEvil, {.until = last})}, last + std::chrono::days(1));
  LinkClient client(kEvil, kServed);
  Bytes proved = client.take(bench.say(kEvilPort, client.hello()), {});
  proved[kHelloProved_bytes] ^= std::byte{1};
  client.take(bench.say(kEvilPort, proved), {});
  ASSERT_TRUE(client.open_refusal.has_value());
  EXPECT_EQ(client.open_refusal->reason, RefusalReason::UnknownKey);
  EXPECT_EQ(bench.sessions.gate().expired_key, 0u);
  EXPECT_EQ(bench.sessions.gate().unknown_key, 1u);
  const auto events = bench.sessions.take_events();
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].kind, ClientEvent::Kind::NotAdmitted);
}

TEST(KeyLimits, AKeyHasNoMoreSessionsThanTheRingAllows) {
  SessionsBench bench;
  bench.sessions.set_ring({kGood, limited(kEvil, {.sessions = 2})});
  LinkClient first = bench.join(kEvilPort, {}, kEvil);
  bench.ask(first, kEvilPort, 1);
  EXPECT_TRUE(bench.join(kEvilPort + 1, {}, kEvil).welcome.has_value());
  static_cast<void>(bench.sessions.take_events());
  EXPECT_EQ(bench.join(kEvilPort + 2, {}, kEvil).refusal->reason, RefusalReason::Busy);
  EXPECT_EQ(bench.sessions.counters().key_full, 1u);
  const auto events = bench.sessions.take_events();
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].kind, ClientEvent::Kind::TooManySessions);
  EXPECT_NE(in_words(events[0]).find("eve (key "), std::string::npos) << in_words(events[0]);
  EXPECT_TRUE(bench.join(kEvilPort, {}, kEvil).welcome.has_value()) << "a client that was started anew";
  EXPECT_TRUE(bench.join(kGoodPort, {}, kGood).welcome.has_value());
}

TEST(KeyLimits, ANewClientReplacesOneThatEndedWithoutAWord) {
  SessionsBench bench;
  bench.sessions.set_ring({kGood, limited(kEvil, {.sessions = 1})});
  LinkClient first = bench.join(kEvilPort, {}, kEvil);
  bench.ask(first, kEvilPort, 1);
  EXPECT_EQ(bench.join(kEvilPort + 1, Time(900ms), kEvil).refusal->reason, RefusalReason::Busy);
  LinkClient second = bench.join(kEvilPort + 2, Time(1100ms), kEvil);
  ASSERT_TRUE(second.welcome.has_value());
  EXPECT_EQ(bench.sessions.size(), 2u) << "it has not shown yet that it has the session keys";
  bench.ask(second, kEvilPort + 2, 1, Time(1100ms));
  EXPECT_EQ(bench.sessions.size(), 1u);
  EXPECT_EQ(bench.sessions.counters().replaced, 1u);
  EXPECT_EQ(bench.sessions.next_job(Time(1100ms))->session, second.session);
  bench.ask(first, kEvilPort, 2, Time(1200ms));
  EXPECT_EQ(first.no_session, 1u);
}

/// A session at the newcomer's own address does not count, and it may move there for that moment.
TEST(KeyLimits, MovingBringsNoMoreSessionsThanTheRingAllows) {
  SessionsBench bench;
  bench.sessions.set_ring({kGood, limited(kEvil, {.sessions = 1})});
  LinkClient first = bench.join(kEvilPort, {}, kEvil);
  std::uint32_t frame = 0;
  const auto ask_from = [&](std::uint16_t port) {
    bench.talk(first, port, first.seal({.request = request_of(++frame, kSize), .probe_echo = first.probe}));
  };
  for (const std::uint16_t port :
       {kEvilPort, kEvilPort, std::uint16_t{kEvilPort + 1}, std::uint16_t{kEvilPort + 1}})
    ask_from(port);
  ASSERT_EQ(bench.sessions.counters().moved, 1u);
  LinkClient second = bench.join(kEvilPort + 1, {}, kEvil);
  ASSERT_TRUE(second.welcome.has_value());
  for (int i = 0; i < 2; ++i) ask_from(kEvilPort);
  ASSERT_EQ(bench.sessions.counters().moved, 2u);
  bench.ask(second, kEvilPort + 1, 1);
  EXPECT_EQ(bench.sessions.size(), 1u);
}

TEST(KeyLimits, AKeysSessionsAreNoFasterThanTheRingAllows) {
  for (const bool slow : {false, true}) {
    SessionsBench bench;
    bench.sessions.set_ring(
        {limited(kEvil, {.bytes_per_second = slow ? std::optional<std::uint64_t>(25'000) : std::nullopt})});
    LinkClient client = bench.join(kEvilPort, {}, kEvil);
    bench.ask(client, kEvilPort, 1);
    EXPECT_EQ(bench.sessions.next_job({})->bytes_per_second, slow ? 25'000u : 4'000'000u);
  }
}

TEST(KeyLimits, AKeysSessionsShareItsLimitAtOnceAfterAChange) {
  SessionsBench bench({.handshakes_per_second = 1e6});
  Time now{};
  std::vector<Hungry> clients;
  clients.push_back({bench.join(kGoodPort, now, kGood), kGoodPort});
  for (std::uint16_t port = kEvilPort; port < kEvilPort + 8; ++port)
    clients.push_back({bench.join(port, now, kEvil), port});
  const auto expect_together = [&](double most) {
    for (Hungry& each : clients) each.bytes = 0;
    serve(bench, clients, now, 4s);
    std::size_t evil = 0;
    for (std::size_t i = 1; i < clients.size(); ++i) {
      evil += clients[i].bytes;
      EXPECT_NEAR(static_cast<double>(clients[i].bytes), most * 4 / 8, most * 4 / 80) << i;
    }
    EXPECT_LE(static_cast<double>(evil), 1.05 * most * 4);
    EXPECT_GT(clients[0].bytes, 1'000'000u) << "the other key has no limit";
  };
  for (const std::uint64_t most : {400'000u, 100'000u, 800'000u}) {
    SCOPED_TRACE(most);
    bench.sessions.set_ring({kGood, limited(kEvil, {.bytes_per_second = most})});
    if (most > 400'000) serve(bench, clients, now, 5s);  // a rate grows with what arrives
    expect_together(static_cast<double>(most));
  }
}

TEST(KeyLimits, WhoComesTakesAPartOfTheLimitAndWhoLeavesGivesItBack) {
  constexpr double kMost = 200e3;
  SessionsBench bench;
  bench.sessions.set_ring({limited(kEvil, {.bytes_per_second = 200'000})});
  Time now{};
  std::vector<Hungry> clients;
  const auto bytes_of_first_in_4_s = [&] {
    const std::size_t before = clients[0].bytes;
    serve(bench, clients, now, 4s);
    return static_cast<double>(clients[0].bytes - before);
  };
  clients.push_back({bench.join(kEvilPort, now, kEvil), kEvilPort});
  EXPECT_NEAR(bytes_of_first_in_4_s(), 4 * kMost, 0.4 * kMost);
  clients.push_back({bench.join(kEvilPort + 1, now, kEvil), kEvilPort + 1});
  EXPECT_NEAR(bytes_of_first_in_4_s(), 2 * kMost, 0.4 * kMost);
  bench.say(kEvilPort + 1, leave_of(clients[1].client), now);
  clients.pop_back();
  serve(bench, clients, now, 5s);  // a rate grows with what arrives
  EXPECT_NEAR(bytes_of_first_in_4_s(), 4 * kMost, 0.4 * kMost);
}

TEST(Insider, AReplayedHelloThatWasRefusedCostsNoHandshake) {
  SessionsBench bench({.sessions = 1, .handshakes_per_second = 10});
  bench.join(kEvilPort, {}, kEvil);
  LinkClient refused(kGood, kServed);
  const Bytes hello = refused.take(bench.say(kGoodPort, refused.hello()), {});
  const Bytes answer = bench.say(kGoodPort, hello);
  refused.take(answer, {});
  ASSERT_TRUE(refused.refusal.has_value());
  for (int i = 0; i < 100; ++i) EXPECT_EQ(bench.say(kGoodPort, hello, Time(i * 1ms)), answer);
  EXPECT_EQ(bench.sessions.gate().too_many, 0u);
  EXPECT_EQ(bench.sessions.counters().busy, 1u);
}

/// As many as the usual limit of handshakes lets begin while a cookie is valid.
TEST(Insider, ManyHellosThatWereRefusedAreRemembered) {
  SessionsBench bench({.sessions = 1, .handshakes_per_second = 1e6});
  bench.join(kEvilPort, {}, kEvil);
  std::vector<std::pair<Bytes, Bytes>> said;
  for (std::uint16_t i = 0; i < 500; ++i) {
    LinkClient refused(kGood, kServed);
    const std::uint16_t port = kEvilPort + 1 + i;
    const Bytes hello = refused.take(bench.say(port, refused.hello()), {});
    said.emplace_back(hello, bench.say(port, hello));
  }
  ASSERT_EQ(bench.sessions.counters().busy, 500u);
  for (std::uint16_t i = 0; i < 500; ++i)
    EXPECT_EQ(bench.say(kEvilPort + 1 + i, said[i].first, Time(1ms)), said[i].second) << i;
  EXPECT_EQ(bench.sessions.counters().busy, 500u) << "none was answered anew";
}

/// A client that knew which counters have no datagram could report all others without looking.
TEST(Insider, CountersAreLeftOutAtRandom) {
  SessionsBench bench;
  LinkClient client = bench.join(kGoodPort, {}, kGood);
  std::vector<std::uint64_t> lengths;  // of the runs between counters that were left out
  std::uint64_t last = 0, begun = 0;
  Peer to;
  for (std::uint32_t frame = 1; lengths.size() < 12 && frame < 1000; ++frame) {
    const Time now(frame * 1s);
    const Bytes reply = bench.say(kGoodPort, client.seal({.request = request_of(frame, kSize)}), now);
    if (!reply.empty()) last = std::get<Sealed>(*open_server_envelope(reply)).counter;
    if (const auto job = bench.sessions.next_job(now))
      bench.sessions.put(job->session, std::vector<Bytes>(100, Bytes(100, std::byte{1})), {}, now);
    for (Bytes datagram; bench.sessions.seal_due(now + 900ms, to, datagram);) {
      const std::uint64_t counter = std::get<Sealed>(*open_server_envelope(datagram)).counter;
      if (counter == last + 2) lengths.push_back(counter - std::exchange(begun, counter));
      last = counter;
    }
  }
  ASSERT_GE(lengths.size(), 12u);
  EXPECT_GT(std::set(lengths.begin(), lengths.end()).size(), 4u);
  EXPECT_LE(std::ranges::max(lengths), 2 * ClientSession::kBetweenGaps + 100) << "probes have counters, too";
}

TEST(Insider, AReplayedHelloOfASessionThatHasLeftBeginsNone) {
  SessionsBench bench;
  LinkClient client(kGood, kServed);
  const Bytes hello = client.take(bench.say(kGoodPort, client.hello()), {});
  client.take(bench.say(kGoodPort, hello), {});
  bench.say(kGoodPort, leave_of(client), Time(1s));
  EXPECT_TRUE(bench.say(kGoodPort, hello, Time(1500ms)).empty());
  EXPECT_EQ(bench.sessions.size(), 0u);
  // With a cookie that is newer than the session's end, it is a client that is there.
  const Time later(1s + kCookieLife + 1ms);
  bench.talk(client, kGoodPort, client.hello(), later);
  EXPECT_EQ(bench.sessions.size(), 1u);
}

}  // namespace
}  // namespace farshade
