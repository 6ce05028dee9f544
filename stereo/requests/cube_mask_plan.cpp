#include "stereo/requests/cube_mask_plan.h"

#include "stereo/head/head_recording.h"

namespace farshade {

/// Whether a new cube mask is due.
bool CubeMaskPlan::is_due(const FrameMoment& shown, SceneMotion motion, bool is_under_way) {
  is_urgent_ = true;
  if (!set_ || shown.display_time < set_->begun) return true;
  const Duration age = shown.display_time - set_->begun;
  if (age < kLeastPeriod || (is_under_way && age < kStillPeriod)) return false;
  const auto place = [](const View& view) { return Point<Stage>{view.stage_from_eye.translation}; };
  const double measured_m = length(place(shown.views[0]) - place(shown.views[1])),
               eyes_m = measured_m > 0 ? measured_m : kDefaultEyeDistance_m,
               moved_m = length(Point<Stage>{head_of(shown.views).translation} - set_->centre);
  if (shown.lights.revision != set_->lights || moved_m > kJump_eyes * eyes_m) return true;
  is_urgent_ = false;
  return moved_m > kFar_eyes * eyes_m ||
         age >= (motion == SceneMotion::Moving ? kMovingPeriod : kStillPeriod);
}

FrameRequest CubeMaskPlan::next_pair(const FrameMoment& shown, Duration lead, SceneClock clock) {
  FrameRequest request{shown};
  request.frame = {kFirstCubeMaskFrame.value + requests_++};
  request.display_time += lead;
  if (clock == SceneClock::Running) request.scene_time += lead;
  request.views = faces_about(set_->centre, set_->pairs++, face_size(shown.views[0].size));
  request.answer = {.kind = Answer::CubeMask};
  return request;
}

std::vector<FrameRequest> CubeMaskPlan::ask(const FrameMoment& shown, Duration lead, SceneClock clock,
                                            SceneMotion motion, bool is_under_way) {
  if (!set_ || set_->pairs == kCubeMaskPairs) {
    if (!is_due(shown, motion, is_under_way)) return {};
    set_ = {{head_of(shown.views).translation}, shown.display_time, shown.lights.revision};
  }
  std::vector<FrameRequest> requests;
  do {
    requests.push_back(next_pair(shown, lead, clock));
  } while (is_urgent_ && set_->pairs < kCubeMaskPairs);
  return requests;
}

}  // namespace farshade
