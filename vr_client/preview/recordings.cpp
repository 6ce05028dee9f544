#include "vr_client/preview/recordings.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <glm/geometric.hpp>

#include "stereo/base/files.h"
#include "stereo/head/reader.h"
#include "stereo/head/writer.h"
#include "stereo/image/codec.h"
#include "stereo/requests/request_plan.h"

namespace farshade {
namespace {

/// The left eye on the left.
Image<Rgb8> side_by_side(const PerEye<Image<Rgb8>>& eyes) {
  const Extent eye = eyes[0].size;
  Image<Rgb8> both({eye.width * 2, eye.height});
  for (std::uint32_t y = 0; y < eye.height; ++y)
    for (std::uint32_t side = 0; side < kEyes; ++side)
      std::copy_n(&eyes[side].at(0, y), eye.width, &both.at(side * eye.width, y));
  return both;
}

}  // namespace

void HeadRecordingWriter::add(Time display_time, const StereoView& views) {
  if (!recording_.samples.empty() && display_time <= recording_.end()) return;
  const auto head = head_of(views);
  recording_.samples.push_back({display_time, {head.rotation, head.translation}});
  recording_.eye_distance_m =
      glm::length(views[1].stage_from_eye.translation - views[0].stage_from_eye.translation);
  recording_.fov = {views[0].fov, views[1].fov};
}

Expected<void> HeadRecordingWriter::write(const std::filesystem::path& path) const {
  if (recording_.samples.size() < kFewestSamples)
    return fail(Fault::OutOfRange, "a head recording needs at least " + std::to_string(kFewestSamples) +
                                       " frames; " + path.string() + " was not written");
  return write_file_atomically(path, euroc_text(recording_));
}

std::filesystem::path Recordings::unused(const char* what, const char* extension) const {
  for (std::uint32_t number = 1;; ++number) {
    const std::string name = fmt::format("{}_{:04}", what, number);
    std::error_code ignored;
    bool taken = false;
    for (const char* suffix : {extension, "_left.png"})
      taken |= std::filesystem::exists(out_ / (name + suffix), ignored);
    if (!taken) return out_ / name;
  }
}

void Recordings::report(const Expected<void>& done, const std::string& success) {
  if (!done && !failed_) failed_ = done.error();
  note_ = done ? success : done.error().what;
  if (done)
    spdlog::info("{}", note_);
  else
    spdlog::error("{}", note_);
}

void Recordings::take_screenshot(const PerEye<Image<Rgb8>>& eyes, const Image<Rgb8>& window) {
  const std::string name = unused("screenshot", "_left.png").string();
  Expected<void> done;
  for (const Side side : kSides)
    if (done) done = write_png(fmt::format("{}_{}.png", name, name_of(side)), eyes[index_of(side)]);
  if (done && window.size.pixels() > 0) done = write_png(name + "_window.png", window);
  report(done, fmt::format("wrote {}_*.png", name));
}

void Recordings::toggle_head() {
  if (!head_) {
    head_.emplace();
    report({}, "recording the head");
    return;
  }
  const std::filesystem::path path = unused("head", ".csv").string() + ".csv";
  report(head_->write(path), "wrote " + path.string());
  head_.reset();
}

void Recordings::toggle_frames() {
  if (frames_) {
    report({}, fmt::format("wrote {} frames to {}", frames_->written, frames_->folder.string()));
    frames_.reset();
    return;
  }
  frames_ = Frames{unused("frames", "")};
  const Expected<void> made = make_folder(frames_->folder);
  report(made, "writing frames to " + frames_->folder.string());
  if (!made) frames_.reset();
}

LinkListener Recordings::listen() {
  capture_ = std::make_unique<CaptureWriter>(clock_);
  capture_path_.clear();
  CaptureWriter* const own = capture_.get();
  // The link outlives a capture and keeps calling its listener.
  return {.received =
              [this, own, inner = own->listener()](auto message, Time arrived) {
                if (capture_.get() == own) inner.received(message, arrived);
              },
          .sent =
              [this, own, inner = own->listener()](const FrameRequest& request) {
                if (capture_.get() == own) inner.sent(request);
              }};
}

void Recordings::begin_capture(const std::filesystem::path& path, const CaptureHeader& header) {
  capture_path_ = path;
  if (path.empty()) capture_path_ = unused("capture", ".farshade").string() + ".farshade";
  const Expected<void> opened = capture_->open(capture_path_, header);
  report(opened, "writing a capture to " + capture_path_.string());
  if (!opened) capture_.reset();
}

void Recordings::refuse_capture(std::string_view mode) {
  note_ = fmt::format("only modes hybrid and full can be captured, not mode {}", mode);
}

void Recordings::end_capture() {
  if (capture_path_.empty()) {
    capture_.reset();  // begin_capture was never called
    return;
  }
  report({}, fmt::format("wrote a capture of {} frames to {}; replay it with --replay", capture_->frames(),
                         capture_path_.string()));
  capture_.reset();
}

void Recordings::watch(const FrameView& view, const PerEye<Image<Rgb8>>* shown,
                       const PerEye<Image<Rgb8>>* displayed) {
  if (head_) head_->add(view.shown.display_time, view.shown.views);
  if (capture_) {
    capture_->watch(view, *shown);
    if (capture_->failed()) {
      report(tl::unexpected(*capture_->failed()), "");
      capture_.reset();
    }
  }
  if (!frames_) return;
  const std::string name = fmt::format("frame_{:05}.png", ++frames_->written);
  if (const Expected<void> done = write_png(frames_->folder / name, side_by_side(*displayed)); !done) {
    report(done, "");
    frames_.reset();
  }
}

Expected<void> Recordings::finish() {
  if (head_) toggle_head();
  if (frames_) toggle_frames();
  if (capture_) end_capture();
  return failed_ ? Expected<void>(tl::unexpected(*failed_)) : Expected<void>{};
}

}  // namespace farshade
