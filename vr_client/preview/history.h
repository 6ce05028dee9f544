/// History: data of the last frames for the panel: the duration of the stages of each frame for the graph,
/// and figures over the last two seconds.
#pragma once

#include <deque>

#include "stereo/link/network_link.h"
#include "vr_client/frame/frame_loop.h"
#include "vr_client/report/measure.h"

namespace farshade {

inline constexpr std::size_t kGraphFrames = 120;
inline constexpr Duration kFigureSpan = std::chrono::seconds(2);

/// The bar of one frame in the graph, from bottom to top.
struct FrameBar {
  Duration request{}, collect{}, gbuffer{}, depth{}, shade{};
  Duration other{};  ///< draw without the stages on the device
  Duration watch{};  ///< overlays, panel, presenting
};

/// Unknown figures are empty.
struct Figures {
  double frames_per_s = 0;
  std::optional<double> frame_ms{};       ///< median of request + collect + draw
  std::optional<double> watch_ms{};       ///< median of the preview's own work
  std::optional<double> staleness_ms{};   ///< of the newest frame
  std::optional<double> age_ms{};         ///< of the newest frame
  std::optional<double> round_trip_ms{};  ///< from request to report, of the newest frame with a report
  std::optional<double> server_ms{};      ///< working time of the server for that frame
  std::optional<double> loss_percent{};   ///< lost datagrams of this session
  double megabit_per_s = 0;               ///< received
  DrawnTriangles triangles{};             ///< of the newest frame
  std::optional<std::uint64_t> rays{};    ///< primary and shadow rays of the newest frame
  std::optional<double> guard_band_percent{};
  double black_percent = 0;  ///< of the worse eye: what a picture of the server does not reach
  std::optional<PerEye<EyeErrors>> errors{};  ///< of the newest frame; empty if it was not measured
  Extent requested{};                         ///< size of an eye in the newest request
};

class History {
 public:
  /// Adds a frame that was shown and whose processing, including the preview's, ended at `now`. `link` is
  /// null without a server.
  void add(const FrameView& view, const std::optional<PerEye<EyeErrors>>& errors, const NetworkLink* link,
           Time now);

  [[nodiscard]] const std::deque<FrameBar>& bars() const { return bars_; }  ///< oldest first
  [[nodiscard]] Figures figures() const;

 private:
  /// Counters at one point in time.
  struct Instant {
    Time at;
    double frame_ms, watch_ms;
    std::uint64_t received = 0, received_bytes = 0, missing = 0, sessions = 0;
  };
  void read_link(const FrameView& view, const NetworkLink& link, Instant& instant);

  std::deque<FrameBar> bars_;
  std::deque<Instant> instants_;
  Figures newest_;
};

}  // namespace farshade
