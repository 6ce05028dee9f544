/// Why foreign bytes were refused, and how often: each reason has its own counter.
/// A refusal is a number, not a sentence: a flood of bad datagrams must cost nothing.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <string_view>
#include <tl/expected.hpp>

namespace farshade {

enum class WireRefusal : std::uint8_t {
  TooLong,         ///< more than kMaxDatagram_bytes
  Truncated,       ///< ends inside a field
  Magic,           ///< not ours
  Version,         ///< ours, another version, and not one of the messages that every version has
  Type,            ///< no message of this direction
  ViewRange,       ///< pose, fov or size of a view out of range
  TimeRange,       ///< a time or duration out of range
  FrameOrder,      ///< a request says that it holds a frame it has not yet asked for
  Code,            ///< an enumeration, flag or reserved byte holds what it may not
  Lights,          ///< more than kMaxLights, or a plane beyond them
  MaskSize,        ///< a side of 0 or more than kMaxViewSide_px
  TileRange,       ///< no tiles, or tiles outside the grid
  TrailingBytes,   ///< bytes after the last field
  Block,           ///< not an LZ4 block, or one that opens to more than a slice may hold
  TileCoding,      ///< a tile coding this version does not know
  TileLength,      ///< tile bytes that are more or fewer than their codings need
  TileBits,        ///< bits where there is no light
  Arrivals,        ///< an arrival report longer or later than any can be
  Padding,         ///< a hello that is not 1,200 bytes, or filled with other than zeros
  UnknownSession,  ///< sealed for a session that is not there
  Replayed,        ///< sealed, and its counter was opened before or has left the window
  Forged,          ///< sealed, and does not open: forged, damaged, or under another key
  AnswerSpec,      ///< an answer that is wanted with what it does not go with, or out of range
  Part,            ///< a part of a picture that no picture has, or of another length
  OtherMask,       ///< a valid slice of a mask with another size or light count than the one to be filled
};
inline constexpr std::size_t kWireRefusals = 25;

[[nodiscard]] std::string_view name_of(WireRefusal refusal);

template <class T>
using Decoded = tl::expected<T, WireRefusal>;

[[nodiscard]] inline tl::unexpected<WireRefusal> refuse(WireRefusal why) {
  return tl::unexpected(why);
}

struct RefusalCounts {
  std::array<std::uint64_t, kWireRefusals> of{};

  void count(WireRefusal refusal) { ++of[static_cast<std::size_t>(refusal)]; }
  [[nodiscard]] std::uint64_t operator[](WireRefusal refusal) const {
    return of[static_cast<std::size_t>(refusal)];
  }
  [[nodiscard]] std::uint64_t total() const {
    return std::accumulate(of.begin(), of.end(), std::uint64_t{0});
  }
  friend bool operator==(const RefusalCounts&, const RefusalCounts&) = default;
};

}  // namespace farshade
