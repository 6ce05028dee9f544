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

/// The middle of the eyes, with the orientation of the left eye.
Rigid<Stage, Head> head_of(const StereoView& views) {
  const auto& left = views[0].stage_from_eye;
  const auto& right = views[1].stage_from_eye;
  return {left.rotation, left.translation + (right.translation - left.translation) * 0.5};
}

}  // namespace

std::unique_ptr<Window> open_mirror_window() {
  const Remembered remembered = recalled();
  Expected<std::unique_ptr<Window>> window = open_window(
      kWindowTitle, [&](const Desktop& desktop) { return first_window({}, desktop, remembered.window); });
  if (window) return std::move(*window);
  spdlog::info("no window mirrors the headset: {}", window.error().what);
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
  controls.settings.carry_over = options.carry_over;
  controls.settings.report = controls.least_report = least_report;
  for (const Command command : kAbsent) controls.absent.set(static_cast<std::size_t>(command));
  return controls;
}

std::unique_ptr<Mirror> Mirror::make(const Options& options, Client& client, std::unique_ptr<Window> window,
                                     Controls& controls) {
  if (!window) return nullptr;
  if (client.device.presents) return std::make_unique<Mirror>(options, client, std::move(window), controls);
  spdlog::info("no window mirrors the headset: {} cannot present on this desktop", client.device.name);
  return nullptr;
}

Mirror::Mirror(const Options& options, Client& client, std::unique_ptr<Window> window, Controls& controls)
    : client_(client),
      controls_(controls),
      mode_(options.mode.mode),
      recordings_(options.out, client.clock),
      window_(std::move(window)),
      shown_(std::make_unique<FrameWindow>(client, *window_, controls, recordings_, options.size)),
      lights_(state_at(client.scene, {}).light_set) {}

void Mirror::watch(const FrameView& view) try {
  lights_ = view.state.light_set;
  head_ = head_of(view.shown.views);
  recordings_.watch(view, nullptr, nullptr);
  if (!shown_) return;
  take_input();
  show(view);
} catch (const vk::DeviceLostError&) {
  throw;
} catch (const std::exception& error) {
  close_after(error);
}

void Mirror::idle() try {
  if (!shown_) return;
  take_input();
  if (!composition_) return;
  composition_->right_px = panel_width_px(controls_, window_->framebuffer_size(), window_->text_scale());
  shown_->show(*composition_, facts(), std::nullopt);
} catch (const vk::DeviceLostError&) {
  throw;
} catch (const std::exception& error) {
  close_after(error);
}

bool Mirror::wants_to_end() const {
  return quit_ == Quit::Wanted || (window_ && window_->should_close());
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

void Mirror::close_after(const std::exception& error) {
  spdlog::warn("the window that mirrors the headset is closed: {}", error.what());
  shown_.reset();
  window_.reset();
}

}  // namespace farshade
