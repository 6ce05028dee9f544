#include "vr_client/openxr/headset_runtime.h"

#include <spdlog/spdlog.h>

#include "stereo/base/check.h"
#include "stereo/math/rotation.h"
#include "vr_client/openxr/blocking_calls.h"
#include "vr_client/openxr/headset_session.h"
#include "vr_client/openxr/picture_copy.h"

namespace farshade::openxr {
namespace {

constexpr Duration kIdleWait = std::chrono::milliseconds(20);

/// A period beyond these is not believed.
constexpr Duration kShortestPeriod = std::chrono::milliseconds(1), kLongestPeriod = std::chrono::seconds(1);
constexpr double kUsualRefresh_hz = 72;

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

/// The frames of a run: waits for them, locates their views, and submits their pictures.
class OpenXrRuntime final : public HeadsetRuntime {
 public:
  OpenXrRuntime(Instance& instance, const gpu::Device& device, const gpu::Image& shown, HeadsetSetup setup)
      : setup_(std::move(setup)), shown_(&shown), session_(instance, device, setup_) {}

  [[nodiscard]] Expected<void> open() { return session_.open(); }
  [[nodiscard]] std::optional<FrameTiming> wait_frame() override;
  [[nodiscard]] StereoView locate_views(Time display_time) override;
  [[nodiscard]] const PerEye<HiddenArea>* hidden() const override {
    return session_.hidden() == PerEye<HiddenArea>{} ? nullptr : &session_.hidden();
  }
  void add_output(const gpu::Recorder& append) override;
  void end_frame(Time display_time) override;
  void leave_device() override {
    is_shown_ = false;
    session_.leave_device();
  }
  void take_device(const gpu::Image& shown) override {
    shown_ = &shown;
    session_.take_device();
  }
  [[nodiscard]] Expected<void> finish() override;
  [[nodiscard]] const Counters& counters() const override { return counters_; }
  [[nodiscard]] double refresh_hz() const override {
    return session_.refresh_hz().value_or(1 / seconds_of(period()));
  }
  [[nodiscard]] const std::string& history() const override { return session_.history(); }

 private:
  enum class Frame : std::uint8_t { Begun, None };
  enum class Output : std::uint8_t { None, Picture, PictureAndDepth };
  [[nodiscard]] Time display_time() const { return time_from_ns(frame_.predictedDisplayTime); }
  [[nodiscard]] Duration period() const;
  [[nodiscard]] bool wait_for_frame();
  [[nodiscard]] Frame begin_frame();
  void end_empty_frame();
  void place_head();
  [[nodiscard]] Frame follow_hands();
  [[nodiscard]] std::optional<vk::Image> next_image(const Swapchain& swapchain);

  HeadsetSetup setup_;
  const gpu::Image* shown_;  ///< not used while there is no device
  HeadsetSession session_;
  XrFrameState frame_{};            ///< the frame that has begun last
  std::optional<Located> located_;  ///< the views that the frame shows
  bool is_shown_ = false;           ///< unless a call has failed since the frame began
  std::optional<Rigid<Stage, Tracked>> stage_from_tracked_;  ///< empty until a head is seen
  Output output_ = Output::None;                             ///< of the frame that has begun, recorded
  BlockingCalls blocking_;                                   ///< xrWaitFrame
  Counters counters_;
};

/// Waits until the next frame should begin. A runtime that blocks for longer than the user wants is left.
bool OpenXrRuntime::wait_for_frame() {
  struct Waited {
    XrFrameState state;
    XrResult result;
  };
  const auto waited = std::make_shared<Waited>();
  const auto goes_on = [this] {
    setup_.idle();
    return !session_.wants_to_end() || !session_.is_overdue();
  };
  const auto wait = [waited, session = session_.current().handle()] {
    waited->result = Session::wait_frame(session, waited->state);
  };
  if (!blocking_.run(wait, goes_on)) {
    spdlog::warn("the OpenXR runtime blocks xrWaitFrame; the client ends without it");
    session_.abandon();
    return false;
  }
  frame_ = waited->state;
  return session_.fine(waited->result, "xrWaitFrame");
}

/// Begins a frame. None if it needs no picture; then it has ended, too.
OpenXrRuntime::Frame OpenXrRuntime::begin_frame() {
  located_.reset();
  if (!wait_for_frame()) return Frame::None;
  if (!session_.fine(session_.current().begin_frame(), "xrBeginFrame")) return Frame::None;
  if (frame_.shouldRender &&
      !session_.fine(session_.current().locate(frame_.predictedDisplayTime, located_), "xrLocateViews"))
    return Frame::None;
  is_shown_ = located_.has_value();
  if (is_shown_) return Frame::Begun;
  end_empty_frame();
  return Frame::None;
}

void OpenXrRuntime::end_empty_frame() {
  ++counters_.empty;
  static_cast<void>(session_.fine(session_.current().end_frame(frame_.predictedDisplayTime, {}, Depth::None),
                                  "xrEndFrame"));
  setup_.idle();
}

std::optional<FrameTiming> OpenXrRuntime::wait_frame() {
  while (session_.goes_on()) {
    if (session_.wants_to_end()) return std::nullopt;
    session_.poll_events();
    if (!session_.goes_on()) break;
    if (!session_.has_frames()) {
      session_.rest(kIdleWait);
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
void OpenXrRuntime::place_head() {
  if (session_.has_recentred(frame_.predictedDisplayTime)) stage_from_tracked_.reset();
  if (!stage_from_tracked_) stage_from_tracked_ = place(head_of(*located_), setup_.start);
}

/// Lets the controllers move the viewer of the frame that has begun. None if a call has failed.
OpenXrRuntime::Frame OpenXrRuntime::follow_hands() {
  if (!setup_.follow_hands) return Frame::Begun;
  std::optional<Hands> hands;
  if (session_.keeps_focus()) {
    const Called called =
        session_.actions().read(session_.current().space(), frame_.predictedDisplayTime, hands);
    if (!session_.fine(called.result, called.name)) return Frame::None;
  }
  const Rigid<Tracked, Eye> head = head_of(*located_);
  stage_from_tracked_ =
      setup_.follow_hands({display_time(), {head.rotation, head.translation}, *stage_from_tracked_, hands});
  return Frame::Begun;
}

/// If the head is not seen any more, the views so far stay.
StereoView OpenXrRuntime::locate_views(Time display_time) {
  check(display_time == this->display_time(), "views are those of the frame that has begun");
  check(located_ && stage_from_tracked_, "views are located after a frame has begun");
  std::optional<Located> newest;
  if (is_shown_)
    is_shown_ =
        session_.fine(session_.current().locate(frame_.predictedDisplayTime, newest), "xrLocateViews");
  if (newest) located_ = newest;
  StereoView views;
  for (std::size_t eye = 0; eye < kEyes; ++eye)
    views[eye] = {*stage_from_tracked_ * located_->tracked_from_eye[eye], located_->fov[eye],
                  setup_.eye_size};
  return views;
}

/// Between two frames, as the runtime predicts it; if that cannot be, as the display's rate says.
Duration OpenXrRuntime::period() const {
  const Duration predicted(frame_.predictedDisplayPeriod);
  if (predicted >= kShortestPeriod && predicted <= kLongestPeriod) return predicted;
  return duration_from_ms(1e3 / session_.refresh_hz().value_or(kUsualRefresh_hz));
}

/// An image of the runtime that may be written to. Empty if a call has failed.
std::optional<vk::Image> OpenXrRuntime::next_image(const Swapchain& swapchain) {
  vk::Image image;
  if (!session_.fine(swapchain.acquire(image), "xrAcquireSwapchainImage")) return std::nullopt;
  const XrResult waited = swapchain.wait();
  if (!session_.fine(waited, "xrWaitSwapchainImage")) return std::nullopt;
  if (waited == XR_TIMEOUT_EXPIRED) {
    session_.fail_with(error_of(waited, "xrWaitSwapchainImage"));
    return std::nullopt;
  }
  return image;
}

/// The images are acquired and waited for before the copies into them are recorded, and released after they
/// were submitted.
void OpenXrRuntime::add_output(const gpu::Recorder& append) {
  output_ = Output::None;
  if (!is_shown_) return;
  const Swapchain& pictures = session_.current().pictures();
  const Swapchain* const depths = setup_.depth ? session_.current().depths() : nullptr;
  const std::optional<vk::Image> picture = next_image(pictures);
  if (!picture) return;
  const std::optional<vk::Image> depth = depths ? next_image(*depths) : std::nullopt;
  if (depths && !depth) return;
  std::vector<LayerCopy> copies{
      {*shown_, 0, vk::ImageLayout::eGeneral, *picture, vk::ImageLayout::eColorAttachmentOptimal}};
  if (depths) {
    const HeadsetDepth shown = setup_.depth();
    copies.push_back({shown.image, shown.first_layer, vk::ImageLayout::eShaderReadOnlyOptimal, *depth,
                      vk::ImageLayout::eDepthStencilAttachmentOptimal});
  }
  append([&](const vk::raii::CommandBuffer& commands) { record_copies(commands, copies, setup_.eye_size); });
  output_ = depths ? Output::PictureAndDepth : Output::Picture;
}

void OpenXrRuntime::end_frame(Time) {
  if (output_ == Output::None) return;
  const bool has_depth = output_ == Output::PictureAndDepth;
  Session& session = session_.current();
  if (!session_.fine(session.pictures().release(), "xrReleaseSwapchainImage") ||
      (has_depth && !session_.fine(session.depths()->release(), "xrReleaseSwapchainImage")))
    return;
  if (session_.fine(session.end_frame(frame_.predictedDisplayTime, located_,
                                      has_depth ? Depth::Submitted : Depth::None),
                    "xrEndFrame"))
    ++counters_.submitted;
}

/// Frames must go on until the runtime stops the session.
Expected<void> OpenXrRuntime::finish() {
  session_.want_to_end();
  while (session_.goes_on()) {
    session_.poll_events();
    if (!session_.goes_on()) break;
    if (session_.is_overdue()) {
      spdlog::warn("the OpenXR runtime did not end the session within {:.0f} s",
                   seconds_of(setup_.longest_exit));
      break;
    }
    if (!session_.has_frames())
      session_.rest(kIdleWait);
    else if (begin_frame() == Frame::Begun)
      end_empty_frame();
  }
  return session_.close();
}

}  // namespace

Expected<std::unique_ptr<HeadsetRuntime>> Instance::open_runtime(const gpu::Device& device,
                                                                 const gpu::Image& shown,
                                                                 HeadsetSetup setup) {
  auto runtime = std::make_unique<OpenXrRuntime>(*this, device, shown, std::move(setup));
  return runtime->open().map([&]() -> std::unique_ptr<HeadsetRuntime> { return std::move(runtime); });
}

}  // namespace farshade::openxr
