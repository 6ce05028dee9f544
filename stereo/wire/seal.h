/// Seal: messages closed so that only the other side opens them, and nobody changes, forges or repeats them.
/// ChaCha20-Poly1305 (RFC 8439) by libsodium; the nonce is a counter that goes with the datagram, each
/// direction and each session has a key of its own, made anew for every handshake, so no nonce is used twice
/// under a key.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "stereo/wire/envelope.h"
#include "stereo/wire/replay_window.h"

namespace farshade {

/// 32 secret bytes, wiped when they go.
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

/// Off closes nothing, and keeps the datagrams as long as they are: for looking at the wire on one machine.
enum class Sealing : std::uint8_t { On, Off };

class Sealer {
 public:
  Sealer(SessionId session, const Secret& key, Sealing sealing)
      : session_(session), key_(key), sealing_(sealing) {}

  /// Replaces `datagram` by the sealed `message` (at most kMaxMessage_bytes). Returns its counter: 0, 1, 2,
  /// ...
  std::uint64_t seal(std::span<const std::byte> message, std::vector<std::byte>& datagram);

 private:
  SessionId session_;
  Secret key_;
  Sealing sealing_;
  std::uint64_t next_ = 0;
};

class Opener {
 public:
  Opener(const Secret& key, Sealing sealing) : key_(key), sealing_(sealing) {}

  /// The message that `sealed`, read from `datagram`, holds; in `opened`, until the next call. Refuses what
  /// was opened before or has left the window (Replayed) and what does not open (Forged): then nothing has
  /// changed.
  [[nodiscard]] Decoded<std::span<const std::byte>> open(const Sealed& sealed,
                                                         std::span<const std::byte> datagram,
                                                         std::vector<std::byte>& opened);

  [[nodiscard]] const ReplayWindow& window() const { return window_; }

 private:
  Secret key_;
  Sealing sealing_;
  ReplayWindow window_;
};

/// One message under a key of its own: the sealed half of an Accept. `around` are the bytes that it is bound
/// to.
[[nodiscard]] std::vector<std::byte> seal_alone(const Secret& key, Sealing sealing,
                                                std::span<const std::byte> around,
                                                std::span<const std::byte> message);
[[nodiscard]] bool open_alone(const Secret& key, Sealing sealing, std::span<const std::byte> around,
                              std::span<const std::byte> sealed, std::vector<std::byte>& message);

}  // namespace farshade
