#include "vr_client/modes/surround.h"

#include <algorithm>

#include "vr_client/modes/masks.h"

namespace farshade {

bool Surround::is_under_way() const {
  return std::ranges::any_of(link_->inbox().surround_records(), [&](const RequestRecord& record) {
    return link_->inbox().may_come(record.request.frame) && !link_->inbox().is_settled(record);
  });
}

bool Surround::plan(const FrameInputs& inputs, Duration lead) {
  requests_.clear();
  sent_.clear();
  if (link_ == nullptr || !link_->takes_parts() || !link_->inbox().offers(Answer::Surround)) return false;
  if (inputs.settings.carry_over.lookup == Lookup::Direct) return false;  // nothing would look it up
  const SceneMotion motion = inputs.settings.scene == SceneClock::Paused ? SceneMotion::Still : motion_;
  if (face_size(inputs.shown.views[0].size).pixels() > link_->inbox().most_pixels()) return false;
  requests_ = plan_.ask(inputs.shown, lead, inputs.settings.scene, motion, is_under_way());
  return !requests_.empty() && plan_.is_urgent();
}

void Surround::send(const FrameInputs& inputs) {
  for (const FrameRequest& request : requests_) {
    link_->request(request, inputs.shown.display_time);
    sent_.push_back(request.frame);
  }
  requests_.clear();
}

void Surround::receive(const FrameInputs& inputs) {
  masks_.clear();
  cost_ = {};
  if (link_ == nullptr) return;
  const bool is_virtual = policy_.pace == Pace::Virtual;
  // After a server has let the patience run out, the client does not wait until it has answered again.
  if (is_virtual)
    for (const FrameId sent : sent_)
      is_answering_ = wait_until_idle(*link_, sent, is_answering_ ? kVirtualPatience : Duration::zero());
  const Time until = is_virtual ? inputs.shown.display_time - policy_.delay + policy_.mask_wait : Time::max();
  for (const RequestRecord* record : link_->inbox().surround(until)) masks_.push_back(mask_of(*record));
  add_costs();
}

std::vector<FaceRequest> Surround::asked() const {
  std::vector<FaceRequest> asked;
  for (const FrameId sent : sent_)
    if (const RequestRecord* const record = link_->inbox().find(sent))
      asked.push_back({record->request, record->slot});
  return asked;
}

void Surround::add_costs() {
  const std::optional<Time> counted = counted_until_;
  for (const RequestRecord& record : link_->inbox().surround_records()) {
    if (!record.report || (counted && *record.report_arrived <= *counted)) continue;
    cost_.rays += record.report->primary_rays + record.report->shadow_rays;
    cost_.bytes += record.report->payload_bytes;
    cost_.server += total_work(*record.report);
    counted_until_ = std::max(counted_until_.value_or(*record.report_arrived), *record.report_arrived);
  }
}

}  // namespace farshade
