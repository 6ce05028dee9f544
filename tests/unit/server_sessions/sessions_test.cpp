#include <gtest/gtest.h>

#include "rt_server/work/server_core.h"
#include "stereo/net/explain.h"
#include "tests/unit/server_sessions/sessions_bench.h"

namespace farshade {
namespace {

using namespace std::chrono_literals;
using namespace sessions_bench;

SessionCounters counted(SessionCounters counters) {
  return counters;
}

TEST(Sessions, WelcomesAClientThatProvesAddressAndKeyInTwoRoundTrips) {
  SessionsBench bench;
  LinkClient client(kRing[0], kServed);
  const Bytes again = client.take(bench.say(1, client.hello()), {});
  EXPECT_EQ(bench.sessions.size(), 0u) << "the server stores nothing before the address is proved";
  ASSERT_FALSE(again.empty());
  client.take(bench.say(1, again), {});
  EXPECT_EQ(client.welcome, kServed);
  EXPECT_EQ(bench.sessions.size(), 1u);
  EXPECT_EQ(bench.sessions.counters(), counted({.welcomed = 1}));
  EXPECT_EQ(bench.sessions.gate().retries, 1u);
}

TEST(Sessions, StoresNothingForAClientWithoutAKey) {
  SessionsBench bench;
  const LinkClient stranger = bench.join(1, {}, key_named("mallory"));
  EXPECT_EQ(bench.sessions.size(), 0u);
  ASSERT_TRUE(stranger.open_refusal.has_value());
  EXPECT_EQ(stranger.open_refusal->reason, RefusalReason::UnknownKey);
  SharedKey forged = key_named("mallory");
  forged.secret = kRing[0].secret;
  forged.secret[5] ^= 1;
  EXPECT_FALSE(bench.join(2, {}, forged).welcome.has_value());
  EXPECT_EQ(bench.sessions.size(), 0u);
  EXPECT_EQ(bench.sessions.gate().unknown_key, 2u);
}

TEST(Sessions, RefusesAnotherSceneAndSaysWhichItServes) {
  SessionsBench bench;
  Welcome other = kServed;
  other.scene_hash[31] ^= 1;
  LinkClient client(kRing[0], other);
  bench.talk(client, 1, client.hello());
  ASSERT_TRUE(client.refusal.has_value()) << "sealed, so only the server can have sent it";
  EXPECT_EQ(*client.refusal, (Refusal{RefusalReason::SceneMismatch, kServed.scene_hash}));
  EXPECT_EQ(bench.sessions.size(), 0u);
  EXPECT_EQ(bench.sessions.counters(), counted({.scene_mismatch = 1}));
}

TEST(Sessions, RefusesAnotherVersionAndSaysWhichItSpeaks) {
  SessionsBench bench;
  LinkClient client(kRing[0], kServed);
  Bytes foreign = client.hello();
  foreign[4] ^= std::byte{1};  // another layout
  bench.talk(client, 1, foreign);
  ASSERT_TRUE(client.open_refusal.has_value());
  EXPECT_EQ(client.open_refusal->reason, RefusalReason::VersionMismatch);
  EXPECT_EQ(client.open_refusal->version, kProtocolVersion);
  EXPECT_EQ(client.open_refusal->echo, client.handshake.echo());
  EXPECT_EQ(bench.sessions.gate().version_mismatch, 1u);
}

TEST(Sessions, AnswersUnknownSessionsWithNoSession) {
  SessionsBench bench, restarted;
  LinkClient client = bench.join(1);
  restarted.ask(client, 1, 1);
  EXPECT_EQ(client.no_session, 1u);
  EXPECT_EQ(restarted.taken.error(), WireRefusal::UnknownSession);
  EXPECT_FALSE(restarted.sessions.job_at().has_value());
}

TEST(Sessions, NewestRequestWinsAndTheOthersAreCounted) {
  SessionsBench bench;
  LinkClient client = bench.join(1);
  for (std::uint32_t frame = 1; frame <= 4; ++frame) bench.ask(client, 1, frame, Time(frame * 1ms));
  const auto job = bench.sessions.next_job(Time(4ms));
  ASSERT_TRUE(job.has_value());
  EXPECT_EQ(job->request.frame, FrameId{4});
  EXPECT_EQ(job->arrived, Time(4ms));
  EXPECT_EQ(job->superseded, 3u);
  EXPECT_FALSE(bench.sessions.job_at().has_value());
  EXPECT_FALSE(bench.sessions.next_job(Time(4ms)).has_value());
  EXPECT_EQ(bench.sessions.counters(), counted({.welcomed = 1, .requests = 4, .superseded = 3}));
}

/// A request for a pair of the cube mask.
FrameRequest cube_mask_request(std::uint32_t number) {
  FrameRequest request = request_of(kFirstCubeMaskFrame.value + number, kSize);
  request.answer = {.kind = Answer::CubeMask};
  return request;
}

/// The frames of the jobs that are taken one after the other, each answered with nothing.
std::vector<std::uint32_t> taken_frames(SessionsBench& bench) {
  std::vector<std::uint32_t> frames;
  while (const std::optional<Job> job = bench.sessions.next_job({}))
    frames.push_back(job->request.frame.value);
  return frames;
}

TEST(SessionsCubeMask, NeitherReplacesOtherRequestsNorIsReplacedByThem) {
  SessionsBench bench;
  bench.sessions.offer(kTracedAnswers);
  LinkClient client = bench.join(1);
  const std::uint32_t first = kFirstCubeMaskFrame.value;
  bench.ask(client, 1, 7);
  for (const std::uint32_t number : {0u, 1u, 2u})
    bench.talk(client, 1, client.seal({.request = cube_mask_request(number)}));
  bench.ask(client, 1, 8);
  EXPECT_EQ(taken_frames(bench), (std::vector<std::uint32_t>{8, first, first + 1, first + 2}));
  EXPECT_EQ(bench.sessions.counters(), counted({.welcomed = 1, .requests = 5, .superseded = 1}));
}

TEST(SessionsCubeMask, ANewerRequestForAPairReplacesTheOlderOne) {
  SessionsBench bench;
  bench.sessions.offer(kTracedAnswers);
  LinkClient client = bench.join(1);
  for (const std::uint32_t number : {0u, 1u, 3u, 1u})
    bench.talk(client, 1, client.seal({.request = cube_mask_request(number)}));
  const std::uint32_t first = kFirstCubeMaskFrame.value;
  EXPECT_EQ(taken_frames(bench), (std::vector<std::uint32_t>{first + 1, first + 3}));
  EXPECT_EQ(bench.sessions.counters(),
            counted({.welcomed = 1, .requests = 4, .superseded = 1, .outdated = 1}));
}

TEST(SessionsCubeMask, PairsThatOvertookEachOtherAreAllAnswered) {
  SessionsBench bench;
  bench.sessions.offer(kTracedAnswers);
  LinkClient client = bench.join(1);
  for (const std::uint32_t number : {1u, 2u, 0u})
    bench.talk(client, 1, client.seal({.request = cube_mask_request(number)}));
  EXPECT_EQ(taken_frames(bench).size(), 3u);
}

TEST(SessionsCubeMask, IsAnsweredAtLastAlthoughOtherRequestsAlwaysWait) {
  SessionsBench bench;
  bench.sessions.offer(kTracedAnswers);
  LinkClient client = bench.join(1);
  bench.talk(client, 1, client.seal({.request = cube_mask_request(0)}));
  std::uint32_t overtaking = 0;
  for (std::uint32_t frame = 1; frame < 20; ++frame) {
    bench.ask(client, 1, frame);
    if (bench.sessions.next_job({})->request.answer.kind == Answer::CubeMask) break;
    ++overtaking;
  }
  EXPECT_EQ(overtaking, WaitingRequests::kMostOvertaking);
}

/// The size of views that is advised after 12 answers of 500 kB and as many of 200 bytes, over 1 MB/s. The
/// large ones are those of the cube mask, or the others.
ViewScale scale_beside_large(bool cube_mask_is_large) {
  SessionsBench bench({.bytes_per_second = 1e6});
  bench.sessions.offer(kTracedAnswers);
  LinkClient client = bench.join(1);
  ViewScale advised{};
  Time now{};
  const auto answer = [&](FrameRequest request, std::size_t messages, std::size_t bytes) {
    request.display_time = now;
    bench.talk(client, 1, client.seal({.request = request, .arrivals = client.arrivals.report()}), now);
    const auto at = bench.sessions.job_at();
    ASSERT_TRUE(at.has_value());
    now = std::max(now, *at);
    const Job job = *bench.sessions.next_job(now);
    ASSERT_EQ(job.request.frame, request.frame);
    advised = job.view_scale;
    bench.sessions.put(job.session, std::vector<Bytes>(messages, Bytes(bytes)), 1ms, now);
    Peer to;
    for (Bytes datagram; const auto due = bench.sessions.due_at();) {
      now = std::max(now, *due);
      ASSERT_TRUE(bench.sessions.seal_due(now, to, datagram));
      client.arrivals.add(std::get<Sealed>(*open_server_envelope(datagram)).counter, now + 5ms);
    }
  };
  for (std::uint32_t number = 0; number < 12; ++number) {
    FrameRequest large = request_of(number + 1, kSize), small = cube_mask_request(number);
    if (cube_mask_is_large) std::swap(large, small);
    answer(large, 500, 1000);
    answer(small, 2, 100);
  }
  return advised;
}

TEST(SessionsCubeMask, ItsLargeAnswersDoNotMakeTheOtherViewsSmaller) {
  EXPECT_EQ(scale_beside_large(true), kFullViewScale);
  EXPECT_LT(scale_beside_large(false), kFullViewScale);
}

TEST(Sessions, RequestsThatWereOvertakenAreDropped) {
  SessionsBench bench;
  LinkClient client = bench.join(1);
  for (const std::uint32_t frame : {7u, 6u, 7u}) bench.ask(client, 1, frame);
  EXPECT_EQ(bench.sessions.next_job({})->request.frame, FrameId{7});
  bench.ask(client, 1, 7);  // the request that was answered
  EXPECT_FALSE(bench.sessions.job_at().has_value());
  EXPECT_EQ(bench.sessions.counters(), counted({.welcomed = 1, .requests = 4, .outdated = 3}));
}

TEST(Sessions, RequestsForMorePixelsThanAllowedAreCountedAndNotTraced) {
  Welcome small = kServed;
  small.most_pixels = kSize.width * kSize.height;
  Sessions sessions(small, kRing);
  SessionsBench bench;
  bench.sessions = std::move(sessions);
  LinkClient client = bench.join(1);
  FrameRequest wide = request_of(1, kSize);
  wide.views[1].size.height += 1;
  bench.talk(client, 1, client.seal({.request = wide}));
  EXPECT_FALSE(bench.sessions.job_at().has_value());
  bench.ask(client, 1, 2);
  EXPECT_EQ(bench.sessions.next_job({})->request.frame, FrameId{2});
  EXPECT_EQ(bench.sessions.counters(), counted({.welcomed = 1, .requests = 2, .too_large = 1}));
}

/// Otherwise whoever has a key moves the numbers of frames around as it likes, without work for the server.
TEST(Sessions, RefusedRequestsDoNotMakeLaterOnesOutdated) {
  Welcome small = kServed;
  small.most_pixels = kSize.width * kSize.height;
  Sessions sessions(small, kRing);
  SessionsBench bench;
  bench.sessions = std::move(sessions);
  LinkClient client = bench.join(1);
  const auto refused = [&](std::uint32_t frame, bool too_large) {
    FrameRequest request = request_of(frame, kSize);
    if (too_large)
      request.views[1].size.height += 1;
    else
      request.answer.kind = Answer::GBuffer;
    bench.talk(client, 1, client.seal({.request = request}));
  };
  bench.ask(client, 1, 0);
  EXPECT_EQ(bench.sessions.next_job({})->request.frame, FrameId{0});
  for (const bool too_large : {true, false}) {
    refused(0x7fffffff, too_large);
    refused(0xfffffffe, too_large);
  }
  EXPECT_EQ(bench.sessions.counters().too_large, 1u);
  EXPECT_EQ(bench.sessions.counters().unanswered, 1u);
  EXPECT_EQ(bench.sessions.counters().outdated, 2u);
  bench.ask(client, 1, 0xffffffff);
  EXPECT_FALSE(bench.sessions.job_at().has_value()) << "older than the first";
  bench.ask(client, 1, 1);
  EXPECT_EQ(bench.sessions.next_job({})->request.frame, FrameId{1});
}

TEST(Sessions, ClientsWithMoreWorkHaveFewerTurns) {
  SessionsBench bench;
  std::vector<LinkClient> clients;
  for (std::uint16_t port = 1; port <= 3; ++port) clients.push_back(bench.join(port, {}, kRing[port - 1u]));
  const std::vector<std::vector<std::byte>> messages;
  std::array<int, 3> served{};
  Duration longest{}, waited{};
  for (std::uint32_t frame = 1; frame <= 120; ++frame) {
    for (std::uint16_t port = 1; port <= 3; ++port) bench.ask(clients[port - 1u], port, frame);
    const auto job = bench.sessions.next_job({});
    const auto who = static_cast<std::size_t>(std::ranges::find(clients, job->session, &LinkClient::session) -
                                              clients.begin());
    const Duration work = who == 2 ? 50ms : 5ms;
    bench.sessions.put(job->session, messages, work, {});
    ++served[who];
    waited = who == 0 ? Duration{} : waited + work;
    longest = std::max(longest, waited);
  }
  EXPECT_NEAR(served[0], served[1], 1);
  EXPECT_NEAR(served[2] * 10, served[0], 20) << "each client gets a third of the time";
  EXPECT_LE(longest, 60ms) << "one large frame at a time";
}

/// Keeps a session alive until `until`, from the time at which its first key is used.
std::uint32_t asked_until(SessionsBench& bench, LinkClient& client, Time until) {
  std::uint32_t frame = 0;
  for (Time now{}; now < until; now += 5s) bench.ask(client, 1, ++frame, now);
  return frame;
}

TEST(Sessions, ADatagramThatIsDueIsSealedWithTheKeyOfItsTime) {
  SessionsBench bench;
  LinkClient client = bench.join(1);
  constexpr Time kBefore = Time(kEpochTime - 1s), kAfter = Time(kEpochTime + 1s);
  const std::uint32_t frame = asked_until(bench, client, kBefore);
  bench.ask(client, 1, frame + 1, kBefore);
  bench.sessions.put(bench.sessions.next_job(kBefore)->session, {Bytes(100)}, {}, kBefore);
  Peer to;
  Bytes datagram;
  ASSERT_TRUE(bench.sessions.seal_due(kAfter, to, datagram));
  EXPECT_EQ(std::get<Sealed>(*open_server_envelope(datagram)).epoch, 1u);
}

TEST(Sessions, AReplyIsSealedWithTheKeyOfItsTime) {
  SessionsBench bench;
  LinkClient client = bench.join(1);
  constexpr Time kAfter = Time(kEpochTime + 1s);
  const std::uint32_t frame = asked_until(bench, client, Time(kEpochTime - 1s));
  const Bytes reply = bench.say(1, client.seal({.request = request_of(frame + 1, kSize)}), kAfter);
  ASSERT_FALSE(reply.empty()) << "a probe, after seconds without one";
  EXPECT_EQ(std::get<Sealed>(*open_server_envelope(reply)).epoch, 1u);
}

TEST(Sessions, AnIdleClientBanksOneTurnAndNoMore) {
  SessionsBench bench;
  LinkClient one = bench.join(1), two = bench.join(2, {}, kRing[1]);
  std::uint32_t frame = 0;
  for (int i = 0; i < 100; ++i) {
    bench.ask(one, 1, ++frame);
    bench.sessions.put(bench.sessions.next_job({})->session, {}, 5ms, {});
  }
  const auto of_one = [&](int turns) {
    int count = 0;
    for (int i = 0; i < turns; ++i) {
      bench.ask(one, 1, ++frame);
      bench.ask(two, 2, ++frame);
      const auto job = bench.sessions.next_job({});
      count += job->session == one.session;
      bench.sessions.put(job->session, {}, 5ms, {});
    }
    return count;
  };
  EXPECT_EQ(of_one(Turns::kBank / 5ms), 0) << "although the other had 100";
  EXPECT_EQ(of_one(10), 5);
}

/// The turns that the first of two sessions of one key gets of the next `turns`, if both always want more.
int turns_of_first(SessionsBench& bench, LinkClient& one, LinkClient& two, std::uint32_t& frame, int turns,
                   Duration work_of_one) {
  int of_one = 0;
  for (int i = 0; i < turns; ++i) {
    bench.ask(one, 1, ++frame);
    bench.ask(two, 2, ++frame);
    const SessionId served = bench.sessions.next_job({})->session;
    of_one += served == one.session;
    bench.sessions.put(served, {}, served == one.session ? work_of_one : 5ms, {});
  }
  return of_one;
}

TEST(Sessions, AnIdleSessionSavesNoTurnsAgainstAnotherOfItsKey) {
  SessionsBench bench;
  LinkClient one = bench.join(1), two = bench.join(2);
  std::uint32_t frame = 0;
  for (int i = 0; i < 100; ++i) {
    bench.ask(one, 1, ++frame);
    bench.sessions.put(bench.sessions.next_job({})->session, {}, 5ms, {});
  }
  EXPECT_NEAR(turns_of_first(bench, one, two, frame, 10, 5ms), 5, 1);
}

TEST(Sessions, ASessionWithMoreWorkHasFewerTurnsThanAnotherOfItsKey) {
  SessionsBench bench;
  LinkClient one = bench.join(1), two = bench.join(2);
  std::uint32_t frame = 0;
  EXPECT_NEAR(turns_of_first(bench, one, two, frame, 110, 50ms), 10, 1);
}

TEST(Sessions, FrameOrderSurvivesWraparound) {
  SessionsBench bench;
  LinkClient client = bench.join(1);
  for (const std::uint32_t frame : {0xffffffffu, 1u, 0xfffffffeu}) bench.ask(client, 1, frame);
  EXPECT_EQ(bench.sessions.next_job({})->request.frame, FrameId{1});
}

TEST(Sessions, ReplayedForgedAndCutDatagramsChangeNothing) {
  SessionsBench bench;
  LinkClient client = bench.join(1);
  const Bytes requested = client.seal({.request = request_of(1, kSize)});
  bench.say(1, requested);
  ASSERT_EQ(bench.sessions.next_job({})->request.frame, FrameId{1});
  EXPECT_TRUE(bench.say(1, requested, Time(1s)).empty());
  EXPECT_EQ(bench.taken.error(), WireRefusal::Replayed);
  const Bytes next = client.seal({.request = request_of(2, kSize)});
  for (std::size_t i = 15; i < next.size(); ++i) {  // after magic, version, type and session
    Bytes forged = next;
    forged[i] ^= std::byte{0x10};
    EXPECT_TRUE(bench.say(2, forged, Time(1s)).empty());
    EXPECT_FALSE(bench.taken.has_value()) << i;
  }
  for (std::size_t size = 0; size < next.size(); ++size) {
    bench.say(2, Bytes(next.begin(), next.begin() + static_cast<std::ptrdiff_t>(size)), Time(1s));
    EXPECT_FALSE(bench.taken.has_value()) << size;
  }
  EXPECT_EQ(bench.sessions.counters(), counted({.welcomed = 1, .requests = 1}));
  bench.say(1, next, Time(2s));
  EXPECT_EQ(bench.sessions.next_job(Time(2s))->request.frame, FrameId{2})
      << "the genuine request still counts";
}

TEST(Sessions, ClientRestartedAtItsAddressReplacesItsOlderSession) {
  SessionsBench bench;
  LinkClient before = bench.join(1), elsewhere = bench.join(2), other = bench.join(1, {}, kRing[1]);
  bench.ask(before, 1, 1000);
  LinkClient after = bench.join(1);
  EXPECT_EQ(bench.sessions.size(), 4u) << "a repeated hello ends no session";
  bench.ask(after, 1, 1);
  EXPECT_EQ(bench.sessions.size(), 3u);
  EXPECT_EQ(bench.sessions.counters().replaced, 1u);
  EXPECT_EQ(bench.sessions.next_job({})->request.frame, FrameId{1});
  bench.ask(before, 1, 1001);
  EXPECT_EQ(before.no_session, 1u);
  bench.ask(elsewhere, 2, 2);
  bench.ask(other, 1, 3);
  EXPECT_EQ(elsewhere.no_session + other.no_session, 0u) << "another address, another key";
}

TEST(Sessions, ClientsTakeTurnsWhateverTheyAsk) {
  SessionsBench bench;
  std::vector<LinkClient> clients;
  for (std::uint16_t port = 0; port < 3; ++port) clients.push_back(bench.join(port));
  std::uint32_t frame = 0;
  const auto ask = [&](std::uint16_t port) { bench.ask(clients[port], port, ++frame); };
  for (std::uint16_t port = 0; port < 3; ++port) ask(port);
  std::vector<std::uint16_t> turns;
  for (int i = 0; i < 9; ++i) {
    const SessionId served = bench.sessions.next_job({})->session;
    const auto client = std::ranges::find(clients, served, &LinkClient::session);
    turns.push_back(static_cast<std::uint16_t>(client - clients.begin()));
    for (int often = 0; often < 5; ++often) ask(0);  // greedy
    ask(turns.back());
  }
  EXPECT_EQ(turns, (std::vector<std::uint16_t>{0, 1, 2, 0, 1, 2, 0, 1, 2}));
}

TEST(SessionOffer, EndsSessionsThatUseAWithdrawnAnswerOrMayAskForIt) {
  SessionsBench bench;
  Welcome served = kServed;
  served.answers = kEveryAnswer;
  bench.sessions = Sessions(served, kRing);
  const auto ask_for = [&](LinkClient& client, std::uint16_t port, std::uint32_t frame, Answer answer) {
    FrameRequest request = request_of(frame, kSize);
    request.answer.kind = answer;
    bench.talk(client, port, client.seal({.request = request}));
  };
  LinkClient masks = bench.join(1), planes = bench.join(2), silent = bench.join(3);
  ask_for(masks, 1, 1, Answer::Masks);
  ask_for(planes, 2, 1, Answer::GBuffer);
  bench.sessions.offer(kTracedAnswers);
  EXPECT_EQ(bench.sessions.counters().withdrawn, 2u);
  EXPECT_EQ(bench.sessions.size(), 1u);
  ask_for(planes, 2, 2, Answer::GBuffer);
  EXPECT_EQ(planes.no_session, 1u) << "the client is told";
  planes = bench.join(2);
  EXPECT_EQ(planes.welcome->answers, kTracedAnswers) << "and learns what is offered";
  ask_for(masks, 1, 2, Answer::Masks);
  ask_for(planes, 2, 3, Answer::GBuffer);
  ask_for(silent, 3, 1, Answer::GBuffer);
  EXPECT_EQ(masks.no_session, 0u);
  EXPECT_EQ(silent.no_session, 1u) << "its Welcome offered the answer";
  EXPECT_EQ(bench.sessions.counters().unanswered, 1u);
  EXPECT_EQ(bench.sessions.next_job({})->request.frame, FrameId{2});
  EXPECT_FALSE(bench.sessions.next_job({}));
}

TEST(SessionOffer, ASessionThatStaysGetsNoWithdrawnAnswer) {
  SessionsBench bench;
  Welcome served = kServed;
  served.answers = kEveryAnswer;
  bench.sessions = Sessions(served, kRing);
  LinkClient client = bench.join(1);
  bench.ask(client, 1, 1);
  ASSERT_TRUE(bench.sessions.next_job({}).has_value());
  bench.sessions.offer(kTracedAnswers);
  FrameRequest request = request_of(2, kSize);
  request.answer.kind = Answer::GBuffer;
  bench.talk(client, 1, client.seal({.request = request}));
  EXPECT_EQ(client.no_session, 0u) << "it has requested masks only, and they are still offered";
  EXPECT_FALSE(bench.sessions.next_job({}).has_value());
  EXPECT_EQ(bench.sessions.counters().unanswered, 1u);
}

TEST(Sessions, RepeatedHelloGetsTheVerySameAcceptAndNoSecondSession) {
  SessionsBench bench;
  LinkClient client(kRing[0], kServed);
  const Bytes proved = client.take(bench.say(1, client.hello()), {});
  const Bytes accept = bench.say(1, proved);
  client.take(accept, {});
  for (int i = 0; i < 10; ++i) EXPECT_EQ(bench.say(1, proved, Time(i * 100ms)), accept);
  bench.ask(client, 1, 1, Time(1s));
  EXPECT_EQ(bench.say(1, proved, Time(1s)), accept) << "an active session is not disturbed";
  bench.ask(client, 1, 2, Time(1s));
  EXPECT_EQ(bench.sessions.size(), 1u);
  EXPECT_EQ(bench.sessions.counters().welcomed, 1u);
  EXPECT_EQ(bench.sessions.counters().repeated, 11u);
  EXPECT_EQ(bench.sessions.next_job(Time(1s))->request.frame, FrameId{2});
}

TEST(Sessions, HelloCaughtAndRepeatedElsewhereProvesNothing) {
  SessionsBench bench;
  LinkClient client(kRing[0], kServed);
  const Bytes proved = client.take(bench.say(1, client.hello()), {});
  const Bytes answer = bench.say(2, proved);
  EXPECT_TRUE(std::holds_alternative<Retry>(*open_server_envelope(answer)));
  EXPECT_EQ(bench.sessions.size(), 0u);
}

TEST(Sessions, HelloRepeatedBySomebodyElseLeavesOneSessionForAsLongAsItIsUnconfirmed) {
  SessionsBench bench;
  LinkClient client(kRing[0], kServed);
  const Bytes proved = client.take(bench.say(1, client.hello()), {});
  const Bytes accept = bench.say(1, proved);
  const Duration unconfirmed = SessionLimits{}.unconfirmed;
  for (Duration at = 0s; at <= unconfirmed; at += 50ms) {
    const Bytes answer = bench.say(1, proved, Time(at));
    if (answer != accept) {
      EXPECT_TRUE(std::holds_alternative<Retry>(*open_server_envelope(answer))) << "its cookie has expired";
      EXPECT_GT(at, kCookiePeriod);
    }
    EXPECT_EQ(bench.sessions.size(), 1u);
  }
  for (Duration at = unconfirmed + 1ms; at < 60s; at += 500ms) {
    bench.say(1, proved, Time(at));
    EXPECT_EQ(bench.sessions.size(), 0u) << "without a valid cookie there is never a session";
  }
  EXPECT_EQ(bench.sessions.counters().welcomed, 1u);
  EXPECT_EQ(bench.sessions.counters().forgotten, 1u);
}

TEST(Sessions, AFullServerRefusesTheNextClientOnly) {
  SessionsBench bench({.sessions = 2});
  LinkClient first = bench.join(1), second = bench.join(2);
  const LinkClient third = bench.join(3);
  ASSERT_TRUE(third.refusal.has_value());
  EXPECT_EQ(third.refusal->reason, RefusalReason::Busy);
  EXPECT_EQ(bench.sessions.size(), 2u);
  EXPECT_EQ(bench.sessions.counters().busy, 1u);
  bench.talk(second, 2, second.hello());
  EXPECT_EQ(bench.sessions.counters().repeated, 1u) << "the server repeats its accept";
  bench.ask(first, 1, 1);
  EXPECT_TRUE(bench.taken.has_value());
}

TEST(Sessions, ShakesHandsNoMoreOftenThanItsLimit) {
  SessionsBench bench({.sessions = 1000, .handshakes_per_second = 10});
  bench.sessions.set_ring({kRing[0]});  // all handshakes are of one key
  std::uint16_t port = 0;
  const auto come = [&](int count, Time now) {
    const std::size_t before = bench.sessions.size();
    for (int i = 0; i < count; ++i) bench.join(++port, now);
    return bench.sessions.size() - before;
  };
  EXPECT_EQ(come(50, Time(0s)), 10u);
  EXPECT_EQ(bench.sessions.gate().too_many, 40u);
  EXPECT_EQ(come(50, Time(500ms)), 5u);
  EXPECT_EQ(come(50, Time(4s)), 10u) << "no more tokens were saved";
}

TEST(Sessions, SendsAClientNoMoreThanItsLimitOfBytesASecond) {
  constexpr double kMost = 100e3;
  SessionsBench bench({.bytes_per_second = kMost});
  LinkClient client = bench.join(1);
  const std::vector<Bytes> messages(20, Bytes(kMaxMessage_bytes, std::byte{5}));
  std::size_t sent = 0;
  Time now{};
  for (std::uint32_t frame = 1; now < Time(10s); now += 5ms, ++frame) {
    bench.talk(client, 1,
               client.seal({.request = request_of(frame, kSize), .arrivals = client.arrivals.report()}), now);
    if (const auto job = bench.sessions.next_job(now)) bench.sessions.put(job->session, messages, {}, now);
    Peer to;
    for (Bytes datagram; bench.sessions.seal_due(now, to, datagram); sent += datagram.size())
      client.arrivals.add(std::get<Sealed>(*open_server_envelope(datagram)).counter, now);
  }
  EXPECT_LE(static_cast<double>(sent), 1.05 * kMost * 10);
  EXPECT_GE(static_cast<double>(sent), 0.7 * kMost * 10);
  EXPECT_GT(bench.sessions.counters().held_back, 20u);
}

std::vector<std::string> events_in_words(SessionsBench& bench) {
  std::vector<std::string> words;
  for (const ClientEvent& event : bench.sessions.take_events()) words.push_back(in_words(event));
  return words;
}

TEST(SessionEvents, TellTheLogWhoComesAndGoes) {
  SessionsBench bench({.silence = 10s, .unconfirmed = 5s});
  LinkClient client = bench.join(1), doctor = bench.join(2);
  Welcome none = kServed;
  none.scene_hash = kNoScene;
  LinkClient asks(kRing[1], none);
  bench.talk(asks, 3, asks.hello());
  bench.ask(client, 1, 1, Time(3s));
  EXPECT_EQ(events_in_words(bench),
            (std::vector<std::string>{
                "welcomed ada at " + to_string(peer(1)), "welcomed ada at " + to_string(peer(2)),
                "bob at " + to_string(peer(3)) + " asked which scene is served (vr_client doctor)"}));
  EXPECT_EQ(bench.sessions.silent_at(), Time(5s) + Duration(1));
  bench.sessions.end_silent(Time(5s));
  EXPECT_TRUE(events_in_words(bench).empty());
  bench.sessions.end_silent(Time(20s));
  EXPECT_EQ(events_in_words(bench),
            (std::vector<std::string>{
                "ada at " + to_string(peer(1)) + " left without a word; it was connected for 3 s",
                "ada at " + to_string(peer(2)) + " left without a request"}));
  EXPECT_FALSE(bench.sessions.silent_at().has_value());
}

/// The server waits until silent_at() if no datagram arrives.
TEST(Sessions, ASilentClientIsForgottenAlthoughNoDatagramArrivesAfterAnEarlierOneWas) {
  SessionsBench bench({.silence = 10s, .unconfirmed = 5s});
  LinkClient asks = bench.join(1);
  bench.join(2);
  bench.ask(asks, 1, 1, Time(3s));
  bench.sessions.end_silent(bench.sessions.silent_at().value());
  EXPECT_EQ(bench.sessions.size(), 1u);
  ASSERT_EQ(bench.sessions.silent_at(), Time(13s) + Duration(1));
  bench.sessions.end_silent(bench.sessions.silent_at().value());
  EXPECT_EQ(bench.sessions.size(), 0u);
}

TEST(SessionEvents, TellTheLogWhyAKeyIsRefused) {
  SessionsBench bench, open;
  open.sessions.set_ring({insecure_key()});
  SharedKey stranger = key_named("mallory"), liar = kRing[0];
  const auto told = [](SessionsBench& where, std::uint16_t port, const SharedKey& key) {
    where.join(port, {}, key);
    return events_in_words(where).at(0);
  };
  EXPECT_NE(told(bench, 1, stranger).find("no key of the ring has its id " + short_form(id_of(stranger))),
            std::string::npos);
  EXPECT_NE(told(bench, 2, insecure_key()).find("start it without --insecure"), std::string::npos);
  EXPECT_NE(told(open, 3, stranger).find("start it with --insecure"), std::string::npos);
  LinkClient honest(liar, kServed);
  Bytes proved = honest.take(bench.say(4, honest.hello()), {});
  proved[kHelloProved_bytes] ^= std::byte{1};
  bench.say(4, proved);
  EXPECT_NE(events_in_words(bench).at(0).find("it named the key 'ada' and could not prove"),
            std::string::npos);
}

TEST(Sessions, ANewRingAdmitsNewKeysAndEndsTheSessionsOfOthers) {
  SessionsBench bench;
  LinkClient ada = bench.join(1), bob = bench.join(2, {}, kRing[1]);
  SharedKey renewed = kRing[1];
  renewed.secret[0] ^= 1;
  bench.sessions.set_ring({kRing[0], renewed, key_named("new")});
  bench.ask(ada, 1, 1);
  bench.ask(bob, 2, 1);
  EXPECT_EQ(ada.no_session, 0u);
  EXPECT_EQ(bob.no_session, 1u) << "the same name with another secret";
  EXPECT_EQ(bench.sessions.counters().revoked, 1u);
  EXPECT_TRUE(bench.join(3, {}, key_named("new")).welcome.has_value());
  EXPECT_FALSE(bench.join(4, {}, kRing[2]).welcome.has_value());
}

TEST(ServerCounters, NameOnlyWhatHasHappened) {
  ServerCounters counters;
  EXPECT_EQ(counters_line(counters),
            "rt_server: 0 clients, 0 requests, 0 frames, 0 datagrams and 0 bytes sent, 0 datagrams received");
  counters.sessions.moved = 2;
  counters.refused.count(WireRefusal::Forged);
  const std::string line = counters_line(counters);
  EXPECT_NE(line.find("; 1 refused (1 forged); sessions: 2 moved"), std::string::npos) << line;
}

TEST(Sessions, SilentClientsAreForgottenAfterTheStatedTime) {
  SessionsBench bench({.sessions = 3, .silence = 10s, .unconfirmed = 5s});
  LinkClient silent = bench.join(1), talks = bench.join(2), unconfirmed = bench.join(3);
  bench.ask(silent, 1, 1);
  const auto ask = [&](std::uint32_t frame, Time now) {
    bench.ask(talks, 2, frame, now);
    return bench.sessions.size();
  };
  EXPECT_EQ(ask(1, Time(5s)), 3u);
  EXPECT_EQ(ask(2, Time(5s + 1ms)), 2u) << "the client that sent nothing sealed";
  EXPECT_EQ(ask(3, Time(10s)), 2u);
  EXPECT_EQ(ask(4, Time(10s + 1ms)), 1u);
  EXPECT_EQ(bench.sessions.counters().forgotten, 2u);
  bench.ask(silent, 1, 2, Time(11s));
  EXPECT_EQ(silent.no_session, 1u);
  EXPECT_TRUE(bench.join(4, Time(11s)).welcome.has_value()) << "there is room again";
}

}  // namespace
}  // namespace farshade
