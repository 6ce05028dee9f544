#include "vr_client/report/run_report.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>

#include "stereo/base/files.h"
#include "stereo/image/codec.h"
#include "stereo/image/difference.h"
#include "vr_client/report/picture_sheet.h"

namespace farshade {
namespace {

/// The mask error, or for a picture from the server the mean squared error, computed from the PSNR.
double badness(const EyeErrors& errors) {
  return std::isnan(errors.mask_error) ? std::pow(10.0, -errors.psnr_db / 10) : errors.mask_error;
}

}  // namespace

Expected<void> write_shown(const std::filesystem::path& folder, FrameId frame,
                           const PerEye<Image<Rgb8>>& shown) {
  for (const Side side : kSides)
    if (auto done = write_png(folder / fmt::format("frame_{:04}_{}.png", frame.value, name_of(side)),
                              shown[index_of(side)]);
        !done)
      return done;
  return {};
}

Expected<void> write_measured(const std::filesystem::path& folder, const MeasuredFrame& frame) {
  struct Part {
    const char *file, *label;
    Image<Rgb8> picture;
  };
  std::vector<std::vector<LabelledPicture>> rows;
  for (const Side side : kSides) {
    const std::size_t eye = index_of(side);
    const Image<Rgb8>&shown = frame.shown[eye], &reference = frame.reference[eye];
    std::vector<Part> parts{{"shown", "shown", shown},
                            {"reference", "full trace", reference},
                            {"difference_x8", "difference x 8", difference_x8(shown, reference)}};
    if (!frame.report[eye].sources.empty())
      parts.push_back({"source", "green: newest mask; colours: other masks",
                       source_picture(frame.report[eye], frame.ages, shown.size)});
    rows.emplace_back();
    for (Part& part : parts) {
      const std::string name =
          fmt::format("worst_{:04}_{}_{}.png", frame.frame.value, name_of(side), part.file);
      if (auto done = write_png(folder / name, part.picture); !done) return done;
      rows.back().push_back(
          {fmt::format("{} eye, frame {}: {}", name_of(side), frame.frame.value, part.label),
           std::move(part.picture)});
    }
  }
  return write_png(folder / "worst.png", picture_sheet(rows));
}

RunReport::RunReport(RunReportOptions options, const std::unique_ptr<Renderer>& renderer,
                     Reference* reference)
    : options_(std::move(options)),
      renderer_(renderer),
      reference_(reference),
      every_(options_.reference_every) {}

bool RunReport::is_pictured(FrameId frame) const {
  // The run is divided into `pictures` equal parts; the frame in the middle of each is written.
  for (std::uint64_t i = 0; i < options_.pictures; ++i)
    if (frame.value == 1 + (2 * i + 1) * options_.frame_count / (std::uint64_t{2} * options_.pictures))
      return true;
  return false;
}

bool RunReport::is_dumped(FrameId frame) const {
  return std::find(options_.dump.begin(), options_.dump.end(), frame.value) != options_.dump.end();
}

void RunReport::keep(Expected<void> done) {
  if (!done && !failed_) failed_ = done.error();
}

namespace {

FrameRecord record_of(const FrameView& view) {
  FrameRecord record{
      .frame = view.shown.frame,
      .display_time = view.shown.display_time,
      .age = view.age,
      .delta = {},
      .start_up = view.start_up,
      .times = view.times,
      .black = view.black,
      .guard_band = guard_band_of(view),
      .server = {},
      .errors = {},
      .requested = view.request ? std::optional(part_of(view.request->requested)) : std::nullopt,
      .cube_mask = view.cube_mask_cost.bytes > 0 ? std::optional(view.cube_mask_cost) : std::nullopt,
      .traffic = view.traffic,
      .silent = view.silent_since.has_value()};
  if (!view.masks.empty())
    record.delta = pose_delta(view.shown.views[0], view.shown.display_time, view.masks[0].views[0],
                              view.masks[0].display_time);
  else if (view.newest)
    record.delta = pose_delta(view.shown.views[0], view.shown.display_time, view.newest->request.views[0],
                              view.newest->request.display_time);
  return record;
}

}  // namespace

bool RunReport::is_measured(FrameId frame) const {
  return every_ > 0 && (frame.value - 1) % every_ == 0;
}

void RunReport::watch(const FrameView& view) {
  const FrameId frame = view.shown.frame;
  FrameRecord record = record_of(view);
  // The report of a server frame is logged once, with the first frame that shows its answer.
  if (view.newest && view.newest->request.frame != counted_) {
    record.server = view.newest->report;
    if (record.server) counted_ = view.newest->request.frame;
  }
  log_.add(record);

  const bool dumped = is_dumped(frame) && !failed_, measured = dumped || is_measured(frame);
  const bool at_once = options_.compare == Compare::AtOnce || (dumped && kept_dump_bytes_ > kMostKept_bytes);
  std::optional<Taken> taken;
  if (measured) taken = {log_.records().size() - 1, read_back(view, *renderer_), std::nullopt};
  if (dumped) taken->dump = dump_of(view, renderer_->read_distance());
  picture(view, taken);
  if (!taken) return;
  if (at_once)
    compare(std::move(*taken));
  else
    keep(std::move(*taken));
}

/// Writes or keeps the frame's pictures, if they are due. Frames from before the first answer are passed
/// over.
void RunReport::picture(const FrameView& view, const std::optional<Taken>& taken) {
  awaits_picture_ |= is_pictured(view.shown.frame);
  if (!awaits_picture_ || view.start_up || failed_) return;
  awaits_picture_ = false;
  const PerEye<Image<Rgb8>> shown = taken ? taken->frame.pictures : renderer_->read_shown();
  kept_picture_bytes_ += kEyes * shown[0].pixels.size() * sizeof(Rgb8);
  if (kept_picture_bytes_ > kMostKept_bytes)
    keep(write_shown(options_.out, view.shown.frame, shown));
  else
    kept_pictures_.push_back({view.shown.frame, shown});
}

/// Measures fewer frames if those of the whole run would not fit.
void RunReport::keep(Taken taken) {
  if (every_ > 0 && kept_.empty()) {
    const std::uint64_t fit =
        std::max<std::uint64_t>(kMostKept_bytes / std::max<std::uint64_t>(taken.frame.bytes(), 1), 1);
    every_ = std::max(every_, static_cast<std::uint32_t>((options_.frame_count + fit - 1) / fit));
  }
  if (taken.dump) kept_dump_bytes_ += taken.frame.bytes() + taken.dump->bytes();
  kept_.push_back(std::move(taken));
}

void RunReport::compare(Taken taken) {
  const PerEye<EyeErrors> errors = measure(std::move(taken.frame), *renderer_, *reference_, current_);
  renderer_->discard_times();  // frees what the comparison has uploaded
  log_.set_errors(taken.record, errors);
  if (taken.dump && !failed_) keep(write_dump(options_.out / "dump", *taken.dump, current_));
  const double error = badness(errors[0]) + badness(errors[1]);
  if (log_.records()[taken.record].start_up || error <= worst_error_) return;
  worst_error_ = error;
  worst_ = current_;
}

void RunReport::compare_kept() {
  if (kept_.empty()) return;
  if (!renderer_)
    return spdlog::warn("without a GPU, frames that wait for their comparison are not compared");
  spdlog::info("comparing {} of the {} shown frames", kept_.size(), log_.records().size());
  for (Taken& kept : kept_) compare(std::move(kept));
  kept_.clear();
}

void RunReport::finish() {
  compare_kept();
  std::string summary = summary_csv(log_.summary());
  if (interrupted_) summary += fmt::format("run,interrupted,,1,1,1,{}\n", log_.records().size());
  keep(write_file_atomically(options_.out / "summary.csv", summary));
  keep(write_file_atomically(options_.out / "frames.csv", frames_csv(log_.records())));
  for (const KeptPicture& kept : kept_pictures_)
    if (!failed_) keep(write_shown(options_.out, kept.frame, kept.shown));
  if (worst_ && !failed_) keep(write_measured(options_.out, *worst_));
}

}  // namespace farshade
