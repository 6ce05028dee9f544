/// A client's session when its server is restarted, its path is silent, its address changes, or somebody
/// forges datagrams of its server.

#include <gtest/gtest.h>

#include <set>

#include "stereo/net/explain.h"
#include "tests/support/sanitized.h"
#include "tests/unit/link/link_bench.h"

namespace farshade {
namespace {

using namespace link_test;

constexpr std::size_t kLong = 32;  ///< requests that the link keeps: more than are in transit

/// A forger's datagrams have the server's address and everything that is visible on the wire.
struct WatchedBench : LinkBench {
  explicit WatchedBench(const LinkModels& models) : LinkBench(models, kLong) {
    on_send = [this](std::span<const std::byte> datagram) {
      const auto envelope = open_client_envelope(datagram);
      if (!envelope) return false;
      if (const auto* sealed = std::get_if<Sealed>(&*envelope)) session = sealed->session;
      if (const auto* hello = std::get_if<Hello>(&*envelope)) echo = echo_of(hello->client);
      return false;
    };
    start_server();
    EXPECT_TRUE(link.connect(2s).has_value());
    run(500ms);
  }
  template <class Envelope>
  void forge(const Envelope& envelope) {
    Bytes datagram;
    encode(envelope, datagram);
    forge_bytes(datagram);
  }
  void forge_bytes(const Bytes& datagram) { wire.server().send(wire.client().local(), datagram); }
  void forge_everything() {
    forge(NoSession{session});
    forge(Retry{echo, Cookie{1}});
    for (const RefusalReason reason : {RefusalReason::VersionMismatch, RefusalReason::UnknownKey})
      forge(OpenRefusal{.reason = reason, .echo = echo});
    Bytes accept;
    encode(Accept{.echo = echo, .session = {99}, .server = {9}}, accept);
    accept.resize(accept.size() + 60, std::byte{3});
    forge_bytes(accept);
    Bytes sealed;
    encode(Sealed{.session = session, .counter = 1'000'000}, sealed);
    sealed.resize(sealed.size() + 60, std::byte{3});
    forge_bytes(sealed);
  }

  SessionId session;
  HelloEcho echo{};
};

TEST(LinkGoodbye, TheServerForgetsAClientThatEnds) {
  LinkBench bench;
  bench.start_server();
  {
    NetworkLink link(bench.client_port, bench.clock, bench.target, kFrames);
    ASSERT_TRUE(link.connect(2s).has_value());
    EXPECT_EQ(bench.server->counters().sessions_open, 1u);
  }
  bench.pass(2 * kWay);
  EXPECT_EQ(bench.server->counters().sessions_open, 0u);
  EXPECT_EQ(bench.server->counters().sessions.left, 1u);
}

TEST(LinkGoodbye, AServerThatEndsIsGreetedAtOnce) {
  WatchedBench bench(kSlow);
  bench.server->say_goodbye();
  bench.server.reset();
  bench.pass(kWay);
  EXPECT_FALSE(bench.link.last_received().has_value());
  ASSERT_TRUE(bench.link.goodbye().has_value());
  EXPECT_NE(bench.link.goodbye()->find("it ends itself"), std::string::npos) << *bench.link.goodbye();
  EXPECT_TRUE(bench.link.silent_since().has_value() ||
              (bench.pass(1ms), bench.link.silent_since().has_value()));
  EXPECT_FALSE(bench.link.refused().has_value());
  bench.start_server();
  const Duration took = bench.run_until_masks(3s);
  EXPECT_LE(took, kHelloInterval + 6 * kWay + 2 * kInterval);
  EXPECT_FALSE(bench.link.goodbye().has_value());
  EXPECT_EQ(bench.link.counters().sessions, 2u);
}

TEST(LinkGoodbye, AClientWhoseKeyIsTakenAwaySaysSo) {
  WatchedBench bench(kSlow);
  bench.server->set_ring({key_named("bob")});
  bench.pass(2 * kWay);
  ASSERT_TRUE(bench.link.refused().has_value());
  EXPECT_NE(bench.link.refused()->what.find("the key 'ada' was taken out of its ring"), std::string::npos)
      << bench.link.refused()->what;
}

TEST(LinkGoodbye, OneThatIsReplayedOrForgedDoesNothing) {
  std::vector<Bytes> old;
  WatchedBench bench(kSlow);
  bench.on_answer = [&](std::span<const std::byte> datagram) {
    old.emplace_back(datagram.begin(), datagram.end());
    return false;
  };
  bench.server->say_goodbye();
  bench.start_server();
  bench.run(500ms);
  ASSERT_EQ(bench.link.counters().sessions, 2u);
  for (const Bytes& datagram : old) bench.forge_bytes(datagram);
  Bytes forged;
  encode(Sealed{.session = bench.session, .counter = 1'000'000}, forged);
  forged.resize(forged.size() + 2 + kTag_bytes, std::byte{23});
  bench.forge_bytes(forged);
  bench.run(100ms);
  EXPECT_EQ(bench.link.counters().sessions, 2u);
  EXPECT_FALSE(bench.link.goodbye().has_value());
}

/// Longer than two epochs. The masks go on, and no datagram is refused.
TEST(LinkGoodbye, ASessionGoesOnWithNewKeys) {
  WatchedBench bench(kSlow);
  std::uint16_t epoch_up = 0, epoch_down = 0;
  bench.on_answer = [&](std::span<const std::byte> datagram) {
    const auto envelope = open_server_envelope(datagram);
    if (const auto* sealed = std::get_if<Sealed>(&*envelope)) epoch_down = sealed->epoch;
    return false;
  };
  bench.on_send = [&](std::span<const std::byte> datagram) {
    const auto envelope = open_client_envelope(datagram);
    if (const auto* sealed = std::get_if<Sealed>(&*envelope)) epoch_up = sealed->epoch;
    return false;
  };
  while (bench.clock.now() < Time(2 * kEpochTime + 10s)) {
    bench.ask(request(++bench.frame, bench.clock.now().time_since_epoch()));
    bench.pass(250ms);
  }
  EXPECT_EQ(epoch_up, 2u);
  EXPECT_EQ(epoch_down, 2u);
  EXPECT_EQ(bench.link.counters().sessions, 1u);
  EXPECT_EQ(bench.link.counters().undecodable.total(), 0u);
  EXPECT_EQ(bench.server->counters().refused.total(), 0u);
}

struct Restart {
  Duration delay;
  bool hint;
};
class LinkRestart : public testing::TestWithParam<Restart> {};

TEST_P(LinkRestart, MasksAreBackWithinASecond) {
  ConnectedBench bench(each_way(GetParam().delay), kLong);
  bench.run(500ms);
  if (!GetParam().hint)
    bench.on_answer = [](std::span<const std::byte> datagram) {
      const auto envelope = open_server_envelope(datagram);
      return envelope && std::holds_alternative<NoSession>(*envelope);
    };
  for (int restart = 1; restart <= 3; ++restart) {
    bench.start_server();
    const Duration took = bench.run_until_masks(3s);
    std::printf("restart at %g ms, %s the hint: masks after %g ms\n", ms_of(GetParam().delay),
                GetParam().hint ? "with" : "without", ms_of(took));
    // A mask of the old server that was in transit does not count: run_until_masks waits for a later one.
    EXPECT_LE(took, 1s);
    EXPECT_EQ(bench.link.counters().sessions, static_cast<std::uint64_t>(restart + 1));
    EXPECT_FALSE(bench.link.refused().has_value());
    bench.run(500ms);
    EXPECT_EQ(bench.server->counters().sessions_open, 1u);
  }
}

INSTANTIATE_TEST_SUITE_P(Delays, LinkRestart,
                         testing::Values(Restart{0ms, true}, Restart{25ms, true}, Restart{100ms, true},
                                         Restart{0ms, false}, Restart{25ms, false}, Restart{100ms, false}));

TEST(LinkSession, EndsWithTheCureWhenTheServerComesBackWithAnotherScene) {
  ConnectedBench bench(kSlow, kLong);
  bench.run(500ms);
  Welcome other = kServed;
  other.scene_hash[0] ^= 1;
  bench.start_server(other);
  bench.run(3s);
  ASSERT_TRUE(bench.link.refused());
  EXPECT_EQ(bench.link.refused()->fault, Fault::Mismatch);
  const std::string& what = bench.link.refused()->what;
  EXPECT_NE(what.find("the server serves scene " + short_form(other.scene_hash)), std::string::npos) << what;
  EXPECT_NE(what.find("start the client again without --scene"), std::string::npos) << what;
}

TEST(LinkSession, OutlivesABusyServer) {
  ConnectedBench bench;
  bench.trace_time = 700ms;  // as long as a round of many clients
  bench.run(10s);
  EXPECT_EQ(bench.link.counters().sessions, 1u);
  EXPECT_EQ(bench.server->counters().sessions.welcomed, 1u);
  EXPECT_EQ(bench.server->counters().gate.retries, 1u) << "no cookie was requested";
  EXPECT_GE(bench.server->counters().frames, 13u);
}

TEST(LinkSession, KnowsSinceWhenTheServerIsSilent) {
  ConnectedBench bench;
  bench.run(2s);
  EXPECT_FALSE(bench.link.silent_since().has_value());
  bench.pass(5s);
  EXPECT_FALSE(bench.link.silent_since().has_value()) << "nothing is asked";
  bench.server.reset();
  const Time killed = bench.clock.now();
  bench.run(900ms);
  EXPECT_FALSE(bench.link.silent_since().has_value()) << "an answer may take long";
  bench.run(2s);
  ASSERT_TRUE(bench.link.silent_since().has_value());
  EXPECT_LE(*bench.link.silent_since() - killed, kInterval);
  bench.start_server();
  bench.run(2s);
  EXPECT_FALSE(bench.link.silent_since().has_value());
}

TEST(LinkSession, IsSilentFromTheFirstHelloOn) {
  LinkBench bench;
  EXPECT_FALSE(bench.link.silent_since().has_value()) << "nobody was greeted";
  EXPECT_FALSE(bench.link.connect(3s).has_value());
  EXPECT_EQ(bench.link.silent_since(), Time{});
}

TEST(LinkSession, IsNotEndedBySomebodyElse) {
  for (const Duration delay : {0ms, 25ms, 100ms}) {
    WatchedBench bench(each_way(delay));
    const SessionId before = bench.session;
    const std::uint64_t frames = bench.server->counters().frames;
    for (int i = 0; i < 100; ++i) {
      bench.forge_everything();
      bench.run(kInterval);
    }
    bench.run(500ms);
    EXPECT_EQ(bench.session, before);
    EXPECT_EQ(bench.link.counters().sessions, 1u);
    EXPECT_EQ(bench.server->counters().gate.retries, 1u) << "no further hello";
    EXPECT_GE(bench.server->counters().frames - frames, 98u);
    EXPECT_TRUE(bench.link.last_received().has_value());
    EXPECT_FALSE(bench.link.refused().has_value());
    EXPECT_EQ(bench.link.counters().undecodable[WireRefusal::Forged], 100u);
  }
}

TEST(LinkSession, ANoSessionOfItsOwnAfterSilenceBringsAHelloAtOnce) {
  WatchedBench bench(kSlow);
  int hellos = 0;
  bench.on_send = [&](std::span<const std::byte> datagram) {
    const auto envelope = open_client_envelope(datagram);
    if (envelope && std::holds_alternative<Hello>(*envelope)) ++hellos;
    return false;
  };
  const auto hellos_after = [&](SessionId lost) {
    bench.forge(NoSession{lost});
    bench.pass(2 * kWay);
    return hellos;
  };
  bench.server.reset();
  EXPECT_EQ(hellos_after(bench.session), 0) << "the server may be busy";
  bench.pass(kServerSilenceAfterNoSession);
  EXPECT_EQ(hellos_after({bench.session.value ^ 1}), 0) << "another session";
  EXPECT_EQ(hellos_after(bench.session), 1);
}

TEST(LinkSession, BeginsAlthoughSomebodyElseRefuses) {
  LinkBench bench(each_way(25ms));
  HelloEcho echo{};
  bench.on_send = [&](std::span<const std::byte> datagram) {
    const auto envelope = open_client_envelope(datagram);
    if (const auto* hello = envelope ? std::get_if<Hello>(&*envelope) : nullptr) {
      echo = echo_of(hello->client);
      Bytes refusal;
      encode(OpenRefusal{.reason = RefusalReason::UnknownKey, .echo = echo}, refusal);
      bench.wire.server().send(bench.wire.client().local(), refusal);  // it arrives first
    }
    return false;
  };
  bench.start_server();
  EXPECT_TRUE(bench.link.connect(2s).has_value());
  EXPECT_FALSE(bench.link.refused().has_value());
}

/// The true server hears nothing for longer than a second.
TEST(LinkSession, AForgedRefusalThatComesFirstDoesNotEndTheClient) {
  LinkBench bench(each_way(5ms));
  bench.start_server();
  bench.on_send = [&](std::span<const std::byte> datagram) {
    const auto envelope = open_client_envelope(datagram);
    const auto* hello = envelope ? std::get_if<Hello>(&*envelope) : nullptr;
    if (hello == nullptr || bench.clock.now() > Time(1500ms)) return false;
    Bytes refusal;
    encode(OpenRefusal{.reason = RefusalReason::UnknownKey, .echo = echo_of(hello->client)}, refusal);
    bench.wire.server().send(bench.wire.client().local(), refusal);
    return true;
  };
  EXPECT_TRUE(bench.link.connect(3s).has_value());
}

TEST(LinkSession, ARefusalIsNamedWhenPatienceIsOver) {
  LinkBench bench(each_way(5ms));
  bench.start_server(kServed, {}, {key_named("bob")});
  const auto connected = bench.link.connect(3s);
  ASSERT_FALSE(connected.has_value());
  EXPECT_EQ(connected.error().fault, Fault::Mismatch);
  EXPECT_NE(connected.error().what.find("has no key"), std::string::npos) << connected.error().what;
}

TEST(LinkSession, ContinuesAtOnceAfterSilence) {
  ConnectedBench bench(each_way(25ms), kLong);
  bench.run(1s);
  bool silent = true;
  bench.on_answer = [&](std::span<const std::byte>) { return silent; };
  bench.on_send = [&](std::span<const std::byte>) { return silent; };
  bench.run(2s);
  silent = false;
  const Duration took = bench.run_until_masks(2s);
  std::printf("after silence: masks after %g ms\n", ms_of(took));
  EXPECT_LE(took, 50ms + kInterval);
  bench.run(2s);
  EXPECT_EQ(bench.link.counters().sessions, 1u) << "the old session continues";
}

TEST(LinkSession, FollowsItsClientWithinTwoRoundTrips) {
  for (const Duration delay : kSanitized ? std::vector{5ms} : std::vector{0ms, 5ms, 25ms, 100ms}) {
    ConnectedBench bench(each_way(delay), kLong);
    bench.run(500ms);
    for (int move = 0; move < 5; ++move) {
      bench.wire.move_client(0);
      const Duration took = bench.run_until_masks(3s);
      EXPECT_LE(took, 4 * delay + 2 * kInterval) << ms_of(delay) << " ms";
      bench.run(1s);
    }
    EXPECT_EQ(bench.link.counters().sessions, 1u);
    EXPECT_EQ(bench.server->counters().sessions.moved, 5u);
  }
}

TEST(LinkSession, StaysWithItsClientWhenItsDatagramsAreSentOnFromElsewhere) {
  LinkBench bench(kSlow, kLong, 2);
  bool steal = false;
  std::size_t stolen_bytes = 0;
  // Datagrams that two clients send at the same time arrive in the order of the clients; the thief is the
  // first.
  bench.on_send = [&](std::span<const std::byte> datagram) {
    if (steal) {
      bench.wire.client(0).send(bench.wire.server().local(), datagram);
      stolen_bytes += datagram.size();
    }
    return false;
  };
  bench.start_server();
  ASSERT_TRUE(bench.link.connect(2s).has_value());
  bench.run(500ms);
  steal = true;
  const std::uint64_t before = bench.server->counters().frames;
  std::size_t got = 0;  // number of masks that the thief received
  bench.on_event = [&] {
    std::array<std::byte, kMaxDatagram_bytes> buffer;
    while (const auto datagram = bench.wire.client(0).receive(buffer, 0s)) got += datagram->bytes.size();
  };
  bench.run(100 * kInterval);
  EXPECT_EQ(bench.server->counters().sessions.moved, 0u);
  EXPECT_GT(bench.server->counters().refused[WireRefusal::Replayed], 90u);
  EXPECT_GE(bench.server->counters().frames - before, 98u);
  EXPECT_GT(got, 0u) << "the server sent it a probe";
  EXPECT_LE(got, stolen_bytes);
  std::size_t whole = 0;
  for (const RequestRecord* frame : bench.link.receiver().received(Time::max()))
    whole += frame->complete() ? 1 : 0;
  EXPECT_GE(whole, kLong - 4) << "slices go to the client";
}

/// The frames within `time` whose masks claim light changes that the server did not trace.
void change_lights_and_compare(LinkBench& bench, Duration time) {
  std::set<std::uint32_t> compared;
  const Time until = bench.clock.now() + time;
  for (std::uint32_t n = 0; bench.clock.now() < until; ++n) {
    change(bench.lights, (n * 7 + n / 5) % 20, n % 3 != 0, LightPose{.position = {{n * 0.01, 1, 2}}});
    bench.run(kInterval);
    for (const RequestRecord* frame : bench.link.receiver().received(Time::max())) {
      const LightChanges& traced = bench.traced_lights.at(frame->request.frame.value);
      ASSERT_EQ(frame->light_set_revision, traced.revision);
      for (const LightChange& believed : frame->request.lights.lights)
        ASSERT_NE(std::ranges::find(traced.lights, believed), traced.lights.end())
            << "frame " << frame->request.frame.value << " light " << believed.light;
      compared.insert(frame->request.frame.value);
    }
  }
  EXPECT_GT(compared.size(), static_cast<std::size_t>(time / kInterval) / 5);
}

/// Without further changes, both sides soon have all of them.
void expect_agreement(LinkBench& bench) {
  bench.run(2s);
  ASSERT_FALSE(bench.traced_lights.empty());
  EXPECT_EQ(bench.traced_lights.rbegin()->second, bench.lights);
}

constexpr LinkModel kRough{.delay = 15ms, .jitter = 20ms, .loss = 0.3, .reorder = 0.1};

TEST(LinkSessions, APauseWithoutRequestsIsNoSilenceOfTheServer) {
  LinkBench bench;
  bench.start_server();
  ASSERT_TRUE(bench.link.connect(1s));
  bench.run(1s);
  const std::uint64_t hellos = bench.server->counters().gate.retries;
  bench.pass(3s);
  bench.run(1s);
  EXPECT_EQ(bench.server->counters().gate.retries, hellos);
}

/// A client that asks for nothing for 30 s, and keeps its session alive or does not. Returns the handshakes
/// that it then needs.
std::uint64_t handshakes_after_rest(LinkBench& bench, bool keeps_alive) {
  bench.start_server();
  EXPECT_TRUE(bench.link.connect(1s));
  bench.lights = {};
  for (std::uint32_t light = 0; light < kLights; ++light) change(bench.lights, light, false, std::nullopt);
  bench.run(1s);
  const std::uint64_t before = bench.server->counters().gate.retries;
  for (int second = 0; second < 30; ++second) {
    bench.pass(1s);
    if (keeps_alive) bench.link.keep_alive();
  }
  EXPECT_FALSE(bench.link.silent_since().has_value());
  bench.run(1s);
  EXPECT_EQ(bench.traced_lights.rbegin()->second, bench.lights);
  return bench.server->counters().gate.retries - before;
}

TEST(LinkSessions, KeepAliveKeepsTheSessionOfAClientThatAsksForNothing) {
  LinkBench kept, lost;
  EXPECT_EQ(handshakes_after_rest(kept, true), 0u);
  EXPECT_GT(handshakes_after_rest(lost, false), 0u) << "without it, the session ends";
  EXPECT_EQ(kept.server->counters().refused.total(), 0u);
  const std::size_t traced = kept.traced_lights.size();
  kept.link.keep_alive();
  kept.pass(1s);
  EXPECT_EQ(kept.traced_lights.size(), traced) << "no request is answered twice";
}

TEST(LinkLights, ChangesAreSentUntilAcknowledgedAndBothSidesAgree) {
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    SCOPED_TRACE(seed);
    LinkBench bench({.to_server = kRough, .to_client = kRough, .seed = seed}, kLong);
    bench.start_server();
    ASSERT_TRUE(bench.link.connect(10s).has_value());
    change_lights_and_compare(bench, 5s);
    expect_agreement(bench);
  }
}

TEST(LinkLights, ARestartedServerGetsAllChanges) {
  LinkBench bench({.to_server = kRough, .to_client = kRough, .seed = 5}, kLong);
  bench.start_server();
  ASSERT_TRUE(bench.link.connect(10s).has_value());
  change_lights_and_compare(bench, 3s);
  for (int restart = 0; restart < 3; ++restart) {
    bench.start_server();
    change_lights_and_compare(bench, 3s);
  }
  expect_agreement(bench);
  EXPECT_EQ(bench.lights.lights.size(), 20u);
}

}  // namespace
}  // namespace farshade
