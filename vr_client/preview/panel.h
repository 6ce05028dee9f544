/// Panel: what the preview says and lets be set, with Dear ImGui: figures, the graph of stages, sliders, and
/// the key map. It sets controls; it does nothing else.
#pragma once

#include "vr_client/preview/controls.h"
#include "vr_client/preview/history.h"

namespace farshade {

/// What is going on, for the panel to say.
struct PanelFacts {
  const History& history;
  const Scene& scene;
  const ControlState& stand;
  std::string device;  ///< that draws
  std::string server;  ///< how it is with the server
  std::string note;    ///< what happened last: a file written, a failure
  Switch recording_head = Switch::Off, recording_session = Switch::Off, recording_frames = Switch::Off;
  Extent window;     ///< pixels
  double scale = 1;  ///< of text
};

/// Pixels of the window's right side that the panel takes; none while it is hidden.
[[nodiscard]] std::uint32_t panel_width_px(const Controls& controls, Extent window, double scale);

/// Between ImGui's NewFrame and Render.
void draw_panel(Controls& controls, const PanelFacts& facts);

/// The panel's first part: figures in rows and the graph of stages (panel_figures.cpp).
void draw_figures(const History& history, const Controls& controls);

}  // namespace farshade
