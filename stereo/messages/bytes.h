/// Writes and reads little-endian fields. ByteWriter and ByteReader have the same functions, so that one
/// `fields(io, message)` is both the encoder and the decoder of a message.
#pragma once

#include <array>
#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "stereo/base/check.h"
#include "stereo/base/clock.h"
#include "stereo/messages/version.h"

namespace farshade {

/// Fields that not every version of the protocol has: `!io.since(12) || io.u8(message.field)`.
class VersionedFields {
 public:
  explicit VersionedFields(ProtocolVersion version = kProtocolVersion) : number_(number_of(version)) {}

  /// The fields are those of protocol number `number` or of a later one.
  [[nodiscard]] bool since(unsigned number) const { return number_ >= number; }

 private:
  unsigned number_;
};

/// Appends to `out`, which it does not own. Never fails: a value that does not fit its field fails a check.
class ByteWriter : public VersionedFields {
 public:
  explicit ByteWriter(std::vector<std::byte>& out, ProtocolVersion version = kProtocolVersion)
      : VersionedFields(version), out_(out) {}

  bool u8(std::integral auto value) { return put<std::uint8_t>(value); }
  bool u16(std::integral auto value) { return put<std::uint16_t>(value); }
  bool u32(std::integral auto value) { return put<std::uint32_t>(value); }
  bool u64(std::uint64_t value) { return put<std::uint64_t>(value); }
  bool f64(double value) { return u64(std::bit_cast<std::uint64_t>(value)); }
  bool ns(Duration value) { return u64(static_cast<std::uint64_t>(value.count())); }
  bool ns(Time value) { return ns(value.time_since_epoch()); }

  /// An enum of underlying type std::uint8_t.
  template <class Enum>
  bool code(Enum value) {
    return u8(static_cast<std::uint8_t>(value));
  }

  template <std::size_t N>
  bool array(const std::array<std::uint8_t, N>& bytes) {
    return rest(std::as_bytes(std::span(bytes)));
  }

  /// The last field: all bytes that remain.
  bool rest(std::span<const std::byte> bytes) {
    out_.insert(out_.end(), bytes.begin(), bytes.end());
    return true;
  }

 private:
  template <std::unsigned_integral Wire>
  bool put(std::integral auto value) {
    const Wire wire = narrow<Wire>(value);
    for (std::size_t i = 0; i < sizeof(Wire); ++i)
      out_.push_back(static_cast<std::byte>(wire >> (8 * i) & 0xff));
    return true;
  }

  std::vector<std::byte>& out_;
};

/// Reads foreign bytes. A read beyond the end returns false and changes nothing. Allocates nothing.
class ByteReader : public VersionedFields {
 public:
  explicit ByteReader(std::span<const std::byte> bytes, ProtocolVersion version = kProtocolVersion)
      : VersionedFields(version), bytes_(bytes) {}

  [[nodiscard]] std::size_t remaining() const { return bytes_.size(); }

  bool u8(std::integral auto& value) { return get<std::uint8_t>(value); }
  bool u16(std::integral auto& value) { return get<std::uint16_t>(value); }
  bool u32(std::integral auto& value) { return get<std::uint32_t>(value); }
  bool u64(std::uint64_t& value) { return get<std::uint64_t>(value); }
  bool f64(double& value) {
    std::uint64_t bits = 0;
    if (!u64(bits)) return false;
    value = std::bit_cast<double>(bits);
    return true;
  }
  bool ns(Duration& value) {
    std::uint64_t count = 0;
    if (!u64(count)) return false;
    value = Duration(static_cast<std::int64_t>(count));
    return true;
  }
  bool ns(Time& value) {
    Duration since_epoch{};
    if (!ns(since_epoch)) return false;
    value = Time(since_epoch);
    return true;
  }

  /// `value` may become a number that Enum does not name; the caller checks its range afterwards.
  template <class Enum>
  bool code(Enum& value) {
    std::uint8_t byte = 0;
    if (!u8(byte)) return false;
    value = static_cast<Enum>(byte);
    return true;
  }

  template <std::size_t N>
  bool array(std::array<std::uint8_t, N>& bytes) {
    if (remaining() < N) return false;
    for (std::uint8_t& byte : bytes) u8(byte);
    return true;
  }

  /// A view of all bytes that remain.
  bool rest(std::span<const std::byte>& bytes) {
    bytes = bytes_;
    bytes_ = {};
    return true;
  }

 private:
  template <std::unsigned_integral Wire, std::integral Value>
  bool get(Value& value) {
    static_assert(sizeof(Value) >= sizeof(Wire));
    if (remaining() < sizeof(Wire)) return false;
    Wire wire = 0;
    for (std::size_t i = 0; i < sizeof(Wire); ++i)
      wire = static_cast<Wire>(wire | std::to_integer<Wire>(bytes_[i]) << (8 * i));
    value = static_cast<Value>(wire);
    bytes_ = bytes_.subspan(sizeof(Wire));
    return true;
  }

  std::span<const std::byte> bytes_;
};

/// A ByteReader or a LayoutRecorder (layout_recorder.h), for field lists that differ from those of a
/// ByteWriter.
template <class T>
concept Reader = !std::same_as<T, ByteWriter>;

}  // namespace farshade
