/// ShadowFrame: what a server makes of a request - both eyes' masks, the views they were traced for, the
/// light set they speak of. A mask never travels or rests without its views.
#pragma once

#include "stereo/base/clock.h"
#include "stereo/frame/answer_spec.h"
#include "stereo/frame/eye_mask.h"
#include "stereo/frame/frame_id.h"
#include "stereo/frame/light_changes.h"
#include "stereo/frame/view.h"

namespace farshade {

/// What a client asks for.
struct FrameRequest {
  FrameId frame;
  Time display_time;  ///< when the traced views are to be shown
  Time scene_time;    ///< where the animation stands
  StereoView views;
  LightChanges lights{};  ///< the light set that the masks are to speak of
  AnswerSpec wanted{};    ///< with what to answer
};

struct ShadowFrame {
  FrameId frame;
  std::uint32_t light_set_revision = 0;
  StereoView views;
  PerEye<EyeMask> masks;
};

}  // namespace farshade
