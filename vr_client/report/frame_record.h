/// FrameRecord: what is measured of one shown frame.
#pragma once

#include <optional>

#include "stereo/frame/pose_delta.h"
#include "vr_client/frame/frame_loop.h"
#include "vr_client/report/measure.h"

namespace farshade {

struct FrameRecord {
  FrameId frame{};
  Time display_time{};
  std::optional<Duration> age{};  ///< since the newest mask was requested; empty without a mask from a server
  /// Of the left eye: from the view of the newest answer to the shown view.
  std::optional<PoseDelta> delta{};
  bool start_up = false;  ///< no answer that the mode needs had arrived yet
  StageTimes times{};
  PerEye<double> black{};                     ///< share of each eye's pixels outside the server's picture
  std::optional<double> guard_band{};         ///< requested pixels beyond the shown ones, as a share of these
  std::optional<FrameReport> server{};        ///< of the answer that this frame was the first to show
  std::optional<PerEye<EyeErrors>> errors{};  ///< empty if no reference was traced
  std::optional<double> requested{};          ///< the share of the requested views that the request asks for
  std::optional<CubeMaskCost> cube_mask{};    ///< set if answers of the cube mask came
  std::optional<LinkTraffic> traffic{};       ///< since the frame before
  bool silent = false;  ///< the server answered nothing; the summary leaves out all but the errors
};

}  // namespace farshade
