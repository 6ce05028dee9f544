/// Seal: encrypts and authenticates messages with ChaCha20-Poly1305 (RFC 8439, libsodium), and refuses
/// replays. The nonce is a counter that the datagram contains. Each direction of each session has its own
/// key, so no nonce is used twice with one key.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "stereo/wire/envelope.h"
#include "stereo/wire/replay_window.h"

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

class Sealer {
 public:
  Sealer(SessionId session, const Secret& key, Sealing sealing)
      : session_(session), key_(key), sealing_(sealing) {}

  /// Replaces `datagram` by the sealed `message` (at most kMaxMessage_bytes). Returns its counter: 0, 1, 2,
  /// ...
  std::uint64_t seal(std::span<const std::byte> message, std::vector<std::byte>& datagram);

  /// Leaves out the next counter and returns it.
  std::uint64_t skip() { return next_++; }

 private:
  SessionId session_;
  Secret key_;
  Sealing sealing_;
  std::uint64_t next_ = 0;
};

class Opener {
 public:
  Opener(const Secret& key, Sealing sealing) : key_(key), sealing_(sealing) {}

  /// Decrypts `sealed`, read from `datagram`, into `opened` and returns a view of it. Refuses a counter that
  /// is too far beyond the newest one (CounterJump), was opened before or is older than the window
  /// (Replayed), and a wrong tag (Forged). After a refusal the window is unchanged.
  [[nodiscard]] Decoded<std::span<const std::byte>> open(const Sealed& sealed,
                                                         std::span<const std::byte> datagram,
                                                         std::vector<std::byte>& opened);

  [[nodiscard]] const ReplayWindow& window() const { return window_; }

 private:
  Secret key_;
  Sealing sealing_;
  ReplayWindow window_;
};

/// Seals or opens a single message with its own key: the sealed part of an Accept.
[[nodiscard]] std::vector<std::byte> seal_alone(const Secret& key, Sealing sealing,
                                                std::span<const std::byte> message);
[[nodiscard]] bool open_alone(const Secret& key, Sealing sealing, std::span<const std::byte> sealed,
                              std::vector<std::byte>& message);

}  // namespace farshade
