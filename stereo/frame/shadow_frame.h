/// ShadowFrame: the masks of both eyes, the views and the light set that they were traced with. A mask is
/// never sent or stored without its views.
#pragma once

#include "stereo/base/clock.h"
#include "stereo/frame/answer_spec.h"
#include "stereo/frame/eye_mask.h"
#include "stereo/frame/frame_id.h"
#include "stereo/frame/light_changes.h"
#include "stereo/frame/requested_blocks.h"
#include "stereo/frame/view.h"

namespace farshade {

/// A client's request for one frame.
struct FrameRequest {
  FrameId frame;
  Time display_time;  ///< when the client will show the requested views
  Time scene_time;    ///< time of the scene's animation
  StereoView views;
  LightChanges lights{};  ///< the light set to trace
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
