/// The words of a frame: FrameMoment (what is seen), FrameRequest (what is asked for) and ShadowFrame, the
/// masks of both eyes with the views and the light set that they were traced with. A mask is never sent or
/// stored without its views.
#pragma once

#include "stereo/base/clock.h"
#include "stereo/frame/answer_spec.h"
#include "stereo/frame/eye_mask.h"
#include "stereo/frame/frame_id.h"
#include "stereo/frame/light_changes.h"
#include "stereo/frame/requested_blocks.h"
#include "stereo/frame/view.h"

namespace farshade {

/// A frame as it is seen: from where, when, and in which light.
struct FrameMoment {
  FrameId frame;
  Time display_time;  ///< when the client shows the views
  Time scene_time;    ///< time of the scene's animation
  StereoView views;
  LightChanges lights{};  ///< the light set
};

/// A client's request for one frame: the moment to trace, and what is asked of it.
struct FrameRequest : FrameMoment {
  AnswerSpec answer{};
  RequestedBlocks requested{};  ///< the part to trace; Answer::Masks only, others ask for whole views
};

struct ShadowFrame {
  FrameId frame;
  LightSetRevision light_set_revision{};
  StereoView views;
  PerEye<EyeMask> masks;
};

}  // namespace farshade
