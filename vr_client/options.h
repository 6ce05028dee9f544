/// The command line of the client. It is checked before any file, device or socket is opened.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "stereo/base/expected.h"
#include "stereo/base/extent.h"
#include "stereo/gpu/device_options.h"
#include "stereo/head/reader.h"
#include "stereo/plan/scene_plan.h"
#include "stereo/reproject/reprojection.h"
#include "stereo/requests/request_plan.h"
#include "stereo/scene/lighting.h"
#include "stereo/scene/start_pose.h"
#include "vr_client/doctor/device_facts.h"
#include "vr_client/doctor/doctor.h"
#include "vr_client/frame/mode.h"
#include "vr_client/pair/pair.h"
#include "vr_client/runtime/runtime.h"

namespace farshade {

/// Where the head recording starts.
enum class Place : std::uint8_t {
  Auto,      ///< Camera; Fit if the head would be inside geometry or see nothing there
  Camera,    ///< at the scene's viewpoint (viewpoint.h), in its direction
  Recorded,  ///< as recorded
  Fit,       ///< in the free space around the viewpoint (fit.h)
};

/// Whether a headset shows the scene.
enum class Xr : std::uint8_t {
  None,
  OpenXr,  ///< it must
  Auto,    ///< if there is one; otherwise as without it
};

struct Options {
  std::filesystem::path scene;      ///< empty: fetch it from the server (fetched_scene.h)
  std::optional<SceneHash> served;  ///< the scene was fetched: its hash with its lighting, by the server
  std::filesystem::path trace, out = "out";
  std::filesystem::path export_trace;  ///< not empty: only write the head recording to this file
  HeadFileOptions trace_reading;       ///< what the user knows better than the head recording
  Place place = Place::Auto;
  std::optional<StartPose> start_pose;  ///< instead of the scene's viewpoint
  Lighting lighting;
  Extent size{512, 512};           ///< of each eye
  std::optional<float> detail_px;  ///< limit of the geometric error of what is drawn; 0: full detail
  std::optional<std::uint32_t> frames;
  double skip_s = 0;
  double refresh_hz = 72;
  std::string server = "127.0.0.1:7447";  ///< or a search (server_address)
  std::filesystem::path key;              ///< file; empty: default_key_path()
  bool insecure = false;                  ///< no key and no encryption; only with a server on this machine
  std::string net;                  ///< impairment of received datagrams, for parse_link_model; empty: none
  std::vector<double> path_mbit_s;  ///< that the network carries down, or down and up; empty: not stated
  ModeSettings mode;
  Pace pace = Pace::Virtual;
  double delay_ms = 20;
  std::optional<std::uint32_t> frames_in_flight;  ///< RendererLimits::frames
  RequestSettings request;
  Reprojection reprojection;
  std::uint32_t reference_every = 1;  ///< 0 = never
  std::uint32_t pictures = 4;
  std::vector<std::uint32_t> dump;
  std::filesystem::path timeline;  ///< not empty: write the timeline to this file
  std::string json;  ///< not empty: write the summary as JSON to this file; "-": standard output
  gpu::DeviceOptions device;
  std::filesystem::path record;  ///< not empty: write a capture to this file
  std::filesystem::path replay;  ///< not empty: replay this capture and compare
  PlanOptions plan;
  std::optional<ShadingPasses> passes;  ///< empty: those that suit the device
  bool preview = false;                 ///< show a window until the user closes it
  Xr xr = Xr::None;
  double xr_scale = 1;                ///< size of an eye over the size that the headset's runtime recommends
  std::filesystem::path record_head;  ///< not empty: write the headset's head recording to this file
  std::optional<ClientDoctorOptions> doctor;  ///< set: only run the doctor
  std::optional<DeviceFactsOptions> facts;    ///< set: only print the facts of the device
  std::optional<ClientPairOptions> pair;      ///< set: only pair with a server
};

/// Without a headset, a window is shown.
[[nodiscard]] inline bool preview_follows(const Options& options) {
  return options.preview || (options.xr == Xr::Auto && options.trace.empty());
}

/// The program should exit with this status: 0 after it printed the help, 2 after an error in the command
/// line.
struct EarlyExit {
  int status;
};

/// Reads the command line. Prints the help and errors itself.
[[nodiscard]] tl::expected<Options, EarlyExit> read_options(int argc, char** argv);

/// Parses `WIDTHxHEIGHT`, both within 1..kMaxViewSide_px.
[[nodiscard]] Expected<Extent> parse_size(const std::string& text);

}  // namespace farshade
