#include "vr_client/report/run_report.h"

#include <algorithm>
#include <cmath>

#include "stereo/base/files.h"
#include "vr_client/report/dump.h"

namespace farshade {

RunReport::RunReport(RunReportOptions options, Renderer& renderer, Reference* reference)
    : options_(std::move(options)), renderer_(renderer), reference_(reference) {}

/// The cost of the guard band: requested pixels beyond the shown ones, as a share of the shown ones.
std::optional<double> RunReport::guard_band_of(const FrameView& view) {
  if (view.request == nullptr) return std::nullopt;
  return static_cast<double>(view.request->views[0].size.pixels()) /
             static_cast<double>(view.shown.views[0].size.pixels()) -
         1;
}

bool RunReport::is_pictured(FrameId frame) const {
  // The run is divided into `pictures` equal parts; the frame in the middle of each is written.
  for (std::uint64_t i = 0; i < options_.pictures; ++i)
    if (frame.value == 1 + (2 * i + 1) * options_.frame_count / (2 * options_.pictures)) return true;
  return false;
}

bool RunReport::is_dumped(FrameId frame) const {
  return std::find(options_.dump.begin(), options_.dump.end(), frame.value) != options_.dump.end();
}

/// The mask error, or for a picture from the server the mean squared error, computed from the PSNR.
double RunReport::badness(const EyeErrors& errors) {
  return std::isnan(errors.mask_error) ? std::pow(10.0, -errors.psnr_db / 10) : errors.mask_error;
}

void RunReport::keep(Expected<void> done) {
  if (!done && !failed_) failed_ = done.error();
}

void RunReport::watch(const FrameView& view) {
  const FrameId frame = view.shown.frame;
  FrameRecord record{.frame = frame,
                     .display_time = view.shown.display_time,
                     .age = view.age,
                     .delta = {},
                     .start_up = view.start_up,
                     .times = view.times,
                     .black = view.black,
                     .guard_band = guard_band_of(view),
                     .server = {},
                     .errors = {}};
  if (!view.masks.empty())
    record.delta = pose_delta(view.shown.views[0], view.shown.display_time, view.masks[0].views[0],
                              view.masks[0].display_time);
  else if (view.newest)
    record.delta = pose_delta(view.shown.views[0], view.shown.display_time, view.newest->request.views[0],
                              view.newest->request.display_time);
  // The report of a server frame is logged once, with the first frame that shows its answer.
  if (view.newest && view.newest->request.frame != counted_) {
    record.server = view.newest->report;
    if (record.server) counted_ = view.newest->request.frame;
  }

  const bool dumped = is_dumped(frame), pictured = is_pictured(frame);
  const bool measured =
      dumped || (options_.reference_every > 0 && (frame.value - 1) % options_.reference_every == 0);
  if (measured) record.errors = measure(view, renderer_, *reference_, current_);
  log_.add(record);
  if (failed_) return;

  if (pictured) keep(write_shown(options_.out, frame, measured ? current_.shown : renderer_.read_shown()));
  if (dumped) keep(write_dump(options_.out / "dump", view, current_, renderer_.read_distance()));
  if (measured && !view.start_up) {
    const double error = badness((*record.errors)[0]) + badness((*record.errors)[1]);
    if (error > worst_error_) {
      worst_error_ = error;
      worst_ = current_;
    }
  }
}

Expected<void> RunReport::finish() const {
  if (failed_) return tl::unexpected(*failed_);
  if (worst_)
    if (auto done = write_measured(options_.out, *worst_); !done) return done;
  if (auto done = write_file_atomically(options_.out / "summary.csv", summary_csv(log_.summary())); !done)
    return done;
  return write_file_atomically(options_.out / "frames.csv", frames_csv(log_.records()));
}

}  // namespace farshade
