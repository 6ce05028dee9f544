/// The two messages of a pairing, sealed (sealed_stream.h). A decoder refuses every other byte string.
#pragma once

#include <span>
#include <vector>

#include "stereo/messages/refusal.h"
#include "stereo/sealing/key_file.h"

namespace farshade {

enum class PairingAnswer : std::uint8_t {
  Added = 1,      ///< the ring has the key
  Taken = 2,      ///< the ring has a key with this name or this secret already
  NotWritten = 3  ///< the ring cannot be written
};

/// Client -> server: the client's own key, for the server's ring.
[[nodiscard]] std::vector<std::byte> encode_pairing_request(const SharedKey& key);
[[nodiscard]] Decoded<SharedKey> decode_pairing_request(std::span<const std::byte> bytes);

/// Server -> client.
[[nodiscard]] std::vector<std::byte> encode(PairingAnswer answer);
[[nodiscard]] Decoded<PairingAnswer> decode_pairing_answer(std::span<const std::byte> bytes);

}  // namespace farshade
