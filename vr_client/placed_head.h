/// PlacedHead: a head recording where the options place it in the scene. Says what the head sees there.
#pragma once

#include <future>
#include <optional>

#include "stereo/frame/exposure.h"
#include "stereo/head/head_recording.h"
#include "stereo/placement/head_test.h"
#include "vr_client/options.h"

namespace farshade {

struct PlacedHead {
  HeadRecording recording;  ///< its walk may be scaled down
  Rigid<Stage, Recorded> stage_from_recorded;
  HeadTest test{};  ///< what the head sees there; of no pose if the scene is too large to test
  std::optional<Exposure> exposure{};  ///< chosen for the scene, unless it is too large
};

/// Logs what the reader of the recording found and assumed, and warns of rows that it left out and of heads
/// that are not upright.
void tell_how_read(const HeadRecording& recording);

/// Tells how the recording was read, places it and logs how and why, with the share of the shown poses that
/// are inside geometry or see nothing (stereo/placement/head_test.h), and what is wrong with the light there
/// (stereo/exposure/picture_check.h). Warns above 5 %. Fails if --place fit finds no free space.
[[nodiscard]] Expected<PlacedHead> place_head(const Options& options, const Scene& scene,
                                              const HeadRecording& recording);

/// The same on a thread of its own. Keeps references; the future's destructor waits.
[[nodiscard]] std::future<Expected<PlacedHead>> place_meanwhile(const Options& options, const Scene& scene,
                                                                HeadRecording recording);

/// Tells what is wrong with the light where a viewer without a recording starts, unless the scene is too
/// large to look at. On a thread of its own; keeps references; the future's destructor waits.
[[nodiscard]] std::future<void> judge_start_meanwhile(const Options& options, const Scene& scene);

}  // namespace farshade
