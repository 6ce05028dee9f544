/// A pairing code: where a server waits for one new client, and a secret that both share only for that. The
/// server shows it as text, the user types or copies it at the client.
/// The text is `farshade://HOST/XXXX-XXXX-XXXX-XXXX-XXXX` or `farshade://HOST:PORT/...`.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "stereo/sealing/key_file.h"

namespace farshade {

/// The TCP port of a code that names none.
inline constexpr std::uint16_t kPairingPort = 7448;

/// Characters of the secret. Each has 5 random bits. 100 bits are more than anybody can try: who has recorded
/// the Hello of a pairing could test guesses without the server.
inline constexpr std::size_t kCodeLength = 20;

struct PairingCode {
  std::string address;                                 ///< HOST, HOST:PORT or [IPv6]:PORT
  std::array<std::uint8_t, kCodeLength> symbols = {};  ///< 0 to 31
  friend bool operator==(const PairingCode&, const PairingCode&) = default;
};

/// A code with symbols from the system's random source.
[[nodiscard]] PairingCode new_pairing_code(std::string address);

/// Digits and capital letters without I, L, O and U (Crockford's base 32).
[[nodiscard]] std::string to_string(const PairingCode& code);

/// Takes small letters, I and L for 1 and O for 0, and a secret without hyphens; `farshade://` may be
/// missing. Malformed otherwise, with a sentence that does not repeat the secret.
[[nodiscard]] Expected<PairingCode> parse_pairing_code(std::string_view text);

/// The key of the one handshake: BLAKE2b-256 of a label and of the symbols.
[[nodiscard]] SharedKey one_time_key(const PairingCode& code);

}  // namespace farshade
