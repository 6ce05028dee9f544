/// ShadowFrame: the server's result for a request: the masks of both eyes, with the views and the light set
/// revision for which they were traced. Masks are always stored and sent with their views.
#pragma once

#include "stereo/base/clock.h"
#include "stereo/frame/answer_spec.h"
#include "stereo/frame/eye_mask.h"
#include "stereo/frame/frame_id.h"
#include "stereo/frame/light_changes.h"
#include "stereo/frame/view.h"

namespace farshade {

/// A request of the client.
struct FrameRequest {
  FrameId frame;
  Time display_time;  ///< time at which the traced views will be shown
  Time scene_time;    ///< time of the animation
  StereoView views;
  LightChanges lights{};  ///< the light changes to trace with
  AnswerSpec wanted{};    ///< the kind of answer
};

struct ShadowFrame {
  FrameId frame;
  std::uint32_t light_set_revision = 0;
  StereoView views;
  PerEye<EyeMask> masks;
};

}  // namespace farshade
