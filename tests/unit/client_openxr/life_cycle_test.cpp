#include "vr_client/openxr/life_cycle.h"

#include <gtest/gtest.h>

#include <set>
#include <string>
#include <utility>
#include <vector>

namespace farshade::openxr {
namespace {

using enum SessionState;

constexpr std::array kStates{None,    Idle,     Ready,       Synchronized, Visible,
                             Focused, Stopping, LossPending, Exiting};
constexpr auto kRunning = LifeCycle::Session::Running, kNotRunning = LifeCycle::Session::NotRunning;

/// The acts of a sequence of events, and the value at its end.
struct Played {
  std::vector<Act> acts;
  LifeCycle end;
};

Played play(const std::vector<Event>& events, LifeCycle life = {}) {
  Played played{{}, life};
  for (const Event& event : events) {
    const Step step = after(played.end, event);
    played.end = step.now;
    played.acts.push_back(step.act);
  }
  return played;
}

constexpr Act kNothing = Act::Nothing;

/// As Monado 25 sends them until a session has the focus.
const std::vector<Event> kUntilFocused{StateChanged{Idle},    StateChanged{Ready},
                                       SessionBegan{},        StateChanged{Synchronized},
                                       StateChanged{Visible}, StateChanged{Focused}};
using Acts = std::vector<Act>;
const Acts kUntilFocusedActs{kNothing, Act::Begin, kNothing, kNothing, kNothing, kNothing};

std::vector<Event> operator+(std::vector<Event> a, const std::vector<Event>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}
std::vector<Act> operator+(std::vector<Act> a, const std::vector<Act>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

TEST(LifeCycle, TheTableIsThatOfTheSpecification) {
  const std::set<std::pair<SessionState, SessionState>> allowed{{None, Idle},
                                                                {Idle, Ready},
                                                                {Idle, Exiting},
                                                                {Ready, Synchronized},
                                                                {Synchronized, Visible},
                                                                {Synchronized, Stopping},
                                                                {Visible, Synchronized},
                                                                {Visible, Focused},
                                                                {Focused, Visible},
                                                                {Stopping, Idle},
                                                                {None, LossPending},
                                                                {Idle, LossPending},
                                                                {Ready, LossPending},
                                                                {Synchronized, LossPending},
                                                                {Visible, LossPending},
                                                                {Focused, LossPending},
                                                                {Stopping, LossPending}};
  for (const SessionState from : kStates)
    for (const SessionState to : kStates)
      EXPECT_EQ(is_in_table(from, to), allowed.contains({from, to}))
          << name_of(from) << " to " << name_of(to);
}

TEST(LifeCycle, EveryChangeOfStateHasItsAct) {
  for (const SessionState from : kStates)
    for (const SessionState to : kStates)
      for (const auto session : {kNotRunning, kRunning}) {
        const LifeCycle before{.state = from, .session = session};
        LifeCycle now = before;
        now.state = to;
        Step expected{now, Act::Nothing};
        if (to == Ready && session == kNotRunning) expected.act = Act::Begin;
        if (to == Stopping && session == kRunning) expected.act = Act::End;
        if (to == LossPending) expected = {{.state = to, .session = kNotRunning}, Act::Replace};
        if (to == Exiting)
          expected = {{.state = to, .session = session, .ending = Ending::Exiting}, Act::Finish};
        EXPECT_EQ(after(before, StateChanged{to}), expected) << name_of(from) << " to " << name_of(to);
      }
}

TEST(LifeCycle, FramesAreShownFromTheBeginOfASessionUntilItStops) {
  LifeCycle life;
  std::vector<bool> has_frames;
  for (const Event& event :
       kUntilFocused + std::vector<Event>{StateChanged{Visible}, StateChanged{Synchronized},
                                          StateChanged{Stopping}, SessionEnded{}, StateChanged{Idle}}) {
    life = after(life, event).now;
    has_frames.push_back(life.has_frames());
  }
  EXPECT_EQ(has_frames,
            (std::vector<bool>{false, false, true, true, true, true, true, true, false, false, false}));
}

TEST(LifeCycle, BeginsASessionOnceItIsReady) {
  const Played played = play(kUntilFocused);
  EXPECT_EQ(played.acts, kUntilFocusedActs);
  EXPECT_EQ(played.end, (LifeCycle{.state = Focused, .session = kRunning}));
}

TEST(LifeCycle, AHeadsetThatIsTakenOffAndPutOnAgainGoesOn) {
  const std::vector<Event> off{StateChanged{Visible}, StateChanged{Synchronized}, StateChanged{Stopping},
                               SessionEnded{}, StateChanged{Idle}};
  const std::vector<Event> on(kUntilFocused.begin() + 1, kUntilFocused.end());
  const Played played = play(kUntilFocused + off + on + off + on);
  const std::vector<Act> off_acts{kNothing, kNothing, Act::End, kNothing, kNothing};
  const std::vector<Act> on_acts(kUntilFocusedActs.begin() + 1, kUntilFocusedActs.end());
  EXPECT_EQ(played.acts, kUntilFocusedActs + off_acts + on_acts + off_acts + on_acts);
  EXPECT_EQ(played.end, (LifeCycle{.state = Focused, .session = kRunning}));
}

TEST(LifeCycle, AUserWhoEndsTheClientIsAskedForOnceAndFollowsTheRuntimeToTheEnd) {
  const Played played =
      play(kUntilFocused + std::vector<Event>{ExitWanted{}, ExitWanted{}, StateChanged{Visible},
                                              StateChanged{Synchronized}, ExitWanted{},
                                              StateChanged{Stopping}, SessionEnded{}});
  EXPECT_EQ(played.acts, (kUntilFocusedActs + Acts{Act::RequestExit, kNothing, kNothing, kNothing, kNothing,
                                                   Act::End, Act::Finish}));
  EXPECT_EQ(played.end.ending, Ending::Wanted);
}

TEST(LifeCycle, AUserWhoEndsTheClientBeforeTheSessionRunsWaitsForNothing) {
  for (const std::vector<Event>& before :
       {std::vector<Event>{}, {StateChanged{Idle}}, {StateChanged{Idle}, StateChanged{Ready}}}) {
    const Played played = play(before + std::vector<Event>{ExitWanted{}});
    EXPECT_EQ(played.acts.back(), Act::Finish);
    EXPECT_EQ(played.end.ending, Ending::Wanted);
  }
}

TEST(LifeCycle, ARuntimeThatEndsTheSessionForGoodEndsTheClient) {
  const Played played = play({StateChanged{Idle}, StateChanged{Exiting}});
  EXPECT_EQ(played.acts.back(), Act::Finish);
  EXPECT_EQ(played.end.ending, Ending::Exiting);
}

TEST(LifeCycle, ALostSessionIsReplacedByOneThatBeginsAnew) {
  for (const Event& loss : {Event(StateChanged{LossPending}), Event(SessionLost{})}) {
    const Played played = play(kUntilFocused + std::vector<Event>{loss, SessionReplaced{}} + kUntilFocused);
    EXPECT_EQ(played.acts, (kUntilFocusedActs + Acts{Act::Replace, kNothing} + kUntilFocusedActs));
    EXPECT_EQ(played.end, (LifeCycle{.state = Focused, .session = kRunning}));
  }
}

TEST(LifeCycle, ALostSessionIsNotReplacedForAUserWhoWantsToEnd) {
  for (const Event& loss : {Event(StateChanged{LossPending}), Event(SessionLost{})}) {
    const Played played = play(kUntilFocused + std::vector<Event>{ExitWanted{}, loss});
    EXPECT_EQ(played.acts.back(), Act::Finish);
    EXPECT_EQ(played.end.ending, Ending::Wanted);
  }
}

TEST(LifeCycle, ARuntimeThatEndsEndsTheClientInEveryState) {
  for (const SessionState state : kStates)
    for (const Event& loss : {Event(InstanceLossPending{}), Event(InstanceLost{})}) {
      const Step step = after({.state = state, .session = kRunning}, loss);
      EXPECT_EQ(step.act, Act::Finish);
      EXPECT_EQ(step.now.ending, Ending::InstanceLost);
      EXPECT_FALSE(step.now.has_frames());
    }
}

TEST(LifeCycle, NothingChangesAfterTheEnd) {
  const LifeCycle ended = play({StateChanged{Idle}, StateChanged{Exiting}}).end;
  for (const Event& event :
       {Event(StateChanged{Ready}), Event(SessionBegan{}), Event(SessionEnded{}), Event(SessionReplaced{}),
        Event(SessionLost{}), Event(InstanceLossPending{}), Event(InstanceLost{}), Event(ExitWanted{})})
    EXPECT_EQ(after(ended, event), (Step{ended, Act::Finish}));
}

/// A runtime that goes straight from focused to stopping, as some do, is followed.
TEST(LifeCycle, ARuntimeThatLeavesTheTableIsFollowed) {
  EXPECT_FALSE(is_in_table(Focused, Stopping));
  const Played played = play(kUntilFocused + std::vector<Event>{StateChanged{Stopping}, SessionEnded{}});
  EXPECT_EQ(played.acts, (kUntilFocusedActs + Acts{Act::End, kNothing}));
  EXPECT_EQ(played.end, (LifeCycle{.state = Stopping}));
}

}  // namespace
}  // namespace farshade::openxr
