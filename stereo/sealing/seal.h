/// Seal: encrypts and authenticates messages with ChaCha20-Poly1305 (RFC 8439, libsodium), and refuses
/// replays. The nonce is a counter that the datagram contains. Each direction of each session has its own
/// key, so no nonce is used twice with one key.
///
/// A key is used for kEpoch_datagrams datagrams and for kEpochTime at most. Then comes the next epoch, whose
/// key is a hash of the last one, which is forgotten. So who takes a key from a program's memory cannot open
/// what was sent in earlier epochs. The keys of later ones follow from it; only a new session protects them.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "stereo/base/clock.h"
#include "stereo/sealing/envelope.h"
#include "stereo/sealing/replay_window.h"

namespace farshade {

/// 32 secret bytes. The destructor overwrites them.
class Secret {
 public:
  Secret() = default;
  explicit Secret(const std::array<std::uint8_t, 32>& bytes) : bytes_(bytes) {}
  Secret(const Secret&) = default;
  Secret& operator=(const Secret&) = default;
  ~Secret();

  [[nodiscard]] const std::uint8_t* data() const { return bytes_.data(); }
  [[nodiscard]] std::uint8_t* data() { return bytes_.data(); }
  static constexpr std::size_t size() { return 32; }
  friend bool operator==(const Secret&, const Secret&) = default;

 private:
  std::array<std::uint8_t, 32> bytes_{};
};

/// Off sends messages without encryption, in datagrams of the same length: to inspect traffic on one machine.
enum class Sealing : std::uint8_t { On, Off };

inline constexpr std::uint64_t kEpoch_datagrams = std::uint64_t{1} << 24;
/// A receiver refuses an epoch further ahead, so that a forged one costs it few hashes. The fastest sender
/// (ReplayWindow::kMostJump) begins six epochs in kSessionTimeout.
inline constexpr std::uint16_t kMostEpochStep = 8;
/// A receiver forgets the key of the last epoch when a counter has opened that is so far beyond the new
/// epoch's first: a datagram that was overtaken by more is lost.
inline constexpr std::uint64_t kEpochGrace = 1024;

/// The key of the epoch after that of `key`: BLAKE2b-256 of a label, keyed with it.
[[nodiscard]] Secret next_key(const Secret& key);

class Sealer {
 public:
  /// `most` is the number of datagrams of an epoch.
  Sealer(SessionId session, const Secret& key, Sealing sealing, ProtocolVersion version = kProtocolVersion,
         std::uint64_t most = kEpoch_datagrams)
      : session_(session), key_(key), sealing_(sealing), version_(version), most_(most) {}

  /// Replaces `datagram` by the sealed `message` (at most kMaxMessage_bytes). Returns its counter: 0, 1, 2,
  /// ...
  std::uint64_t seal(std::span<const std::byte> message, std::vector<std::byte>& datagram);

  /// Leaves out the next counter and returns it.
  std::uint64_t skip() { return next_++; }

  /// Begins the next epoch if this one began longer than kEpochTime before `now`. The first call begins the
  /// time. A session of the last epoch (65,535) keeps its key.
  void renew(Time now);

  [[nodiscard]] std::uint16_t epoch() const { return epoch_; }

 private:
  void begin_epoch();

  SessionId session_;
  Secret key_;
  Sealing sealing_;
  ProtocolVersion version_;
  std::uint64_t most_;
  std::uint64_t next_ = 0;
  std::uint64_t epoch_first_ = 0;  ///< counter with which this epoch began
  std::optional<Time> epoch_began_{};
  std::uint16_t epoch_ = 0;
};

class Opener {
 public:
  Opener(const Secret& key, Sealing sealing) : key_(key), sealing_(sealing) {}

  /// Decrypts `sealed`, read from `datagram`, into `opened` and returns a view of it. Refuses a counter that
  /// or an epoch that is too far beyond the newest one (CounterJump), a counter that was opened before or is
  /// older than the window, an epoch whose key is forgotten (Replayed), and a wrong tag (Forged). After a
  /// refusal window and epoch are unchanged.
  [[nodiscard]] Decoded<std::span<const std::byte>> open(const Sealed& sealed,
                                                         std::span<const std::byte> datagram,
                                                         std::vector<std::byte>& opened);

  [[nodiscard]] const ReplayWindow& window() const { return window_; }

 private:
  Secret key_;                        ///< of the newest epoch that has opened
  std::optional<Secret> last_key_{};  ///< of the epoch before, for kEpochGrace
  Sealing sealing_;
  ReplayWindow window_;
  std::uint16_t epoch_ = 0;
  std::uint64_t epoch_first_ = 0;  ///< counter of its first datagram that opened
};

/// Seals or opens a single message with its own key: the sealed part of an Accept.
[[nodiscard]] std::vector<std::byte> seal_alone(const Secret& key, Sealing sealing,
                                                std::span<const std::byte> message);
[[nodiscard]] bool open_alone(const Secret& key, Sealing sealing, std::span<const std::byte> sealed,
                              std::vector<std::byte>& message);

}  // namespace farshade
