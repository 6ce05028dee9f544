#include "vr_client/record/capture_link.h"

namespace farshade {

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
      inbox_.begin(*welcome);
      welcomed_ = true;
    } else if (const auto* const slice = std::get_if<Slice>(&*message)) {
      inbox_.take(*slice, captured.arrived);
    } else if (const auto* const report = std::get_if<FrameReport>(&*message)) {
      inbox_.take(*report, captured.arrived);
    }
  }
  busy_ += watch.elapsed();
}

void CaptureLink::request(const FrameRequest& request, Time asked_at,
                          std::span<const std::vector<std::byte>>) {
  if (!frame_->request && !was_welcomed_) return;
  requested_ = true;
  const Time now = frame_->request ? frame_->request->sent : Time{};
  const FrameRequest sent = inbox_.ask(request, asked_at, now);
  difference_ = frame_->request ? difference_of(sent, frame_->request->request)
                                : "sends a request that was not captured";
}

bool CaptureLink::wait_for(FrameId frame, Duration) {
  take(std::span(frame_->after).subspan(taken_));
  taken_ = frame_->after.size();
  return inbox_.is_whole(frame);
}

std::optional<std::string> CaptureLink::end() {
  if (frame_->request && !requested_) return "sends no request, though one was captured";
  return difference_;
}

}  // namespace farshade
