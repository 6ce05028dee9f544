#include "vr_client/mirror.h"

#include <spdlog/spdlog.h>

#include <utility>

namespace farshade {
namespace {

constexpr Command kAbsent[] = {
    Command::Reference,   Command::NextMode,      Command::Reprojection, Command::GuardBand,
    Command::SlowerMasks, Command::FasterMasks,   Command::WorsePath,    Command::BetterPath,
    Command::HeadSource,  Command::PlayPause,     Command::Back,         Command::Forward,
    Command::Slower,      Command::Faster,        Command::Loop,         Command::WiderEyes,
    Command::CloserEyes,  Command::WiderFov,      Command::NarrowerFov,  Command::HoldFrame,
    Command::NextFrame,   Command::RecordCapture, Command::RecordFrames};

}  // namespace

std::unique_ptr<Window> open_mirror_window() {
  const Remembered remembered = recalled();
  Expected<std::unique_ptr<Window>> window = open_window(
      kTitle, [&](const Desktop& desktop) { return first_window({}, desktop, remembered.window); },
      "only the headset shows the scene");
  if (window) return std::move(*window);
  spdlog::info(window.error().what);
  return nullptr;
}

gpu::Presentation wished_presentation(const Window& window) {
  gpu::Presentation presentation = window.presentation();
  presentation.need = gpu::Need::Wished;
  return presentation;
}

Controls headset_controls(const Options& options, PixelReport least_report) {
  Controls controls;
  controls.mode = options.mode.mode;
  controls.modes = {options.mode.mode};
  controls.settings.request = options.request;
  controls.settings.reprojection = options.reprojection;
  controls.settings.report = controls.least_report = least_report;
  for (const Command command : kAbsent) controls.absent.set(static_cast<std::size_t>(command));
  return controls;
}

Mirror::Mirror(const Options& options, Client& client, std::unique_ptr<Window> window, Controls& controls)
    : client_(client),
      controls_(controls),
      mode_(options.mode.mode),
      recordings_(options.out, client.clock),
      window_(std::move(window)),
      lights_(state_at(client.scene, {}).light_set) {
  if (!window_) return;
  if (client.device.presents)
    guard([&] {
      shown_ = std::make_unique<FrameWindow>(client, *window_, controls, recordings_, options.size);
    });
  else
    close(client.device.name + " cannot present on this desktop");
}

/// The window's failures are not the headset's, but a lost device is (run_frames.h).
template <class Act>
void Mirror::guard(const Act& act) try {
  act();
} catch (const vk::DeviceLostError&) {
  throw;
} catch (const std::exception& error) {
  close(error.what());
}

void Mirror::close(const std::string& why) {
  spdlog::warn("no window mirrors the headset: {}", why);
  shown_.reset();
  window_.reset();
  // Nobody can switch them off any more.
  controls_.overlay = Overlay::None;
  controls_.grab.reset();
  controls_.settings.report = controls_.least_report;
}

void Mirror::watch(const FrameView& view) {
  lights_ = view.state.light_set;
  head_ = head_of(view.shown.views);
  recordings_.watch(view, nullptr, nullptr);
  if (!shown_) return;
  guard([&] {
    take_input();
    show(view);
  });
}

void Mirror::idle() {
  if (!shown_) return;
  guard([&] {
    take_input();
    if (!composition_) return;
    composition_->right_px = panel_width_px(controls_, window_->framebuffer_size(), window_->text_scale());
    shown_->show(*composition_, facts(), std::nullopt);
  });
}

void Mirror::leave_device() {
  composition_.reset();
  if (!shown_) return;
  try {
    guard([&] { shown_->leave_device(); });
  } catch (const vk::DeviceLostError&) {
    // It is lost anyway.
  }
}

void Mirror::take_device() {
  if (shown_) guard([&] { shown_->take_device(); });
}

bool Mirror::wants_to_end() const {
  return quit_ == Quit::Wanted || (window_ && window_->should_close());
}

Expected<void> Mirror::finish() {
  if (shown_) spdlog::info("the desktop window showed {} frames", frames_);
  // Before the device can be abandoned, after which nothing on it is destroyed.
  if (wants_to_end()) quit_ = Quit::Wanted;
  shown_.reset();
  window_.reset();
  return recordings_.finish();
}

void Mirror::take_input() {
  apply_input(window_->poll(), controls_, facts().context);
  if (controls_.take(Command::RecordHead)) recordings_.toggle_head();
  if (controls_.take(Command::Quit)) quit_ = Quit::Wanted;
}

void Mirror::show(const FrameView& view) {
  shown_->begin();
  show_overlay(view);
  composition_ = shown_->compose(view);
  if (controls_.take(Command::Screenshot))
    recordings_.take_screenshot(shown_->inspection().shown(), shown_->read_back(*composition_));
  const auto pixel = shown_->inspected(view, *composition_);
  if (shown_->show(*composition_, facts(), pixel) == Presenter::Outcome::Shown) ++frames_;
  shown_->add(view, mode_);
}

/// The newest overlay that is drawn. A frame without a report was drawn before the viewer's wish.
void Mirror::show_overlay(const FrameView& view) {
  const std::optional<PerEye<Image<Rgb8>>> drawn = overlays_.take();
  if (controls_.overlay == Overlay::None || view.as == ShownAs::Picture) return shown_->show_eyes();
  if (drawn) shown_->replace(*drawn);
  if (view.settings.report == PixelReport::On) overlays_.begin(view, *client_.renderer, controls_);
}

}  // namespace farshade
