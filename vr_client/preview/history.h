/// History: what the last frames were, as the panel tells it: stages frame by frame for the graph, and
/// figures over the last two seconds. Pure.
#pragma once

#include <deque>

#include "vr_client/frame/frame_loop.h"
#include "vr_client/link/network_link.h"
#include "vr_client/report/measure.h"

namespace farshade {

inline constexpr std::size_t kGraphFrames = 120;
inline constexpr Duration kFigureSpan = std::chrono::seconds(2);

/// One frame of the graph, in the order in which its bar is stacked.
struct FrameBar {
  Duration request{}, collect{}, gbuffer{}, depth{}, shade{};
  Duration other{};  ///< draw, but for the three stages on the device
  Duration watch{};  ///< overlays, panel, presenting
};

/// Figures that nothing is known of are empty.
struct Figures {
  double frames_per_s = 0;
  std::optional<double> frame_ms{};       ///< median of request + collect + draw
  std::optional<double> watch_ms{};       ///< median of what the preview adds
  std::optional<double> staleness_ms{};   ///< newest frame's
  std::optional<double> age_ms{};         ///< the same
  std::optional<double> round_trip_ms{};  ///< of the newest frame whose report came: request to report
  std::optional<double> server_ms{};      ///< of the same: what the server worked
  std::optional<double> loss_percent{};   ///< of datagrams of this session
  double megabit_per_s = 0;               ///< that arrived here
  std::optional<std::uint64_t> rays{};    ///< primary and shadow rays of the newest frame
  std::optional<double> guard_band_percent{};
  std::optional<PerEye<EyeErrors>> errors{};  ///< newest measured frame's; gone once measuring stops
  Extent asked{};                             ///< an eye of the newest request
};

class History {
 public:
  /// A frame was shown and all of it, the preview's part included, ended at `now`. `link` is null without
  /// a server.
  void add(const FrameView& view, const std::optional<PerEye<EyeErrors>>& errors, const NetworkLink* link,
           Time now);

  [[nodiscard]] const std::deque<FrameBar>& bars() const { return bars_; }  ///< oldest first
  [[nodiscard]] Figures figures() const;

 private:
  /// Counters as they stood at an instant.
  struct Instant {
    Time at;
    double frame_ms, watch_ms;
    std::uint64_t received = 0, received_bytes = 0, missing = 0, sessions = 0;
  };
  void learn_link(const FrameView& view, const NetworkLink& link, Instant& instant);

  std::deque<FrameBar> bars_;
  std::deque<Instant> instants_;
  Figures newest_;
};

}  // namespace farshade
