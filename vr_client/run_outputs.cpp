#include "vr_client/run_outputs.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "stereo/base/files.h"
#include "vr_client/report/own_files.h"

namespace farshade {

RunReportOptions report_options(const Options& options, std::uint32_t frames, Compare compare) {
  return {.out = options.out,
          .frame_count = frames,
          .reference_every = options.reference_every,
          .pictures = options.pictures,
          .dump = options.dump,
          .compare = compare};
}

PixelReport report_of(const Options& options) {
  return report_options(options, 0, Compare::AtOnce).measures_any() ? PixelReport::On : PixelReport::Off;
}

Expected<void> RunOutputs::prepare(const Options& options) {
  return CaptureWriter::may_create(options.record)
      .and_then([&] { return make_folder(options.out); })
      .and_then([&] { return remove_own_files(options.out); });
}

RunOutputs::RunOutputs(const Options& options, Client& client, Stages& stages,
                       std::optional<RunReportOptions> measuring)
    : options_(options), client_(client), stages_(stages), capture_(client.clock) {
  if (measuring) report_.emplace(std::move(*measuring), client.renderer, client.reference.get());
}

Expected<void> RunOutputs::open_capture(const Options& shown) {
  if (!captures()) return {};
  return capture_.open(options_.record, header_of(shown, client_));
}

Expected<void> RunOutputs::begin() {
  silence_ = Silence(to_string(client_.server), client_.link && client_.link->counters().sessions == 0);
  if (auto done = timeline_.write(options_.timeline); !done) return done;
  if (!report_ || options_.json.empty() || options_.json == "-") return {};
  return write_file_atomically(options_.json, "{}\n");
}

void RunOutputs::lose_device() {
  if (!captures() || capture_.has_ended()) return;
  if (client_.link) client_.link->tell({});
  if (capture_.finish())
    spdlog::warn("the capture {} ends after {} frames, before the loss of the GPU", options_.record.string(),
                 capture_.frames());
}

std::optional<std::string> RunOutputs::watch(const FrameView& view) {
  if (frames_++ == 0) {
    stages_.end("first frame");
    spdlog::info("the first frame was shown after {}", stages_.in_words());
  }
  if (captures() && !capture_.has_ended()) capture_.watch(view, client_.renderer->read_shown());
  if (report_) report_->watch(view);
  // In a replay, messages carry the arrival times of the captured run's clock, which do not fit the timeline.
  // A client that replays has no link.
  if (!options_.timeline.empty()) timeline_.add(view, client_.link ? &client_.link->receiver() : nullptr);
  const auto why = client_.link ? client_.link->goodbye() : std::nullopt;
  return silence_.add(view.shown.frame, view.silent_since, kSteadyClock.now(), why);
}

/// If the device is lost or has no memory, the comparison ends, and the errors so far are written.
Expected<void> RunOutputs::compare_kept() try {
  report_->compare_kept();
  return {};
} catch (const vk::SystemError& failed) {
  client_.renderer.reset();
  return fail(Fault::Unavailable,
              fmt::format("the GPU failed while frames were compared after the run ({})", failed.what()));
}

Expected<void> RunOutputs::finish(bool was_interrupted, const std::function<Expected<void>()>& summarize) {
  Expected<void> done = timeline_.write(options_.timeline);
  if (report_) {
    if (was_interrupted) report_->mark_interrupted();
    for (const std::uint32_t dump : options_.dump)
      if (dump == 0 || report_->log().records().empty() || dump > report_->log().records().back().frame.value)
        spdlog::warn("frame {} was not dumped, because it was not shown", dump);
    if (auto compared = compare_kept(); done) done = compared;
    report_->finish();
    if (auto written = summarize(); done) done = written;
    if (done && report_->failed()) done = tl::unexpected(*report_->failed());
  }
  if (auto captured = capture_.finish(); done) done = captured;
  return done;
}

}  // namespace farshade
