#include "rt_server/work/server_core.h"

#include <gtest/gtest.h>

#include <atomic>
#include <latch>

#include "stereo/net/udp.h"
#include "tests/support/manual_clock.h"
#include "tests/support/virtual_link.h"
#include "tests/unit/link_client.h"

namespace farshade {
namespace {

using namespace std::chrono_literals;
using namespace link_test;

const std::vector<SharedKey> kTwoKeys{key_named("ada"), key_named("bob")};
constexpr Extent kAskedSize{100, 60};

FrameRequest request(std::uint32_t frame) {
  return request_of(frame, kAskedSize);
}

/// Masks that differ in each frame, eye and pixel.
TraceStats paint(const FrameRequest& requested, ShadowFrame& frame) {
  frame.frame = requested.frame;
  frame.light_set_revision = requested.lights.revision;
  frame.views = requested.views;
  for (const Side side : kSides) {
    EyeMask& mask = frame.masks[index_of(side)];
    mask = EyeMask(requested.views[index_of(side)].size, kServed.light_count);
    for (std::uint32_t y = 0; y < kAskedSize.height; ++y)
      for (std::uint32_t x = 0; x < kAskedSize.width; ++x)
        mask.set_word(x, y, 0, (x * x / 9 + y * requested.frame.value + index_of(side)) % 8);
  }
  return {.update = 2ms,
          .primary = 3ms,
          .shadow = 4ms,
          .primary_rays = 10,
          .shadow_rays = 20,
          .full_shadow_rays = 30};
}

PerEye<EyeMask> painted(std::uint32_t frame) {
  ShadowFrame made;
  paint(request(frame), made);
  return made.masks;
}

/// A server and a client on a virtual link, in one thread.
struct Bench {
  explicit Bench(const LinkModels& models = {}, RequestHandlers answers = masks_from(paint))
      : link(clock, models) {
    core.emplace(kServed, kTwoKeys, std::move(answers), link.server(), clock);
    link.while_waiting([this] { serve(*core); }, [this] { return core->next_due(); });
  }

  ManualClock clock;
  VirtualLink link;
  std::optional<ServerCore> core;
  PortClient client{link.client(), link.server().local(), kTwoKeys[0], kServed};
};

/// A port of a process that is stopped for `stall` while it waits.
class StalledPort final : public DatagramPort {
 public:
  StalledPort(DatagramPort& port, ManualClock& clock) : port_(port), clock_(clock) {}
  [[nodiscard]] Peer local() const override { return port_.local(); }
  bool send(const Peer& to, std::span<const std::byte> bytes) override { return port_.send(to, bytes); }
  [[nodiscard]] std::optional<Datagram> receive(std::span<std::byte> into, Duration wait) override {
    clock_.advance_to(clock_.now() + std::exchange(stall, Duration{}));
    return port_.receive(into, wait);
  }
  void wake() override { port_.wake(); }
  [[nodiscard]] PortCounters counters() const override { return port_.counters(); }
  Duration stall{};

 private:
  DatagramPort& port_;
  ManualClock& clock_;
};

TEST(ServerCore, AStallEndsNoSession) {
  ManualClock clock;
  VirtualLink link(clock, {});
  StalledPort port(link.server(), clock);
  ServerCore core(kServed, kTwoKeys, masks_from(paint), port, clock);
  link.while_waiting([&] { serve(core); }, [&] { return core.next_due(); });
  PortClient client(link.client(), link.server().local(), kTwoKeys[0], kServed);
  ASSERT_TRUE(client.connect(1s));
  client.say(client.seal({.request = request(1)}));
  serve(core);
  for (const Duration stall : {5s, 11s, 60s, 3600s}) {
    port.stall = stall;
    core.receive({});
    EXPECT_EQ(core.counters().sessions_open, 1u) << seconds_of(stall);
  }
  clock.advance_to(clock.now() + SessionLimits{}.silence + 1s);
  core.receive({});
  EXPECT_EQ(core.counters().sessions_open, 0u) << "nobody came, and the server ran";
}

TEST(ServerCore, AnswersARequestWithBothMasksBitForBit) {
  Bench bench({.to_server = {.delay = 5ms}, .to_client = {.delay = 5ms}});
  ASSERT_TRUE(bench.client.connect(1s));
  EXPECT_EQ(bench.clock.now(), Time(20ms)) << "two round trips";
  EXPECT_EQ(bench.client.welcome, kServed);
  bench.client.say(bench.client.ask(request(1)));
  while (bench.client.hear(100ms)) {
  }
  const RequestRecord* received = bench.client.assembler.find({1});
  ASSERT_NE(received, nullptr);
  EXPECT_TRUE(received->complete());
  EXPECT_EQ(received->masks, painted(1));
}

TEST(ServerCore, AClientOfThePreviousVersionGetsItsMasksInThatVersion) {
  Bench bench;
  PortClient old(bench.link.client(), bench.link.server().local(), kTwoKeys[0], kServed, kPreviousVersion);
  ASSERT_TRUE(old.connect(1s));
  EXPECT_EQ(old.welcome, kServed);
  old.say(old.ask(request(1)));
  while (old.reports == 0) ASSERT_TRUE(old.hear(1s));
  const RequestRecord* received = old.assembler.find({1});
  ASSERT_NE(received, nullptr);
  EXPECT_EQ(received->masks, painted(1));
  EXPECT_EQ(old.refused.total(), 0u) << "every datagram is of its version";
  // A server that was started anew says so in that version, too.
  bench.core.emplace(kServed, kTwoKeys, masks_from(paint), bench.link.server(), bench.clock);
  old.say(old.ask(request(2)));
  ASSERT_TRUE(old.hear(1s));
  EXPECT_EQ(old.no_session, 1u);
}

TEST(ServerCore, ASessionKeepsItsVersion) {
  Bench bench;
  ASSERT_TRUE(bench.client.connect(1s));
  const SessionKeys& keys = *bench.client.keys;
  bench.client.sealer.emplace(keys.session, keys.to_server, keys.sealing, kPreviousVersion);
  bench.client.say(bench.client.ask(request(1)));
  EXPECT_FALSE(bench.client.hear(1s));
  EXPECT_EQ(bench.client.reports, 0u);
}

TEST(ServerCore, ReportsTheFrameAndItsCost) {
  Bench bench;
  ASSERT_TRUE(bench.client.connect(1s));
  for (std::uint32_t frame = 1; frame <= 3; ++frame) bench.client.say(bench.client.ask(request(frame)));
  while (bench.core->receive(0s)) {
  }
  bench.clock.advance_to(Time(2ms));
  ASSERT_TRUE(bench.core->work());
  while (bench.client.hear(100ms)) {
  }
  const RequestRecord* received = bench.client.assembler.find({3});
  ASSERT_TRUE(received->report.has_value());
  FrameReport report = *received->report;
  EXPECT_EQ(report.slices, bench.client.assembler.counters().slices);
  EXPECT_GT(report.payload_bytes, 0u);
  EXPECT_GT(report.pack, 0s);
  report.pack = {};
  report.slices = report.payload_bytes = 0;
  EXPECT_EQ(report, (FrameReport{.frame = {3},
                                 .primary_rays = 10,
                                 .shadow_rays = 20,
                                 .full_shadow_rays = 30,
                                 .update = 2ms,
                                 .primary = 3ms,
                                 .shadow = 4ms,
                                 .waited = 2ms,
                                 .superseded = 2,
                                 .bytes_per_second = static_cast<std::uint32_t>(RateControl::kStart)}));
  EXPECT_EQ(bench.core->counters().frames, 1u);
  EXPECT_EQ(bench.core->counters().sessions.superseded, 2u);
  EXPECT_FALSE(bench.client.assembler.find({1})->anything_known());
}

TEST(ServerCore, CountsDatagramsThatAreNoMessages) {
  Bench bench;
  const std::array<std::byte, 40> noise{};
  bench.link.client().send(bench.link.server().local(), noise);
  serve(*bench.core);
  EXPECT_EQ(bench.core->counters().refused[WireRefusal::Magic], 1u);
  EXPECT_EQ(bench.core->counters().port.sent, 0u);
}

TEST(ServerCore, TracesNothingForStrangers) {
  Bench bench;
  PortClient stranger(bench.link.client(), bench.link.server().local(), key_named("mallory"), kServed);
  EXPECT_FALSE(stranger.connect(100ms));
  EXPECT_TRUE(stranger.open_refusal.has_value());
  Welcome other = kServed;
  other.scene_hash = {9};
  PortClient astray(bench.link.client(), bench.link.server().local(), kTwoKeys[0], other);
  EXPECT_FALSE(astray.connect(100ms));
  EXPECT_TRUE(astray.refusal.has_value());
  EXPECT_EQ(bench.core->counters().frames, 0u);
  EXPECT_EQ(bench.core->counters().sessions_open, 0u);
}

TEST(ServerCore, WithdrawsAnAnswerThatCanNoLongerBeMade) {
  RequestHandlers answers = answers_from(set_of(Answer::GBuffer), [](const Job&, FramePacker&) -> AnswerCost {
    throw AnswersLost(set_of(Answer::GBuffer), "no device");
  });
  answers.add(Answer::Masks,
              std::make_unique<AnswerFrom>([](const Job&, FramePacker&) { return AnswerCost{}; }));
  Bench bench({}, std::move(answers));
  ASSERT_TRUE(bench.client.connect(1s));
  EXPECT_EQ(bench.client.welcome->answers, set_of(Answer::GBuffer) | set_of(Answer::Masks));
  FrameRequest requested = request(1);
  requested.answer.kind = Answer::GBuffer;
  bench.client.say(bench.client.ask(requested));
  while (bench.client.hear(10ms)) {
  }
  EXPECT_EQ(bench.core->counters().sessions.withdrawn, 1u);
  requested.frame = {2};
  bench.client.say(bench.client.ask(requested));
  while (bench.client.hear(10ms)) {
  }
  EXPECT_EQ(bench.client.no_session, 1u);
  PortClient again(bench.link.client(), bench.link.server().local(), kTwoKeys[0], kServed);
  ASSERT_TRUE(again.connect(1s));
  EXPECT_EQ(again.welcome->answers, set_of(Answer::Masks));
}

TEST(ServerCore, GivesUpALongAnswerForAClientThatWaitsAndSendsItsReport) {
  ManualClock clock;
  VirtualLink link(clock, {});
  std::optional<ServerCore> core;
  std::optional<PortClient> ada, bob;
  Time ended{};
  const auto answer = [&](const Job& job, FramePacker&) {
    if (job.request.frame.value == 1) bob->say(bob->ask(request(2)));
    while (clock.now() < Time(1min) && !job.is_given_up()) {
      clock.advance_to(clock.now() + 1ms);
      while (core->receive(0s)) {
      }
    }
    ended = clock.now();
    go_on_with(job);
    return AnswerCost{};
  };
  core.emplace(kServed, kTwoKeys, answers_from(set_of(Answer::Masks), answer), link.server(), clock);
  link.while_waiting([&] { serve(*core); }, [&] { return core->next_due(); });
  ada.emplace(link.client(), link.server().local(), kTwoKeys[0], kServed);
  ASSERT_TRUE(ada->connect(1s));
  bob.emplace(link.client(), link.server().local(), kTwoKeys[1], kServed);
  ASSERT_TRUE(bob->connect(1s));
  const Time begun = clock.now();
  ada->say(ada->ask(request_of(1, {2048, 1024})));
  while (core->receive(0s)) {
  }
  ASSERT_TRUE(core->work());
  EXPECT_GT(ended - begun, kMostTurn);
  EXPECT_LE(ended - begun, kMostTurn + 12ms) << "the sessions are looked at every 10 ms";
  EXPECT_EQ(core->counters().given_up, 1u);
  EXPECT_NE(counters_line(core->counters()).find("1 given up"), std::string::npos);
}

TEST(ServerCore, AnAnswerForWhichThereIsNoMemoryIsItsReportAloneAndTheNextIsMade) {
  bool is_short = true;
  Bench bench({}, masks_from([&](const FrameRequest& requested, ShadowFrame& frame) {
                if (is_short) throw std::bad_alloc();
                return paint(requested, frame);
              }));
  ASSERT_TRUE(bench.client.connect(1s));
  bench.client.say(bench.client.ask(request(1)));
  while (bench.client.hear(100ms)) {
  }
  EXPECT_TRUE(bench.client.assembler.find({1})->report.has_value());
  EXPECT_FALSE(bench.client.assembler.find({1})->anything_known());
  EXPECT_EQ(bench.core->counters().out_of_memory, 1u);
  is_short = false;
  bench.client.say(bench.client.ask(request(2)));
  while (bench.client.hear(100ms)) {
  }
  EXPECT_TRUE(bench.client.assembler.find({2})->complete());
}

TEST(ServerCore, SlicesLeaveOverHalfTheFrameIntervalAndNotAtOnce) {
  Bench bench;
  ASSERT_TRUE(bench.client.connect(1s));
  FrameRequest requested = request(1);
  std::vector<Time> arrivals;
  for (std::uint32_t frame = 1; frame <= 100; ++frame) {
    const Time begin = Time(frame * 14ms);
    while (bench.clock.now() < begin) bench.client.hear(begin - bench.clock.now());
    requested.frame = {frame};
    requested.display_time = begin;
    bench.client.say(bench.client.ask(requested));
    if (frame < 100) continue;
    while (bench.client.hear(14ms)) arrivals.push_back(bench.clock.now());
  }
  ASSERT_GT(arrivals.size(), 2u);
  const Duration spread = arrivals.back() - arrivals.front();
  EXPECT_GT(spread, 14ms * 0.5 * 0.9 * static_cast<double>(arrivals.size() - 1) /
                        static_cast<double>(arrivals.size()));
  EXPECT_LT(spread, 14ms * 0.5);
}

TEST(ServerCore, SameSeedSameMasksOverALossyLink) {
  const auto run = [] {
    Bench bench({.to_server = {.delay = 3ms, .jitter = 2ms, .loss = 0.05},
                 .to_client = {.delay = 4ms, .jitter = 8ms, .loss = 0.2},
                 .seed = 11});
    std::vector<PerEye<EyeMask>> masks;
    std::vector<PerEye<std::uint32_t>> known;
    while (!bench.client.session) bench.client.connect(50ms);
    for (std::uint32_t frame = 1; frame <= 20; ++frame) {
      bench.client.say(bench.client.ask(request(frame)));
      const Time display = bench.clock.now() + 14ms;
      while (bench.clock.now() < display) bench.client.hear(display - bench.clock.now());
      if (const RequestRecord* newest = bench.client.assembler.newest_known()) {
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
  ServerCore core(kServed, kTwoKeys, masks_from([&](const FrameRequest& requested, ShadowFrame& frame) {
                    if (traced++ == 0) {
                      tracing.count_down();
                      all_asked.wait();
                    }
                    return paint(requested, frame);
                  }),
                  **port, clock);
  const Serving serving(core);

  PortClient client(*connected->port, connected->server, kTwoKeys[0], kServed);
  ASSERT_TRUE(client.connect(60s));
  client.say(client.ask(request(1)));
  tracing.wait();
  for (std::uint32_t frame = 2; frame <= 6; ++frame) client.say(client.ask(request(frame)));
  // Loopback keeps the order: when the server has counted this malformed datagram, it has all requests.
  connected->port->send(connected->server, std::array<std::byte, 1>{});
  while (core.counters().refused.total() == 0) std::this_thread::yield();
  all_asked.count_down();
  while (!client.assembler.find({6})->report) ASSERT_TRUE(client.hear(60s));
  EXPECT_TRUE(client.assembler.find({1})->complete());
  EXPECT_TRUE(client.assembler.find({6})->complete());
  for (std::uint32_t frame = 2; frame <= 5; ++frame)
    EXPECT_FALSE(client.assembler.find({frame})->anything_known()) << frame;
  EXPECT_EQ(traced, 2);
  EXPECT_EQ(core.counters().sessions.superseded, 4u);
}

TEST(Serving, ServesTwoClientsAtOnceOverRealUdp) {
  auto port = listen_udp("127.0.0.1:0");
  ASSERT_TRUE(port.has_value());
  const SteadyClock clock;
  ServerCore core(kServed, kTwoKeys, masks_from(paint), **port, clock);
  std::array<std::uint32_t, 2> whole{};
  {
    const Serving serving(core);
    std::vector<std::jthread> threads;
    for (std::size_t i = 0; i < whole.size(); ++i)
      threads.emplace_back([&core, &whole, i, to = to_string((*port)->local())] {
        auto connected = connect_udp(to);
        if (!connected) return;
        PortClient client(*connected->port, connected->server, kTwoKeys[i], kServed);
        if (!client.connect(60s)) return;
        for (std::uint32_t frame = 1; frame <= 50; ++frame) {
          client.say(client.ask(request(frame)));
          const RequestRecord& received = *client.assembler.find({frame});
          while (!(received.report && received.complete()) && client.hear(5s)) {
          }
          if (received.complete() && received.masks == painted(frame)) ++whole[i];
          (void)core.counters();
        }
      });
  }
  // Loopback may lose a datagram if the machine is busy.
  for (const std::uint32_t frames : whole) EXPECT_GE(frames, 45u);
  EXPECT_EQ(core.counters().sessions.welcomed, 2u);
}

TEST(Serving, GivesUpTheAnswerInWorkWhenItEnds) {
  auto port = listen_udp("127.0.0.1:0");
  ASSERT_TRUE(port.has_value());
  auto connected = connect_udp(to_string((*port)->local()));
  ASSERT_TRUE(connected.has_value());
  std::latch working(1);
  std::atomic<bool> knew = false;
  const auto answer = [&](const Job& job, FramePacker&) -> AnswerCost {
    working.count_down();
    const Stopwatch watch;
    while (!job.is_given_up() && watch.elapsed() < 60s) std::this_thread::yield();
    knew = job.is_given_up();
    throw AnswerGivenUp();
  };
  const SteadyClock clock;
  ServerCore core(kServed, kTwoKeys, answers_from(set_of(Answer::Masks), answer), **port, clock);
  {
    const Serving serving(core);
    PortClient client(*connected->port, connected->server, kTwoKeys[0], kServed);
    ASSERT_TRUE(client.connect(60s));
    client.say(client.ask(request(1)));
    working.wait();
  }
  EXPECT_TRUE(knew) << "the answer ends at once, not when it gives up by itself";
  EXPECT_EQ(core.counters().given_up, 1u);
}

/// Nothing interrupts a graphics device.
TEST(Serving, DoesNotWaitForAnAnswerThatCannotBeGivenUp) {
  auto port = listen_udp("127.0.0.1:0");
  ASSERT_TRUE(port.has_value());
  auto connected = connect_udp(to_string((*port)->local()));
  ASSERT_TRUE(connected.has_value());
  std::latch drawing(1), drawn(1);
  const auto answer = [&](const Job&, FramePacker&) -> AnswerCost {
    drawing.count_down();
    drawn.wait();
    return {};
  };
  const SteadyClock clock;
  ServerCore core(kServed, kTwoKeys, answers_from(set_of(Answer::Masks), answer), **port, clock);
  PortClient client(*connected->port, connected->server, kTwoKeys[0], kServed);
  {
    Serving serving(core);
    ASSERT_TRUE(client.connect(60s));
    client.say(client.ask(request(1)));
    drawing.wait();
    const Stopwatch watch;
    EXPECT_FALSE(serving.end(200ms));
    EXPECT_GE(watch.elapsed(), 200ms);
    core.say_goodbye();  // meanwhile
    EXPECT_EQ(core.counters().sessions_open, 1u);
    drawn.count_down();
  }
  EXPECT_EQ(core.counters().frames, 1u);
}

TEST(Serving, EndsInTimeWithoutAnAnswerInWork) {
  auto port = listen_udp("127.0.0.1:0");
  ASSERT_TRUE(port.has_value());
  const SteadyClock clock;
  ServerCore core(kServed, kTwoKeys, masks_from(paint), **port, clock);
  Serving serving(core);
  EXPECT_TRUE(serving.end(60s));
}

TEST(Serving, EndsWhileNothingHappens) {
  auto port = listen_udp("127.0.0.1:0");
  ASSERT_TRUE(port.has_value());
  const SteadyClock clock;
  ServerCore core(kServed, kTwoKeys, masks_from(paint), **port, clock);
  const Stopwatch watch;
  { const Serving serving(core); }
  EXPECT_LT(watch.elapsed(), 30s) << "the network thread waits for up to 60 s";
}

}  // namespace
}  // namespace farshade
