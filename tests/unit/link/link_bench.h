/// A NetworkLink over a virtual link. At the other end a server answers. A test can replace the server and
/// read what it traced. Time advances from one event to the next.
#pragma once

#include <functional>
#include <map>
#include <optional>

#include "stereo/link/network_link.h"
#include "tests/support/manual_clock.h"
#include "tests/support/virtual_link.h"
#include "tests/unit/link_client.h"

namespace farshade::link_test {

using namespace std::chrono_literals;

constexpr std::uint32_t kLights = 3;
constexpr Extent kSize{100, 60};
constexpr std::size_t kFrames = 6;
constexpr Duration kWay = 5ms;
constexpr Duration kInterval = 14ms;  ///< of the display
constexpr LinkModels kSlow{.to_server = {.delay = kWay}, .to_client = {.delay = kWay}};

inline LinkModels each_way(Duration delay) {
  return {.to_server = {.delay = delay}, .to_client = {.delay = delay}};
}

inline FrameRequest request(std::uint32_t frame, Duration display = {}) {
  FrameRequest requested = request_of(frame, kSize);
  requested.display_time = Time(display);
  return requested;
}

/// Replaces the tracer: masks that differ between frames, eyes and pixels.
inline TraceStats paint(const FrameRequest& requested, ShadowFrame& frame) {
  frame.frame = requested.frame;
  frame.light_set_revision = requested.lights.revision;
  frame.views = requested.views;
  std::uint32_t noise = requested.frame.value;
  for (EyeMask& mask : frame.masks) {
    mask = EyeMask(kSize, kLights);
    for (std::uint32_t y = 0; y < kSize.height; ++y)
      for (std::uint32_t x = 0; x < kSize.width; ++x)
        mask.set_word(x, y, 0, (noise = noise * 1664525 + 1013904223) >> 29);
  }
  return {};
}

inline PerEye<EyeMask> painted(std::uint32_t frame) {
  ShadowFrame made;
  paint(request(frame), made);
  return made.masks;
}

/// A port whose datagrams a test can watch and drop.
class WatchedPort final : public DatagramPort {
 public:
  using Drops = std::function<bool(std::span<const std::byte>)>;

  WatchedPort(DatagramPort& port, const Drops& drops) : port_(port), drops_(drops) {}
  [[nodiscard]] Peer local() const override { return port_.local(); }
  bool send(const Peer& to, std::span<const std::byte> bytes) override {
    return (drops_ && drops_(bytes)) || port_.send(to, bytes);
  }
  std::optional<Datagram> receive(std::span<std::byte> into, Duration wait) override {
    return port_.receive(into, wait);
  }
  void wake() override { port_.wake(); }
  [[nodiscard]] PortCounters counters() const override { return port_.counters(); }

 private:
  DatagramPort& port_;
  const Drops& drops_;
};

struct LinkBench {
  /// The link keeps `frames` requests. Its client is the last of the `clients` clients of the wire.
  explicit LinkBench(const LinkModels& models = kSlow, std::size_t frames = kFrames, std::size_t clients = 1)
      : wire(clock, models, clients),
        client_port(wire.client(clients - 1), on_send),
        link(client_port, clock, target, frames) {
    wire.while_waiting([this] { serve(); }, [this] { return due(); });
  }
  /// The link says goodbye at its end, after what a test's hooks refer to has ended.
  ~LinkBench() { on_send = on_answer = {}; }
  LinkBench(const LinkBench&) = delete;
  LinkBench& operator=(const LinkBench&) = delete;
  void start_server(const Welcome& served = kServed, const SessionLimits& limits = {},
                    const std::vector<SharedKey>& ring = {kKey}) {
    const auto trace = [this](const FrameRequest& requested, ShadowFrame& made) {
      traced_lights[requested.frame.value] = requested.lights;
      return paint(requested, made);
    };
    server.emplace(served, ring, masks_from(trace), server_port, clock, limits);
  }
  void serve() {
    if (server) {
      while (server->receive(0s)) {
      }
      while (clock.now() >= busy_until && server->work()) busy_until = clock.now() + trace_time;
      return server->send_due();
    }
    std::array<std::byte, kMaxDatagram_bytes> nobody_reads_it;
    while (wire.server().receive(nobody_reads_it, 0s)) {
    }
  }
  /// The time at which serve() has work if no datagram arrives.
  [[nodiscard]] std::optional<Time> due() const {
    if (!server) return std::nullopt;
    const std::optional<Time> any = server->next_due(), send = server->next_send();
    if (!any || clock.now() >= busy_until) return any;
    const Time work = std::max(*any, busy_until);
    return send ? std::min(*send, work) : work;
  }
  void pass(Duration time) {
    const Time until = clock.now() + time;
    while (clock.now() < until) {
      Time next = until;
      if (const auto arrival = wire.next_arrival()) next = std::min(next, *arrival);
      if (const auto at = due()) next = std::min(next, *at);
      clock.advance_to(next);
      serve();
      link.poll();
      if (on_event) on_event();
    }
  }
  /// The requesting frame shows the requested views themselves.
  void ask(const FrameRequest& requested) { link.request(requested, requested.display_time); }
  /// Sends a request in each display interval.
  void run(Duration time) {
    for (const Time until = clock.now() + time; clock.now() < until;) {
      FrameRequest requested = request(++frame, clock.now().time_since_epoch());
      requested.lights = lights;
      ask(requested);
      pass(kInterval);
    }
  }
  /// The same until a mask has arrived that was requested after the call. Returns the time that this took.
  Duration run_until_masks(Duration patience) {
    const Time begin = clock.now();
    const std::uint32_t before = frame;
    std::optional<Time> came;
    on_event = [&] {
      for (std::uint32_t f = before + 1; f <= frame && !came; ++f)
        if (const auto* got = link.receiver().find({f}); got != nullptr && got->anything_known())
          came = clock.now();
    };
    while (!came && clock.now() < begin + patience) run(kInterval);
    on_event = {};
    return (came ? *came : Time::max()) - begin;
  }

  /// Called with each datagram before it is sent. Returns true to lose the datagram.
  WatchedPort::Drops on_send, on_answer;
  Duration trace_time{};
  Time busy_until{};

  ManualClock clock;
  VirtualLink wire;
  WatchedPort client_port, server_port{wire.server(), on_answer};
  std::optional<ServerCore> server;
  std::map<std::uint32_t, LightChanges> traced_lights;  ///< by frame
  LinkTarget target{wire.server().local(), kKey, kServed.scene_hash, {kLights}};
  NetworkLink link;
  std::uint32_t frame = 0;
  LightChanges lights;
  std::function<void()> on_event;
};

struct ConnectedBench : LinkBench {
  explicit ConnectedBench(const LinkModels& models = kSlow, std::size_t frames = kFrames)
      : LinkBench(models, frames) {
    start_server();
    EXPECT_TRUE(link.connect(2s).has_value());
  }
};

}  // namespace farshade::link_test
