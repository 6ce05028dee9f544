// Sixty-four clients of one server whose tracer takes 5 ms per frame. They request three times as much as it
// can trace. Everything happens in virtual time. Datagrams travel while a frame is traced.

#include <gtest/gtest.h>

#include <cstdio>
#include <deque>
#include <random>

#include "tests/support/manual_clock.h"
#include "tests/support/sanitized.h"
#include "tests/support/virtual_link.h"
#include "tests/unit/link_client.h"

namespace farshade {
namespace {

using namespace std::chrono_literals;
using namespace link_test;

constexpr std::size_t kClients = 64;
constexpr Duration kTrace = 5ms, kRound = kClients * kTrace;
constexpr Duration kTime = kSanitized ? 2s : 6s;

/// Masks that depend on all fields of a request.
void paint(const FrameRequest& requested, ShadowFrame& frame) {
  frame.frame = requested.frame;
  frame.light_set_revision = requested.lights.revision;
  frame.views = requested.views;
  for (std::size_t eye = 0; eye < kEyes; ++eye) {
    const View& view = requested.views[eye];
    frame.masks[eye] = EyeMask(view.size, kServed.light_count);
    const double place = view.stage_from_eye.translation.x * 1000;
    const auto seed = static_cast<std::uint32_t>(static_cast<std::int64_t>(place) +
                                                 requested.scene_time.time_since_epoch() / 1us);
    for (std::uint32_t y = 0; y < view.size.height; ++y)
      for (std::uint32_t x = 0; x < view.size.width; ++x)
        frame.masks[eye].set_word(x, y, 0, (x / 3 * seed + y * (seed >> 7) + eye) >> 4 & 7);
  }
}

enum class Manner { Good, Hostile, Stalled };

struct Member : PortClient {
  Member(DatagramPort& own, const Peer& to, std::size_t number, Manner how)
      : PortClient(own, to, kKey, kServed), index(number), manner(how) {
    interval = how == Manner::Hostile ? 1ms : (8 + static_cast<int>(number % 17)) * 1ms;
    size = {32 + 8 * static_cast<std::uint32_t>(number % 9), 24 + 4 * static_cast<std::uint32_t>(number % 7)};
  }

  [[nodiscard]] FrameRequest next_request(Time now) {
    FrameRequest request = request_of(++frame, size);
    request.display_time = now;
    request.scene_time = now + static_cast<int>(index) * 1s;
    for (std::size_t eye = 0; eye < kEyes; ++eye)
      request.views[eye].stage_from_eye.translation.x =
          static_cast<double>(index) + 0.06 * static_cast<double>(eye);
    return request;
  }
  void act(Time now) {
    next = now + interval;
    if (!session) {
      say(hello());
      next = now + 250ms;
    } else if (manner == Manner::Hostile) {
      harass(now);
    } else {
      say(ask(next_request(now)));
    }
  }
  /// Sends ten times as often as others: noise, forged datagrams, hellos and absurd requests.
  void harass(Time now) {
    Bytes noise(any(kMaxDatagram_bytes));
    for (std::byte& byte : noise) byte = static_cast<std::byte>(random());
    say(noise);
    LinkClient other(kKey, kServed);
    if (frame % 16 == 0) say(other.hello());
    FrameRequest absurd = next_request(now);
    frame += 1u << any(28);
    absurd.scene_time = Time(std::chrono::hours(any(1000)));
    for (View& view : absurd.views) view.size = {1 + any(900), 1 + any(900)};
    for (std::uint32_t i = 0; i < RequestMessage::kMostLightChanges; ++i)
      change(absurd.lights, any(kMaxLights), false, {});
    RequestMessage message{.request = absurd, .probe_echo = random()};
    message.arrivals = {.first = random(), .base = now, .count = ArrivalReport::kMost};
    Bytes datagram = seal(message);
    say(datagram);
    say(datagram);
    datagram[any(static_cast<std::uint32_t>(datagram.size()))] ^= std::byte{1};
    say(datagram);
  }
  std::uint32_t any(std::uint32_t below) { return static_cast<std::uint32_t>(random() % below); }
  void listen(Time now) {
    std::array<std::byte, kMaxDatagram_bytes> unread;
    while (manner == Manner::Stalled && session && port.receive(unread, 0s)) {
    }
    const std::uint64_t before = reports;
    while (hear(0s)) {
    }
    if (reports == before || manner != Manner::Good) return;
    if (served) longest_wait = std::max(longest_wait, now - *served);
    served = now;
    ++frames;
    const RequestRecord& received = *assembler.find(report->frame);
    ShadowFrame expected;
    paint(received.request, expected);
    if (received.complete() && received.masks == expected.masks) ++right;
  }

  std::size_t index;
  Manner manner;
  Duration interval{};
  Extent size{};
  Time next{};
  std::uint32_t frame = 0;
  std::mt19937 random{7};
  std::optional<Time> served{};
  Duration longest_wait{};
  std::uint64_t frames = 0, right = 0;
};

struct Crowd {
  explicit Crowd(const std::vector<Manner>& manners)
      : link(clock, {.to_server = {.delay = 5ms}, .to_client = {.delay = 5ms}}, manners.size()),
        core(kServed, {kKey}, masks_from([this](const FrameRequest& requested, ShadowFrame& frame) {
               paint(requested, frame);
               pass_until(clock.now() + kTrace);
               return TraceStats{};
             }),
             link.server(), clock) {
    for (std::size_t i = 0; i < manners.size(); ++i)
      members.emplace_back(link.client(i), link.server().local(), i, manners[i]);
  }

  void run(Duration time) {
    const Time end = clock.now() + time;
    while (clock.now() < end)
      if (!core.work()) pass_until(std::min(end, next_event(core.next_due())));
  }
  [[nodiscard]] Time next_event(const std::optional<Time>& server) const {
    Time next = std::min(server.value_or(Time::max()), link.next_arrival().value_or(Time::max()));
    for (const Member& member : members) next = std::min(next, member.next);
    return next;
  }
  void pass_until(Time until) {
    do {
      clock.advance_to(std::min(until, next_event(core.next_send())));
      for (Member& member : members)
        if (member.next <= clock.now()) member.act(clock.now());
      core.send_due();
      while (link.next_arrival() && *link.next_arrival() <= clock.now()) {
        while (core.receive(0s)) {
        }
        for (Member& member : members) member.listen(clock.now());
      }
    } while (clock.now() < until);
  }

  ManualClock clock;
  VirtualLink link;
  std::deque<Member> members;
  ServerCore core;
};

void say_figures(const char* what, const Crowd& crowd) {
  Duration longest{};
  std::uint64_t least = ~0ull, most = 0;
  for (const Member& member : crowd.members) {
    if (member.manner != Manner::Good) continue;
    longest = std::max(longest, member.longest_wait);
    least = std::min(least, member.frames);
    most = std::max(most, member.frames);
  }
  std::printf("%s: %llu to %llu frames each in %g s, longest wait %g ms; a round of all is %g ms\n", what,
              static_cast<unsigned long long>(least), static_cast<unsigned long long>(most),
              seconds_of(kTime), ms_of(longest), ms_of(kRound));
}

TEST(ManyClients, EachGetsItsOwnMasksAndNoneWaitsLongerThanTwoRounds) {
  Crowd crowd(std::vector(kClients, Manner::Good));
  crowd.run(kTime);
  say_figures("64 good clients", crowd);
  EXPECT_EQ(crowd.core.counters().sessions_open, kClients);
  for (const Member& member : crowd.members) {
    EXPECT_GE(member.frames, kTime / kRound - 2) << member.index;
    EXPECT_EQ(member.right, member.frames) << member.index;
    EXPECT_LE(member.longest_wait, 2 * kRound) << member.index;
  }
}

TEST(ManyClients, HostileAndStalledOnesChangeNothingForTheOthers) {
  Crowd quiet(std::vector(kClients, Manner::Good));
  std::vector<Manner> manners(kClients, Manner::Good);
  manners[10] = Manner::Hostile;
  manners[40] = Manner::Stalled;
  Crowd loud(manners);
  quiet.run(kTime);
  loud.run(kTime);
  say_figures("two of them hostile and stalled", loud);
  EXPECT_EQ(loud.core.counters().sessions_open, kClients);
  EXPECT_GT(loud.core.counters().refused.total(), kTime / 1ms);
  EXPECT_GT(loud.core.counters().sessions.superseded,
            quiet.core.counters().sessions.superseded + kTime / 2ms);
  for (std::size_t i = 0; i < kClients; ++i) {
    const Member &with = loud.members[i], &without = quiet.members[i];
    if (with.manner != Manner::Good) continue;
    EXPECT_GE(with.frames + 1, without.frames) << i;
    EXPECT_EQ(with.right, with.frames) << i;
    EXPECT_LE(with.longest_wait, without.longest_wait + 2 * kTrace) << i;
  }
}

}  // namespace
}  // namespace farshade
