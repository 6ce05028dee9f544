/// Panel: figures, the graph of stages, sliders and the list of keys, drawn with Dear ImGui. It changes the
/// controls and has no other effect.
#pragma once

#include "vr_client/preview/controls.h"
#include "vr_client/preview/history.h"
#include "vr_client/preview/pixel_facts.h"

namespace farshade {

/// The data that the panel shows.
struct PanelFacts {
  const History& history;
  const Scene& scene;
  const ControlContext& context;
  std::string device;                      ///< name of the GPU
  std::string server;                      ///< state of the server
  std::string note;                        ///< the last message of Recordings, or why a mode is not shown
  const std::optional<PixelFacts>& pixel;  ///< the pixel under the mouse, while it is inspected
  bool recording_head = false, writing_capture = false, recording_frames = false;
  Extent window;     ///< pixels
  double scale = 1;  ///< of the text (layout.h)
};

/// Width of the panel at the right side of the window, pixels; 0 while it is hidden.
[[nodiscard]] std::uint32_t panel_width_px(const Controls& controls, Extent window, double scale);

/// Draws the panel. Call it between ImGui's NewFrame and Render.
void draw_panel(Controls& controls, const PanelFacts& facts);

/// Draws the first part of the panel: the table of figures and the graph of stages.
void draw_figures(const History& history, const Controls& controls);

}  // namespace farshade
