/// Pre-shared keys of clients and servers, and their text files.
/// A file has one key a line: `farshade-key-1 NAME SECRET`, SECRET as 64 hex digits. Behind the secret may
/// stand limits (KeyLimits), each once: `until=2027-01-31`, `sessions=2`, `bytes-per-second=1000000`. Blank
/// lines and lines that begin with # are ignored. A client's file has one key. A server's ring has any
/// number; concatenated key files are a ring. No error text, log line or KeyId reveals anything of a secret.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "stereo/base/expected.h"

namespace farshade {

inline constexpr std::size_t kMaxKeyName = 64;
inline constexpr std::size_t kMaxRingKeys = 4096;
inline constexpr std::size_t kMaxKeyFileBytes = std::size_t{1} << 20;

/// What the holder of a key may have, beside the limits of the server itself. Those in the server's ring
/// count.
struct KeyLimits {
  static constexpr std::uint64_t kMostSessions = 4096;
  static constexpr std::uint64_t kLeastBytesPerSecond = 25'000, kMostBytesPerSecond = 10'000'000'000;

  std::optional<std::chrono::sys_days> until{};     ///< the last day (UTC) on which the key is valid
  std::optional<std::uint64_t> sessions{};          ///< at one time, 1 to kMostSessions
  std::optional<std::uint64_t> bytes_per_second{};  ///< to all its sessions together
  friend bool operator==(const KeyLimits&, const KeyLimits&) = default;
};

/// A day written as 2027-01-31; no value for anything else.
[[nodiscard]] std::optional<std::chrono::sys_days> parse_day(std::string_view text);

/// The destructor overwrites the secret. Copies have secrets of their own.
// With declared copies it would not be an aggregate.
// NOLINTNEXTLINE(cppcoreguidelines-special-member-functions)
struct SharedKey {
  std::string name;                          ///< 1 to kMaxKeyName of A-Z a-z 0-9 . _ -
  std::array<std::uint8_t, 32> secret = {};  ///< 256 random bits, from new_key()
  KeyLimits limits = {};
  ~SharedKey();
  friend bool operator==(const SharedKey&, const SharedKey&) = default;
};

/// Identifies a client's key in the unencrypted part of a Hello.
using KeyId = std::array<std::uint8_t, 8>;

/// The first 8 bytes of keyed BLAKE2b (RFC 7693, libsodium's crypto_generichash) of a fixed label, under the
/// secret. It does not depend on the name.
[[nodiscard]] KeyId id_of(const SharedKey& key);

/// Whether the name follows the rule above and the secret is not zeros.
[[nodiscard]] bool is_sound(const SharedKey& key);

/// Whether the key has not expired.
[[nodiscard]] bool is_valid_on(const SharedKey& key, std::chrono::sys_days day);

using KeyRing = std::map<KeyId, SharedKey>;
[[nodiscard]] KeyRing by_id(const std::vector<SharedKey>& keys);

/// Makes a key with a secret from the system's random source. Refuses an invalid name.
[[nodiscard]] Expected<SharedKey> new_key(std::string_view name);

/// Returns the keys in `text`, in their order. Errors contain `where` and the line number.
/// Refuses a secret of zeros, duplicate names and secrets, and more than kMaxRingKeys keys or
/// kMaxKeyFileBytes bytes.
[[nodiscard]] Expected<std::vector<SharedKey>> parse_keys(std::string_view text, std::string_view where);

/// A line that parse_keys can read, with its newline. It contains the secret.
[[nodiscard]] std::string key_line(const SharedKey& key);

/// Reads a file with exactly one key. Unreadable if group or others may read or write the file, or if it
/// belongs to neither this user nor root.
[[nodiscard]] Expected<SharedKey> load_key(const std::filesystem::path& path);

/// Reads a file with any number of keys; otherwise as load_key.
[[nodiscard]] Expected<std::vector<SharedKey>> load_key_ring(const std::filesystem::path& path);

/// Makes a client's key file with mode 0600, and missing folders with mode 0700.
/// An existing file is an error (Unavailable) and stays unchanged.
[[nodiscard]] Expected<void> write_key(const std::filesystem::path& path, const SharedKey& key);

/// Adds a key to a ring and keeps its other lines, with comments. Programs that add keys at the same time
/// wait for each other. A link stays a link: the file behind it changes. Makes the file as write_key does if
/// it does not exist. Refuses a name or a secret that the ring already has (Unavailable), and a ring that
/// load_key_ring refuses.
[[nodiscard]] Expected<void> append_to_ring(const std::filesystem::path& path, const SharedKey& key);

/// `client.key` and `ring.keys` in $XDG_CONFIG_HOME/farshade, else in ~/.config/farshade.
[[nodiscard]] std::filesystem::path default_key_path();
[[nodiscard]] std::filesystem::path default_ring_path();

}  // namespace farshade
