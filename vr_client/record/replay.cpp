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

std::optional<std::string> difference_of(const FrameRequest& request, const FrameRequest& captured) {
  if (request.frame != captured.frame)
    return "requests frame " + std::to_string(request.frame.value) + " instead of frame " +
           std::to_string(captured.frame.value);
  if (request.display_time != captured.display_time)
    return "requests a display time " + std::to_string(ms_of(request.display_time - captured.display_time)) +
           " ms later than captured";
  if (request.scene_time != captured.scene_time)
    return "requests a scene time " + std::to_string(ms_of(request.scene_time - captured.scene_time)) +
           " ms later than captured";
  for (const Side side : kSides) {
    const View &now = request.views[index_of(side)], &before = captured.views[index_of(side)];
    if (now == before) continue;
    const char* const what = now.size != before.size ? "size" : now.fov != before.fov ? "fov" : "pose";
    return std::string("requests another ") + what + " of the " + name_of(side) + " eye";
  }
  if (request.lights != captured.lights) return "requests other light changes";
  return std::nullopt;
}

void CaptureLink::begin(const CapturedFrame& frame) {
  frame_ = &frame;
  taken_ = 0;
  requested_ = false;
  difference_.reset();
  was_welcomed_ = welcomed_;
  take(frame.before);
}

void CaptureLink::take(std::span<const CapturedMessage> messages) {
  const Stopwatch watch;
  for (const CapturedMessage& captured : messages) {
    const Decoded<ServerMessage> message = decode_server(captured.bytes);
    if (!message) continue;
    if (const auto* const welcome = std::get_if<Welcome>(&*message)) {
      receiver_.begin(*welcome);
      welcomed_ = true;
    } else if (const auto* const slice = std::get_if<Slice>(&*message)) {
      receiver_.take(*slice, captured.arrived);
    } else if (const auto* const report = std::get_if<FrameReport>(&*message)) {
      receiver_.take(*report, captured.arrived);
    }
  }
  busy_ += watch.elapsed();
}

void CaptureLink::request(const FrameRequest& request, Time requested_at, const RequestParts& parts) {
  if (!frame_->request && !was_welcomed_) return;
  requested_ = true;
  const Time now = frame_->request ? frame_->request->sent : Time{};
  const FrameRequest sent = receiver_.ask(request, requested_at, now, parts.reprojected);
  difference_ = frame_->request ? difference_of(sent, frame_->request->request)
                                : "sends a request that was not captured";
}

bool CaptureLink::wait_for(FrameId frame, Duration) {
  take(std::span(frame_->after).subspan(taken_));
  taken_ = frame_->after.size();
  return receiver_.is_whole(frame);
}

std::optional<std::string> CaptureLink::end() {
  if (frame_->request && !requested_) return "sends no request, though one was captured";
  return difference_;
}

std::string to_string(const ReplayVerdict& verdict) {
  const std::string frames = std::to_string(verdict.frames) + (verdict.frames == 1 ? " frame" : " frames");
  const std::string lacks = verdict.cut_off ? "; " + *verdict.cut_off : std::string();
  if (!verdict.first) return frames + ", all requests and pictures as captured" + lacks;
  return "frame " + std::to_string(verdict.first->frame.value) + " of " + frames + " differs: it " +
         verdict.first->what + lacks;
}

Replay::Replay(CaptureReader reader, PixelReport report) : reader_(std::move(reader)), report_(report) {
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

StereoView Replay::locate_views(Time) {
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
  ReplayVerdict verdict = verdict_;
  verdict.cut_off = reader_.cut_off();
  return verdict;
}

}  // namespace farshade
