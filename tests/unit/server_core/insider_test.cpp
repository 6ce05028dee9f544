// A client that holds a valid key, and does with it what it likes, costs the clients of other keys nothing.
#include <gtest/gtest.h>

#include "tests/unit/forged.h"
#include "tests/unit/server_core/house.h"

namespace farshade {
namespace {

using namespace std::chrono_literals;
using namespace house_test;

const SharedKey kGood = kRing[0], kEvil = kRing[2];
constexpr std::uint16_t kGoodPort = 1, kEvilPort = 100;
constexpr SessionLimits kOpen{.sessions = 65, .handshakes_per_second = 1e6};

/// The time of the worker that a good client gets which always wants more. Both sides' jobs take what the
/// arguments say. `reconnects`: each session of the other key begins anew after each job.
double good_share(Duration good_job, Duration evil_job, std::size_t evil_sessions, bool reconnects) {
  House house(kOpen);
  LinkClient good = house.join(kGoodPort, {}, kGood);
  std::vector<LinkClient> evil;
  const auto port_of = [](std::size_t i) { return static_cast<std::uint16_t>(kEvilPort + i); };
  for (std::size_t i = 0; i < evil_sessions; ++i) evil.push_back(house.join(port_of(i), {}, kEvil));
  Duration to_good{}, all{};
  std::uint32_t frame = 1;
  house.ask(good, kGoodPort, frame);
  for (std::size_t i = 0; i < evil.size(); ++i) house.ask(evil[i], port_of(i), frame);
  while (all < 20s) {
    ++frame;
    const auto job = house.sessions.next_job({});
    const bool is_good = job->session == good.session;
    if (is_good) house.ask(good, kGoodPort, frame);
    for (std::size_t i = 0; i < evil.size(); ++i) {
      if (evil[i].session != job->session) continue;
      if (reconnects) evil[i] = house.join(port_of(i), {}, kEvil);
      house.ask(evil[i], port_of(i), frame);  // of a new session: the one whose job is in work ends
    }
    const Duration work = is_good ? good_job : evil_job;
    house.sessions.put(job->session, {}, work, {});
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
  House house(kOpen);
  LinkClient good = house.join(kGoodPort, {}, kGood), evil = house.join(kEvilPort, {}, kEvil);
  std::uint32_t frame = 1;
  house.ask(evil, kEvilPort, frame);
  house.sessions.put(house.sessions.next_job({})->session, {}, 1s, {});
  const Time later = Time(SessionLimits{}.silence + 1s);
  house.sessions.end_silent(later);
  ASSERT_EQ(house.sessions.size(), 0u);
  good = house.join(kGoodPort, later, kGood);
  evil = house.join(kEvilPort, later, kEvil);
  for (int i = 0; i < 199; ++i) {
    house.ask(evil, kEvilPort, ++frame, later);
    house.ask(good, kGoodPort, frame, later);
    const auto job = house.sessions.next_job(later);
    ASSERT_EQ(job->session, good.session) << i;
    house.sessions.put(job->session, {}, 5ms, later);
  }
}

TEST(Insider, AFullServerTakesASessionFromTheKeyWithTheMost) {
  House house({.sessions = 4, .handshakes_per_second = 1e6});
  std::vector<LinkClient> evil;
  for (std::uint16_t i = 0; i < 4; ++i) {
    evil.push_back(house.join(kEvilPort + i, Time(i * 1ms), kEvil));
    house.ask(evil.back(), kEvilPort + i, 1, Time(i * 1ms));
  }
  LinkClient good = house.join(kGoodPort, Time(10ms), kGood);
  ASSERT_TRUE(good.welcome.has_value());
  EXPECT_EQ(house.sessions.size(), 4u);
  EXPECT_EQ(house.sessions.counters().displaced, 1u);
  house.ask(evil[3], kEvilPort + 3, 2, Time(11ms));
  EXPECT_EQ(evil[3].no_session, 1u) << "the newest";
  EXPECT_TRUE(house.join(kEvilPort + 9, Time(12ms), kEvil).refusal.has_value()) << "it has the most already";
  EXPECT_TRUE(house.join(kGoodPort + 1, Time(13ms), kGood).welcome.has_value());
  EXPECT_TRUE(house.join(kGoodPort + 2, Time(14ms), kGood).refusal.has_value()) << "two each";
  EXPECT_EQ(house.sessions.counters().displaced, 2u);
}

TEST(Insider, OneKeyCannotUseUpTheHandshakes) {
  House house({.sessions = 1000, .handshakes_per_second = 10});
  std::size_t evil = 0;
  for (std::uint16_t i = 0; i < 50; ++i)
    evil += house.join(kEvilPort + i, {}, kEvil).welcome.has_value() ? 1 : 0;
  EXPECT_EQ(evil, 5u) << "half of the limit";
  EXPECT_EQ(house.sessions.gate().too_many, 45u);
  EXPECT_TRUE(house.join(kGoodPort, {}, kGood).welcome.has_value());
}

TEST(Insider, AKeyThatIsNoLongerAloneHasHalfOfTheHandshakes) {
  House house({.sessions = 1000, .handshakes_per_second = 10});
  house.sessions.set_ring({kEvil});
  EXPECT_TRUE(house.join(kEvilPort, {}, kEvil).welcome.has_value());
  house.sessions.set_ring(kRing);
  std::size_t evil = 0;
  for (std::uint16_t i = 0; i < 50; ++i)
    evil += house.join(kEvilPort + i, Time(10s), kEvil).welcome.has_value() ? 1 : 0;
  EXPECT_EQ(evil, 5u);
}

TEST(Insider, WhoSeesAHelloCannotRegisterItUnderItsOwnKey) {
  House house;
  LinkClient good(kGood, kServed);
  const Bytes first = good.hello();
  const PublicKey seen = std::get<Hello>(*open_client_envelope(first)).client;
  const Bytes retry = house.say(kEvilPort, hello_with(seen, kEvil, kServed.scene_hash, {}));
  const Cookie cookie = std::get<Retry>(*open_server_envelope(retry)).cookie;
  const Bytes stolen = house.say(kEvilPort, hello_with(seen, kEvil, kServed.scene_hash, cookie));
  ASSERT_TRUE(std::holds_alternative<Accept>(*open_server_envelope(stolen)));
  house.talk(good, kGoodPort, first);
  EXPECT_TRUE(good.welcome.has_value()) << "the good client has its own session";
  EXPECT_EQ(house.sessions.size(), 2u);
}

TEST(Insider, ACounterThatJumpsDoesNotCount) {
  House house;
  LinkClient client = house.join(kGoodPort, {}, kGood);
  house.ask(client, kGoodPort, 1);
  const Bytes honest = client.seal({.request = request_of(2, kSize)});
  Bytes far = honest;
  far[15 + 7] = std::byte{0xff};
  house.say(kGoodPort, far);
  EXPECT_EQ(house.taken.error(), WireRefusal::CounterJump);
  house.say(kGoodPort, honest);
  EXPECT_TRUE(house.taken.has_value());
}

/// A sealed Leave of this client.
Bytes leave_of(LinkClient& client) {
  Bytes bytes, datagram;
  encode(ClientMessage(Leave{}), bytes);
  client.sealer->seal(bytes, datagram);
  return datagram;
}

TEST(Goodbye, AClientThatLeavesFreesItsPlaceAtOnce) {
  House house({.sessions = 1});
  LinkClient client = house.join(kGoodPort, {}, kGood);
  house.ask(client, kGoodPort, 1);
  EXPECT_TRUE(house.join(kEvilPort, {}, kEvil).refusal.has_value());
  static_cast<void>(house.sessions.take_events());
  house.say(kGoodPort, leave_of(client), Time(3s));
  EXPECT_EQ(house.sessions.size(), 0u);
  EXPECT_EQ(house.sessions.counters().left, 1u);
  EXPECT_EQ(house.sessions.counters().forgotten, 0u);
  const auto events = house.sessions.take_events();
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].kind, ClientEvent::Kind::Left);
  EXPECT_EQ(events[0].connected, 3s);
  EXPECT_TRUE(house.join(kEvilPort, Time(3s), kEvil).welcome.has_value());
}

TEST(Goodbye, ALeaveThatIsReplayedOrForgedDoesNothing) {
  House house;
  LinkClient first = house.join(kGoodPort, {}, kGood);
  house.ask(first, kGoodPort, 1);
  const Bytes leave = leave_of(first);
  house.say(kGoodPort, leave);
  LinkClient second = house.join(kGoodPort, {}, kGood);
  house.ask(second, kGoodPort, 1);
  house.say(kGoodPort, leave);
  EXPECT_EQ(house.taken.error(), WireRefusal::UnknownSession);
  Bytes moved = leave;
  const Bytes own = second.seal({.request = request_of(2, kSize)});
  std::copy_n(own.begin(), kSealedHeader_bytes, moved.begin());
  house.say(kGoodPort, moved);
  EXPECT_EQ(house.taken.error(), WireRefusal::Forged);
  EXPECT_EQ(house.sessions.size(), 1u);
}

/// What the sessions send now.
std::vector<std::pair<Peer, Bytes>> sent_by(Sessions& sessions) {
  std::vector<std::pair<Peer, Bytes>> all;
  Peer to;
  Bytes datagram;
  while (sessions.seal_due({}, to, datagram)) all.emplace_back(to, datagram);
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
  House house;
  LinkClient good = house.join(kGoodPort, {}, kGood), evil = house.join(kEvilPort, {}, kEvil);
  house.sessions.set_ring({kGood});
  ASSERT_TRUE(house.sessions.due_at().has_value());
  const auto revoked = sent_by(house.sessions);
  ASSERT_EQ(revoked.size(), std::size_t{kGoodbyes});
  for (const auto& [to, datagram] : revoked) {
    EXPECT_EQ(to, peer(kEvilPort));
    EXPECT_EQ(std::get<Goodbye>(*opened(evil, datagram)).reason, EndReason::Revoked);
  }
  EXPECT_FALSE(house.sessions.due_at().has_value());
  house.sessions.say_goodbye();
  const auto ends = sent_by(house.sessions);
  ASSERT_EQ(ends.size(), std::size_t{kGoodbyes});
  EXPECT_EQ(std::get<Goodbye>(*opened(good, ends[0].second)).reason, EndReason::ServerEnds);
}

TEST(Goodbye, AClientThatFellSilentIsToldNothing) {
  House house;
  LinkClient client = house.join(kGoodPort, {}, kGood);
  house.ask(client, kGoodPort, 1);
  static_cast<void>(house.sessions.take_events());
  house.sessions.end_silent(Time(SessionLimits{}.silence + 1s));
  EXPECT_EQ(house.sessions.size(), 0u);
  EXPECT_TRUE(sent_by(house.sessions).empty());
  EXPECT_EQ(house.sessions.take_events().at(0).kind, ClientEvent::Kind::FellSilent);
}

SharedKey limited(SharedKey key, const KeyLimits& limits) {
  key.limits = limits;
  return key;
}

TEST(KeyLimits, AnExpiredKeyIsRefusedAndItsSessionsEnd) {
  House house;
  const auto last = parse_day("2027-01-31").value();
  const std::vector<SharedKey> ring{kGood, limited(kEvil, {.until = last})};
  house.sessions.set_ring(ring, last);
  LinkClient good = house.join(kGoodPort, {}, kGood), evil = house.join(kEvilPort, {}, kEvil);
  ASSERT_TRUE(evil.welcome.has_value());
  static_cast<void>(house.sessions.take_events());
  house.sessions.set_ring(ring, last + std::chrono::days(1));
  EXPECT_EQ(house.sessions.size(), 1u);
  EXPECT_EQ(house.sessions.counters().expired, 1u);
  EXPECT_EQ(house.sessions.counters().revoked, 0u);
  EXPECT_EQ(std::get<Goodbye>(*opened(evil, sent_by(house.sessions).at(0).second)).reason,
            EndReason::Expired);
  EXPECT_EQ(house.sessions.take_events().at(0).kind, ClientEvent::Kind::Expired);

  const LinkClient again = house.join(kEvilPort, {}, kEvil);
  EXPECT_EQ(again.open_refusal->reason, RefusalReason::UnknownKey) << "no more than a stranger is told";
  EXPECT_EQ(house.sessions.gate().expired_key, 1u);
  EXPECT_EQ(house.sessions.gate().unknown_key, 0u);
  const auto events = house.sessions.take_events();
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].kind, ClientEvent::Kind::KeyExpired);
  EXPECT_EQ(events[0].key, id_of(kEvil));
  SharedKey liar = kEvil;
  liar.secret[5] ^= 1;
  house.join(kEvilPort, {}, liar);
  EXPECT_EQ(house.sessions.gate().unknown_key, 1u);
}

TEST(KeyLimits, AKeyHasNoMoreSessionsThanTheRingAllows) {
  House house;
  house.sessions.set_ring({kGood, limited(kEvil, {.sessions = 2})});
  LinkClient first = house.join(kEvilPort, {}, kEvil);
  house.ask(first, kEvilPort, 1);
  EXPECT_TRUE(house.join(kEvilPort + 1, {}, kEvil).welcome.has_value());
  static_cast<void>(house.sessions.take_events());
  EXPECT_EQ(house.join(kEvilPort + 2, {}, kEvil).refusal->reason, RefusalReason::Busy);
  EXPECT_EQ(house.sessions.counters().key_full, 1u);
  const auto events = house.sessions.take_events();
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].kind, ClientEvent::Kind::TooManySessions);
  EXPECT_NE(in_words(events[0]).find("eve (key "), std::string::npos) << in_words(events[0]);
  EXPECT_TRUE(house.join(kEvilPort, {}, kEvil).welcome.has_value()) << "a client that was started anew";
  EXPECT_TRUE(house.join(kGoodPort, {}, kGood).welcome.has_value());
}

TEST(KeyLimits, AKeysSessionsAreNoFasterThanTheRingAllows) {
  for (const bool slow : {false, true}) {
    House house;
    house.sessions.set_ring(
        {limited(kEvil, {.bytes_per_second = slow ? std::optional<std::uint64_t>(25'000) : std::nullopt})});
    LinkClient client = house.join(kEvilPort, {}, kEvil);
    house.ask(client, kEvilPort, 1);
    EXPECT_EQ(house.sessions.next_job({})->bytes_per_second, slow ? 25'000u : 4'000'000u);
  }
}

TEST(Insider, AReplayedHelloThatWasRefusedCostsNoHandshake) {
  House house({.sessions = 1, .handshakes_per_second = 10});
  house.join(kEvilPort, {}, kEvil);
  LinkClient refused(kGood, kServed);
  const Bytes hello = refused.take(house.say(kGoodPort, refused.hello()), {});
  const Bytes answer = house.say(kGoodPort, hello);
  refused.take(answer, {});
  ASSERT_TRUE(refused.refusal.has_value());
  for (int i = 0; i < 100; ++i) EXPECT_EQ(house.say(kGoodPort, hello, Time(i * 1ms)), answer);
  EXPECT_EQ(house.sessions.gate().too_many, 0u);
  EXPECT_EQ(house.sessions.counters().busy, 1u);
}

TEST(Insider, AReplayedHelloOfASessionThatHasLeftBeginsNone) {
  House house;
  LinkClient client(kGood, kServed);
  const Bytes hello = client.take(house.say(kGoodPort, client.hello()), {});
  client.take(house.say(kGoodPort, hello), {});
  house.say(kGoodPort, leave_of(client), Time(1s));
  EXPECT_TRUE(house.say(kGoodPort, hello, Time(1500ms)).empty());
  EXPECT_EQ(house.sessions.size(), 0u);
  // With a cookie that is newer than the session's end, it is a client that is there.
  const Time later(1s + kCookieLife + 1ms);
  house.talk(client, kGoodPort, client.hello(), later);
  EXPECT_EQ(house.sessions.size(), 1u);
}

}  // namespace
}  // namespace farshade
