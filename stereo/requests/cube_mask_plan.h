/// Cube mask plan: when the next pair of faces of the cube mask is requested, and about which point
/// (docs/cube-mask.md).
#pragma once

#include <optional>
#include <vector>

#include "stereo/frame/cube_mask.h"
#include "stereo/frame/shadow_frame.h"
#include "stereo/requests/request_plan.h"

namespace farshade {

class CubeMaskPlan {
 public:
  /// If nothing moves, a cube mask is requested again after this time, so that nothing wrong lives longer.
  static constexpr Duration kStillPeriod = std::chrono::seconds(2);
  /// If something in the scene moves, after this time.
  static constexpr Duration kMovingPeriod = std::chrono::milliseconds(333);
  /// No sooner than after this time, however fast the head moves.
  static constexpr Duration kLeastPeriod = std::chrono::milliseconds(100);
  /// It is requested sooner if the head has moved by so many distances between the eyes (of usual eyes, if
  /// both are at one place): from there, much is uncovered that it does not show.
  static constexpr double kFar_eyes = 4;
  /// After a move by so many distances between the eyes within kStillPeriod, the old one hardly serves.
  static constexpr double kJump_eyes = 32;

  /// `begun`: so many whole cube masks have been requested before; their frame ids are used.
  explicit CubeMaskPlan(std::uint32_t begun = 0) : requests_(begun * std::uint32_t{kCubeMaskPairs}) {}

  /// The requests for pairs that are due in the frame that shows `shown`: one pair in a frame, but all at
  /// once if nothing that was requested before serves. They are made for the time `lead` later.
  /// `is_under_way`: an answer of the cube mask may still come.
  [[nodiscard]] std::vector<FrameRequest> ask(const FrameMoment& shown, Duration lead, SceneClock clock,
                                              SceneMotion motion, bool is_under_way);

  /// The last requests were made because nothing before them serves: they should leave before all others.
  [[nodiscard]] bool is_urgent() const { return is_urgent_; }

 private:
  [[nodiscard]] bool is_due(const FrameMoment& shown, SceneMotion motion, bool is_under_way);
  [[nodiscard]] FrameRequest next_pair(const FrameMoment& shown, Duration lead, SceneClock clock);

  /// The cube mask that was requested last.
  struct Set {
    Point<Stage> centre;
    Time begun;
    LightSetRevision lights{};
    std::size_t pairs = 0;  ///< requested so far
  };
  std::optional<Set> set_;
  std::uint32_t requests_;
  bool is_urgent_ = false;
};

}  // namespace farshade
