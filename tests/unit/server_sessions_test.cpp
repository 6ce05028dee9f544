#include <gtest/gtest.h>

#include "rt_server/sessions.h"

namespace farshade {
namespace {

using namespace std::chrono_literals;

const ContentHash kScene{1, 2, 3};
const Welcome kServed{kScene, 3, 1};

Peer peer(std::uint16_t port) {
  return Peer{{0, 1}, 0, port};
}

Hello hello() {
  return {.scene_hash = kScene};
}

RequestMessage request(std::uint32_t frame) {
  RequestMessage message;
  message.request.frame = {frame};
  return message;
}

RefusalReason reason_of(const std::optional<ServerMessage>& answer) {
  return std::get<Refusal>(answer.value()).reason;
}

TEST(Sessions, WelcomesTheSameScene) {
  Sessions sessions(kServed);
  const auto answer = sessions.handle(peer(1), hello(), {});
  ASSERT_TRUE(answer.has_value());
  EXPECT_EQ(std::get<Welcome>(*answer), kServed);
  EXPECT_EQ(sessions.counters(), SessionCounters{.welcomed = 1});
}

TEST(Sessions, RefusesAnotherSceneAndSaysWhichItServes) {
  Sessions sessions(kServed);
  Hello other = hello();
  other.scene_hash[31] ^= 1;
  const auto answer = sessions.handle(peer(1), other, {});
  EXPECT_EQ(reason_of(answer), RefusalReason::SceneMismatch);
  EXPECT_EQ(std::get<Refusal>(*answer).scene_hash, kScene);
  EXPECT_EQ(sessions.size(), 0u);
  EXPECT_EQ(sessions.counters(), SessionCounters{.scene_mismatch = 1});
}

TEST(Sessions, RefusesAnotherVersionAndSaysWhichItSpeaks) {
  Sessions sessions(kServed);
  Hello other = hello();
  other.version = kProtocolVersion + 1;
  other.scene_hash[0] ^= 1;  // the version comes first: with another one the rest may mean anything
  const auto answer = sessions.handle(peer(1), other, {});
  EXPECT_EQ(reason_of(answer), RefusalReason::VersionMismatch);
  EXPECT_EQ(std::get<Refusal>(*answer).version, kProtocolVersion);
  EXPECT_EQ(sessions.counters(), SessionCounters{.version_mismatch = 1});
}

TEST(Sessions, RefusesRequestsWithoutHello) {
  Sessions sessions(kServed);
  EXPECT_EQ(reason_of(sessions.handle(peer(1), request(1), {})), RefusalReason::NotWelcomed);
  EXPECT_FALSE(sessions.has_job());
  EXPECT_EQ(sessions.counters(), SessionCounters{.not_welcomed = 1});
}

TEST(Sessions, NewestRequestWinsAndTheOthersAreCounted) {
  Sessions sessions(kServed);
  sessions.handle(peer(1), hello(), {});
  for (std::uint32_t frame = 1; frame <= 4; ++frame)
    EXPECT_FALSE(sessions.handle(peer(1), request(frame), Time(frame * 1ms)).has_value());
  const auto job = sessions.next_job();
  ASSERT_TRUE(job.has_value());
  EXPECT_EQ(job->request.frame, FrameId{4});
  EXPECT_EQ(job->arrived, Time(4ms));
  EXPECT_EQ(job->superseded, 3u);
  EXPECT_FALSE(sessions.has_job());
  EXPECT_FALSE(sessions.next_job().has_value());
  EXPECT_EQ(sessions.counters(), (SessionCounters{.welcomed = 1, .requests = 4, .superseded = 3}));
}

TEST(Sessions, RequestsThatWereOvertakenAreDropped) {
  Sessions sessions(kServed);
  sessions.handle(peer(1), hello(), {});
  sessions.handle(peer(1), request(7), {});
  sessions.handle(peer(1), request(6), {});
  sessions.handle(peer(1), request(7), {});
  EXPECT_EQ(sessions.next_job()->request.frame, FrameId{7});
  sessions.handle(peer(1), request(7), {});  // a duplicate of what was served
  EXPECT_FALSE(sessions.has_job());
  EXPECT_EQ(sessions.counters(), (SessionCounters{.welcomed = 1, .requests = 4, .outdated = 3}));
}

TEST(Sessions, FrameOrderSurvivesWraparound) {
  Sessions sessions(kServed);
  sessions.handle(peer(1), hello(), {});
  sessions.handle(peer(1), request(0xffffffff), {});
  sessions.handle(peer(1), request(1), {});
  sessions.handle(peer(1), request(0xfffffffe), {});
  EXPECT_EQ(sessions.next_job()->request.frame, FrameId{1});
}

TEST(Sessions, HelloStartsAnewAtTheSameAddress) {
  Sessions sessions(kServed);
  sessions.handle(peer(1), hello(), {});
  sessions.handle(peer(1), request(1000), {});
  sessions.handle(peer(1), hello(), {});
  EXPECT_FALSE(sessions.has_job());
  sessions.handle(peer(1), request(1), {});
  EXPECT_EQ(sessions.next_job()->request.frame, FrameId{1});
  EXPECT_EQ(sessions.size(), 1u);
  EXPECT_EQ(sessions.counters().welcomed, 1u);
}

TEST(Sessions, ClientsTakeTurnsWhateverTheyAsk) {
  Sessions sessions(kServed);
  for (std::uint16_t port = 1; port <= 3; ++port) sessions.handle(peer(port), hello(), {});
  std::uint32_t frame = 0;
  const auto ask = [&](std::uint16_t port) { sessions.handle(peer(port), request(++frame), {}); };
  for (std::uint16_t port = 1; port <= 3; ++port) ask(port);
  std::vector<std::uint16_t> turns;
  for (int i = 0; i < 9; ++i) {
    turns.push_back(sessions.next_job()->client.port);
    for (int often = 0; often < 5; ++often) ask(1);  // greedy
    ask(turns.back());
  }
  EXPECT_EQ(turns, (std::vector<std::uint16_t>{1, 2, 3, 1, 2, 3, 1, 2, 3}));
}

TEST(Sessions, FullHouseRefusesOnlyTheNext) {
  Sessions sessions(kServed, {.sessions = 2});
  sessions.handle(peer(1), hello(), {});
  sessions.handle(peer(2), hello(), {});
  EXPECT_EQ(reason_of(sessions.handle(peer(3), hello(), {})), RefusalReason::Busy);
  EXPECT_TRUE(std::holds_alternative<Welcome>(*sessions.handle(peer(2), hello(), {})));
  EXPECT_EQ(sessions.size(), 2u);
  EXPECT_EQ(sessions.counters().busy, 1u);
}

TEST(Sessions, SilentClientsAreForgotten) {
  Sessions sessions(kServed, {.sessions = 2, .silence = 10s});
  sessions.handle(peer(1), hello(), Time(0s));
  sessions.handle(peer(2), hello(), Time(0s));
  sessions.handle(peer(2), request(1), Time(6s));
  EXPECT_TRUE(std::holds_alternative<Welcome>(*sessions.handle(peer(3), hello(), Time(11s))));
  EXPECT_EQ(reason_of(sessions.handle(peer(1), request(1), Time(12s))), RefusalReason::NotWelcomed);
  EXPECT_FALSE(sessions.handle(peer(2), request(2), Time(12s)).has_value());
  EXPECT_EQ(sessions.counters().forgotten, 1u);
}

}  // namespace
}  // namespace farshade
