/// Mirror: a window on the desktop that shows what a headset shows, with the overlays and the panel of the
/// preview. It never waits for the desktop: where the display has no free image, or the window is minimised,
/// a frame is not shown. Overlays are drawn on a thread of their own, so they are some frames old.
#pragma once

#include <memory>

#include "vr_client/frame_window.h"
#include "vr_client/preview/overlay_maker.h"

namespace farshade {

/// A window for a mirror, of the size that the last preview has left. Null, with one line in the log, if
/// there is no desktop.
[[nodiscard]] std::unique_ptr<Window> open_mirror_window();

/// What `window` wishes of the device. A device that cannot present is chosen, too.
[[nodiscard]] gpu::Presentation wished_presentation(const Window& window);

/// The controls of a run in a headset, with the options' settings. They lack what the headset decides (head,
/// eyes, time), what begins a new session (mode, capture), what needs memory that is allocated at the start
/// (rate of requests, guard band, reprojection, network path) and what takes longer than a frame (reference,
/// a picture of every frame). `least_report`: On if the run measures frames.
[[nodiscard]] Controls headset_controls(const Options& options, PixelReport least_report);

class Mirror {
 public:
  /// `window` may be null; then only the recording of the head works. If it cannot show what the client's
  /// device draws, it is closed, with a warning. Of `options`, the size of an eye, mode and output folder are
  /// read. Keeps the references.
  Mirror(const Options& options, Client& client, std::unique_ptr<Window> window, Controls& controls);

  /// Applies the window's input to the controls and shows a frame that the headset has got already. A window
  /// that fails is closed, with a warning. Throws nothing.
  void watch(const FrameView& view);

  /// The same while the headset shows no frame: the window stays alive with the last picture.
  void idle();

  /// The device is lost. The window keeps its last picture until take_device.
  void leave_device();
  /// The client has another device, with another renderer.
  void take_device();

  /// The user has closed the window or pressed Escape.
  [[nodiscard]] bool wants_to_end() const;

  /// Frames that the window has shown.
  [[nodiscard]] std::uint64_t frames() const { return frames_; }
  /// Says how many frames the window has shown, and ends the recording of the head. Returns its failure.
  [[nodiscard]] Expected<void> finish();

 private:
  [[nodiscard]] RunFacts facts() const { return {{lights_, head_, nullptr}, mode_, {}}; }
  void take_input();
  void show(const FrameView& view);
  void show_overlay(const FrameView& view);
  template <class Act>
  void guard(const Act& act);
  void close(const std::string& why);

  Client& client_;
  Controls& controls_;
  Mode mode_;
  Recordings recordings_;
  std::unique_ptr<Window> window_;      ///< null after a failure
  std::unique_ptr<FrameWindow> shown_;  ///< like the window
  OverlayMaker overlays_;
  LightSet lights_;                         ///< of the last frame
  Rigid<Stage, Head> head_;                 ///< of the last frame
  std::optional<Composition> composition_;  ///< of the last frame
  std::uint64_t frames_ = 0;
  enum class Quit : std::uint8_t { No, Wanted } quit_ = Quit::No;
};

}  // namespace farshade
