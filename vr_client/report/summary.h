/// Summary: what a run prints at its end, and the same with everything as JSON.
#pragma once

#include <string>

#include "vr_client/frame/mode.h"
#include "vr_client/report/verdict.h"
#include "vr_client/runtime/runtime.h"

namespace farshade {

/// The settings of a run that its figures depend on most.
struct RunSetting {
  std::string scene{}, device{};
  std::string head{};  ///< name of the head recording, or of the capture
  Mode mode = Mode::Hybrid;
  Extent eye_size{};
  double refresh_hz = 72;
  Pace pace = Pace::Virtual;
  double delay_ms = 0;  ///< Pace::Virtual only
  bool interrupted = false;
};

/// A table of the rows that matter in `mode`: those of the worse eye, without rows that are 0 in every frame.
[[nodiscard]] std::string table(const FrameLog& log, Mode mode);

/// Settings, verdict, and every figure with unit, definition and way of measuring.
[[nodiscard]] std::string summary_json(const RunSetting& setting, const RunTotals& totals,
                                       const FrameLog& log);

}  // namespace farshade
