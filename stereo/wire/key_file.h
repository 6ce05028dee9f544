/// Keys that clients and server share before they meet, and the text files that hold them.
/// One key a line: `farshade-key-1 NAME SECRET`, SECRET as 64 hex digits; blank lines and lines that begin
/// with # say nothing. A client's file has one key; a ring has any number: files put together are a ring.
/// No sentence, log line or KeyId tells anything of a secret.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "stereo/base/expected.h"

namespace farshade {

inline constexpr std::size_t kMaxKeyName = 64;
inline constexpr std::size_t kMaxRingKeys = 4096;
inline constexpr std::size_t kMaxKeyFileBytes = std::size_t{1} << 20;

struct SharedKey {
  std::string name;                          ///< 1 to kMaxKeyName of A-Z a-z 0-9 . _ -
  std::array<std::uint8_t, 32> secret = {};  ///< of full entropy: new_key() makes them
  friend bool operator==(const SharedKey&, const SharedKey&) = default;
};

/// Which key a client means, said in the open.
using KeyId = std::array<std::uint8_t, 8>;

/// The first 8 bytes of keyed BLAKE2b (RFC 7693, libsodium's crypto_generichash) of a fixed label, under the
/// secret. The name has no part in it.
[[nodiscard]] KeyId id_of(const SharedKey& key);

/// A key with a secret from the machine's random source. Refuses a name that is none.
[[nodiscard]] Expected<SharedKey> new_key(std::string_view name);

/// The keys in `text`, in their order. `where` is said in errors, with the number of the line.
/// Refuses a secret of zeros, names and secrets that are there twice, and more than kMaxRingKeys keys or
/// kMaxKeyFileBytes bytes.
[[nodiscard]] Expected<std::vector<SharedKey>> parse_keys(std::string_view text, std::string_view where);

/// The line that parse_keys reads back, with its newline. It holds the secret.
[[nodiscard]] std::string key_line(const SharedKey& key);

/// Of a file with exactly one key. Unreadable if group or others may read or write the file, or if it belongs
/// to neither this user nor root.
[[nodiscard]] Expected<SharedKey> load_key(const std::filesystem::path& path);

/// Of a file with any number of keys; else as load_key.
[[nodiscard]] Expected<std::vector<SharedKey>> load_key_ring(const std::filesystem::path& path);

/// Makes a client's file, of mode 0600, and the folders on its way, of mode 0700.
/// A file that is there stays as it is: Unavailable.
[[nodiscard]] Expected<void> write_key(const std::filesystem::path& path, const SharedKey& key);

/// Adds a key to a ring; one that is not there is made, as by write_key. What the ring said before stays,
/// with its comments. Refuses a name or a secret that it has (Unavailable), and a ring that load_key_ring
/// refuses.
[[nodiscard]] Expected<void> append_to_ring(const std::filesystem::path& path, const SharedKey& key);

/// `client.key` and `ring.keys` in $XDG_CONFIG_HOME/farshade, else in ~/.config/farshade.
[[nodiscard]] std::filesystem::path default_key_path();
[[nodiscard]] std::filesystem::path default_ring_path();

}  // namespace farshade
