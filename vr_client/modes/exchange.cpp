#include "vr_client/modes/exchange.h"

#include <algorithm>

namespace farshade {
namespace {

/// In virtual time a frame's answer is awaited in real time before it is drawn, so that what is shown depends
/// on the set delay alone. This is how long a reply may really take before it counts as lost.
constexpr Duration kVirtualPatience = std::chrono::seconds(5);
/// What has not come for so long after some of its frame's answer has is lost.
constexpr Duration kLull = std::chrono::milliseconds(250);

}  // namespace

Exchange::Exchange(const Session& session) : session_(session), plan_(session.steering.wish) {
  const MaskPolicy& policy = session.policy;
  plan_.learn(policy.pace == Pace::Real ? policy.round_trip : policy.delay - policy.mask_wait);
}

const TraceRequest* Exchange::plan(const Moment& moment, const Wanted& wanted) {
  request_.reset();
  if (session_.link == nullptr) return nullptr;
  RequestWish wish = moment.steering.wish;
  const bool is_picture = is_drawn(wanted.answer);
  if (is_picture) wish.guard_band = GuardBandUse::Off;
  plan_.follow(wish);
  plan_.shrink(is_picture ? RequestPlan::kFullSize : session_.link->inbox().scale_eighths());
  plan_.limit(session_.link->inbox().most_pixels());
  request_ = plan_.ask(moment.shown, moment.period, moment.steering.scene);
  if (!request_) return nullptr;
  request_->wanted = wanted;
  return &*request_;
}

const TraceRequest* Exchange::complete(std::uint32_t slices) {
  request_->wanted.slices = slices;
  return &*request_;
}

void Exchange::send(const Moment& moment, std::span<const std::vector<std::byte>> positions) {
  if (!request_) return;
  asked_ = request_->frame;
  session_.link->request(*request_, moment.shown.display_time, positions);
}

std::span<const ReceivedFrame* const> Exchange::receive(const Moment& moment) {
  received_.clear();
  if (session_.link == nullptr) return received_;
  await();
  const MaskInbox& inbox = session_.link->inbox();
  received_ = inbox.received(usable_until(moment.shown.display_time));
  for (const ReceivedFrame* frame : received_)
    if (is_newer(frame->request.frame, newest_seen_))
      plan_.learn(moment.shown.display_time - inbox.asked_at(frame->request.frame).value());
  if (!received_.empty()) newest_seen_ = received_.front()->request.frame;
  return received_;
}

std::optional<Duration> Exchange::age(const ReceivedFrame* frame, const Moment& moment) const {
  if (frame == nullptr) return std::nullopt;
  const std::optional<Time> asked_at = session_.link->inbox().asked_at(frame->request.frame);
  if (!asked_at) return std::nullopt;
  return moment.shown.display_time - *asked_at;
}

/// A server that once let the patience run out is not waited for again until it has answered.
void Exchange::await() {
  if (session_.policy.pace == Pace::Real) {
    session_.link->wait_for(asked_, session_.policy.mask_wait);
  } else if (asked_ != awaited_) {
    const Duration patience = answering_ ? kVirtualPatience : Duration::zero();
    answering_ = await_what_comes(patience) || is_whole(awaited_);
    awaited_ = asked_;
  }
}

/// True if some of what was asked for has come.
bool Exchange::await_what_comes(Duration patience) {
  const auto known = [&] {
    const ReceivedFrame* const received = session_.link->inbox().find(asked_);
    return received == nullptr ? 0 : received->pieces_known();
  };
  std::uint32_t before = 0;
  for (Duration waited{}; waited <= patience; waited += kLull) {
    if (session_.link->wait_for(asked_, std::min(kLull, patience - waited))) return true;
    if (known() > 0 && known() == before) return true;
    before = known();
  }
  return before > 0;
}

bool Exchange::is_whole(FrameId frame) const {
  const ReceivedFrame* const received = session_.link->inbox().find(frame);
  return received != nullptr && received->complete();
}

Time Exchange::usable_until(Time display_time) const {
  if (session_.policy.pace == Pace::Real) return Time::max();
  return display_time - session_.policy.delay + session_.policy.mask_wait;
}

}  // namespace farshade
