/// Attackers over real sockets: strangers at addresses all over 127/8, and somebody on the path of a good
/// client who sees, delays, changes and repeats what it sends. Each knows what the server must make of every
/// datagram of theirs, so that its counters can be held against a tally.
#pragma once

#include <memory>
#include <mutex>
#include <random>
#include <span>
#include <vector>

#include "stereo/net/datagram.h"
#include "stereo/wire/handshake.h"

namespace farshade {

using Bytes = std::vector<std::byte>;
using Random = std::mt19937_64;

/// What was sent to the server, by what has to become of it.
struct Tally {
  std::uint64_t truncated = 0, magic = 0, version = 0, type = 0, padding = 0;  ///< refusals of these names
  std::uint64_t foreign_version = 0;                                           ///< hellos of another version
  std::uint64_t hellos = 0;        ///< of ours, that must not begin a session
  std::uint64_t false_proofs = 0;  ///< of these, with a cookie that holds unless it is seconds old
  std::uint64_t unknown_session = 0, replayed = 0, forged = 0;  ///< sealed
  std::uint64_t sealed = 0;                                     ///< sealed, and one of these three, whichever

  Tally& operator+=(const Tally& other);
  [[nodiscard]] std::uint64_t sealed_of_any_kind() const {
    return unknown_session + replayed + forged + sealed;
  }
  [[nodiscard]] std::uint64_t total() const {
    return truncated + magic + version + type + padding + foreign_version + hellos + sealed_of_any_kind();
  }
};

/// Whether the server has seen the counter of a sealed datagram before a changed copy of it comes.
enum class Counter : std::uint8_t { New, Seen };

/// Flips one bit of a sealed datagram.
void flip_a_bit(Bytes& sealed, Counter counter, Random& random, Tally& tally);
/// Cuts a sealed datagram anywhere.
void cut(Bytes& sealed, Counter counter, Random& random, Tally& tally);

/// Takes in all that has come to `port`, so that its counters tell of it.
void drain(DatagramPort& port);

/// The newest datagrams that a good client has sent, for attackers to repeat. Any thread may call.
class Overheard {
 public:
  void add(std::span<const std::byte> datagram);
  /// Nothing (an empty one) while none was heard.
  [[nodiscard]] Bytes any_hello(Random& random) const { return any(hellos_, random); }
  [[nodiscard]] Bytes any_sealed(Random& random) const { return any(sealed_, random); }

 private:
  static constexpr std::size_t kMost = 64;
  [[nodiscard]] Bytes any(const std::vector<Bytes>& of, Random& random) const;

  mutable std::mutex mutex_;
  std::vector<Bytes> hellos_, sealed_;
  std::size_t heard_ = 0;
};

/// A client's port with somebody on its path, who hears all that it sends, and from attack() on sends changed
/// copies of each sealed datagram before it from the client's own address, some of them whole from elsewhere
/// first, and each once more after it.
class OnPath final : public DatagramPort {
 public:
  OnPath(DatagramPort& inner, Overheard& overheard, std::uint64_t seed);

  void attack() { attacking_ = true; }

  [[nodiscard]] const Tally& tally() const { return tally_; }
  [[nodiscard]] std::uint64_t hellos() const { return hellos_; }  ///< the client's own
  [[nodiscard]] std::uint64_t sealed() const { return sealed_; }  ///< the client's own
  /// Where the datagrams from elsewhere come from; counts what the server answers there.
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

/// Attackers without a key at ever new addresses.
class Strangers {
 public:
  /// `id` is the key that the overheard client means; everybody can read it.
  Strangers(const Peer& server, const KeyId& id, const Overheard& overheard, std::uint64_t seed);

  /// Sends one datagram from any of the addresses.
  void send_one();

  /// One address gives way to a new one, which has got a cookie when this returns. The server takes datagrams
  /// in their order, so it has by then answered all that was sent before. False: it has not, in a minute.
  [[nodiscard]] bool catch_up();

  /// Adds what left `port` and came to it, before the port goes.
  void settle(const DatagramPort& port);

  [[nodiscard]] const Tally& tally() const { return tally_; }
  [[nodiscard]] std::uint64_t bytes_sent() const { return bytes_sent_; }
  [[nodiscard]] std::uint64_t bytes_got() const { return bytes_got_; }
  [[nodiscard]] std::uint64_t addresses() const { return addresses_; }
  /// Addresses at which more bytes came than had left.
  [[nodiscard]] std::uint64_t amplified() const { return amplified_; }
  /// Datagrams from the server other than a retry, an open refusal or that there is no such session.
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
