#include "vr_client/modes/mask_stream.h"

#include <algorithm>

#include "stereo/messages/timing.h"

namespace farshade {
namespace {

/// If a part of an answer has come, and then nothing more for so long, the rest counts as lost. Longer than
/// a busy machine holds up a server.
constexpr Duration kIdle = std::chrono::seconds(1), kPoll = std::chrono::milliseconds(100);

static_assert(kVirtualPatience < kSessionTimeout, "a client that waits for a lost request keeps its session");

}  // namespace

bool wait_until_idle(ServerConnection& link, FrameId frame, Duration patience) {
  const auto known = [&] {
    const RequestRecord* const received = link.receiver().find(frame);
    // A report alone is news, too: nothing that was asked for has reached the server.
    return received == nullptr ? 0 : received->pieces_known() + (received->report ? 1 : 0);
  };
  std::uint32_t before = 0;
  Duration idle{};
  for (Duration waited{}; waited <= patience && idle < kIdle; waited += kPoll) {
    if (link.wait_for(frame, std::min(kPoll, patience - waited))) return true;
    const bool is_waiting_for_more = before > 0 && known() == before;
    idle = is_waiting_for_more ? idle + kPoll : Duration::zero();
    before = known();
  }
  return before > 0;
}

DrawnFrame draw_black(Renderer& renderer, const StereoView& shown) {
  const PerEye<Image<Rgb8>> black{Image<Rgb8>(shown[0].size), Image<Rgb8>(shown[1].size)};
  renderer.show_timewarped(black, shown, shown);
  return {.as = ShownAs::Picture, .start_up = true, .black = {1.0, 1.0}};
}

MaskStream::MaskStream(ServerConnection* link, const MaskPolicy& policy, const RequestSettings& settings,
                       SceneMotion motion)
    : link_(link), policy_(policy), plan_(settings) {
  plan_.expect(motion);
  plan_.learn(policy.pace == Pace::Real ? policy.round_trip : policy.delay - policy.mask_wait);
}

std::optional<FrameRequest> MaskStream::plan(const FrameInputs& inputs, const AnswerSpec& answer) {
  if (link_ == nullptr) return std::nullopt;
  RequestSettings settings = inputs.settings.request;
  const bool is_picture = is_drawn(answer.kind);
  if (answer.kind == Answer::GBuffer) settings.guard_band = GuardBandUse::Off;
  plan_.follow(settings);
  plan_.use(is_picture ? AnswerUse::Timewarped : AnswerUse::Reprojected);
  plan_.shrink(is_picture ? kFullViewScale : link_->receiver().view_scale());
  plan_.limit(link_->receiver().most_pixels());
  std::optional<FrameRequest> request = plan_.ask(inputs.shown, inputs.period, inputs.settings.scene);
  if (request) request->answer = answer;
  return request;
}

void MaskStream::send(const FrameInputs& inputs, const FrameRequest& request, const RequestParts& parts) {
  requested_ = request.frame;
  link_->request(request, inputs.shown.display_time, parts);
}

const RequestRecord* MaskStream::newest_settled(const FrameInputs& inputs) {
  if (policy_.pace == Pace::Real) link_->wait_for(requested_, Duration::zero());
  for (const RequestRecord* record : link_->receiver().received(usable_until(inputs.shown.display_time)))
    if (link_->receiver().is_settled(*record)) return record;
  return nullptr;
}

std::span<const RequestRecord* const> MaskStream::receive(const FrameInputs& inputs) {
  received_.clear();
  settled_ = nullptr;
  if (link_ == nullptr) return received_;
  wait_for_answer();
  received_ = link_->receiver().received(usable_until(inputs.shown.display_time));
  settle(inputs);
  return received_;
}

void MaskStream::settle(const FrameInputs& inputs) {
  for (const RequestRecord* record : received_) {
    if (!link_->receiver().is_settled(*record)) continue;
    if (settled_ == nullptr) settled_ = record;
    if (is_newer(record->request.frame, newest_learned_)) plan_.learn(age_of(*record, inputs));
  }
  if (settled_ != nullptr) newest_learned_ = settled_->request.frame;
  if (settled_ == nullptr && !received_.empty()) settled_ = received_.front();
}

void MaskStream::drawn_with(const FrameInputs& inputs, const RequestRecord& record) {
  plan_.drawn_with(inputs.shown.views, record.request.views, age_of(record, inputs));
}

const RequestRecord* MaskStream::record(std::optional<FrameId> request) const {
  return request && link_ ? link_->receiver().find(*request) : nullptr;
}

/// After a server has let the patience run out, the client does not wait until the server has answered again.
void MaskStream::wait_for_answer() {
  if (policy_.pace == Pace::Real) {
    link_->wait_for(requested_, policy_.mask_wait);
  } else if (requested_ != waited_for_) {
    const Duration patience = is_answering_ ? kVirtualPatience : Duration::zero();
    const RequestRecord* const before = link_->receiver().find(waited_for_);
    is_answering_ =
        wait_until_idle(*link_, requested_, patience) || (before != nullptr && before->complete());
    waited_for_ = requested_;
  }
}

Time MaskStream::usable_until(Time display_time) const {
  if (policy_.pace == Pace::Real) return Time::max();
  return display_time - policy_.delay + policy_.mask_wait;
}

}  // namespace farshade
