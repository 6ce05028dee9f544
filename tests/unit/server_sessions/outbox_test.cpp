#include "rt_server/sessions/outbox.h"

#include <gtest/gtest.h>

#include "rt_server/sessions/job.h"

namespace farshade {
namespace {

using std::chrono::milliseconds;

Time at(std::int64_t ms) {
  return time_from_ns(ms * 1'000'000);
}

std::vector<std::vector<std::byte>> frame(std::size_t messages, std::size_t bytes = 1000) {
  std::vector<std::vector<std::byte>> made;
  for (std::size_t i = 0; i < messages; ++i) made.emplace_back(bytes, std::byte(i));
  return made;
}

/// Takes each message when it is due, on a path with this rate. Returns the times.
std::vector<Time> leave(Outbox& outbox, double bytes_per_second) {
  std::vector<Time> left;
  while (const auto due = outbox.due()) {
    const auto message = outbox.take(bytes_per_second);
    EXPECT_EQ(message.front(), std::byte(left.size()));
    left.push_back(*due);
  }
  return left;
}

TEST(Outbox, EmptyHasNothingDue) {
  Outbox outbox;
  EXPECT_TRUE(outbox.empty());
  EXPECT_EQ(outbox.due(), std::nullopt);
  outbox.put({}, at(5), milliseconds(10));
  EXPECT_TRUE(outbox.empty());
}

TEST(Outbox, FastPathSpreadsEvenlyOverTheInterval) {
  Outbox outbox;
  outbox.put(frame(5), at(100), milliseconds(10));
  EXPECT_EQ(leave(outbox, 1e9), (std::vector{at(100), at(102), at(104), at(106), at(108)}));
  EXPECT_EQ(outbox.drained_at(), at(110));
}

TEST(Outbox, NeverSendsFasterThanTheSlowPath) {
  Outbox outbox;
  outbox.put(frame(4), at(100), milliseconds(10));  // 10 ms per message
  EXPECT_EQ(leave(outbox, 100e3), (std::vector{at(100), at(110), at(120), at(130)}));
  EXPECT_EQ(outbox.drained_at(), at(140));
}

TEST(Outbox, NextFrameWaitsUntilThePathHasTakenTheLast) {
  Outbox outbox;
  outbox.put(frame(4), at(100), milliseconds(10));
  leave(outbox, 100e3);
  outbox.put(frame(2), at(120), milliseconds(10));
  EXPECT_EQ(leave(outbox, 1e9), (std::vector{at(140), at(145)}));
  outbox.put(frame(1), at(900), milliseconds(10));
  EXPECT_EQ(leave(outbox, 1e9), (std::vector{at(900)}));
}

TEST(Outbox, FollowsTheRateOfTheMomentWithinAFrame) {
  Outbox outbox;
  outbox.put(frame(7), at(100), milliseconds(7));
  std::vector<Time> left;
  for (const double rate : {1e9, 1e9, 100e3, 100e3, 1e9, 1e9, 1e9}) {
    left.push_back(*outbox.due());
    static_cast<void>(outbox.take(rate));
  }
  EXPECT_EQ(left, (std::vector{at(100), at(101), at(102), at(112), at(122), at(123), at(124)}));
  EXPECT_EQ(outbox.drained_at(), at(125));
}

TEST(Outbox, LargerMessagesTakeLonger) {
  Outbox outbox;
  const std::vector<std::vector<std::byte>> messages{std::vector<std::byte>(1000, std::byte{0}),
                                                     std::vector<std::byte>(100, std::byte{1}),
                                                     std::vector<std::byte>(500, std::byte{2})};
  outbox.put(messages, at(0), Duration{});
  EXPECT_EQ(leave(outbox, 100e3), (std::vector{at(0), at(10), at(11)}));
  EXPECT_EQ(outbox.drained_at(), at(16));
}

TEST(Outbox, TakesTheMessagesThemselvesAndKeepsNoneThatIsSent) {
  Outbox outbox;
  auto messages = frame(20, 1200);
  const std::byte* const first = messages[0].data();
  outbox.put(std::move(messages), at(0), milliseconds(10));
  EXPECT_EQ(outbox.bytes(), 20u * (1200u + kMessage_bytes));
  EXPECT_EQ(outbox.take(1e9).data(), first) << "not a copy";
  EXPECT_EQ(outbox.bytes(), 19u * (1200u + kMessage_bytes));
  while (!outbox.empty()) static_cast<void>(outbox.take(1e9));
  EXPECT_EQ(outbox.bytes(), 0u);
}

TEST(OutboxDeathTest, RefusesASecondFrameBeforeTheFirstHasLeft) {
  Outbox outbox;
  outbox.put(frame(2), at(0), milliseconds(10));
  EXPECT_DEATH(outbox.put(frame(2), at(0), milliseconds(10)), "only when it is empty");
}

}  // namespace
}  // namespace farshade
