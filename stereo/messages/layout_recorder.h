/// LayoutRecorder: which fields messages have, as a hash. The same field lists that write and read messages
/// fill it (stereo/sealing/layout.h).
#pragma once

#include <array>
#include <concepts>
#include <cstdint>
#include <span>

#include "stereo/base/clock.h"
#include "stereo/messages/bytes.h"

namespace farshade {

/// Has the functions of a ByteReader, but reads no bytes: it hashes which fields a field list has. All bits
/// of the integers that it gives are set, so that lists have elements and optional fields are there.
class LayoutRecorder : public VersionedFields {
 public:
  using VersionedFields::VersionedFields;

  bool u8(std::integral auto& value) { return integer<std::uint8_t>(value); }
  bool u16(std::integral auto& value) { return integer<std::uint16_t>(value); }
  bool u32(std::integral auto& value) { return integer<std::uint32_t>(value); }
  bool u64(std::uint64_t& value) { return integer<std::uint64_t>(value); }
  bool f64(double&) { return field('f', 8); }
  bool ns(auto&) { return field('t', 8); }
  bool code(auto&) { return field('c', 1); }
  template <std::size_t N>
  bool array(std::array<std::uint8_t, N>&) {
    return field('a', N);
  }
  bool rest(std::span<const std::byte>&) { return field('r', 0); }

  /// The next fields are those of this type of envelope or message.
  void type(std::uint8_t number) { field('m', number); }

  /// Of all fields so far: 10 bits.
  [[nodiscard]] unsigned hash() const { return (hash_ ^ hash_ >> 10 ^ hash_ >> 20) & 0x3ff; }

 private:
  template <std::unsigned_integral Wire, std::integral Value>
  bool integer(Value& value) {
    value = static_cast<Value>(static_cast<Wire>(~Wire{0}));
    return field('u', sizeof(Wire));
  }
  /// FNV-1a.
  bool field(char kind, std::size_t size) {
    for (const std::size_t next : {static_cast<std::size_t>(kind), size})
      hash_ = (hash_ ^ static_cast<std::uint32_t>(next)) * 0x01000193u;
    return true;
  }

  std::uint32_t hash_ = 0x811c9dc5u;
};

void record_messages(LayoutRecorder& io);
void record_fetch_messages(LayoutRecorder& io);

}  // namespace farshade
