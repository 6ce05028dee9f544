/// Attackers on real sockets: strangers at many addresses of 127/8, and an attacker on the path of a good
/// client who reads, delays, changes and repeats its datagrams. Each counts for every datagram how the server
/// must classify it, so that a test can compare the server's counters.
#pragma once

#include <memory>
#include <mutex>
#include <random>
#include <span>
#include <vector>

#include "stereo/net/datagram.h"
#include "stereo/sealing/handshake.h"

namespace farshade {

using Bytes = std::vector<std::byte>;
using Random = std::mt19937_64;

/// Datagrams sent to the server, by the class that the server must count them in.
struct Tally {
  std::uint64_t truncated = 0, magic = 0, version = 0, type = 0, padding = 0;  ///< refusals with these names
  std::uint64_t foreign_version = 0;                                           ///< hellos of another version
  std::uint64_t hellos = 0;  ///< hellos that must not begin a session
  std::uint64_t false_proofs =
      0;  ///< hellos among them with a wrong proof; the cookie is valid unless it is seconds old
  std::uint64_t unknown_session = 0, replayed = 0, forged = 0;  ///< sealed
  std::uint64_t sealed = 0;  ///< sealed datagrams that belong to one of these three

  Tally& operator+=(const Tally& other);
  [[nodiscard]] std::uint64_t sealed_of_any_kind() const {
    return unknown_session + replayed + forged + sealed;
  }
  [[nodiscard]] std::uint64_t total() const {
    return truncated + magic + version + type + padding + foreign_version + hellos + sealed_of_any_kind();
  }
};

/// Whether the server received the counter of a sealed datagram before it receives a changed copy.
enum class Counter : std::uint8_t { New, Repeated };

/// Flips one bit of a sealed datagram.
void flip_a_bit(Bytes& sealed, Counter counter, Random& random, Tally& tally);
/// Truncates a sealed datagram at a random place.
void cut(Bytes& sealed, Counter counter, Random& random, Tally& tally);

/// Receives all datagrams that have arrived at `port`, so that its counters contain them.
void drain(DatagramPort& port);

/// The newest datagrams that a good client sent, for attackers to repeat. Thread-safe.
class Overheard {
 public:
  void add(std::span<const std::byte> datagram);
  /// A random one of them; empty if there is none.
  [[nodiscard]] Bytes any_hello(Random& random) const { return any(hellos_, random); }
  [[nodiscard]] Bytes any_sealed(Random& random) const { return any(sealed_, random); }

 private:
  static constexpr std::size_t kMost = 64;
  [[nodiscard]] Bytes any(const std::vector<Bytes>& of, Random& random) const;

  mutable std::mutex mutex_;
  std::vector<Bytes> hellos_, sealed_;
  std::size_t heard_ = 0;
};

/// A client's port with an attacker on its path. The attacker records everything that the client sends. After
/// attack() it sends changed copies of each sealed datagram before the original, from the client's own
/// address, and the unchanged datagram again after it. It sends some datagrams unchanged from another address
/// first.
class OnPath final : public DatagramPort {
 public:
  OnPath(DatagramPort& inner, Overheard& overheard, std::uint64_t seed);

  void attack() { attacking_ = true; }

  [[nodiscard]] const Tally& tally() const { return tally_; }
  [[nodiscard]] std::uint64_t hellos() const { return hellos_; }  ///< the client's own
  [[nodiscard]] std::uint64_t sealed() const { return sealed_; }  ///< the client's own
  /// The port at the other address. Its counters contain the server's answers to that address.
  [[nodiscard]] DatagramPort& elsewhere() { return *elsewhere_; }

  [[nodiscard]] Peer local() const override { return inner_.local(); }
  bool send(const Peer& to, std::span<const std::byte> bytes) override;
  [[nodiscard]] std::optional<Datagram> receive(std::span<std::byte> into, Duration wait) override {
    return inner_.receive(into, wait);
  }
  void wake() override { inner_.wake(); }
  [[nodiscard]] PortCounters counters() const override { return inner_.counters(); }

 private:
  void send_changed(const Peer& to, std::span<const std::byte> sealed);

  DatagramPort& inner_;
  std::unique_ptr<DatagramPort> elsewhere_;
  Overheard& overheard_;
  Random random_;
  bool attacking_ = false;
  std::uint64_t hellos_ = 0, sealed_ = 0;
  Tally tally_;
};

/// Attackers without a key, whose addresses change.
class Strangers {
 public:
  /// `id` is the key id of the overheard client; it is not secret.
  Strangers(const Peer& server, const KeyId& id, const Overheard& overheard, std::uint64_t seed);

  /// Sends one random datagram from a random address.
  void send_one();

  /// Replaces one address by a new one and gets a cookie for it. The server handles datagrams in order, so it
  /// has then answered everything sent before. Returns false if it does not answer within a minute.
  [[nodiscard]] bool catch_up();

  /// Adds the bytes that `port` sent and received to the sums. Call before a port is closed.
  void settle(const DatagramPort& port);

  [[nodiscard]] const Tally& tally() const { return tally_; }
  [[nodiscard]] std::uint64_t bytes_sent() const { return bytes_sent_; }
  [[nodiscard]] std::uint64_t bytes_got() const { return bytes_got_; }
  [[nodiscard]] std::uint64_t addresses() const { return addresses_; }
  /// Addresses that received more bytes than they sent.
  [[nodiscard]] std::uint64_t amplified() const { return amplified_; }
  /// Datagrams from the server other than Retry, OpenRefusal and NoSession.
  [[nodiscard]] std::uint64_t served() const { return served_; }

 private:
  struct Source {
    std::unique_ptr<DatagramPort> port;
    PublicKey key;
    Cookie cookie{};
  };

  [[nodiscard]] std::unique_ptr<DatagramPort> new_port();
  [[nodiscard]] bool get_cookie(Source& source);
  void take_answers(DatagramPort& port);
  [[nodiscard]] Bytes make(const Source& source);
  [[nodiscard]] Bytes make_hello(const Source& source);
  [[nodiscard]] Bytes make_sealed();
  [[nodiscard]] Bytes make_garbage();
  [[nodiscard]] std::uint64_t below(std::uint64_t bound) { return random_() % bound; }

  Peer server_;
  KeyId id_;
  const Overheard& overheard_;
  Random random_;
  std::vector<Source> sources_;
  std::size_t next_ = 0;
  Tally tally_;
  std::uint64_t bytes_sent_ = 0, bytes_got_ = 0, addresses_ = 0, amplified_ = 0, served_ = 0;
};

}  // namespace farshade
