#include "vr_client/modes/cube_mask.h"

#include <algorithm>

#include "vr_client/modes/masks.h"

namespace farshade {

namespace {

/// The whole cube masks that earlier pipelines have begun to request on this link.
std::uint32_t begun_on(const ServerConnection* link) {
  std::uint32_t begun = 0;
  if (link == nullptr) return begun;
  for (const RequestRecord& record : link->receiver().cube_mask_records())
    if (const std::uint32_t id = record.request.frame.value; id >= kFirstCubeMaskFrame.value)
      begun = std::max(begun, (id - kFirstCubeMaskFrame.value) / std::uint32_t{kCubeMaskPairs} + 1);
  return begun;
}

}  // namespace

CubeMask::CubeMask(ServerConnection* link, const MaskPolicy& policy, SceneMotion motion)
    : link_(link), policy_(policy), motion_(motion), plan_(begun_on(link)) {}

bool CubeMask::is_under_way() const {
  return std::ranges::any_of(link_->receiver().cube_mask_records(), [&](const RequestRecord& record) {
    return link_->receiver().may_come(record.request.frame) && !link_->receiver().is_settled(record);
  });
}

bool CubeMask::plan(const FrameInputs& inputs, Duration lead) {
  requests_.clear();
  sent_.clear();
  if (link_ == nullptr || !link_->takes_parts() || !link_->receiver().offers(Answer::CubeMask)) return false;
  if (inputs.settings.reprojection.lookup == Lookup::Direct) return false;  // nothing would look it up
  const SceneMotion motion = inputs.settings.scene == SceneClock::Paused ? SceneMotion::Still : motion_;
  if (face_size(inputs.shown.views[0].size).pixels() > link_->receiver().most_pixels()) return false;
  requests_ = plan_.ask(inputs.shown, lead, inputs.settings.scene, motion, is_under_way());
  return !requests_.empty() && plan_.is_urgent();
}

void CubeMask::send(const FrameInputs& inputs) {
  for (const FrameRequest& request : requests_) {
    link_->request(request, inputs.shown.display_time);
    sent_.push_back(request.frame);
  }
  requests_.clear();
}

void CubeMask::receive(const FrameInputs& inputs) {
  masks_.clear();
  cost_ = {};
  if (link_ == nullptr) return;
  const bool is_virtual = policy_.pace == Pace::Virtual;
  // After a server has let the patience run out, the client does not wait until it has answered again.
  if (is_virtual)
    for (const FrameId sent : sent_)
      is_answering_ = wait_until_idle(*link_, sent, is_answering_ ? kVirtualPatience : Duration::zero());
  const Time until = is_virtual ? inputs.shown.display_time - policy_.delay + policy_.mask_wait : Time::max();
  for (const RequestRecord* record : link_->receiver().cube_mask(until)) masks_.push_back(mask_of(*record));
  add_costs();
}

std::vector<FaceRequest> CubeMask::requested() const {
  std::vector<FaceRequest> requested;
  for (const FrameId sent : sent_)
    if (const RequestRecord* const record = link_->receiver().find(sent))
      requested.push_back({record->request, record->slot});
  return requested;
}

void CubeMask::add_costs() {
  const std::optional<Time> counted = counted_until_;
  for (const RequestRecord& record : link_->receiver().cube_mask_records()) {
    if (!record.report || (counted && *record.report_arrived <= *counted)) continue;
    cost_.rays += record.report->primary_rays + record.report->shadow_rays;
    cost_.bytes += record.report->payload_bytes;
    cost_.server += total_work(*record.report);
    counted_until_ = std::max(counted_until_.value_or(*record.report_arrived), *record.report_arrived);
  }
}

}  // namespace farshade
