#include "rt_server/sessions/waiting_requests.h"

#include <algorithm>

#include "stereo/frame/tiles.h"
#include "stereo/messages/timing.h"

namespace farshade {
namespace {

/// Upper limit of the interval between two requests.
constexpr Duration kLongestInterval = std::chrono::milliseconds(50);

/// The tiles that the messages of a request have, if each comes once: a position has three coordinates.
std::size_t tiles_of(const FrameRequest& request) {
  std::size_t tiles = 0;
  for (const View& view : request.views) tiles += TileGrid{view.size}.count();
  return request.answer.kind == Answer::MasksOfPositions ? 3 * tiles : tiles;
}

}  // namespace

std::optional<ReceivedMessage> WaitingRequests::refuse(const FrameRequest& request) const {
  for (const View& view : request.views)
    if (view.size.pixels() > most_pixels_) return ReceivedMessage::TooLarge;
  const Answer answer = request.answer.kind;
  if ((answers_ & set_of(answer)) == 0) return ReceivedMessage::Unanswered;
  // A renderer draws two eyes of one size.
  if (is_drawn(answer) && request.views[0].size != request.views[1].size) return ReceivedMessage::Unanswered;
  return std::nullopt;
}

std::optional<Job>& WaitingRequests::waiting_for(const FrameRequest& request) {
  return request.answer.kind == Answer::CubeMask ? waiting_cube_mask_[pair_of(request.frame)] : waiting_;
}

ReceivedMessage WaitingRequests::receive(const FrameRequest& request, Time now) {
  merge(lights_, request.lights);
  const FrameId frame = request.frame;
  const Answer answer = request.answer.kind;
  const bool is_cube_mask = answer == Answer::CubeMask;
  std::optional<FrameId>& newest = is_cube_mask ? newest_cube_mask_[pair_of(frame)] : newest_;
  if (newest && !is_newer(frame, *newest)) return ReceivedMessage::Outdated;
  // A request that is refused leaves nothing behind that later ones are compared with.
  if (const std::optional<ReceivedMessage> why = refuse(request)) return *why;
  if (!is_cube_mask) update_interval(request, now);
  newest = frame;
  std::optional<Job>& waiting = waiting_for(request);
  const bool superseded = waiting.has_value();
  if (superseded) ++superseded_;
  waiting = Job{.request = request, .arrived = now};
  waiting->request.lights = lights_;
  if (!is_cube_mask) {
    requested_answer_ = answer;
    parts_bytes_ = 0;
    tiles_left_ = tiles_of(request);
    part_arrived_ = now;
  }
  return superseded ? ReceivedMessage::Superseded : ReceivedMessage::NewRequest;
}

/// Stores the compressed message. It is unpacked when the request is answered, so that waiting messages take
/// no more memory than they took on the wire.
template <class TileSlice>
ReceivedMessage WaitingRequests::receive_part(Answer of, const TileSlice& slice,
                                              std::span<const std::byte> message, Time now,
                                              std::size_t room) {
  const bool fits =
      waiting_ && waiting_->request.frame == slice.frame && waiting_->request.answer.kind == of &&
      waiting_->parts.size() < waiting_->request.answer.slices &&
      parts_bytes_ + message.size() <= kMostParts_bytes &&
      slice.size == waiting_->request.views[index_of(slice.eye)].size && slice.tile_count <= tiles_left_;
  if (!fits) return ReceivedMessage::Stray;
  if (message.size() + kMessage_bytes > room) return ReceivedMessage::OverMemory;
  tiles_left_ -= slice.tile_count;
  waiting_->parts.emplace_back(message.begin(), message.end());
  parts_bytes_ += message.size();
  part_arrived_ = now;
  return ReceivedMessage::Part;
}

ReceivedMessage WaitingRequests::receive(const PlaneSlice& slice, std::span<const std::byte> message,
                                         Time now, std::size_t room) {
  if (slice.kind < PlaneKind::PositionX) return ReceivedMessage::Stray;
  return receive_part(Answer::MasksOfPositions, slice, message, now, room);
}

ReceivedMessage WaitingRequests::receive(const AskSlice& slice, std::span<const std::byte> message, Time now,
                                         std::size_t room) {
  return receive_part(Answer::Masks, slice, message, now, room);
}

/// Uses the shorter of two measures. In virtual time a client sends requests less often than its display
/// times say. In real time several requests may arrive at once after a delay.
void WaitingRequests::update_interval(const FrameRequest& request, Time now) {
  if (newest_) {
    const Duration measured = std::min(request.display_time - newest_display_, now - newest_arrived_);
    interval_ += (std::clamp(measured, Duration::zero(), kLongestInterval) - interval_) / 8;
  }
  newest_display_ = request.display_time;
  newest_arrived_ = now;
}

bool WaitingRequests::any() const {
  return newest_ ||
         std::ranges::any_of(newest_cube_mask_, [](const auto& frame) { return frame.has_value(); });
}

/// All parts of the waiting request have come.
bool WaitingRequests::is_complete() const {
  return waiting_ && waiting_->parts.size() >= waiting_->request.answer.slices;
}

/// The pair whose request has waited longest.
std::optional<std::size_t> WaitingRequests::oldest_cube_mask() const {
  std::optional<std::size_t> oldest;
  for (std::size_t pair = 0; pair < kCubeMaskPairs; ++pair)
    if (waiting_cube_mask_[pair] && (!oldest || is_newer(waiting_cube_mask_[*oldest]->request.frame,
                                                         waiting_cube_mask_[pair]->request.frame)))
      oldest = pair;
  return oldest;
}

std::optional<Time> WaitingRequests::ready_at() const {
  if (is_complete() || oldest_cube_mask()) return Time{};
  return waiting_ ? std::optional(part_arrived_ + kPartsTimeout) : std::nullopt;
}

/// A request for the cube mask is taken before another one only if that is not complete yet, or if enough
/// others have overtaken it.
Job WaitingRequests::take() {
  const std::optional<std::size_t> pair = oldest_cube_mask();
  const bool is_cube_mask = pair && (!is_complete() || overtaken_ >= kMostOvertaking);
  Job job = std::move(*std::exchange(is_cube_mask ? waiting_cube_mask_[*pair] : waiting_, std::nullopt));
  overtaken_ = pair && !is_cube_mask ? overtaken_ + 1 : 0;
  job.superseded = superseded_;
  return job;
}

}  // namespace farshade
