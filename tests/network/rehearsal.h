/// Rehearsal: the complete server and client on a virtual link in virtual time. Pictures and errors depend
/// only on scene, head and network, and are the same in every run. Run times depend on the machine.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "rt_server/work/server_core.h"
#include "stereo/head/head_recording.h"
#include "stereo/link/network_link.h"
#include "stereo/lod/levels.h"
#include "stereo/plan/scene_plan.h"
#include "tests/support/virtual_link.h"
#include "vr_client/frame/frame_loop.h"
#include "vr_client/report/frame_log.h"
#include "vr_client/report/measure.h"

namespace farshade {

/// The network between server and client.
struct Network {
  std::string name;
  LinkModel model;         ///< of each direction
  Duration moves_every{};  ///< interval at which the client's address changes; 0 = never
};

/// kNetworks, and a network on which the client's address changes every 5 s.
[[nodiscard]] std::vector<Network> named_networks();

/// Parses a name of named_networks() or a link model (parse_link_model).
[[nodiscard]] Expected<Network> network_from(const std::string& text);

struct Play {
  const gpu::Device& device;
  const Scene& scene;
  const HeadRecording& head;
  Extent size{128, 128};
  double refresh_hz = 72;
  std::uint32_t frames = 72;
  std::uint32_t reference_every = 8;    ///< every Nth frame is compared with its reference; 0 = none
  std::uint32_t reference_samples = 1;  ///< of the smooth reference, per side of a pixel; 1: there is none
  ModeSettings mode{};
  RequestSettings request{};
  Reprojection reprojection{};
  Duration mask_wait{};  ///< how long a frame waits for its own answer
  /// Called for each frame. The last argument is null for frames that are not compared.
  std::function<void(const FrameView&, const FrameRecord&, const MeasuredFrame*)> watch{};
  /// Called after `watch` with each compared frame and its smooth reference, if there is one.
  std::function<void(const FrameView&, const FrameRecord&, const MeasuredFrame&,
                     const PerEye<Image<Rgb8>>& smooth)>
      watch_smooth{};
  Duration skip{};  ///< skipped at the start of the recording
  SessionLimits limits{};
  const SceneLevels* levels = nullptr;  ///< the scene's levels of detail; null: full detail
  std::optional<float> detail_px{};     ///< limit of the geometric error of levels; 0: full detail
  enum class Start : std::uint8_t {
    Cold,
    DrawnAhead
  } start = Start::Cold;                       ///< DrawnAhead: as with a real clock
  const PerEye<HiddenArea>* hidden = nullptr;  ///< by the lenses of the headset; null: nothing
  /// The device is lost while it works on this frame, and opened again.
  struct Loss {
    gpu::Device& device;  ///< that of the play
    std::uint32_t frame;
  };
  std::optional<Loss> loss{};
};

struct PlayedFrame {
  Time at;                          ///< start of the frame on the link's clock
  std::optional<FrameId> newest{};  ///< the newest mask that the frame used
  std::optional<Time> newest_asked{};
  double tiles_current = 0;  ///< share of the newest mask's tiles that have arrived, both eyes
  double tiles_recent = 0;   ///< that have arrived in it or in the mask before it, if that has the same size
  ViewScale view_scale{};
  std::size_t pipelines = 0;  ///< compiled by the client up to and including this frame
};

struct Played {
  FrameLog log;
  std::vector<PlayedFrame> frames;
  NetworkLink::Counters client;
  ServerCounters server;
  std::vector<FrameReport> reports{};  ///< of all answers, as the client received them
  std::uint64_t most_submissions = 0;  ///< to the device, of a frame until it was shown
  std::array<std::size_t, 2>
      heap_peak{};  ///< largest heap in bytes in the first and in the second half of the run

  [[nodiscard]] std::vector<double> worse_eye(double EyeErrors::*figure) const;
  /// Mean of all frames with a mask.
  [[nodiscard]] double mean_of(double PlayedFrame::*share) const;
};

/// Runs `frames` display frames. Tracing takes no virtual time.
[[nodiscard]] Played play(const Play& play, const Network& network);

}  // namespace farshade
