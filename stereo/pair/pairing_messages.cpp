#include "stereo/pair/pairing_messages.h"

#include "stereo/messages/bytes.h"

namespace farshade {
namespace {

enum class PairingType : std::uint8_t { Request = 1, Answer = 16 };

}  // namespace

std::vector<std::byte> encode_pairing_request(const SharedKey& key) {
  std::vector<std::byte> bytes;
  ByteWriter io(bytes);
  io.code(PairingType::Request);
  io.array(key.secret);
  io.rest(std::as_bytes(std::span(key.name)));
  return bytes;
}

Decoded<SharedKey> decode_pairing_request(std::span<const std::byte> bytes) {
  ByteReader io(bytes);
  PairingType type{};
  if (!io.code(type)) return refuse(WireRefusal::Truncated);
  if (type != PairingType::Request) return refuse(WireRefusal::Type);
  SharedKey key;
  std::span<const std::byte> name;
  if (!io.array(key.secret) || !io.rest(name)) return refuse(WireRefusal::Truncated);
  key.name.assign(reinterpret_cast<const char*>(name.data()), name.size());
  if (!is_sound(key)) return refuse(WireRefusal::Code);
  return key;
}

std::vector<std::byte> encode(PairingAnswer answer) {
  std::vector<std::byte> bytes;
  ByteWriter io(bytes);
  io.code(PairingType::Answer);
  io.code(answer);
  return bytes;
}

Decoded<PairingAnswer> decode_pairing_answer(std::span<const std::byte> bytes) {
  ByteReader io(bytes);
  PairingType type{};
  PairingAnswer answer{};
  if (!io.code(type)) return refuse(WireRefusal::Truncated);
  if (type != PairingType::Answer) return refuse(WireRefusal::Type);
  if (!io.code(answer)) return refuse(WireRefusal::Truncated);
  if (answer < PairingAnswer::Added || answer > PairingAnswer::NotWritten) return refuse(WireRefusal::Code);
  if (io.remaining() > 0) return refuse(WireRefusal::TrailingBytes);
  return answer;
}

}  // namespace farshade
