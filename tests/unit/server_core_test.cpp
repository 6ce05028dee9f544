#include <gtest/gtest.h>

#include <latch>

#include "rt_server/serve.h"
#include "stereo/net/assembler.h"
#include "stereo/net/udp.h"
#include "stereo/net/virtual_link.h"

namespace farshade {
namespace {

using namespace std::chrono_literals;

constexpr std::uint32_t kLights = 3;
const Welcome kServed{{1, 2, 3}, kLights, 5};
constexpr Extent kSize{100, 60};

TraceRequest request(std::uint32_t frame) {
  TraceRequest asked;
  asked.frame = {frame};
  for (View& view : asked.views) {
    view.fov = {-0.7, 0.8, 0.6, -0.5};
    view.size = kSize;
  }
  return asked;
}

/// Masks that differ from frame to frame, eye to eye and pixel to pixel.
TraceStats paint(const TraceRequest& asked, ShadowFrame& frame) {
  frame.frame = asked.frame;
  frame.light_set_revision = kServed.light_set_revision;
  frame.views = asked.views;
  for (const Side side : kSides) {
    EyeMask& mask = frame.masks[index_of(side)];
    mask = EyeMask(asked.views[index_of(side)].size, kLights);
    for (std::uint32_t y = 0; y < kSize.height; ++y)
      for (std::uint32_t x = 0; x < kSize.width; ++x)
        mask.set_word(x, y, 0, (x * x / 9 + y * asked.frame.value + index_of(side)) % 8);
  }
  return {.primary = 3ms, .shadow = 4ms, .primary_rays = 10, .shadow_rays = 20, .full_shadow_rays = 30};
}

/// A client as short as it can be.
struct TestClient {
  DatagramPort& port;
  Peer server;
  Assembler assembler{};
  std::vector<ServerMessage> answers{};  ///< all but slices and reports

  void say(const ClientMessage& message) {
    std::vector<std::byte> bytes;
    encode(message, bytes);
    port.send(server, bytes);
  }
  void ask(std::uint32_t frame) {
    assembler.expect(request(frame), kLights, kServed.light_set_revision);
    say(RequestMessage{request(frame), std::nullopt});
  }
  bool hear(Duration wait) {
    std::array<std::byte, kMaxDatagram_bytes> buffer;
    const auto datagram = port.receive(buffer, wait);
    if (!datagram) return false;
    const auto message = decode_server(datagram->bytes);
    if (!message) {
      ADD_FAILURE() << name_of(message.error());
    } else if (const auto* slice = std::get_if<Slice>(&*message)) {
      assembler.accept(*slice);
    } else if (const auto* report = std::get_if<FrameReport>(&*message)) {
      assembler.accept(*report);
    } else {
      answers.push_back(*message);
    }
    return true;
  }
};

/// A server and a client over a virtual link, in one thread.
struct Bench {
  explicit Bench(const LinkModels& models = {}, TraceFunction trace = paint) : link(clock, models) {
    core.emplace(kServed, std::move(trace), link.server(), clock);
    link.while_waiting([this] { serve(); });
  }
  void serve() {
    while (core->receive(0s)) {
    }
    while (core->work()) {
    }
  }

  ManualClock clock;
  VirtualLink link;
  std::optional<ServerCore> core;
  TestClient client{link.client(), link.server().local()};
};

TEST(ServerCore, AnswersARequestWithBothMasksBitForBit) {
  Bench bench({.to_server = {.delay = 5ms}, .to_client = {.delay = 5ms}});
  bench.client.say(Hello{.scene_hash = kServed.scene_hash});
  bench.client.ask(1);
  while (bench.client.hear(20ms)) {
  }
  ASSERT_EQ(bench.client.answers.size(), 1u);
  EXPECT_EQ(std::get<Welcome>(bench.client.answers[0]), kServed);
  const ReceivedFrame* received = bench.client.assembler.find({1});
  ASSERT_NE(received, nullptr);
  EXPECT_TRUE(received->complete());
  ShadowFrame painted;
  paint(request(1), painted);
  EXPECT_EQ(received->masks, painted.masks);
}

TEST(ServerCore, ReportsWhatTheFrameWasAndCost) {
  Bench bench;
  bench.client.say(Hello{.scene_hash = kServed.scene_hash});
  for (std::uint32_t frame = 1; frame <= 3; ++frame) bench.client.ask(frame);
  while (bench.core->receive(0s)) {
  }
  bench.clock.advance_to(Time(2ms));
  ASSERT_TRUE(bench.core->work());
  while (bench.client.hear(0s)) {
  }
  const ReceivedFrame* received = bench.client.assembler.find({3});
  ASSERT_TRUE(received->report.has_value());
  FrameReport report = *received->report;
  const AssemblerCounters& counters = bench.client.assembler.counters();
  EXPECT_EQ(report.slices, counters.slices);
  EXPECT_GT(report.payload_bytes, 0u);
  EXPECT_GT(report.pack, 0s);
  report.pack = {};
  report.slices = report.payload_bytes = 0;
  EXPECT_EQ(report, (FrameReport{.frame = {3},
                                 .primary_rays = 10,
                                 .shadow_rays = 20,
                                 .full_shadow_rays = 30,
                                 .primary = 3ms,
                                 .shadow = 4ms,
                                 .waited = 2ms,
                                 .superseded = 2}));
  EXPECT_EQ(bench.core->counters().frames, 1u);
  EXPECT_EQ(bench.core->counters().sessions.superseded, 2u);
  EXPECT_FALSE(bench.client.assembler.find({1})->anything_known());
}

TEST(ServerCore, CountsWhatIsNoMessage) {
  Bench bench;
  const std::array<std::byte, 40> noise{};
  bench.link.client().send(bench.link.server().local(), noise);
  bench.serve();
  EXPECT_EQ(bench.core->counters().refused[WireRefusal::Magic], 1u);
  EXPECT_EQ(bench.core->counters().port.sent, 0u);
}

TEST(ServerCore, AnswersStrangersWithARefusal) {
  Bench bench;
  bench.client.ask(1);
  Hello other;
  other.scene_hash = {9};
  bench.client.say(other);
  bench.serve();
  while (bench.client.hear(0s)) {
  }
  ASSERT_EQ(bench.client.answers.size(), 2u);
  EXPECT_EQ(std::get<Refusal>(bench.client.answers[0]).reason, RefusalReason::NotWelcomed);
  EXPECT_EQ(std::get<Refusal>(bench.client.answers[1]).reason, RefusalReason::SceneMismatch);
  EXPECT_EQ(bench.core->counters().frames, 0u);
}

TEST(ServerCore, SameSeedSameMasksOverALossyLink) {
  const auto run = [] {
    Bench bench({.to_server = {.delay = 3ms, .jitter = 2ms, .loss = 0.05},
                 .to_client = {.delay = 4ms, .jitter = 8ms, .loss = 0.2},
                 .seed = 11});
    std::vector<PerEye<EyeMask>> masks;
    std::vector<PerEye<std::uint32_t>> known;
    for (std::uint32_t frame = 1; frame <= 20; ++frame) {
      if (!bench.core->counters().sessions.welcomed)
        bench.client.say(Hello{.scene_hash = kServed.scene_hash});
      bench.client.ask(frame);
      const Time display = Time(frame * 14ms);
      while (bench.clock.now() < display) bench.client.hear(display - bench.clock.now());
      if (const ReceivedFrame* newest = bench.client.assembler.newest_known()) {
        masks.push_back(newest->masks);
        known.push_back(newest->tiles_known);
      }
    }
    return std::pair(masks, known);
  };
  const auto first = run();
  EXPECT_GT(first.first.size(), 10u);
  EXPECT_EQ(first, run());
}

TEST(Serving, NewestWinsWhileTheTracerIsBusyOverRealUdp) {
  auto port = listen_udp("127.0.0.1:0");
  ASSERT_TRUE(port.has_value());
  auto connected = connect_udp(to_string((*port)->local()));
  ASSERT_TRUE(connected.has_value());
  std::latch tracing(1), all_asked(1);
  std::atomic<int> traced = 0;
  const SteadyClock clock;
  ServerCore core(
      kServed,
      [&](const TraceRequest& asked, ShadowFrame& frame) {
        if (traced++ == 0) {
          tracing.count_down();
          all_asked.wait();
        }
        return paint(asked, frame);
      },
      **port, clock);
  const Serving serving(core);

  TestClient client{*connected->port, connected->server};
  client.say(Hello{.scene_hash = kServed.scene_hash});
  ASSERT_TRUE(client.hear(10s));
  client.ask(1);
  tracing.wait();
  for (std::uint32_t frame = 2; frame <= 6; ++frame) client.ask(frame);
  // Loopback keeps the order: once the server has counted this as no message, it has all the requests.
  const std::array<std::byte, 1> end{};
  connected->port->send(connected->server, end);
  while (core.counters().refused.total() == 0) std::this_thread::yield();
  all_asked.count_down();
  while (!client.assembler.find({6})->report) ASSERT_TRUE(client.hear(10s));
  EXPECT_TRUE(client.assembler.find({1})->complete());
  EXPECT_TRUE(client.assembler.find({6})->complete());
  for (std::uint32_t frame = 2; frame <= 5; ++frame)
    EXPECT_FALSE(client.assembler.find({frame})->anything_known()) << frame;
  EXPECT_EQ(traced, 2);
  EXPECT_EQ(core.counters().sessions.superseded, 4u);
}

TEST(Serving, EndsWhileNothingHappens) {
  auto port = listen_udp("127.0.0.1:0");
  ASSERT_TRUE(port.has_value());
  const SteadyClock clock;
  ServerCore core(kServed, paint, **port, clock);
  const Stopwatch watch;
  { const Serving serving(core); }
  EXPECT_LT(watch.elapsed(), 10s);
}

}  // namespace
}  // namespace farshade
