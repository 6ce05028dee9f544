/// Rehearsal: a server and a client, whole, over a virtual link in virtual time. What is shown, and how wrong
/// it is, depends on nothing but scene, head and network: the same on every run. Only run times are the
/// machine's.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "rt_server/core/server_core.h"
#include "stereo/head/head_recording.h"
#include "stereo/net/virtual_link.h"
#include "vr_client/frame/frame_loop.h"
#include "vr_client/link/network_link.h"
#include "vr_client/report/frame_log.h"
#include "vr_client/report/pictures.h"

namespace farshade {

/// What lies between server and client.
struct Network {
  std::string name;
  LinkModel model;         ///< of either direction
  Duration moves_every{};  ///< the client's address changes so often; 0 = never
};

/// kNetworks, and one on which the client's address changes every 5 s.
[[nodiscard]] std::vector<Network> named_networks();

/// As people write it: a name of named_networks() or what parse_link_model takes.
[[nodiscard]] Expected<Network> network_from(const std::string& text);

struct Play {
  const gpu::Device& device;
  const Scene& scene;
  const HeadRecording& head;
  Extent size{128, 128};
  double refresh_hz = 72;
  std::uint32_t frames = 72;
  std::uint32_t reference_every = 8;  ///< frames of which the error is measured; 0 = none
  ModeSettings mode{};
  RequestSettings request{};
  CarryOver carry_over{};
  Duration mask_wait{};  ///< how long a frame waits for its own answer
  /// Sees each frame; the last is null where it was not measured.
  std::function<void(const FrameView&, const FrameRecord&, const MeasuredFrame*)> watch{};
  Duration skip{};  ///< of the head's beginning
  SessionLimits limits{};
};

struct PlayedFrame {
  Time at;                          ///< on the link's clock: when the frame was begun
  std::optional<FrameId> newest{};  ///< mask it was shown with
  std::optional<Time> newest_asked{};
  double tiles_current = 0;  ///< share of the newest mask's tiles that have come, of both eyes
  double tiles_recent =
      0;  ///< that have come in it or in the mask before it, where that one has the same size
  ViewScale view_scale{};
  std::size_t pipelines = 0;  ///< compiled by the client up to and including this frame
};

struct Played {
  FrameLog log;
  std::vector<PlayedFrame> frames;
  NetworkLink::Counters client;
  ServerCounters server;
  std::vector<FrameReport> reports{};      ///< of all answers, as their client heard them
  std::array<std::size_t, 2> heap_peak{};  ///< most bytes in use in the first and in the second half

  [[nodiscard]] std::vector<double> worse_eye(double EyeErrors::*figure) const;
  /// Mean over frames with a mask.
  [[nodiscard]] double mean_of(double PlayedFrame::*share) const;
};

/// Plays `frames` display frames. The server's trace takes no virtual time.
[[nodiscard]] Played play(const Play& play, const Network& network);

}  // namespace farshade
