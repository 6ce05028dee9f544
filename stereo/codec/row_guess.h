/// Row guesses: what the rows above a row of a mask's cell, and the bits left of it, let expect.
///
/// Each bit is the more frequent one in its context (cells.h). How often it is wrong gives the class of the
/// guess. The table holds frequencies in traced masks; all of it is fixed, so encoder and decoder agree.
#pragma once

#include <array>
#include <cstdint>

#include "stereo/codec/cells.h"

namespace farshade {

/// For each context the more frequent bit (bit 7), and the bits of information that it costs, in 1/64.
inline constexpr std::array<std::uint8_t, kBitContexts> kLikelyBits{
    0x04, 0x01, 0x90, 0x99, 0x32, 0x08, 0x24, 0x2c, 0xba, 0xbe, 0xb6, 0xa6, 0x25, 0x37, 0x87, 0x82,
    0x11, 0x0a, 0x85, 0x8e, 0x26, 0x3d, 0x24, 0x15, 0x9a, 0x9c, 0x83, 0x83, 0x1c, 0xaf, 0x83, 0x81,
    0x02, 0x04, 0x9b, 0x98, 0x04, 0x07, 0x33, 0x2b, 0xa2, 0xa0, 0xad, 0xa3, 0x0a, 0x0a, 0x90, 0x91,
    0x02, 0x05, 0xa2, 0xb0, 0xbf, 0x96, 0xa8, 0x9e, 0xaa, 0xa4, 0x86, 0xb6, 0x1d, 0x2c, 0x81, 0x85};
/// Costs of a row, in 1/64 bit, from which on the next class begins.
inline constexpr std::array<std::uint32_t, 7> kGuessClasses{3, 8, 16, 32, 51, 77, 115};

struct RowGuess {
  std::uint8_t bits = 0;    ///< bit x of the row
  std::uint8_t class_ = 0;  ///< 0, the surest, to kGuessClasses.size()
};

/// The bits that a guess depends on: 2 left of the row, 6 of the row above, 4 of the row above that.
[[nodiscard]] constexpr std::uint32_t guess_index(std::uint32_t left, const Border& border) {
  return left | (border.above >> 1 & 63) << 2 | (border.above_2 >> 2 & 15) << 8;
}

[[nodiscard]] constexpr RowGuess make_guess(std::uint32_t index) {
  Border border{Neighbours{}};
  border.above = (index >> 2 & 63) << 1;
  border.above_2 = (index >> 8) << 2;
  std::uint32_t row = index & 3, cost = 0;
  for (std::uint32_t x = 0; x < 4; ++x) {
    const std::uint32_t likely = kLikelyBits[bit_context(row, border, x)];
    row |= (likely >> 7) << (x + 2);
    cost += likely & 127;
  }
  RowGuess guess{.bits = static_cast<std::uint8_t>(row >> 2)};
  for (const std::uint32_t least : kGuessClasses)
    if (cost >= least) ++guess.class_;
  return guess;
}

/// By guess_index().
inline constexpr std::array<RowGuess, 4096> kRowGuesses = [] {
  std::array<RowGuess, 4096> guesses;
  for (std::uint32_t index = 0; index < guesses.size(); ++index) guesses[index] = make_guess(index);
  return guesses;
}();

}  // namespace farshade
