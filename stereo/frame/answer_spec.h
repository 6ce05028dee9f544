/// AnswerSpec: the kind of answer that a request asks for. Every request contains its own; docs/modes.md
/// lists the modes that use each kind.
#pragma once

#include <cstdint>

#include "stereo/base/clock.h"

namespace farshade {

enum class Answer : std::uint8_t {
  Masks,             ///< masks of the surfaces that the views see
  MasksOfPositions,  ///< masks of the surface positions that the client sends after the request
  GBuffer,           ///< base colour, normal, depth and masks
  Video,             ///< the shaded pictures of both eyes, side by side
  Difference,        ///< pictures with shadows minus pictures without, side by side
  CubeMask,          ///< masks of two faces of the cube mask (cube_mask.h), beside the answers of other kinds
};
inline constexpr std::uint8_t kAnswers = 6;

[[nodiscard]] constexpr bool has_masks(Answer answer) {
  return answer == Answer::Masks || answer == Answer::MasksOfPositions || answer == Answer::GBuffer ||
         answer == Answer::CubeMask;
}
[[nodiscard]] constexpr bool is_video(Answer answer) {
  return answer == Answer::Video || answer == Answer::Difference;
}

/// A set of answers: bit k is Answer k.
using AnswerSet = std::uint8_t;
[[nodiscard]] constexpr AnswerSet set_of(Answer answer) {
  return static_cast<AnswerSet>(1u << static_cast<unsigned>(answer));
}
inline constexpr AnswerSet kTracedAnswers =
    set_of(Answer::Masks) | set_of(Answer::MasksOfPositions) | set_of(Answer::CubeMask);
/// Answers that need a renderer on the server. The client rotates them to the shown views.
inline constexpr AnswerSet kDrawnAnswers =
    set_of(Answer::GBuffer) | set_of(Answer::Video) | set_of(Answer::Difference);
[[nodiscard]] constexpr bool is_drawn(Answer answer) {
  return (set_of(answer) & kDrawnAnswers) != 0;
}
inline constexpr AnswerSet kEveryAnswer = (1u << kAnswers) - 1;

/// How an answer is coded.
enum class Coding : std::uint8_t {
  AfterLast,  ///< the encoder may predict a picture from the one before it. Masks are range coded (slice.h)
  Alone,      ///< it must not: the decoder lacks the picture before
  Lz4,        ///< Masks of whole views are one LZ4 block (mask_block.h)
};

inline constexpr std::uint32_t kLeastVideo_bits = 100'000, kMostVideo_bits = 1'000'000'000;  ///< a second
inline constexpr Duration kMostPictureInterval = std::chrono::seconds(10);
inline constexpr std::uint32_t kLeastPosition_bits = 8, kMostPosition_bits = 24;  ///< of an axis

struct AnswerSpec {
  Answer kind = Answer::Masks;
  // For Video and Difference; otherwise 0.
  std::uint32_t bits_per_second = 0;
  Duration interval{};  ///< between two pictures, up to kMostPictureInterval
  Coding coding = Coding::AfterLast;
  // For MasksOfPositions; otherwise 0.
  std::uint32_t position_bits = 0;  ///< bits of an axis of the positions' grid
  // For MasksOfPositions and Masks; otherwise 0.
  /// Messages that follow the request: PlaneSlices that contain the positions, or AskSlices that contain the
  /// requested blocks. Masks without AskSlices are of whole views.
  std::uint32_t slices = 0;
  friend bool operator==(const AnswerSpec&, const AnswerSpec&) = default;
};

}  // namespace farshade
