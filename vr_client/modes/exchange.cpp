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

Exchange::Exchange(const RunContext& context) : context_(context), plan_(context.steering.wish) {
  const MaskPolicy& policy = context.policy;
  plan_.learn(policy.pace == Pace::Real ? policy.round_trip : policy.delay - policy.mask_wait);
}

const FrameRequest* Exchange::plan(const FrameInputs& inputs, const AnswerSpec& wanted) {
  request_.reset();
  if (context_.link == nullptr) return nullptr;
  RequestSettings wish = inputs.steering.wish;
  const bool is_picture = is_drawn(wanted.answer);
  if (is_picture) wish.guard_band = GuardBandUse::Off;
  plan_.follow(wish);
  plan_.shrink(is_picture ? kFullViewScale : context_.link->inbox().view_scale());
  plan_.limit(context_.link->inbox().most_pixels());
  request_ = plan_.ask(inputs.shown, inputs.period, inputs.steering.scene);
  if (!request_) return nullptr;
  request_->wanted = wanted;
  return &*request_;
}

const FrameRequest* Exchange::complete(std::uint32_t slices) {
  request_->wanted.slices = slices;
  return &*request_;
}

void Exchange::send(const FrameInputs& inputs, std::span<const std::vector<std::byte>> positions) {
  if (!request_) return;
  asked_ = request_->frame;
  context_.link->request(*request_, inputs.shown.display_time, positions);
}

std::span<const ReceivedFrame* const> Exchange::receive(const FrameInputs& inputs) {
  received_.clear();
  if (context_.link == nullptr) return received_;
  await();
  const AnswerInbox& inbox = context_.link->inbox();
  received_ = inbox.received(usable_until(inputs.shown.display_time));
  for (const ReceivedFrame* frame : received_)
    if (is_newer(frame->request.frame, newest_seen_))
      plan_.learn(inputs.shown.display_time - inbox.asked_at(frame->request.frame).value());
  if (!received_.empty()) newest_seen_ = received_.front()->request.frame;
  return received_;
}

std::optional<Duration> Exchange::age(const ReceivedFrame* frame, const FrameInputs& inputs) const {
  if (frame == nullptr) return std::nullopt;
  const std::optional<Time> asked_at = context_.link->inbox().asked_at(frame->request.frame);
  if (!asked_at) return std::nullopt;
  return inputs.shown.display_time - *asked_at;
}

/// A server that once let the patience run out is not waited for again until it has answered.
void Exchange::await() {
  if (context_.policy.pace == Pace::Real) {
    context_.link->wait_for(asked_, context_.policy.mask_wait);
  } else if (asked_ != awaited_) {
    const Duration patience = answering_ ? kVirtualPatience : Duration::zero();
    answering_ = await_what_comes(patience) || is_whole(awaited_);
    awaited_ = asked_;
  }
}

/// True if some of what was asked for has come.
bool Exchange::await_what_comes(Duration patience) {
  const auto known = [&] {
    const ReceivedFrame* const received = context_.link->inbox().find(asked_);
    return received == nullptr ? 0 : received->pieces_known();
  };
  std::uint32_t before = 0;
  for (Duration waited{}; waited <= patience; waited += kLull) {
    if (context_.link->wait_for(asked_, std::min(kLull, patience - waited))) return true;
    if (known() > 0 && known() == before) return true;
    before = known();
  }
  return before > 0;
}

bool Exchange::is_whole(FrameId frame) const {
  const ReceivedFrame* const received = context_.link->inbox().find(frame);
  return received != nullptr && received->complete();
}

Time Exchange::usable_until(Time display_time) const {
  if (context_.policy.pace == Pace::Real) return Time::max();
  return display_time - context_.policy.delay + context_.policy.mask_wait;
}

}  // namespace farshade
