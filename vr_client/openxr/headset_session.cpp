#include "vr_client/openxr/headset_session.h"

#include <spdlog/spdlog.h>

#include <limits>
#include <thread>

#include "vr_client/openxr/visibility_mask.h"

namespace farshade::openxr {
namespace {

/// Between two questions whether the headset is there again. The user may want to end at each of their steps.
constexpr Duration kLostStep = std::chrono::milliseconds(100);
constexpr int kLostSteps = 5;

SessionState state_of(XrSessionState state) {
  static_assert(static_cast<int>(SessionState::Idle) == XR_SESSION_STATE_IDLE);
  static_assert(static_cast<int>(SessionState::Exiting) == XR_SESSION_STATE_EXITING);
  if (state < XR_SESSION_STATE_IDLE || state > XR_SESSION_STATE_EXITING) return SessionState::None;
  return static_cast<SessionState>(state);
}

}  // namespace

/// A call that blocks may still use the device.
HeadsetSession::~HeadsetSession() {
  if (abandoned_) gpu::abandon(device_);
  end_session();
}

/// The images of a session may be destroyed when the device has finished the frame that is under way.
void HeadsetSession::end_session() {
  try {
    if (session_ && !abandoned_ && !device_.use->abandoned)
      gpu::run_now(device_, [](const vk::raii::CommandBuffer&) {});
  } catch (const vk::SystemError&) {
    // The device is lost; the frame that used it last is told.
  }
  session_.reset();
}

Expected<void> HeadsetSession::open() {
  Expected<std::unique_ptr<Session>> session = Session::open(instance_, device_, setup_.eye_size);
  if (!session) return tl::unexpected(session.error());
  if (Expected<void> attached = attach_actions(**session); !attached) return attached;
  session_ = std::move(*session);
  read_hidden_area();
  refresh_hz_ = session_->refresh_hz();
  if (refresh_hz_) spdlog::info("the headset's display has {:.4g} Hz", *refresh_hz_);
  spdlog::info("the headset's space is {}; pictures are {}, {} depth", session_->space_name(),
               vk::to_string(session_->pictures().format),
               setup_.depth && session_->depths() ? "with" : "without");
  return {};
}

/// The actions are made once and attached to every session.
Expected<void> HeadsetSession::attach_actions(const Session& session) {
  if (!setup_.follow_hands) return {};
  if (!actions_) {
    Expected<std::unique_ptr<Actions>> made = Actions::create(instance_.handle());
    if (!made) return tl::unexpected(made.error());
    actions_ = std::move(*made);
  }
  return actions_->attach(session.handle());
}

bool HeadsetSession::fine(XrResult result, const char* call) {
  if (XR_SUCCEEDED(result)) return true;
  if (result == XR_ERROR_SESSION_LOST && session_) {
    give(SessionLost{});
  } else if (!failed_) {
    failed_ = error_of(result, call);
    if (result == XR_ERROR_INSTANCE_LOST) give(InstanceLost{});
  }
  return false;
}

void HeadsetSession::give(const Event& event) {
  const Step step = after(life_, event);
  life_ = step.now;
  carry_out(step.act);
}

void HeadsetSession::carry_out(Act act) {
  switch (act) {
    case Act::Nothing:
    case Act::Finish:
      return;
    case Act::Begin:
      if (fine(session_->begin(), "xrBeginSession")) give(SessionBegan{});
      return;
    case Act::End:
      static_cast<void>(fine(session_->end(), "xrEndSession"));
      give(SessionEnded{});
      return;
    case Act::RequestExit:
      static_cast<void>(fine(session_->request_exit(), "xrRequestExitSession"));
      return;
    case Act::Replace:
      return replace();
  }
}

bool HeadsetSession::wants_to_end() {
  if (!wanted_end_ && setup_.wants_to_end()) wanted_end_.emplace();
  return wanted_end_.has_value();
}

void HeadsetSession::want_to_end() {
  if (!wanted_end_) wanted_end_.emplace();
  if (goes_on()) give(ExitWanted{});
}

void HeadsetSession::abandon() {
  abandoned_ = true;
  if (actions_) actions_->abandon();
  session_->abandon();
  instance_.abandon();
}

/// A call that failed since the device was lost failed because of it.
void HeadsetSession::leave_device() {
  if (life_.ending == Ending::None) failed_.reset();
  end_session();
  give(SessionReplaced{});  // by none: it does not run
}

Expected<void> HeadsetSession::close() {
  end_session();
  if (failed_) return tl::unexpected(*failed_);
  return {};
}

/// Blocks until there is a session again, the user wants to end, or the runtime ends. The headset may go
/// again between two calls.
void HeadsetSession::replace() {
  spdlog::warn("the headset's session is lost; waiting for the headset");
  end_session();
  recentres_ = {std::numeric_limits<XrTime>::min()};  // the new session's space is another one
  while (goes_on() && !wants_to_end()) {
    const Expected<void> opened = instance_.find_again(device_).and_then([this] { return open(); });
    if (opened) return give(SessionReplaced{});
    if (opened.error().fault != Fault::Missing) {
      failed_ = opened.error();
      return;
    }
    for (int step = 0; step < kLostSteps && goes_on() && !wants_to_end(); ++step) {
      rest(kLostStep);
      poll_events();
    }
  }
  if (goes_on()) give(ExitWanted{});
}

void HeadsetSession::poll_events() {
  while (goes_on()) {
    XrEventDataBuffer event{XR_TYPE_EVENT_DATA_BUFFER, nullptr, {}};
    const XrResult result = xrPollEvent(instance_.handle(), &event);
    if (result == XR_EVENT_UNAVAILABLE || !fine(result, "xrPollEvent")) return;
    handle(event);
  }
}

void HeadsetSession::handle(const XrEventDataBuffer& event) {
  switch (event.type) {
    case XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED: {
      const auto& changed = reinterpret_cast<const XrEventDataSessionStateChanged&>(event);
      if (!session_ || changed.session != session_->handle()) return;  // of a session that was lost
      const SessionState to = state_of(changed.state);
      if (!is_in_table(life_.state, to))
        spdlog::warn(
            "the OpenXR runtime changes the session from {} to {}, which the specification does not allow",
            name_of(life_.state), name_of(to));
      spdlog::info("the headset's session is {}", name_of(to));
      if (to != SessionState::Focused) lost_focus_ = true;
      history_ += (history_.empty() ? "" : ", ") + std::string(name_of(to));
      return give(StateChanged{to});
    }
    case XR_TYPE_EVENT_DATA_INSTANCE_LOSS_PENDING:
      failed_ = Error{Fault::Unavailable, "the OpenXR runtime ends"};
      return give(InstanceLossPending{});
    case XR_TYPE_EVENT_DATA_REFERENCE_SPACE_CHANGE_PENDING: {
      const auto& change = reinterpret_cast<const XrEventDataReferenceSpaceChangePending&>(event);
      if (!session_ || change.session != session_->handle()) return;
      if (change.referenceSpaceType == session_->space_type()) recentres_.push_back(change.changeTime);
      return;
    }
    case XR_TYPE_EVENT_DATA_EVENTS_LOST:
      spdlog::warn("the OpenXR runtime has lost events");
      return;
    default:
      return handle_display(event);
  }
}

void HeadsetSession::handle_display(const XrEventDataBuffer& event) {
  if (event.type == XR_TYPE_EVENT_DATA_VISIBILITY_MASK_CHANGED_KHR) {
    const auto& changed = reinterpret_cast<const XrEventDataVisibilityMaskChangedKHR&>(event);
    if (session_ && changed.session == session_->handle()) read_hidden_area();
  } else if (event.type == XR_TYPE_EVENT_DATA_DISPLAY_REFRESH_RATE_CHANGED_FB) {
    const auto& changed = reinterpret_cast<const XrEventDataDisplayRefreshRateChangedFB&>(event);
    if (!is_rate(changed.toDisplayRefreshRate)) return;
    spdlog::info("the headset's display changes from {:.4g} to {:.4g} Hz", changed.fromDisplayRefreshRate,
                 changed.toDisplayRefreshRate);
    refresh_hz_ = changed.toDisplayRefreshRate;
  }
}

void HeadsetSession::read_hidden_area() {
  if (setup_.hides) hidden_ = read_hidden(instance_, session_->handle());
}

void HeadsetSession::rest(Duration span) const {
  setup_.idle();
  setup_.sleep ? setup_.sleep(span) : std::this_thread::sleep_for(span);
}

bool HeadsetSession::keeps_focus() {
  return life_.state == SessionState::Focused && !std::exchange(lost_focus_, false);
}

bool HeadsetSession::has_recentred(XrTime time) {
  return std::erase_if(recentres_, [time](XrTime recentre) { return recentre <= time; }) > 0;
}

}  // namespace farshade::openxr
