/// FrameWindow: shows the frames of a run in a window, beside the panel. The preview and the mirror of a
/// headset both show their frames with it.
#pragma once

#include <optional>
#include <string>

#include "vr_client/client.h"
#include "vr_client/preview/inspection.h"
#include "vr_client/preview/panel.h"
#include "vr_client/preview/presenter.h"
#include "vr_client/preview/recordings.h"

namespace farshade {

/// What the panel says beside the figures.
struct RunFacts {
  ControlContext context;
  Mode mode;         ///< of the shown frames
  std::string note;  ///< empty: that of the recordings
};

class FrameWindow {
 public:
  /// `eye` is the size of an eye's picture, which the client's renderer draws. Keeps all references.
  FrameWindow(Client& client, Window& window, Controls& controls, Recordings& recordings, Extent eye);

  /// The client has another renderer. The device has finished all work of the one before.
  void take_renderer() { presenter_->take_eyes(client_.renderer->shown()); }
  /// Destroys what was made on the client's device. Nothing is shown until take_device.
  void leave_device() { presenter_.reset(); }
  /// The client has another device, with another renderer.
  void take_device() { presenter_.emplace(client_.device, window_, client_.renderer->shown()); }

  /// The renderer has drawn a frame.
  void begin() { inspection_.begin(*client_.renderer); }
  [[nodiscard]] Inspection& inspection() { return inspection_; }

  /// From now on the eyes' pictures are shown, or these in their place.
  void show_eyes() { pictures_ = {Picture::LeftEye, Picture::RightEye}; }
  void replace(const PerEye<Image<Rgb8>>& pictures);

  /// How the controls want this frame to be shown, with the panel's place as of now.
  [[nodiscard]] Composition compose(const FrameView& view) const;
  /// The pixel under the mouse, while the inspector is open and the client has shaded it.
  [[nodiscard]] std::optional<PixelFacts> inspected(const FrameView& view,
                                                    const Composition& composition) const;

  /// Shows a composition, unless the window cannot show one now.
  Presenter::Outcome show(const Composition& composition, const RunFacts& run,
                          const std::optional<PixelFacts>& pixel);
  /// The same without the panel, as a picture; empty while the window is minimised.
  [[nodiscard]] Image<Rgb8> read_back(const Composition& composition) const {
    return presenter_->read_back(composition);
  }

  /// Adds a frame to the figures, which end at present, and brings the title up to date once a second.
  void add(const FrameView& view, Mode mode);
  /// The figures begin again.
  void forget() {
    history_ = {};
    titled_.reset();  // the title may say what the restart waits for
  }

 private:
  [[nodiscard]] PanelFacts facts_of(const RunFacts& run, const std::optional<PixelFacts>& pixel) const;
  [[nodiscard]] std::string server_state(Mode mode) const;
  /// `waits`: no answer that the mode needs has come yet.
  void update_title(Mode mode, bool waits);

  Client& client_;
  Window& window_;
  Controls& controls_;
  Recordings& recordings_;
  Extent eye_;
  std::optional<Presenter> presenter_;  ///< set while there is a device
  Inspection inspection_;
  History history_;
  PerEye<Picture> pictures_{Picture::LeftEye, Picture::RightEye};
  std::optional<Time> titled_;  ///< when the title was brought up to date
  std::optional<Mode> titled_mode_;
  bool titled_waiting_ = false;
};

/// Of every window, before a frame is shown.
inline constexpr const char* kTitle = "Farshade";

/// The layout that the last preview has left. The default, with a warning, if its file is broken.
[[nodiscard]] Remembered recalled();

}  // namespace farshade
