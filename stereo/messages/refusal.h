/// Reasons to refuse foreign bytes, and a counter for each of them.
/// A refusal is a number and not a sentence, so that a flood of bad datagrams is cheap.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <string_view>
#include <tl/expected.hpp>

namespace farshade {

enum class WireRefusal : std::uint8_t {
  TooLong,         ///< more than a datagram of this direction has
  Truncated,       ///< ends inside a field
  Magic,           ///< not a datagram of this protocol
  Version,         ///< of another version, and not an envelope that every version has
  Type,            ///< no envelope or message of this direction has this type
  ViewRange,       ///< pose, fov or size of a view out of range
  TimeRange,       ///< a time or duration out of range
  FrameOrder,      ///< a frame refers to a newer one
  Code,            ///< an enumeration, flag or reserved byte has an undefined value
  Lights,          ///< more than kMaxLights, a plane beyond them, or light changes out of order
  MaskSize,        ///< a side of 0 or more than kMaxViewSide_px
  TileRange,       ///< no tiles, or tiles outside the grid
  TrailingBytes,   ///< bytes after the last field
  Block,           ///< not an LZ4 block, other content than expected, or a range-coded block with another end
  TileCoding,      ///< a tile coding that this version does not know
  TileLength,      ///< more or fewer bytes than the tiles need
  TileBits,        ///< a bit of a light or pixel that does not exist is set
  Arrivals,        ///< an arrival report is too long, or its counter too large
  Padding,         ///< a Hello has another length, or padding other than zeros
  UnknownSession,  ///< a Sealed of a session that does not exist
  CounterJump,     ///< the counter is too far beyond the newest one
  Replayed,        ///< the counter was opened before, or is older than the window
  Forged,          ///< the tag is wrong: forged, damaged, or sealed with another key
  AnswerSpec,      ///< fields that do not fit the kind of answer, or are out of range
  Part,            ///< a VideoPart with a wrong index, number or length
  OtherMask,       ///< a valid slice or block of masks, but of another size, light count or light set
};
inline constexpr std::size_t kWireRefusals = 26;

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
