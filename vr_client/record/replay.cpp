#include "vr_client/record/replay.h"

namespace farshade {
namespace {

std::optional<std::string> difference_of(const PerEye<PictureHash>& shown,
                                         const PerEye<PictureHash>& captured) {
  if (shown == captured) return std::nullopt;
  if (shown[0] != captured[0] && shown[1] != captured[1]) return "shows other pictures to both eyes";
  return std::string("shows another picture to the ") +
         name_of(shown[0] != captured[0] ? Side::Left : Side::Right) + " eye";
}

}  // namespace

std::string to_string(const ReplayVerdict& verdict) {
  const std::string frames = std::to_string(verdict.frames) + (verdict.frames == 1 ? " frame" : " frames");
  if (!verdict.first) return frames + ", all requests and pictures as captured";
  return "frame " + std::to_string(verdict.first->frame.value) + " of " + frames + " differs: it " +
         verdict.first->what;
}

Replay::Replay(CaptureReader reader, ShadingPass::Report report)
    : reader_(std::move(reader)), report_(report) {
  if (reader_.header().origin == MaskOrigin::Server) link_.emplace(reader_.header());
}

std::optional<FrameTiming> Replay::wait_frame() {
  Expected<std::optional<CapturedFrame>> frame = reader_.next();
  if (!frame) error_ = frame.error();
  if (!frame || !*frame) return std::nullopt;
  frame_ = std::move(**frame);
  settings_ = frame_.input.settings;
  settings_.report = report_;
  if (link_) link_->begin(frame_);
  return frame_.input.timing;
}

StereoView Replay::locate_views(Time) const {
  return frame_.input.views;
}

void Replay::watch(const FrameView& view, const PerEye<Image<Rgb8>>& shown) {
  ++verdict_.frames;
  std::optional<std::string> what = link_ ? link_->end() : std::nullopt;
  if (verdict_.first) return;
  if (!what) what = difference_of({hash_of(shown[0]), hash_of(shown[1])}, frame_.pictures);
  if (what) verdict_.first = {view.shown.frame, *what};
}

Expected<ReplayVerdict> Replay::verdict() const {
  if (error_) return tl::unexpected(*error_);
  return verdict_;
}

}  // namespace farshade
