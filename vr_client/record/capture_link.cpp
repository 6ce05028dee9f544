#include "vr_client/record/capture_link.h"

namespace farshade {

std::optional<std::string> difference_of(const FrameRequest& request, const FrameRequest& recorded) {
  if (request.frame != recorded.frame)
    return "asks as frame " + std::to_string(request.frame.value) + ", not as frame " +
           std::to_string(recorded.frame.value);
  if (request.display_time != recorded.display_time)
    return "asks for a display time " + std::to_string(ms_of(request.display_time - recorded.display_time)) +
           " ms later than recorded";
  if (request.scene_time != recorded.scene_time)
    return "asks for a scene time " + std::to_string(ms_of(request.scene_time - recorded.scene_time)) +
           " ms later than recorded";
  for (const Side side : kSides) {
    const View &asked = request.views[index_of(side)], &before = recorded.views[index_of(side)];
    if (asked == before) continue;
    const char* const what = asked.size != before.size ? "size" : asked.fov != before.fov ? "fov" : "pose";
    return std::string("asks for another ") + what + " of the " + name_of(side) + " eye";
  }
  if (request.lights != recorded.lights) return "asks with other changes of lights";
  return std::nullopt;
}

void CaptureLink::begin(const CapturedFrame& frame) {
  frame_ = &frame;
  taken_ = 0;
  asked_ = false;
  difference_.reset();
  was_welcomed_ = welcomed_;
  take(frame.before);
}

void CaptureLink::take(std::span<const CapturedMessage> messages) {
  const Stopwatch watch;
  for (const CapturedMessage& heard : messages) {
    const Decoded<ServerMessage> message = decode_server(heard.bytes);
    if (!message) continue;
    if (const auto* const welcome = std::get_if<Welcome>(&*message)) {
      inbox_.begin(*welcome);
      welcomed_ = true;
    } else if (const auto* const slice = std::get_if<Slice>(&*message)) {
      inbox_.take(*slice, heard.arrived);
    } else if (const auto* const report = std::get_if<FrameReport>(&*message)) {
      inbox_.take(*report, heard.arrived);
    }
  }
  busy_ += watch.elapsed();
}

void CaptureLink::request(const FrameRequest& request, Time asked_at,
                          std::span<const std::vector<std::byte>>) {
  if (!frame_->asked && !was_welcomed_) return;
  asked_ = true;
  const Time now = frame_->asked ? frame_->asked->sent : Time{};
  const FrameRequest sent = inbox_.ask(request, asked_at, now);
  difference_ = frame_->asked ? difference_of(sent, frame_->asked->request) : "asks, where nothing was asked";
}

bool CaptureLink::wait_for(FrameId frame, Duration) {
  take(std::span(frame_->after).subspan(taken_));
  taken_ = frame_->after.size();
  return inbox_.is_whole(frame);
}

std::optional<std::string> CaptureLink::end() {
  if (frame_->asked && !asked_) return "asks for nothing, where a request was recorded";
  return difference_;
}

}  // namespace farshade
