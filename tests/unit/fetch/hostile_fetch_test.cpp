// A hostile server against the client's fetch, and hostile clients against the sender.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <atomic>
#include <future>

#include "stereo/messages/fetch_messages.h"
#include "tests/unit/fetch/fetch_bench.h"

namespace farshade {
namespace {

using namespace std::chrono_literals;

constexpr Duration kPatience = 60s;  // not reached if both sides do what a test expects

Waiting for_time(Duration span) {
  return {SteadyClock().now() + span, {}};
}
Waiting patiently() {
  return for_time(kPatience);
}

/// A server that has the key and says what a test wants.
class HostileServer {
 public:
  using Say = std::function<void(SealedStream&, const FetchRequest&)>;
  HostileServer(const SharedKey& key, Say say)
      : thread_([this, key, say = std::move(say)](const std::stop_token& stop) {
          while (!stop.stop_requested()) {
            auto tcp = listener_.accept(for_time(50ms));
            if (!tcp) continue;
            auto connected = SealedStream::admit(*std::move(tcp), StreamPurpose::SceneFetch,
                                                 {{id_of(key), key}}, Welcome{.light_count = 1}, until(stop));
            while (connected && !stop.stop_requested()) {
              const auto message = connected->receive(until(stop));
              const auto request = message ? decode_fetch_request(*message) : refuse(WireRefusal::Truncated);
              if (!request) break;
              say(*connected, *request);
              if (!connected->flush(until(stop))) break;
            }
          }
        }) {}

  [[nodiscard]] Peer address() const { return listener_.local(); }

 private:
  static Waiting until(const std::stop_token& stop) {
    return {patiently().until, [&stop] { return stop.stop_requested(); }};
  }

  TcpListener listener_ = TcpListener::listen(loopback()).value();
  std::jthread thread_;
};

void say(SealedStream& stream, const FetchAnswer& answer) {
  std::vector<std::byte> message;
  encode(answer, message);
  stream.add(message);
}

const std::string kHonest = "honest bytes";
SceneOffer honest_offer() {
  SceneOffer offer;
  offer.files = {{"a.glb", kHonest.size(), digest_of(std::as_bytes(std::span(kHonest)))}};
  return offer;
}

void say_offer(SealedStream& stream) {
  say(stream, OfferPart{OfferPart::More::No, encode(honest_offer())});
}

/// Waits until `holds` returns true. False: it did not within kPatience.
bool comes_true(const std::function<bool()>& holds) {
  for (const Stopwatch waited; waited.elapsed() < kPatience; std::this_thread::yield())
    if (holds()) return true;
  return false;
}

class HostileFetchTest : public FetchTest {
 protected:
  /// The error of a fetch from a server that offers a sound scene, and then sends what `content` says.
  /// A fetch whose patience was over fails with Missing, so every other fault came before that.
  Error error_after(std::function<void(SealedStream&, std::uint64_t begin)> content,
                    Duration patience = kPatience) {
    const HostileServer server(key_, [&](SealedStream& stream, const FetchRequest& request) {
      if (const auto* range = std::get_if<ContentRequest>(&request))
        content(stream, range->begin);
      else
        say_offer(stream);
    });
    return error_from(server, patience);
  }
  Error error_from(const HostileServer& server, Duration patience = kPatience) {
    FetchPlan wanted = plan();
    wanted.servers = {server.address()};
    wanted.patience = patience;
    const Expected<FetchedScene> fetched = fetch_scene(wanted);
    return fetched ? Error{} : fetched.error();
  }
};

TEST_F(HostileFetchTest, OtherBytesThanAskedForAreRefused) {
  const std::vector<std::byte> bytes(8);
  // All of the honest content, so that a client that stored it would have the scene.
  const auto honest = std::as_bytes(std::span(kHonest));
  const std::vector<std::byte> all(honest.begin(), honest.end());
  EXPECT_EQ(error_after([&](auto& stream, std::uint64_t at) {
              say(stream, Content{at + 1, all});
            }).fault,
            Fault::Malformed);
  EXPECT_EQ(error_after([&](auto& stream, std::uint64_t at) {
              say(stream, Content{at, bytes});
              say(stream, Content{at + 8, bytes});  // 16 of 12 bytes
            }).fault,
            Fault::Malformed);
  EXPECT_EQ(error_after([&](auto& stream, std::uint64_t) { say_offer(stream); }).fault, Fault::Malformed);
}

TEST_F(HostileFetchTest, AWrongHashIsRefused) {
  const Error error = error_after([&](auto& stream, std::uint64_t at) {
    say(stream, Content{at, std::vector<std::byte>(kHonest.size())});
  });
  EXPECT_EQ(error.fault, Fault::Mismatch);
  EXPECT_NE(error.what.find("'a.glb' does not have the hash"), std::string::npos) << error.what;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder_.path() / "cache"))
    EXPECT_TRUE(entry.is_directory() || entry.path().extension() == ".lock") << entry.path();
}

TEST_F(HostileFetchTest, AServerThatDripsOrFallsSilentEndsTheFetch) {
  // The client gives up in the midst of the drops: each comes in a third of its patience, and no drop buys
  // time.
  constexpr Duration kShort = 600ms;
  std::atomic<std::size_t> drops = 0;
  const auto drip = [&](SealedStream& stream, std::uint64_t at) {
    for (std::uint64_t i = at; i + 1 < kHonest.size(); ++i) {
      say(stream, Content{i, std::as_bytes(std::span(kHonest)).subspan(i, 1)});
      if (!stream.flush(patiently())) return;
      ++drops;
      std::this_thread::sleep_for(kShort / 3);
    }
  };
  const Error dripped = error_after(drip, kShort);
  EXPECT_EQ(dripped.fault, Fault::Missing);
  EXPECT_NE(dripped.what.find("less than 20000 bytes"), std::string::npos) << dripped.what;
  EXPECT_LT(drops, kHonest.size() - 1);
  EXPECT_EQ(error_after([](auto&, std::uint64_t) {}, kShort).fault, Fault::Missing);
}

TEST_F(HostileFetchTest, AnEndlessOfferIsRefused) {
  const HostileServer server(key_, [&](SealedStream& stream, const FetchRequest&) {
    const std::vector<std::byte> part(kMaxOfferPart_bytes);
    for (std::size_t i = 0; i < 2 * kMostOffer_bytes / part.size(); ++i)
      say(stream, OfferPart{OfferPart::More::Yes, part});
  });
  EXPECT_EQ(error_from(server).fault, Fault::Malformed);
}

TEST_F(HostileFetchTest, OnlyAClientWithItsKeyGetsBytesAndNoHelloOfUdpHelps) {
  write({{"a.glb", 1000}});
  serve({.first_message = 300ms});
  const auto answer_to = [&](const ContentHash& scene) {
    auto tcp = connect_tcp(server_, patiently()).value();
    std::vector<std::byte> hello, framed{std::byte{0xb0}, std::byte{0x04}};  // 1200
    ClientHandshake(key_, scene).write_hello(hello);
    framed.insert(framed.end(), hello.begin(), hello.end());
    EXPECT_TRUE(tcp.write(framed, patiently()));
    std::array<std::byte, 4096> buffer;
    std::size_t got = 0;
    while (const auto more = tcp.read_some(buffer, patiently())) got += *more;
    return got;
  };
  EXPECT_EQ(answer_to({1, 2, 3}), 0u) << "a hello that was recorded from UDP";
  // A recorded hello of this transport gets an Accept, but its sender cannot seal a request.
  EXPECT_LT(answer_to(hello_of(StreamPurpose::SceneFetch)), 200u);
  EXPECT_TRUE(comes_true([&] { return sender_->counters().unproved == 2; }));
  EXPECT_EQ(sender_->counters().sent_bytes, 0u);
}

TEST_F(HostileFetchTest, ManyStrangersDoNotKeepAClientOut) {
  write({{"a.glb", 50'000}});
  serve({.first_message = kPatience, .between_accepts = 1ms});
  std::vector<TcpStream> strangers;
  for (int i = 0; i < 12; ++i) strangers.push_back(connect_tcp(server_, patiently()).value());
  // Four wait from this address for their first message; the others were closed. Those of another address
  // would push the oldest out.
  EXPECT_TRUE(comes_true([&] { return sender_->counters().accepted == 12; }));
  EXPECT_EQ(sender_->counters().dropped, 8u);
  // A client of the same address is closed at once, too. It says so and tries again until there is room.
  FetchPlan waits = plan();
  std::string note;
  waits.note = [&](const std::string& said) {
    note = said;
    strangers.clear();
  };
  const Expected<FetchedScene> fetched = fetch_scene(waits);
  EXPECT_NE(note.find("trying again for 60 s"), std::string::npos) << note;
  ASSERT_TRUE(fetched.has_value()) << fetched.error().what;
  expect_equal_files(*fetched);
}

TEST_F(HostileFetchTest, StrangersAreTakenOneAfterTheOther) {
  write({{"a.glb", 50}});
  serve({.between_accepts = 300ms});
  const Stopwatch watch;
  const auto one = connect_tcp(server_, patiently()), two = connect_tcp(server_, patiently());
  EXPECT_TRUE(comes_true([&] { return sender_->counters().accepted == 2; }));
  EXPECT_GE(watch.elapsed(), 300ms);
}

TEST_F(HostileFetchTest, AStrangerTooManyEndsTheOldest) {
  write({{"a.glb", 50}});
  serve({.strangers = 2, .strangers_of_network = 8, .first_message = 10min, .between_accepts = 1ms});
  std::vector<TcpStream> strangers;
  for (std::uint64_t i = 1; i <= 3; ++i) {
    strangers.push_back(connect_tcp(server_, patiently()).value());
    ASSERT_TRUE(comes_true([&] { return sender_->counters().accepted == i; }));
  }
  std::array<std::byte, 16> buffer;
  const Stopwatch watch;
  EXPECT_FALSE(strangers[0].read_some(buffer, patiently()));
  EXPECT_LT(watch.elapsed(), kPatience) << "it was closed";
  for (const std::size_t kept : {std::size_t{1}, std::size_t{2}}) {
    const Stopwatch waited;
    EXPECT_FALSE(strangers[kept].read_some(buffer, for_time(100ms)));
    EXPECT_GE(waited.elapsed(), 100ms) << kept;
  }
  EXPECT_EQ(sender_->counters().dropped, 1u);
}

/// What is sent to new clients takes nothing from those that need masks.
TEST_F(HostileFetchTest, TheSendersThreadsLeaveOthersTheProcessor) {
  if (getpriority(PRIO_PROCESS, 0) >= 10) GTEST_SKIP() << "this program itself has a low priority";
  write({{"a.glb", 50}});
  serve();
  ASSERT_TRUE(fetch_scene(plan()));
  std::size_t nice = 0;
  for (const auto& task : std::filesystem::directory_iterator("/proc/self/task")) {
    const int id = std::stoi(task.path().filename());
    if (getpriority(PRIO_PROCESS, static_cast<id_t>(id)) == 10) ++nice;
  }
  EXPECT_GE(nice, 1u);
  EXPECT_LT(getpriority(PRIO_PROCESS, 0), 10);
}

TEST_F(HostileFetchTest, ManyConnectionsOfOneKeyAreBusyAndSlowReadersEnd) {
  write({{"a.glb", 30'000'000}});
  serve({.of_one_key = 2, .silence = 2s, .bytes_per_second = 1e9});
  std::vector<SealedStream> greedy;
  std::vector<std::optional<FetchRefusal>> refusals;
  std::vector<std::byte> request;
  encode(FetchRequest(ContentRequest{0, 30'000'000}), request);
  for (int i = 0; i < 3; ++i) {
    auto connected = SealedStream::connect(connect_tcp(server_, patiently()).value(),
                                           StreamPurpose::SceneFetch, key_, patiently());
    ASSERT_TRUE(connected.has_value()) << connected.error().what;
    connected->add(request);
    ASSERT_TRUE(connected->flush(patiently()));
    const auto answer = connected->receive(patiently());
    ASSERT_TRUE(answer.has_value()) << answer.error().what;
    const FetchAnswer decoded = decode_fetch_answer(*answer).value();
    const auto* refusal = std::get_if<FetchRefusal>(&decoded);
    refusals.push_back(refusal == nullptr ? std::nullopt : std::optional(*refusal));
    greedy.push_back(*std::move(connected));
  }
  EXPECT_FALSE(refusals[0]);
  EXPECT_FALSE(refusals[1]);
  EXPECT_EQ(refusals[2], FetchRefusal::Busy);
  // The first two read no more. They are ended, so another client of the key gets its turn.
  const Expected<FetchedScene> fetched = fetch_scene(plan());
  ASSERT_TRUE(fetched.has_value()) << fetched.error().what;
  EXPECT_GE(sender_->counters().busy, 1u);
}

}  // namespace
}  // namespace farshade
