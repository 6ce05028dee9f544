/// Wanted: with what a request is to be answered. Each request says it for itself; docs/modes.md has the
/// modes that ask so.
#pragma once

#include <cstdint>

#include "stereo/base/clock.h"

namespace farshade {

enum class Answer : std::uint8_t {
  Masks,             ///< of the surfaces that the views see
  MasksOfPositions,  ///< of the positions that follow the request
  GBuffer,           ///< base colour, normal, depth and masks
  Video,             ///< both eyes as they should look, side by side
  Difference,        ///< the same with shadows minus without
};
inline constexpr std::uint8_t kAnswers = 5;

[[nodiscard]] constexpr bool has_masks(Answer answer) {
  return answer == Answer::Masks || answer == Answer::MasksOfPositions || answer == Answer::GBuffer;
}
[[nodiscard]] constexpr bool is_video(Answer answer) {
  return answer == Answer::Video || answer == Answer::Difference;
}

/// A set of answers: bit k is Answer k.
using AnswerSet = std::uint8_t;
[[nodiscard]] constexpr AnswerSet set_of(Answer answer) {
  return static_cast<AnswerSet>(1u << static_cast<unsigned>(answer));
}
inline constexpr AnswerSet kTracedAnswers = set_of(Answer::Masks) | set_of(Answer::MasksOfPositions);
/// Pictures that a renderer draws for the views asked, and that are turned to those shown.
inline constexpr AnswerSet kDrawnAnswers =
    set_of(Answer::GBuffer) | set_of(Answer::Video) | set_of(Answer::Difference);
[[nodiscard]] constexpr bool is_drawn(Answer answer) {
  return (set_of(answer) & kDrawnAnswers) != 0;
}
inline constexpr AnswerSet kUncodedAnswers = kTracedAnswers | set_of(Answer::GBuffer);
inline constexpr AnswerSet kEveryAnswer = (1u << kAnswers) - 1;

/// Whether a picture may be coded as what changed since the one before it.
enum class Coding : std::uint8_t {
  AfterLast,
  Alone,  ///< the decoder lacks a picture: this one must do without
};

inline constexpr std::uint32_t kLeastVideo_bits = 100'000, kMostVideo_bits = 1'000'000'000;  ///< a second
inline constexpr std::uint32_t kLeastPosition_bits = 8, kMostPosition_bits = 24;             ///< an axis

struct AnswerSpec {
  Answer answer = Answer::Masks;
  // Of Video and Difference; else 0.
  std::uint32_t bits_per_second = 0;
  Duration interval{};  ///< between two pictures, up to 10 s
  Coding coding = Coding::AfterLast;
  // Of MasksOfPositions; else 0.
  std::uint32_t position_bits = 0;  ///< an axis of their grid
  std::uint32_t slices = 0;         ///< PlaneSlices that carry them
  friend bool operator==(const AnswerSpec&, const AnswerSpec&) = default;
};

}  // namespace farshade
