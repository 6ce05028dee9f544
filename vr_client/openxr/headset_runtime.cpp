#include "vr_client/openxr/headset_runtime.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <thread>

#include "stereo/base/check.h"
#include "stereo/math/rotation.h"
#include "vr_client/openxr/actions.h"
#include "vr_client/openxr/blocking_calls.h"
#include "vr_client/openxr/life_cycle.h"
#include "vr_client/openxr/picture_copy.h"
#include "vr_client/openxr/session.h"
#include "vr_client/openxr/visibility_mask.h"

namespace farshade {

using namespace openxr;

namespace {

constexpr Duration kIdleWait = std::chrono::milliseconds(20);
/// Between two questions whether the headset is there again. The user may want to end at each of their steps.
constexpr Duration kLostStep = std::chrono::milliseconds(100);
constexpr int kLostSteps = 5;

/// A period beyond these is not believed.
constexpr Duration kShortestPeriod = std::chrono::milliseconds(1), kLongestPeriod = std::chrono::seconds(1);
constexpr double kUsualRefresh_hz = 72;

SessionState state_of(XrSessionState state) {
  static_assert(static_cast<int>(SessionState::Idle) == XR_SESSION_STATE_IDLE);
  static_assert(static_cast<int>(SessionState::Exiting) == XR_SESSION_STATE_EXITING);
  if (state < XR_SESSION_STATE_IDLE || state > XR_SESSION_STATE_EXITING) return SessionState::None;
  return static_cast<SessionState>(state);
}

/// The middle of both eyes, whose displays may be turned outwards.
Rigid<Tracked, Eye> head_of(const Located& located) {
  const auto& [left, right] = located.tracked_from_eye;
  return interpolate(left, right, 0.5);
}

/// Places the head at `start` and turns it to its direction. The direction of gravity stays.
Rigid<Stage, Tracked> place(const Rigid<Tracked, Eye>& head, const Rigid<Stage, Eye>& start) {
  const glm::dquat turn = rotation_exp({0.0, heading_rad(start.rotation) - heading_rad(head.rotation), 0.0});
  return {turn, start.translation - turn * head.translation};
}

}  // namespace

HeadsetSystem::HeadsetSystem(std::unique_ptr<Instance> instance) : instance_(std::move(instance)) {}
HeadsetSystem::HeadsetSystem(HeadsetSystem&&) noexcept = default;
HeadsetSystem& HeadsetSystem::operator=(HeadsetSystem&&) noexcept = default;
HeadsetSystem::~HeadsetSystem() = default;

Expected<HeadsetSystem> HeadsetSystem::open() {
  return Instance::open().map(
      [](std::unique_ptr<Instance>&& instance) { return HeadsetSystem(std::move(instance)); });
}

std::string HeadsetSystem::name() const {
  return instance_->name();
}

Extent HeadsetSystem::eye_size(double scale) const {
  const auto side = [scale](std::uint32_t recommended, std::uint32_t largest) {
    const double most = std::min(largest, kMaxViewSide_px);
    return static_cast<std::uint32_t>(std::clamp(std::round(recommended * scale), 1.0, std::max(most, 1.0)));
  };
  const Extent recommended = instance_->recommended(), largest = instance_->largest();
  return {side(recommended.width, largest.width), side(recommended.height, largest.height)};
}

gpu::VulkanMaker HeadsetSystem::vulkan() const {
  return instance_->vulkan();
}

class HeadsetRuntime::Parts {
 public:
  Parts(Instance& instance, const gpu::Device& device, const gpu::Image& shown, HeadsetSetup setup)
      : instance_(instance), device_(device), setup_(std::move(setup)), shown_(shown), copy_(device) {}

  Parts(const Parts&) = delete;
  Parts& operator=(const Parts&) = delete;
  ~Parts();

  [[nodiscard]] Expected<void> open_session();
  [[nodiscard]] std::optional<FrameTiming> wait_frame();
  [[nodiscard]] StereoView views() const;
  [[nodiscard]] Time display_time() const { return time_from_ns(frame_.predictedDisplayTime); }
  [[nodiscard]] const PerEye<HiddenArea>* hidden() const;
  [[nodiscard]] Duration period() const;
  [[nodiscard]] double refresh_hz() const;
  void end_frame();
  [[nodiscard]] Expected<void> finish();

  Counters counters;
  std::string history;

 private:
  enum class Frame : std::uint8_t { Begun, None };
  [[nodiscard]] Expected<void> attach_actions(const Session& session);
  [[nodiscard]] bool goes_on() const { return !failed_ && !abandoned_ && life_.ending == Ending::None; }
  [[nodiscard]] bool wants_to_end();
  void poll_events();
  void handle(const XrEventDataBuffer& event);
  void handle_display(const XrEventDataBuffer& event);
  void read_hidden_area();
  void give(const Event& event);
  void carry_out(Act act);
  void replace_session();
  [[nodiscard]] bool fine(XrResult result, const char* call);
  [[nodiscard]] bool wait_for_frame();
  [[nodiscard]] Frame begin_frame();
  void end_empty_frame();
  void place_head();
  [[nodiscard]] std::optional<vk::Image> next_image(const Swapchain& swapchain);
  [[nodiscard]] Frame follow_hands();
  void rest(Duration span) const;

  Instance& instance_;
  const gpu::Device& device_;
  HeadsetSetup setup_;
  const gpu::Image& shown_;
  PictureCopy copy_;
  std::unique_ptr<Actions> actions_;  ///< of all sessions; null: controllers are not used
  bool lost_focus_ = true;            ///< since the controllers were read last
  std::unique_ptr<Session> session_;
  PerEye<HiddenArea> hidden_;         ///< by the lenses, in this session
  std::optional<double> refresh_hz_;  ///< as the runtime states it
  LifeCycle life_;
  XrFrameState frame_{};  ///< the frame that has begun last
  std::optional<Located> located_;
  std::optional<Rigid<Stage, Tracked>> stage_from_tracked_;  ///< empty until a head is seen
  std::vector<XrTime> recentres_;        ///< at these times the space in use gets another origin
  std::optional<Stopwatch> wanted_end_;  ///< since the user wants to end
  BlockingCalls blocking_;               ///< xrWaitFrame
  bool abandoned_ = false;               ///< xrWaitFrame blocks until the end of the program
  std::optional<Error> failed_;
};

/// A call that blocks may still use the device.
HeadsetRuntime::Parts::~Parts() {
  if (abandoned_) gpu::abandon(device_);
}

Expected<void> HeadsetRuntime::Parts::open_session() {
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
Expected<void> HeadsetRuntime::Parts::attach_actions(const Session& session) {
  if (!setup_.follow_hands) return {};
  if (!actions_) {
    Expected<std::unique_ptr<Actions>> made = Actions::create(instance_.handle());
    if (!made) return tl::unexpected(made.error());
    actions_ = std::move(*made);
  }
  return actions_->attach(session.handle());
}

/// Whether the call has succeeded. A loss is an event of the life cycle, any other failure ends the run.
bool HeadsetRuntime::Parts::fine(XrResult result, const char* call) {
  if (XR_SUCCEEDED(result)) return true;
  if (result == XR_ERROR_SESSION_LOST && session_) {
    give(SessionLost{});
  } else if (!failed_) {
    failed_ = error_of(result, call);
    if (result == XR_ERROR_INSTANCE_LOST) give(InstanceLost{});
  }
  return false;
}

void HeadsetRuntime::Parts::give(const Event& event) {
  const Step step = after(life_, event);
  life_ = step.now;
  carry_out(step.act);
}

void HeadsetRuntime::Parts::carry_out(Act act) {
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
      return replace_session();
  }
}

bool HeadsetRuntime::Parts::wants_to_end() {
  if (!wanted_end_ && setup_.wants_to_end()) wanted_end_.emplace();
  return wanted_end_.has_value();
}

/// Blocks until there is a session again, the user wants to end, or the runtime ends. The headset may go
/// again between two calls.
void HeadsetRuntime::Parts::replace_session() {
  spdlog::warn("the headset's session is lost; waiting for the headset");
  session_.reset();
  recentres_.clear();
  stage_from_tracked_.reset();
  while (goes_on() && !wants_to_end()) {
    const Expected<void> opened = instance_.find_again(device_).and_then([this] { return open_session(); });
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

void HeadsetRuntime::Parts::poll_events() {
  while (goes_on()) {
    XrEventDataBuffer event{XR_TYPE_EVENT_DATA_BUFFER, nullptr, {}};
    const XrResult result = xrPollEvent(instance_.handle(), &event);
    if (result == XR_EVENT_UNAVAILABLE || !fine(result, "xrPollEvent")) return;
    handle(event);
  }
}

void HeadsetRuntime::Parts::handle(const XrEventDataBuffer& event) {
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
      history += (history.empty() ? "" : ", ") + std::string(name_of(to));
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

void HeadsetRuntime::Parts::handle_display(const XrEventDataBuffer& event) {
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

void HeadsetRuntime::Parts::read_hidden_area() {
  if (setup_.hides) hidden_ = read_hidden(instance_, session_->handle());
}

void HeadsetRuntime::Parts::rest(Duration span) const {
  setup_.idle();
  setup_.sleep ? setup_.sleep(span) : std::this_thread::sleep_for(span);
}

/// Waits until the next frame should begin. A runtime that blocks for longer than the user wants is left.
bool HeadsetRuntime::Parts::wait_for_frame() {
  struct Waited {
    XrFrameState state;
    XrResult result;
  };
  const auto waited = std::make_shared<Waited>();
  const auto goes_on = [this] {
    setup_.idle();
    return !wants_to_end() || wanted_end_->elapsed() < setup_.longest_exit;
  };
  const auto wait = [waited, session = session_->handle()] {
    waited->result = Session::wait_frame(session, waited->state);
  };
  if (!blocking_.run(wait, goes_on)) {
    spdlog::warn("the OpenXR runtime blocks xrWaitFrame; the client ends without it");
    abandoned_ = true;
    if (actions_) actions_->abandon();
    session_->abandon();
    instance_.abandon();
    return false;
  }
  frame_ = waited->state;
  return fine(waited->result, "xrWaitFrame");
}

/// Begins a frame. None if it needs no picture; then it has ended, too.
HeadsetRuntime::Parts::Frame HeadsetRuntime::Parts::begin_frame() {
  located_.reset();
  if (!wait_for_frame()) return Frame::None;
  if (!fine(session_->begin_frame(), "xrBeginFrame")) return Frame::None;
  if (frame_.shouldRender && !fine(session_->locate(frame_.predictedDisplayTime, located_), "xrLocateViews"))
    return Frame::None;
  if (located_) return Frame::Begun;
  end_empty_frame();
  return Frame::None;
}

void HeadsetRuntime::Parts::end_empty_frame() {
  ++counters.empty;
  static_cast<void>(fine(session_->end_frame(frame_.predictedDisplayTime, {}, Depth::None), "xrEndFrame"));
  setup_.idle();
}

std::optional<FrameTiming> HeadsetRuntime::Parts::wait_frame() {
  while (goes_on()) {
    if (wants_to_end()) return std::nullopt;
    poll_events();
    if (!goes_on()) break;
    if (!life_.has_frames()) {
      rest(kIdleWait);
      continue;
    }
    if (begin_frame() == Frame::None) continue;
    place_head();
    if (follow_hands() == Frame::None) continue;
    return FrameTiming{display_time(), period()};
  }
  return std::nullopt;
}

/// At the start, if the head is seen for the first time, or the user has recentred.
void HeadsetRuntime::Parts::place_head() {
  const auto has_come = [this](XrTime recentre) { return recentre <= frame_.predictedDisplayTime; };
  if (std::erase_if(recentres_, has_come) > 0) stage_from_tracked_.reset();
  if (!stage_from_tracked_) stage_from_tracked_ = place(head_of(*located_), setup_.start);
}

/// Lets the controllers move the viewer of the frame that has begun. None if a call has failed. Between two
/// times with the focus there is a frame without hands, so that no button seems pressed all the time.
HeadsetRuntime::Parts::Frame HeadsetRuntime::Parts::follow_hands() {
  if (!setup_.follow_hands) return Frame::Begun;
  std::optional<Hands> hands;
  if (life_.state == SessionState::Focused && !std::exchange(lost_focus_, false)) {
    const Called called = actions_->read(session_->space(), frame_.predictedDisplayTime, hands);
    if (!fine(called.result, called.name)) return Frame::None;
  }
  const Rigid<Tracked, Eye> head = head_of(*located_);
  stage_from_tracked_ =
      setup_.follow_hands({display_time(), {head.rotation, head.translation}, *stage_from_tracked_, hands});
  return Frame::Begun;
}

StereoView HeadsetRuntime::Parts::views() const {
  check(located_ && stage_from_tracked_, "views are located after a frame has begun");
  StereoView views;
  for (std::size_t eye = 0; eye < kEyes; ++eye)
    views[eye] = {*stage_from_tracked_ * located_->tracked_from_eye[eye], located_->fov[eye],
                  setup_.eye_size};
  return views;
}

const PerEye<HiddenArea>* HeadsetRuntime::Parts::hidden() const {
  return hidden_ == PerEye<HiddenArea>{} ? nullptr : &hidden_;
}

/// Between two frames, as the runtime predicts it; if that cannot be, as the display's rate says.
Duration HeadsetRuntime::Parts::period() const {
  const Duration predicted(frame_.predictedDisplayPeriod);
  if (predicted >= kShortestPeriod && predicted <= kLongestPeriod) return predicted;
  return duration_from_ms(1e3 / refresh_hz_.value_or(kUsualRefresh_hz));
}

double HeadsetRuntime::Parts::refresh_hz() const {
  return refresh_hz_.value_or(1 / seconds_of(period()));
}

/// An image of the runtime that may be written to. Empty if a call has failed.
std::optional<vk::Image> HeadsetRuntime::Parts::next_image(const Swapchain& swapchain) {
  vk::Image image;
  if (!fine(swapchain.acquire(image), "xrAcquireSwapchainImage")) return std::nullopt;
  const XrResult waited = swapchain.wait();
  if (!fine(waited, "xrWaitSwapchainImage")) return std::nullopt;
  if (waited == XR_TIMEOUT_EXPIRED) {
    failed_ = error_of(waited, "xrWaitSwapchainImage");
    return std::nullopt;
  }
  return image;
}

void HeadsetRuntime::Parts::end_frame() {
  const Swapchain& pictures = session_->pictures();
  const Swapchain* const depths = setup_.depth ? session_->depths() : nullptr;
  const std::optional<vk::Image> picture = next_image(pictures);
  if (!picture) return;
  const std::optional<vk::Image> depth = depths ? next_image(*depths) : std::nullopt;
  if (depths && !depth) return;
  std::vector<LayerCopy> copies{
      {shown_, 0, vk::ImageLayout::eGeneral, *picture, vk::ImageLayout::eColorAttachmentOptimal}};
  if (depths) {
    const HeadsetDepth shown = setup_.depth();
    copies.push_back({shown.image, shown.first_layer, vk::ImageLayout::eShaderReadOnlyOptimal, *depth,
                      vk::ImageLayout::eDepthStencilAttachmentOptimal});
  }
  const Stopwatch watch;
  copy_.copy(copies, setup_.eye_size);
  counters.copying += watch.elapsed();
  if (!fine(pictures.release(), "xrReleaseSwapchainImage") ||
      (depths && !fine(depths->release(), "xrReleaseSwapchainImage")))
    return;
  if (fine(
          session_->end_frame(frame_.predictedDisplayTime, located_, depths ? Depth::Submitted : Depth::None),
          "xrEndFrame"))
    ++counters.submitted;
}

/// Frames must go on until the runtime stops the session.
Expected<void> HeadsetRuntime::Parts::finish() {
  if (!wanted_end_) wanted_end_.emplace();
  if (goes_on()) give(ExitWanted{});
  while (goes_on()) {
    poll_events();
    if (!goes_on()) break;
    if (wanted_end_->elapsed() > setup_.longest_exit) {
      spdlog::warn("the OpenXR runtime did not end the session within {:.0f} s",
                   seconds_of(setup_.longest_exit));
      break;
    }
    if (!life_.has_frames())
      rest(kIdleWait);
    else if (begin_frame() == Frame::Begun)
      end_empty_frame();
  }
  session_.reset();
  if (failed_) return tl::unexpected(*failed_);
  return {};
}

HeadsetRuntime::HeadsetRuntime(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
HeadsetRuntime::~HeadsetRuntime() = default;

Expected<std::unique_ptr<HeadsetRuntime>> HeadsetRuntime::open(HeadsetSystem& system,
                                                               const gpu::Device& device,
                                                               const gpu::Image& shown, HeadsetSetup setup) {
  auto parts = std::make_unique<Parts>(*system.instance_, device, shown, std::move(setup));
  if (auto opened = parts->open_session(); !opened) return tl::unexpected(opened.error());
  return std::unique_ptr<HeadsetRuntime>(new HeadsetRuntime(std::move(parts)));
}

std::optional<FrameTiming> HeadsetRuntime::wait_frame() {
  return parts_->wait_frame();
}

StereoView HeadsetRuntime::locate_views(Time display_time) const {
  check(display_time == parts_->display_time(), "views are those of the frame that has begun");
  return parts_->views();
}

const PerEye<HiddenArea>* HeadsetRuntime::hidden() const {
  return parts_->hidden();
}

double HeadsetRuntime::refresh_hz() const {
  return parts_->refresh_hz();
}

void HeadsetRuntime::end_frame(Time) {
  parts_->end_frame();
}

Expected<void> HeadsetRuntime::finish() {
  return parts_->finish();
}

const HeadsetRuntime::Counters& HeadsetRuntime::counters() const {
  return parts_->counters;
}

const std::string& HeadsetRuntime::history() const {
  return parts_->history;
}

}  // namespace farshade
