#include "vr_client/shadow_link.h"

#include <gtest/gtest.h>

#include "rt_server/server_core.h"
#include "stereo/frame/tiles.h"
#include "stereo/net/virtual_link.h"

namespace farshade {
namespace {

using namespace std::chrono_literals;

constexpr std::uint32_t kLights = 3;
const Welcome kServed{{1, 2, 3}, kLights, 5};
constexpr Extent kSize{100, 60};
constexpr std::size_t kFrames = 6;
constexpr Duration kWay = 5ms;
constexpr LinkModels kSlow{.to_server = {.delay = kWay}, .to_client = {.delay = kWay}};

TraceRequest request(std::uint32_t frame, Duration display = {}) {
  TraceRequest asked;
  asked.frame = {frame};
  asked.display_time = Time(display);
  for (View& view : asked.views) view = {{}, {-0.7, 0.8, 0.6, -0.5}, kSize};
  return asked;
}

/// In place of a tracer: masks that differ from frame to frame, eye to eye and pixel to pixel.
TraceStats paint(const TraceRequest& asked, ShadowFrame& frame) {
  frame.frame = asked.frame;
  frame.light_set_revision = kServed.light_set_revision;
  frame.views = asked.views;
  std::uint32_t noise = asked.frame.value;
  for (EyeMask& mask : frame.masks) {
    mask = EyeMask(kSize, kLights);
    for (std::uint32_t y = 0; y < kSize.height; ++y)
      for (std::uint32_t x = 0; x < kSize.width; ++x)
        mask.set_word(x, y, 0, (noise = noise * 1664525 + 1013904223) >> 29);
  }
  return {};
}

PerEye<EyeMask> painted(std::uint32_t frame) {
  ShadowFrame made;
  paint(request(frame), made);
  return made.masks;
}

/// The link under test, and a server that answers while it waits.
struct Bench {
  explicit Bench(const LinkModels& models = kSlow) : wire(clock, models) {
    wire.while_waiting([this] { serve(); });
  }
  void start_server(const Welcome& served = kServed, SessionLimits limits = {}) {
    server.emplace(served, paint, wire.server(), clock, limits);
  }
  void serve() {
    if (!server) return;
    while (server->receive(0s)) {
    }
    while (server->work()) {
    }
  }
  void pass(Duration time) {
    const Time until = clock.now() + time;
    while (const auto next = wire.next_arrival()) {
      if (*next > until) break;
      clock.advance_to(*next);
      serve();
      link.poll();
    }
    clock.advance_to(until);
  }
  /// By the frame that shows the views themselves.
  void ask(const TraceRequest& asked) { link.request(asked, asked.display_time); }
  void from_server(const ServerMessage& message) {
    std::vector<std::byte> bytes;
    encode(message, bytes);
    wire.server().send(wire.client().local(), bytes);
  }

  ManualClock clock;
  VirtualLink wire;
  std::optional<ServerCore> server;
  ShadowLink link{wire.client(), wire.server().local(), clock, kServed.scene_hash, kLights, kFrames};
};

struct MetBench : Bench {
  explicit MetBench(const LinkModels& models = kSlow) : Bench(models) {
    start_server();
    EXPECT_TRUE(link.meet(1s).has_value());
  }
};

TEST(ShadowLinkMeet, IsWelcomedAfterOneRoundTrip) {
  Bench bench;
  bench.start_server();
  EXPECT_TRUE(bench.link.meet(3s).has_value());
  EXPECT_TRUE(bench.link.welcomed());
  EXPECT_EQ(bench.clock.now(), Time(2 * kWay));
}

TEST(ShadowLinkMeet, SaysWhichSceneEachSideHasAndStopsAsking) {
  Bench bench;
  Welcome other = kServed;
  other.scene_hash = {0xAB, 0xCD};
  bench.start_server(other);
  const Expected<void> met = bench.link.meet(3s);
  ASSERT_FALSE(met.has_value());
  EXPECT_EQ(met.error().fault, Fault::Mismatch);
  EXPECT_NE(met.error().what.find("abcd0000"), std::string::npos) << met.error().what;
  EXPECT_NE(met.error().what.find("01020300"), std::string::npos) << met.error().what;
  EXPECT_EQ(bench.clock.now(), Time(2 * kWay)) << "no patience can cure it";
  bench.clock.advance_to(Time(5s));
  bench.ask(request(1));
  EXPECT_EQ(bench.link.counters().port.sent, 1u);
  EXPECT_TRUE(bench.link.refused().has_value());
}

TEST(ShadowLinkMeet, RefusesAServerWithAnotherNumberOfLights) {
  Bench bench;
  Welcome other = kServed;
  other.light_count = kLights + 1;
  bench.start_server(other);
  const Expected<void> met = bench.link.meet(3s);
  ASSERT_FALSE(met.has_value());
  EXPECT_EQ(met.error().fault, Fault::Mismatch);
  EXPECT_FALSE(bench.link.welcomed());
}

TEST(ShadowLinkMeet, GivesUpOnAServerThatIsNotThereAfterItsPatience) {
  Bench bench;
  const Expected<void> met = bench.link.meet(3s);
  ASSERT_FALSE(met.has_value());
  EXPECT_EQ(met.error().fault, Fault::Missing);
  EXPECT_NE(met.error().what.find(to_string(bench.wire.server().local())), std::string::npos);
  EXPECT_EQ(bench.clock.now(), Time(3s));
  EXPECT_EQ(bench.link.counters().port.sent, 12u) << "a hello each 250 ms";
}

TEST(ShadowLinkMeet, SaysThatAServerIsFull) {
  Bench bench;
  bench.start_server(kServed, {.sessions = 0});
  const Expected<void> met = bench.link.meet(1s);
  ASSERT_FALSE(met.has_value());
  EXPECT_EQ(met.error().fault, Fault::Unavailable);
  EXPECT_NE(met.error().what.find("no room"), std::string::npos);
  EXPECT_FALSE(bench.link.refused().has_value()) << "it may have room later";
}

TEST(ShadowLink, ServesMasksBitForBit) {
  MetBench bench;
  bench.ask(request(1));
  EXPECT_TRUE(bench.link.wait_for({1}, 1s));
  ASSERT_NE(bench.link.find({1}), nullptr);
  EXPECT_EQ(bench.link.find({1})->masks, painted(1));
}

TEST(ShadowLink, GoesOnTryingAServerThatComesLate) {
  Bench bench;
  EXPECT_FALSE(bench.link.meet(1s).has_value());
  bench.start_server();
  bench.clock.advance_to(Time(2s));
  bench.ask(request(1));
  bench.pass(20ms);
  EXPECT_TRUE(bench.link.welcomed());
  bench.ask(request(2));
  EXPECT_TRUE(bench.link.wait_for({2}, 1s));
}

TEST(ShadowLink, SaysHelloAgainToARestartedServerAndGetsMasksAgain) {
  MetBench bench;
  bench.ask(request(1));
  ASSERT_TRUE(bench.link.wait_for({1}, 1s));
  bench.start_server();
  bench.clock.advance_to(Time(1s));
  bench.ask(request(2));
  bench.pass(2 * kWay);
  EXPECT_FALSE(bench.link.welcomed()) << "the new server does not know us";
  EXPECT_FALSE(bench.link.refused().has_value());
  bench.pass(2 * kWay);
  EXPECT_TRUE(bench.link.welcomed());
  bench.ask(request(3));
  EXPECT_TRUE(bench.link.wait_for({3}, 1s));
  EXPECT_EQ(bench.link.masks(Time::max()).size(), 2u) << "of 1 and 3; 2 was never served";
}

TEST(ShadowLink, TakesTheLightSetRevisionOfARestartedServer) {
  MetBench bench;
  Welcome renewed = kServed;
  renewed.light_set_revision = 9;
  bench.from_server(renewed);
  bench.pass(kWay);
  bench.ask(request(1));
  bench.pass(2 * kWay);
  EXPECT_FALSE(bench.link.find({1})->anything_known()) << "slices of revision 5 are of another light set";
  EXPECT_GT(bench.link.counters().assembler.other_light_set, 0u);
}

TEST(ShadowLink, LostSlicesLeaveTheirTilesUnknownAndNothingElse) {
  Bench lossy({.to_server = {}, .to_client = {.loss = 0.4}, .seed = 3});
  lossy.start_server();
  ASSERT_TRUE(lossy.link.meet(10s).has_value());
  std::size_t known = 0, unknown = 0;
  for (std::uint32_t frame = 1; frame <= 20; ++frame) {
    lossy.ask(request(frame));
    lossy.link.wait_for({frame}, 1ms);
    const ReceivedFrame& received = *lossy.link.find({frame});
    const PerEye<EyeMask> truth = painted(frame);
    for (std::size_t eye = 0; eye < kEyes; ++eye)
      for (std::uint32_t tile = 0; tile < TileGrid{kSize}.count(); ++tile) {
        ++(received.known_tiles[eye][tile] ? known : unknown);
        const TileRect rect = TileGrid{kSize}.rect(tile);
        for (std::uint32_t y = rect.y0; y < rect.y1; ++y)
          for (std::uint32_t x = rect.x0; x < rect.x1; ++x)
            ASSERT_EQ(received.masks[eye].word(x, y),
                      received.known_tiles[eye][tile] ? truth[eye].word(x, y) : 0u);
      }
  }
  EXPECT_GT(known, unknown);
  EXPECT_GT(unknown, 20u);
}

TEST(ShadowLink, MasksComeNewestFirstAndNotBeyondUntil) {
  MetBench bench;
  for (std::uint32_t frame = 1; frame <= 4; ++frame) {
    bench.ask(request(frame, frame * 10ms));
    if (frame != 3) bench.pass(2 * kWay);
  }
  const auto frames = [&](Time until) {
    std::vector<std::uint32_t> values;
    for (const ReceivedFrame* mask : bench.link.masks(until)) values.push_back(mask->request.frame.value);
    return values;
  };
  EXPECT_EQ(frames(Time::max()), (std::vector<std::uint32_t>{4, 2, 1})) << "4 took the place of 3";
  EXPECT_EQ(frames(Time(40ms)), (std::vector<std::uint32_t>{4, 2, 1}));
  EXPECT_EQ(frames(Time(40ms - 1ns)), (std::vector<std::uint32_t>{2, 1}));
  EXPECT_EQ(frames(Time(9ms)), (std::vector<std::uint32_t>{}));
}

TEST(ShadowLink, TellsFramesApartByWhenTheyAskedNotByWhatFor) {
  MetBench bench;
  for (std::uint32_t frame = 1; frame <= 3; ++frame) {
    bench.link.request(request(frame, 500ms - frame * 10ms), Time(frame * 10ms));  // for ever earlier times
    ASSERT_TRUE(bench.link.wait_for({frame}, 1s));
  }
  ASSERT_EQ(bench.link.masks(Time(20ms)).size(), 2u);
  EXPECT_EQ(bench.link.masks(Time(20ms)).front()->request.frame, FrameId{2});
  EXPECT_TRUE(bench.link.masks(Time(10ms - 1ns)).empty());
  EXPECT_EQ(bench.link.asked_at({3}), Time(30ms));
  EXPECT_EQ(bench.link.find({3})->request.display_time, Time(470ms));
  EXPECT_EQ(bench.link.asked_at({4}), std::nullopt);
}

TEST(ShadowLink, KeepsTheNewestRequestsOnly) {
  MetBench bench;
  for (std::uint32_t frame = 1; frame <= 20; ++frame) {
    bench.ask(request(frame, frame * 10ms));
    ASSERT_TRUE(bench.link.wait_for({frame}, 1s));
  }
  const auto masks = bench.link.masks(Time::max());
  ASSERT_EQ(masks.size(), kFrames);
  EXPECT_EQ(masks.front()->request.frame, FrameId{20});
  EXPECT_EQ(masks.back()->request.frame, FrameId{15});
  EXPECT_EQ(bench.link.find({14}), nullptr);
  EXPECT_EQ(bench.link.asked_at({14}), std::nullopt);
  EXPECT_EQ(bench.link.asked_at({15}), Time(150ms));
}

TEST(ShadowLinkWait, EndsWhenTheFrameIsWhole) {
  MetBench bench;
  const Time asked = bench.clock.now();
  bench.ask(request(1));
  EXPECT_TRUE(bench.link.wait_for({1}, 1s));
  EXPECT_EQ(bench.clock.now() - asked, 2 * kWay);
  EXPECT_TRUE(bench.link.find({1})->report.has_value());
}

TEST(ShadowLinkWait, LastsAsLongAsItsPatience) {
  MetBench bench;
  const Time asked = bench.clock.now();
  bench.ask(request(1));
  EXPECT_FALSE(bench.link.wait_for({1}, 0ms));
  EXPECT_EQ(bench.clock.now(), asked);
  EXPECT_FALSE(bench.link.wait_for({1}, 7ms));
  EXPECT_EQ(bench.clock.now() - asked, 7ms);
  bench.server.reset();
  bench.ask(request(2));
  EXPECT_FALSE(bench.link.wait_for({2}, 100ms));
  EXPECT_EQ(bench.clock.now() - asked, 107ms);
  EXPECT_TRUE(bench.link.find({1})->complete()) << "what came meanwhile was taken";
}

TEST(ShadowLinkWait, DoesNotWaitForAServerThatHasNotWelcomedIt) {
  Bench bench;
  bench.ask(request(1));
  EXPECT_FALSE(bench.link.wait_for({1}, 10s));
  EXPECT_EQ(bench.clock.now(), Time{});
}

TEST(ShadowLink, HostileBytesChangeNothingButCounters) {
  MetBench bench({.to_server = {}, .to_client = {}});
  bench.ask(request(1));
  ASSERT_TRUE(bench.link.wait_for({1}, 1s));
  const std::vector<std::byte> noise(40, std::byte{0x5A});
  bench.wire.server().send(bench.wire.client().local(), noise);
  std::vector<std::byte> cut;
  encode(ServerMessage(kServed), cut);
  cut.pop_back();
  bench.wire.server().send(bench.wire.client().local(), cut);
  const std::array block{std::byte{0xF0}, std::byte{0xFF}, std::byte{0xFF}};
  Slice slice{.frame = {1},
              .light_set_revision = kServed.light_set_revision,
              .size = kSize,
              .lights = kLights,
              .tile_count = 1,
              .block = block};
  bench.from_server(slice);
  slice.frame = {77};
  bench.from_server(slice);
  bench.from_server(FrameReport{.frame = {78}});
  bench.link.poll();

  const ShadowLink::Counters counters = bench.link.counters();
  EXPECT_EQ(counters.undecodable[WireRefusal::Magic], 1u);
  EXPECT_EQ(counters.undecodable[WireRefusal::Truncated], 1u);
  EXPECT_EQ(counters.undecodable.total(), 2u);
  EXPECT_EQ(counters.assembler.refused.total(), 1u);
  EXPECT_EQ(counters.assembler.unexpected, 2u);
  EXPECT_TRUE(bench.link.welcomed());
  EXPECT_EQ(bench.link.find({1})->masks, painted(1));
}

TEST(ShadowLink, SurvivesFrameIdWraparound) {
  MetBench bench;
  for (std::uint32_t i = 0; i < 6; ++i) {
    const std::uint32_t frame = 0xFFFF'FFFDu + i;
    bench.ask(request(frame, (i + 1) * 10ms));
    ASSERT_TRUE(bench.link.wait_for({frame}, 1s)) << frame;
    EXPECT_EQ(bench.link.find({frame})->masks, painted(frame));
    EXPECT_EQ(bench.link.masks(Time::max()).front()->request.frame, FrameId{frame});
  }
  EXPECT_EQ(bench.link.masks(Time::max()).size(), kFrames);
}

}  // namespace
}  // namespace farshade
