#include "vr_client/preview/player.h"

#include <gtest/gtest.h>

#include <cmath>

namespace farshade {
namespace {

using namespace std::chrono_literals;

TEST(Player, PlaysFromTheBeginningAtTheSpeedOfTheDisplay) {
  Player player(10s);
  EXPECT_EQ(player.length(), 10s);
  EXPECT_EQ(player.position(), 0s);
  EXPECT_TRUE(player.playing());
  player.advance(1500ms);
  player.advance(0s);
  player.advance(1ns);
  EXPECT_EQ(player.position(), 1500ms + 1ns);
}

TEST(Player, DoesNotAdvanceWhilePaused) {
  Player player(10s);
  player.advance(1s);
  player.pause();
  player.advance(1s);
  EXPECT_EQ(player.position(), 1s);
  EXPECT_EQ(player.position_after(5s), 1s);
  player.play();
  player.advance(1s);
  EXPECT_EQ(player.position(), 2s) << "pausing and playing lose nothing";
}

TEST(Player, ScrubbingIsClampedToTheRecording) {
  for (const bool plays : {false, true}) {
    Player player(10s);
    if (!plays) player.pause();
    player.scrub(4s);
    EXPECT_EQ(player.position(), 4s);
    player.scrub(-1s);
    EXPECT_EQ(player.position(), 0s);
    player.scrub(11s);
    EXPECT_EQ(player.position(), 10s);
    player.scrub(9s);
    EXPECT_EQ(player.playing(), plays);
  }
}

TEST(Player, HoldsTheEndAndRestartsWhenPlayedAgain) {
  Player player(10s);
  player.scrub(9s);
  player.advance(3s);
  EXPECT_EQ(player.position(), 10s);
  EXPECT_FALSE(player.playing());
  player.advance(3s);
  EXPECT_EQ(player.position(), 10s);
  player.play();
  EXPECT_EQ(player.position(), 0s);
  player.advance(1s);
  EXPECT_EQ(player.position(), 1s);
}

TEST(Player, LoopsSeveralTimesInOneStep) {
  Player player(10s);
  player.set_at_end(AtEnd::Loop);
  player.advance(9s);
  player.advance(3s);
  EXPECT_EQ(player.position(), 2s);
  player.advance(8s);
  EXPECT_EQ(player.position(), 0s) << "the end equals the beginning";
  player.advance(10'000s + 1s);
  EXPECT_EQ(player.position(), 1s);
  EXPECT_TRUE(player.playing());
}

TEST(Player, LoopsAfterScrubbingToTheEnd) {
  Player player(10s);
  player.set_at_end(AtEnd::Loop);
  player.scrub(10s);
  player.advance(1s);
  EXPECT_EQ(player.position(), 1s);
}

TEST(Player, ClampsItsSpeed) {
  struct Case {
    double requested, speed;
  };
  for (const Case c : {Case{1, 1}, Case{0.25, 0.25}, Case{4, 4}, Case{0, 0.1}, Case{-2, 0.1}, Case{100, 4}}) {
    Player player(10s);
    player.set_speed(c.requested);
    EXPECT_EQ(player.speed(), c.speed);
    player.advance(2s);
    EXPECT_EQ(player.position(), std::chrono::round<Duration>(2s * c.speed)) << c.requested;
  }
}

TEST(Player, PredictsPositionsWithoutMoving) {
  Player player(10s);
  player.set_speed(2);
  player.scrub(3s);
  EXPECT_EQ(player.position_after(1s), 5s);
  EXPECT_EQ(player.position_after(-1s), 1s);
  EXPECT_EQ(player.position_after(-5s), 0s);
  EXPECT_EQ(player.position_after(5s), 10s);
  player.set_at_end(AtEnd::Loop);
  EXPECT_EQ(player.position_after(-5s), 3s);
  EXPECT_EQ(player.position_after(5s), 3s);
  EXPECT_EQ(player.position(), 3s);
}

TEST(Player, StepsOfAFrameAddUp) {
  Player player(3600s);
  player.set_speed(0.7);
  for (int i = 0; i < 72 * 60; ++i) player.advance(13'888'889ns);
  EXPECT_NEAR(seconds_of(player.position()), 42, 1e-5);
}

TEST(PlayerDeathTest, RefusesInvalidTimes) {
  EXPECT_DEATH(Player(0s), "has a length");
  Player player(1s);
  EXPECT_DEATH(player.advance(-1ns), "advances by at least 0");
  EXPECT_DEATH(player.set_speed(NAN), "is a number");
}

}  // namespace
}  // namespace farshade
