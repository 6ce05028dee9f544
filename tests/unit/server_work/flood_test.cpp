// A flood of datagrams with spoofed addresses: tests the size of the server's answers and of its memory.

#include <gtest/gtest.h>
#include <malloc.h>
#include <unistd.h>

#include <cstdio>
#include <ctime>
#include <fstream>
#include <random>

#include "stereo/base/quantile.h"
#include "tests/support/manual_clock.h"
#include "tests/support/sanitized.h"
#include "tests/unit/link_client.h"

namespace farshade {
namespace {

using namespace std::chrono_literals;
using namespace link_test;

constexpr std::uint64_t kFlood = kSanitized ? 30'000 : 1'000'000;
constexpr std::uint64_t kMiB = std::uint64_t{1} << 20;

std::uint64_t resident_bytes() {
  std::uint64_t all = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> all >> resident;
  return resident * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

/// A port on which each receive() returns another datagram from another address.
class Flood final : public DatagramPort {
 public:
  explicit Flood(std::uint64_t datagrams) : left_(datagrams) {
    LinkClient(kKey, kServed).handshake.write_hello(hello_);
  }

  [[nodiscard]] Peer local() const override { return {}; }
  bool send(const Peer&, std::span<const std::byte> bytes) override {
    ++counters_.sent;
    counters_.sent_bytes += bytes.size();
    longest_answer_less_datagram_ =
        std::max(longest_answer_less_datagram_, static_cast<std::ptrdiff_t>(bytes.size() - datagram_.size()));
    return true;
  }
  std::optional<Datagram> receive(std::span<std::byte> into, Duration) override {
    if (left_-- == 0) return std::nullopt;
    Peer from;
    for (std::uint8_t& byte : from.address) byte = static_cast<std::uint8_t>(random_());
    from.port = static_cast<std::uint16_t>(random_());
    datagram_ = into.first(make(into));
    ++counters_.received;
    counters_.received_bytes += datagram_.size();
    return Datagram{from, datagram_, {}};
  }
  void wake() override {}
  [[nodiscard]] PortCounters counters() const override { return counters_; }
  [[nodiscard]] std::ptrdiff_t worst() const { return longest_answer_less_datagram_; }

 private:
  void fill(std::span<std::byte> into) {
    for (std::size_t i = 0; i < into.size(); i += 8) {
      const std::uint64_t word = random_();
      for (std::size_t k = i; k < std::min(i + 8, into.size()); ++k)
        into[k] = static_cast<std::byte>(word >> 8 * (k - i));
    }
  }
  /// Writes a datagram into `into` and returns its size.
  std::size_t make(std::span<std::byte> into) {
    std::ranges::copy(hello_, into.begin());
    constexpr std::size_t kHead = 7, kPublic = 32;  // magic, version and type; then the public key
    const std::uint64_t kind = random_() % 6;
    if (kind == 0) {  // random content
      const std::size_t size = random_() % (into.size() + 1);
      fill(into.first(size));
      return size;
    }
    if (kind == 1) {  // hello of another version
      into[4] = static_cast<std::byte>(3 + random_() % 250);
      return random_() % 4 == 0 ? random_() % (into.size() + 1) : into.size();
    }
    fill(into.subspan(kHead, kPublic));
    if (kind == 2) fill(into.subspan(kHelloLasting_bytes, 16));  // with a random cookie
    if (kind == 3) fill(into.subspan(kHead, kHelloProved_bytes - kHead + 32));
    if (kind == 4) {  // sealed, for no session
      into[6] = std::byte{6};
      const std::size_t size = random_() % (into.size() + 1);
      fill(into.subspan(kHead));
      return size;
    }
    return hello_.size();  // kind 5: a correct first hello
  }

  std::uint64_t left_;
  std::mt19937_64 random_{20240};
  Bytes hello_;
  std::span<const std::byte> datagram_;
  PortCounters counters_;
  std::ptrdiff_t longest_answer_less_datagram_ = -static_cast<std::ptrdiff_t>(kMaxDatagram_bytes);
};

TEST(ServerFlood, AnswersSpoofedDatagramsWithFewerBytesAndKeepsNothing) {
  ManualClock clock;
  Flood flood(kFlood + 1000);
  ServerCore core(kServed, {kKey}, RequestHandlers(), flood, clock);
  for (int i = 0; i < 1000; ++i) core.receive(0s);  // afterwards the buffers do not grow any more
  const std::uint64_t before = resident_bytes();
  for (std::uint64_t i = 0; i < kFlood; ++i) {
    clock.advance_to(Time(i * 20us));
    core.receive(0s);
    if (i % 1000 == 0) {
      ASSERT_EQ(core.counters().sessions_open, 0u);
    }
  }
  const std::uint64_t after = resident_bytes();
  const ServerCounters counters = core.counters();
  std::printf("%llu datagrams: %llu bytes in, %llu bytes out, %lld bytes more resident\n",
              static_cast<unsigned long long>(kFlood),
              static_cast<unsigned long long>(counters.port.received_bytes),
              static_cast<unsigned long long>(counters.port.sent_bytes),
              static_cast<long long>(after) - static_cast<long long>(before));
  EXPECT_LE(counters.port.sent_bytes, counters.port.received_bytes);
  EXPECT_LE(flood.worst(), 0) << "no answer is longer than the datagram it answers";
  // Sanitizers keep freed memory.
  if (!kSanitized) {
    EXPECT_LT(after, before + kMiB);
  }
  EXPECT_EQ(counters.sessions, SessionCounters{});
  EXPECT_GT(counters.gate.retries, kFlood / 3) << "the well-formed hellos got a cookie";
  EXPECT_GT(counters.gate.version_mismatch, kFlood / 10);
  EXPECT_GT(counters.refused[WireRefusal::UnknownSession], kFlood / 10);
}

/// Sessions of clients that have shaken hands, and strangers who flood them.
class Flooded {
 public:
  explicit Flooded(std::size_t clients)
      : sessions_(kServed, {kKey}, {.sessions = clients, .handshakes_per_second = 1e9}) {
    for (std::size_t i = 0; i < clients; ++i) {
      LinkClient client(kKey, kServed);
      const Peer from{{0, 9}, 0, static_cast<std::uint16_t>(i)};
      for (Bytes datagram = client.hello(); !datagram.empty();) {
        (void)sessions_.handle(from, datagram, {}, answer_);
        datagram = answer_.empty() ? Bytes() : client.take(answer_, {});
      }
    }
    EXPECT_EQ(sessions_.size(), clients);
  }

  /// Processor time to make and handle kDatagrams, s. What other programs do meanwhile does not count.
  double handle() {
    const std::clock_t begun = std::clock();
    Flood flood(kDatagrams);
    std::array<std::byte, kMaxDatagram_bytes> buffer;
    while (const auto datagram = flood.receive(buffer, {})) {
      (void)sessions_.handle(datagram->from, datagram->bytes, {}, answer_);
      EXPECT_FALSE(sessions_.was_opened() && sessions_.job_at());
      EXPECT_FALSE(sessions_.due_at().has_value());
      EXPECT_TRUE(sessions_.silent_at().has_value());
    }
    return static_cast<double>(std::clock() - begun) / CLOCKS_PER_SEC;
  }

  static constexpr std::uint64_t kDatagrams = 10'000;

 private:
  Sessions sessions_;
  Bytes answer_;
};

TEST(ServerFlood, ADatagramOfAStrangerCostsTheSameWithManySessions) {
  Flooded few(1), many(4096);
  std::vector<double> few_s, many_s;
  for (int turn = 0; turn < 10; ++turn) {
    few_s.push_back(few.handle());
    many_s.push_back(many.handle());
  }
  const double few_median_s = quantile(few_s, 0.5), many_median_s = quantile(many_s, 0.5);
  std::printf("datagrams of strangers per second of one core: %.0f with 1 session, %.0f with 4,096\n",
              Flooded::kDatagrams / few_median_s, Flooded::kDatagrams / many_median_s);
  EXPECT_LT(many_median_s, 4 * few_median_s);
}

/// The memory of a session without its frame's datagrams, after a minute of requests that change lights,
/// report arrivals and come from changing addresses.
TEST(ServerMemory, ASessionIsUnderTwoMebibytesBeyondItsFrame) {
  if (kSanitized) GTEST_SKIP() << "the heap of a sanitizer cannot be measured";
  constexpr std::size_t kClients = 64, kMessages = 12;
  const std::vector<Bytes> messages(kMessages, Bytes(kMaxMessage_bytes, std::byte{7}));
  std::vector<LinkClient> clients(kClients, LinkClient(kKey, kServed));
  for (LinkClient& client : clients) client = LinkClient(kKey, kServed);
  const auto heap = [] { return mallinfo2().uordblks + mallinfo2().hblkhd; };
  const std::size_t before = heap();
  Sessions sessions(kServed, {kKey});
  const auto home = [](std::size_t i, std::size_t moves) {
    return Peer{{0, 1}, static_cast<std::uint32_t>(moves), static_cast<std::uint16_t>(i)};
  };
  Bytes answer;
  Time now{};
  const auto say = [&](std::size_t i, std::size_t moves, Bytes datagram) {
    while (!datagram.empty()) {
      (void)sessions.handle(home(i, moves), datagram, now, answer);
      datagram = answer.empty() ? Bytes() : clients[i].take(answer, now);
    }
  };
  for (std::size_t i = 0; i < kClients; ++i) say(i, 0, clients[i].hello());
  ASSERT_EQ(sessions.size(), kClients);
  for (std::uint32_t frame = 1; now < Time(60s); now += 100ms, ++frame) {
    for (std::size_t i = 0; i < kClients; ++i) {
      RequestMessage message{.request = request_of(frame, {64, 64}), .probe_echo = clients[i].probe};
      message.request.lights.revision = {frame};
      change(message.request.lights, frame % kMaxLights, true, LightPose{});
      message.arrivals = clients[i].arrivals.report();
      say(i, frame / 50, clients[i].seal(message));
    }
    while (const auto job = sessions.next_job(now)) sessions.put(job->session, messages, {}, now);
    std::size_t who = 0;
    Peer to;
    for (Bytes datagram; sessions.seal_due(now + 99ms, to, datagram);) {
      who = to.port;
      const Sealed sealed = std::get<Sealed>(*open_server_envelope(datagram));
      clients[who].arrivals.add(sealed.counter, now + 10ms);
    }
  }
  ASSERT_EQ(sessions.size(), kClients);
  EXPECT_GT(sessions.counters().moved, kClients);
  const std::size_t frame_bytes = kMessages * kMaxMessage_bytes;
  const double per_session =
      static_cast<double>(heap() - before) / kClients - static_cast<double>(frame_bytes);
  std::printf("a session: %zu bytes in place, %.0f bytes in all beyond its frame's %zu\n",
              sizeof(ClientSession), per_session, frame_bytes);
  EXPECT_LT(per_session, 2.0 * kMiB);
  EXPECT_GE(per_session, 0.9 * sizeof(ClientSession)) << "the measurement includes the whole session";
}

}  // namespace
}  // namespace farshade
