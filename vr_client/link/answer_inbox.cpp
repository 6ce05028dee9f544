#include "vr_client/link/answer_inbox.h"

#include <algorithm>

namespace farshade {
namespace {

/// Null if it is not among `all`.
auto* of_frame(auto& all, FrameId frame) {
  const auto found = std::ranges::find_if(all, [&](const auto& one) { return one.exchange.frame == frame; });
  return found == all.end() ? nullptr : &*found;
}

}  // namespace

void AnswerInbox::begin(const Welcome& welcome) {
  most_pixels_ = welcome.most_pixels;
  acknowledged_ = kFirstLightSet;
  newest_report_.reset();
  ++session_;
}

FrameRequest AnswerInbox::ask(const FrameRequest& request, Time asked_at, Time now) {
  FrameRequest sent = request;
  sent.lights = since(request.lights, acknowledged_, RequestMessage::kMostLightChanges);
  // What the masks will speak of.
  FrameRequest expected = request;
  expected.lights = up_to(request.lights, sent.lights.revision);
  assembler_.expect(expected, layout_, expected.lights.revision);
  asked_.push_back({.exchange = {.frame = request.frame, .sent = now, .first = {}, .last = {}},
                    .at = asked_at,
                    .session = session_});
  std::erase_if(asked_, [&](const Asked& one) { return assembler_.find(one.exchange.frame) == nullptr; });
  return sent;
}

/// Some of `frame` has come; null: it told nothing new.
void AnswerInbox::note(const ReceivedFrame* frame, Time arrived) {
  if (frame == nullptr) return;
  if (is_newer_light_set(frame->light_set_revision, acknowledged_)) acknowledged_ = frame->light_set_revision;
  if (Asked* const asked = of_frame(asked_, frame->request.frame); asked && !asked->exchange.first)
    asked->exchange.first = arrived;
}

void AnswerInbox::take(const Slice& slice, Time arrived) {
  note(assembler_.accept(slice), arrived);
}
void AnswerInbox::take(const PlaneSlice& slice, Time arrived) {
  note(assembler_.accept(slice), arrived);
}
void AnswerInbox::take(const VideoPart& part, Time arrived) {
  note(assembler_.accept(part), arrived);
}

void AnswerInbox::take(const FrameReport& report, Time arrived) {
  assembler_.accept(report);
  if (Asked* const asked = of_frame(asked_, report.frame)) asked->exchange.last = arrived;
  if (newest_report_ && !is_newer(report.frame, *newest_report_)) return;
  newest_report_ = report.frame;
  view_scale_ = report.view_scale;
}

std::vector<const ReceivedFrame*> AnswerInbox::received(Time until) const {
  std::vector<const ReceivedFrame*> found;
  for (auto asked = asked_.rbegin(); asked != asked_.rend(); ++asked)
    if (const ReceivedFrame* received = assembler_.find(asked->exchange.frame);
        received && received->anything_known() && asked->at <= until)
      found.push_back(received);
  return found;
}

const AnswerInbox::Exchange* AnswerInbox::exchange(FrameId frame) const {
  const auto* const asked = of_frame(asked_, frame);
  return asked ? &asked->exchange : nullptr;
}

std::optional<Time> AnswerInbox::asked_at(FrameId frame) const {
  const Asked* const asked = of_frame(asked_, frame);
  return asked ? std::optional(asked->at) : std::nullopt;
}

bool AnswerInbox::is_whole(FrameId frame) const {
  const ReceivedFrame* const received = assembler_.find(frame);
  return received != nullptr && received->complete() && received->report.has_value();
}

bool AnswerInbox::may_come(FrameId frame) const {
  const Asked* const asked = of_frame(asked_, frame);
  return asked != nullptr && asked->session == session_;
}

}  // namespace farshade
