/// What a user asks of the client, checked before anything is opened.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "stereo/base/expected.h"
#include "stereo/base/extent.h"
#include "stereo/draw/shading.h"
#include "stereo/gpu/device.h"
#include "stereo/plan/scene_plan.h"
#include "vr_client/ask/request_plan.h"
#include "vr_client/doctor/doctor.h"
#include "vr_client/frame/mode.h"
#include "vr_client/runtime/runtime.h"

namespace farshade {

/// Where the recorded head starts.
enum class Place : std::uint8_t {
  Camera,    ///< at the scene's reference camera, facing its way (as recorded where the scene has none)
  Recorded,  ///< as recorded
};

struct Options {
  std::filesystem::path scene, trace, out = "out";
  std::filesystem::path export_trace;  ///< not empty: write the recording there, and nothing else
  std::optional<double> trace_scale;   ///< the recording's units a metre, where its file cannot say
  Place place = Place::Camera;
  Extent size{512, 512};  ///< an eye
  std::optional<std::uint32_t> frames;
  double skip_s = 0;
  double refresh_hz = 72;
  std::string server = "127.0.0.1:7447";
  std::filesystem::path key;  ///< file; empty for default_key_path()
  bool insecure = false;      ///< no key, unsealed, to a server on this machine
  std::string net;  ///< the network towards the client, as parse_link_model has it; empty for as it is
  ModeSettings mode;
  Pace pace = Pace::Virtual;
  double delay_ms = 20, mask_wait_ms = 0;
  RequestSettings request;
  CarryOver carry_over;
  std::uint32_t reference_every = 1;  ///< 0 = never
  std::uint32_t pictures = 4;
  std::vector<std::uint32_t> dump;
  std::filesystem::path timeline;  ///< not empty: write the stages of client and server there
  gpu::DeviceOptions device;
  std::filesystem::path record;  ///< not empty: write the session there, to be replayed
  std::filesystem::path replay;  ///< not empty: show the session on this file again, and compare
  PlanOptions plan;
  bool preview = false;                       ///< in a window, until it is closed
  std::optional<ClientDoctorOptions> doctor;  ///< set: look at the machine, and nothing else
};

/// The program is done before it began: help was printed (status 0), or what is wrong with the command line.
struct EarlyExit {
  int status;
};

/// Reads the command line. Prints help or what is wrong with it itself.
[[nodiscard]] tl::expected<Options, EarlyExit> read_options(int argc, char** argv);

/// Size from `WIDTHxHEIGHT`, both within 1..kMaxViewSide_px.
[[nodiscard]] Expected<Extent> parse_size(const std::string& text);

}  // namespace farshade
