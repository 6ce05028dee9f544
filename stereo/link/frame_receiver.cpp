#include "stereo/link/frame_receiver.h"

#include <algorithm>

namespace farshade {

void FrameReceiver::begin(const Welcome& welcome) {
  most_pixels_ = welcome.most_pixels;
  answers_ = welcome.answers;
  exposure_ = welcome.exposure;
  acknowledged_ = kFirstLightSet;
  newest_report_.reset();
  ++session_;
}

FrameRequest FrameReceiver::ask(const FrameRequest& request, Time requested_at, Time now,
                                const PerEye<EyeMask>* reprojected) {
  FrameRequest sent = request;
  sent.lights = since(request.lights, acknowledged_, RequestMessage::kMostLightChanges);
  // The masks of the answer are of this light set.
  FrameRequest expected = request;
  expected.lights = up_to(request.lights, sent.lights.revision);
  Assembler& assembler = request.answer.kind == Answer::CubeMask ? cube_mask_ : assembler_;
  assembler.expect(expected, layout_, expected.lights.revision,
                   {.requested_at = requested_at, .sent = now, .session = session_}, reprojected);
  return sent;
}

Assembler& FrameReceiver::assembler_of(FrameId frame) {
  return cube_mask_.find(frame) != nullptr ? cube_mask_ : assembler_;
}

const RequestRecord* FrameReceiver::find(FrameId frame) const {
  const RequestRecord* const found = assembler_.find(frame);
  return found != nullptr ? found : cube_mask_.find(frame);
}

namespace {

/// Of two usable records of one pair: a whole one is better than one with holes, if both have one light set.
/// Otherwise the newer one is.
bool is_better(const RequestRecord& a, const RequestRecord& b) {
  if (a.light_set_revision == b.light_set_revision && a.complete() != b.complete()) return a.complete();
  return is_newer(a.request.frame, b.request.frame);
}

}  // namespace

std::vector<const RequestRecord*> FrameReceiver::cube_mask(Time until) const {
  const auto is_final = [&](const RequestRecord& record) {
    return record.complete() || record.report ||
           std::ranges::any_of(cube_mask_.records(), [&](const RequestRecord& other) {
             return other.anything_known() && is_newer(other.request.frame, record.request.frame) &&
                    pair_of(other.request.frame) == pair_of(record.request.frame);
           });
  };
  std::array<const RequestRecord*, kCubeMaskPairs> best{};
  for (const RequestRecord& record : cube_mask_.records()) {
    const RequestRecord*& of_pair = best[pair_of(record.request.frame)];
    if (!record.anything_known() || record.origin.requested_at > until || !is_final(record)) continue;
    if (of_pair == nullptr || is_better(record, *of_pair)) of_pair = &record;
  }
  std::vector<const RequestRecord*> found;
  std::ranges::copy_if(best, std::back_inserter(found), [](const RequestRecord* record) { return record; });
  return found;
}

AssemblerCounters FrameReceiver::counters() const {
  AssemblerCounters all = assembler_.counters();
  return all += cube_mask_.counters();
}

/// A piece of an answer shows which light set the server has.
void FrameReceiver::acknowledge(const RequestRecord* changed) {
  if (changed != nullptr && is_newer(changed->light_set_revision, acknowledged_))
    acknowledged_ = changed->light_set_revision;
}

void FrameReceiver::take(const FrameReport& report, Time arrived) {
  assembler_of(report.frame).accept(report, arrived);
  if (cube_mask_.find(report.frame) != nullptr) return;
  if (newest_report_ && !is_newer(report.frame, *newest_report_)) return;
  newest_report_ = report.frame;
  view_scale_ = report.view_scale;
}

std::vector<const RequestRecord*> FrameReceiver::received(Time until) const {
  std::vector<const RequestRecord*> found;
  for (const RequestRecord& record : assembler_.records())
    if (record.anything_known() && record.origin.requested_at <= until) found.push_back(&record);
  std::ranges::sort(found, [](const RequestRecord* a, const RequestRecord* b) {
    return is_newer(a->request.frame, b->request.frame);
  });
  return found;
}

bool FrameReceiver::is_whole(FrameId frame) const {
  const RequestRecord* const record = find(frame);
  return record != nullptr && record->complete() && record->report.has_value();
}

bool FrameReceiver::is_settled(const RequestRecord& record) const {
  if (record.complete() || record.report) return true;
  const RequestRecord* const newest =
      (record.request.answer.kind == Answer::CubeMask ? cube_mask_ : assembler_).newest_known();
  return newest != nullptr && is_newer(newest->request.frame, record.request.frame);
}

bool FrameReceiver::may_come(FrameId frame) const {
  const RequestRecord* const record = find(frame);
  return record != nullptr && record->origin.session == session_;
}

}  // namespace farshade
