// Pairing over loopback: the honest way, and attackers who replay, guess, listen, or come too late.
#include "stereo/pair/pairing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <future>
#include <thread>

#include "stereo/net/sealed_stream.h"
#include "tests/unit/scratch_folder.h"

namespace farshade {
namespace {

using namespace std::chrono_literals;

constexpr Peer kLoopback{{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xff, 0xff, 127, 0, 0, 1}, 0, 0};

Waiting for_time(Duration span) {
  return {SteadyClock().now() + span, {}};
}

/// A server that waits for a client with a code, in a thread of its own.
class Waiter {
 public:
  Waiter(std::filesystem::path ring, const PairingLimits& limits = {}, std::optional<PairingCode> same = {}) {
    TcpListener listener = TcpListener::listen(kLoopback).value();
    address_ = listener.local();
    code_ = same ? *same : new_pairing_code("");
    code_.address = to_string(address_);
    result_ = std::async(std::launch::async, [moved = std::move(listener), code = code_, limits,
                                              ring = std::move(ring)]() mutable {
      return wait_for_pairing(
          std::move(moved), code, [&](const SharedKey& key) { return append_to_ring(ring, key); }, limits);
    });
  }

  [[nodiscard]] const PairingCode& code() const { return code_; }
  [[nodiscard]] const Peer& address() const { return address_; }
  [[nodiscard]] Expected<PairedClient> result() { return result_.get(); }
  [[nodiscard]] bool still_waits() const { return result_.wait_for(0s) == std::future_status::timeout; }

 private:
  Peer address_;
  PairingCode code_;
  std::future<Expected<PairedClient>> result_;
};

/// Passes one connection on and keeps all its bytes.
class Listener {
 public:
  explicit Listener(const Peer& server)
      : thread_([this, server] {
          std::optional<TcpStream> client = listener_.accept(for_time(60s));
          Expected<TcpStream> to = connect_tcp(server, for_time(60s));
          std::vector<std::byte> buffer(4096);
          for (bool open = client && to; open;) {
            open = pass(*client, *to, from_client, buffer) && pass(*to, *client, from_server, buffer);
          }
        }) {}

  [[nodiscard]] Peer address() const { return listener_.local(); }
  void join() { thread_.join(); }

  std::vector<std::byte> from_client, from_server;  ///< valid after join()

 private:
  /// False if one of both sides has closed.
  static bool pass(TcpStream& from, TcpStream& to, std::vector<std::byte>& kept,
                   std::vector<std::byte>& buffer) {
    const Time until = SteadyClock().now() + 2ms;
    const auto got = from.read_some(buffer, {until});
    if (!got) return SteadyClock().now() >= until;
    kept.insert(kept.end(), buffer.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(*got));
    return to.write(std::span(buffer).first(*got), for_time(60s)).has_value();
  }

  TcpListener listener_ = TcpListener::listen(kLoopback).value();
  std::jthread thread_;
};

bool contains(const std::vector<std::byte>& bytes, std::span<const std::byte> part) {
  return std::search(bytes.begin(), bytes.end(), part.begin(), part.end()) != bytes.end();
}

class Pairing : public testing::Test {
 protected:
  [[nodiscard]] std::filesystem::path ring() const { return folder_.path() / "ring.keys"; }
  [[nodiscard]] std::vector<SharedKey> keys() const {
    return load_key_ring(ring()).value_or(std::vector<SharedKey>{});
  }
  [[nodiscard]] Expected<void> pair_as(const SharedKey& key, const PairingCode& code) const {
    return pair_with(code, key, for_time(60s));
  }

  ScratchFolder folder_;
  SharedKey key_ = new_key("desk").value();
};

TEST_F(Pairing, BringsTheClientsKeyToTheRingAndClosesThePort) {
  Waiter server(ring());
  const Expected<void> paired = pair_as(key_, server.code());
  ASSERT_TRUE(paired) << paired.error().what;
  const Expected<PairedClient> result = server.result();
  ASSERT_TRUE(result) << result.error().what;
  EXPECT_EQ(result->key, key_);
  EXPECT_TRUE(is_loopback(result->client));
  EXPECT_EQ(keys(), std::vector{key_});
}

TEST_F(Pairing, ACodeWorksOnce) {
  Waiter server(ring());
  ASSERT_TRUE(pair_as(key_, server.code()));
  ASSERT_TRUE(server.result());
  const Expected<void> again = pair_as(new_key("thief").value(), server.code());
  ASSERT_FALSE(again);
  EXPECT_EQ(again.error().fault, Fault::Missing);
  EXPECT_NE(again.error().what.find("Start rt_server pair again"), std::string::npos) << again.error().what;
  EXPECT_EQ(keys(), std::vector{key_});
}

TEST_F(Pairing, ACodeExpires) {
  Waiter server(ring(), {.life = 20ms});
  const Expected<PairedClient> result = server.result();
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().fault, Fault::Missing);
  EXPECT_EQ(pair_as(key_, server.code()).error().fault, Fault::Missing);
  EXPECT_TRUE(keys().empty());
}

TEST_F(Pairing, AConnectionThatWasOpenWhenTheCodeExpiredIsTooLate) {
  // A slow machine may connect after a short life of the code.
  for (Duration life = 200ms; life < 20s; life *= 2) {
    Waiter server(ring(), {.life = life, .patience = 60s});
    Expected<TcpStream> stream = connect_tcp(server.address(), for_time(60s));
    EXPECT_EQ(server.result().error().fault, Fault::Missing) << "the patience ends with the code";
    if (!stream) continue;
    EXPECT_FALSE(SealedStream::connect(*std::move(stream), StreamPurpose::Pairing,
                                       one_time_key(server.code()), for_time(60s)));
    return;
  }
  FAIL() << "no code lived until the connection";
}

TEST_F(Pairing, WrongCodesAreRefusedAndTooManyEndThePairing) {
  Waiter server(ring(), {.life = 60s, .guesses = 3});
  for (std::size_t guess = 0; guess < 3; ++guess) {
    EXPECT_TRUE(server.still_waits());
    PairingCode wrong = server.code();
    wrong.symbols[19 - guess] ^= 1;
    const Expected<void> paired = pair_as(key_, wrong);
    ASSERT_FALSE(paired);
    EXPECT_EQ(paired.error().fault, Fault::Mismatch);
    EXPECT_NE(paired.error().what.find("mistyped"), std::string::npos) << paired.error().what;
  }
  const Expected<PairedClient> result = server.result();
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().fault, Fault::Mismatch);
  EXPECT_EQ(pair_as(key_, server.code()).error().fault, Fault::Missing) << "the right code is of no use now";
  EXPECT_TRUE(keys().empty());
}

TEST_F(Pairing, FewWrongCodesDoNotKeepTheRightOneOut) {
  Waiter server(ring(), {.life = 60s, .guesses = 3});
  PairingCode wrong = server.code();
  wrong.symbols[0] ^= 1;
  for (int guess = 0; guess < 2; ++guess) EXPECT_FALSE(pair_as(key_, wrong));
  EXPECT_TRUE(pair_as(key_, server.code()));
  EXPECT_TRUE(server.result());
}

TEST_F(Pairing, WhoHearsEverythingLearnsNoKey) {
  Waiter server(ring());
  Listener between(server.address());
  PairingCode code = server.code();
  code.address = to_string(between.address());
  ASSERT_TRUE(pair_as(key_, code));
  ASSERT_TRUE(server.result());
  between.join();
  const SharedKey once = one_time_key(code);
  const KeyId id = id_of(key_);
  for (const auto* heard : {&between.from_client, &between.from_server}) {
    EXPECT_GT(heard->size(), 50u);
    EXPECT_FALSE(contains(*heard, std::as_bytes(std::span(key_.secret))));
    EXPECT_FALSE(contains(*heard, std::as_bytes(std::span(key_.name))));
    EXPECT_FALSE(contains(*heard, std::as_bytes(std::span(id))));
    EXPECT_FALSE(contains(*heard, std::as_bytes(std::span(once.secret))));
    EXPECT_FALSE(contains(*heard, std::as_bytes(std::span(code.symbols))));
  }
}

TEST_F(Pairing, AReplayedPairingAddsNothingEvenWhereTheCodeStillHolds) {
  std::vector<std::byte> heard;
  PairingCode code;
  {
    Waiter server(ring());
    Listener between(server.address());
    code = server.code();
    code.address = to_string(between.address());
    ASSERT_TRUE(pair_as(key_, code));
    ASSERT_TRUE(server.result());
    between.join();
    heard = between.from_client;
  }
  // A server that still waits with the same code, and an empty ring: only the attacker's bytes are old.
  const std::filesystem::path other = folder_.path() / "other.keys";
  Waiter server(other, {.patience = 2s}, code);
  for (int time = 0; time < 3; ++time) {
    TcpStream stream = connect_tcp(server.address(), for_time(60s)).value();
    ASSERT_TRUE(stream.write(heard, for_time(60s)));
    std::vector<std::byte> answer(4096);
    while (stream.read_some(answer, for_time(60s))) {
    }
  }
  EXPECT_TRUE(server.still_waits());
  EXPECT_FALSE(std::filesystem::exists(other));
  const SharedKey honest = new_key("honest").value();
  EXPECT_TRUE(pair_as(honest, server.code())) << "replays do not keep the client out";
  EXPECT_EQ(server.result().value().key, honest);
  EXPECT_EQ(load_key_ring(other).value(), std::vector{honest});
}

TEST_F(Pairing, AServerWithoutTheCodeGetsNothingButAHello) {
  TcpListener listener = TcpListener::listen(kLoopback).value();
  PairingCode code = new_pairing_code(to_string(listener.local()));
  std::size_t heard = 0;
  std::jthread impostor([&] {
    std::optional<TcpStream> stream = listener.accept(for_time(60s));
    const SharedKey own = new_key("own").value();
    std::vector<std::byte> buffer(4096), accepted;
    while (heard < 2 + 1200) {
      const auto got = stream->read_some(std::span(buffer).subspan(heard), for_time(60s));
      if (!got) return;
      heard += *got;
    }
    const std::span<const std::byte> hello = std::span(buffer).subspan(2, 1200);
    const auto envelope = open_client_envelope(hello).value();
    accepted = accept(std::get<Hello>(envelope), hello, own, Welcome{}).value().datagram;
    accepted.insert(accepted.begin(), {static_cast<std::byte>(accepted.size()), std::byte{0}});
    static_cast<void>(stream->write(accepted, for_time(60s)));
    while (const auto more = stream->read_some(buffer, for_time(60s))) heard += *more;
  });
  const Expected<void> paired = pair_as(key_, code);
  impostor.join();
  ASSERT_FALSE(paired);
  EXPECT_EQ(paired.error().fault, Fault::Malformed);
  EXPECT_EQ(heard, 2u + 1200u);
}

TEST_F(Pairing, AHelloOfAnotherPurposeIsOfNoUse) {
  Waiter server(ring(), {.patience = 2s});
  const auto connected =
      SealedStream::connect(connect_tcp(server.address(), for_time(60s)).value(), StreamPurpose::SceneFetch,
                            one_time_key(server.code()), for_time(60s));
  EXPECT_FALSE(connected);
  EXPECT_TRUE(pair_as(key_, server.code()));
  EXPECT_TRUE(server.result());
}

TEST_F(Pairing, AStrangerWhoSaysNothingDelaysTheClientOnly) {
  Waiter server(ring(), {.patience = 1s});
  std::vector<TcpStream> silent;
  for (int i = 0; i < 2; ++i) silent.push_back(connect_tcp(server.address(), for_time(60s)).value());
  EXPECT_TRUE(pair_as(key_, server.code()));
  EXPECT_TRUE(server.result());
}

TEST_F(Pairing, ANameThatTheRingHasLeavesTheCodeUsable) {
  ASSERT_TRUE(append_to_ring(ring(), new_key("desk").value()));
  Waiter server(ring());
  const Expected<void> paired = pair_as(key_, server.code());
  ASSERT_FALSE(paired);
  EXPECT_EQ(paired.error().fault, Fault::Unavailable);
  EXPECT_NE(paired.error().what.find("--name"), std::string::npos) << paired.error().what;
  EXPECT_TRUE(pair_as(new_key("desk2").value(), server.code()));
  EXPECT_EQ(server.result().value().key.name, "desk2");
  EXPECT_EQ(keys().size(), 2u);
}

TEST_F(Pairing, ARingThatCannotBeWrittenIsToldOnBothSides) {
  Waiter server(folder_.path());  // a folder is no ring
  EXPECT_EQ(pair_as(key_, server.code()).error().fault, Fault::Unreadable);
  EXPECT_FALSE(server.result());
}

}  // namespace
}  // namespace farshade
