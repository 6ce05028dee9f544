#include "vr_client/options.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <charconv>
#include <cmath>

#include "stereo/frame/view.h"
#include "stereo/wire/key_file.h"

namespace farshade {
namespace {

constexpr const char* kAbout =
    "Shows a scene to both eyes along a recorded head, with shadows traced by an rt_server.\n"
    "Writes pictures, summary.csv and frames.csv to the output folder and prints the summary.";

constexpr const char* kExamples =
    "Examples:\n"
    "  vr_client --scene assets/room.glb --trace assets/walk.csv --server 127.0.0.1:7447\n"
    "  vr_client --scene assets/room.glb --trace assets/walk.csv --mode full --frames 10";

/// As CLI::Range, which lets NaN through.
CLI::Validator within(double low, double high) {
  const std::string range = fmt::format("{:g} to {:g}", low, high);
  return {[=](std::string& text) {
            double value = 0;
            const bool inside = CLI::detail::lexical_cast(text, value) && value >= low && value <= high;
            return inside ? std::string() : fmt::format("'{}' is not within {}", text, range);
          },
          range};
}

std::vector<std::string> predictors() {
  std::vector<std::string> names;
  for (const PredictorKind kind : kPredictorKinds) names.emplace_back(to_string(kind));
  return names;
}

std::map<std::string, Mode> modes() {
  std::map<std::string, Mode> named;
  for (const ModeName& mode : kModes) named.emplace(mode.name, mode.mode);
  return named;
}

std::string one_line(const CLI::App*, const CLI::Error& error) {
  return fmt::format("vr_client: {} (--help tells more)\n", error.what());
}

}  // namespace

Expected<Extent> parse_size(const std::string& text) {
  const auto wrong = [&] {
    return fail(Fault::OutOfRange, "size '" + text + "' is not WIDTHxHEIGHT with both within 1 to " +
                                       std::to_string(kMaxViewSide_px) + ", such as 512x512");
  };
  Extent size;
  const char* end = text.data() + text.size();
  const auto width = std::from_chars(text.data(), end, size.width);
  if (width.ec != std::errc{} || width.ptr == end || *width.ptr != 'x') return wrong();
  const auto height = std::from_chars(width.ptr + 1, end, size.height);
  if (height.ec != std::errc{} || height.ptr != end) return wrong();
  if (size.width < 1 || size.height < 1 || size.width > kMaxViewSide_px || size.height > kMaxViewSide_px)
    return wrong();
  return size;
}

tl::expected<Options, EarlyExit> read_options(int argc, char** argv) {
  Options options;
  CLI::App app{kAbout, "vr_client"};
  app.footer(kExamples);
  app.failure_message(&one_line);
  std::string size = "512x512";
  std::string predictor(to_string(kDefaultPredictor));
  bool validate = false;
  double video_megabits = options.mode.bits_per_second * 1e-6;
  ClientDoctorOptions examined;
  add_doctor(app, examined);
  app.require_subcommand(0, 1);

  app.add_option("--scene", options.scene, "glTF scene (.gltf or .glb)");
  app.add_option("--trace", options.trace, "recorded head: EuRoC/ASL CSV, TUM or EyeNavGS CSV");
  app.add_option("--trace-scale", options.trace_scale,
                 "units of the recording a metre, where its file cannot say")
      ->check(within(1e-6, 1e6));
  app.add_option("--place", options.place, "start the head at the scene's reference camera, or as recorded")
      ->transform(CLI::CheckedTransformer(
          std::map<std::string, Place>{{"camera", Place::Camera}, {"recorded", Place::Recorded}}));
  app.add_option("--size", size, "pixels an eye")->capture_default_str();
  app.add_option("--frames", options.frames, "display frames to show (default: the whole recording)")
      ->check(CLI::PositiveNumber);
  app.add_option("--skip", options.skip_s, "seconds of the recording to skip")->check(within(0, 1e6));
  app.add_option("--refresh", options.refresh_hz, "display rate, Hz")
      ->check(within(1, 1000))
      ->capture_default_str();
  app.add_option("--server", options.server, "address of the rt_server")->capture_default_str();
  app.add_option("--key", options.key,
                 "key file that rt_server keygen made; " + default_key_path().string() + " unless told");
  app.add_flag("--insecure", options.insecure, "no key and nothing sealed, to a server on this machine");
  app.add_option(
      "--net", options.net,
      "impair what arrives here, as a bad network would: poor, or loss=2%,delay=25ms,jitter=5ms, ...");
  app.add_option("--mode", options.mode.mode,
                 "how the work is split (docs/modes.md): hybrid shades with the server's masks, full traces "
                 "everything here")
      ->transform(CLI::CheckedTransformer(modes()));
  app.add_option("--bitrate", video_megabits,
                 "remote, delta: millions of bits a second of the server's video")
      ->check(within(kLeastVideo_bits * 1e-6, kMostVideo_bits * 1e-6))
      ->capture_default_str();
  app.add_option("--position-bits", options.mode.position_bits,
                 "client-positions: of a coordinate, over the scene's longest side")
      ->check(CLI::Range(kLeastPosition_bits, kMostPosition_bits))
      ->capture_default_str();
  app.add_option("--shadow-maps", options.mode.shadow_maps.side_px, "local: pixels of a shadow map's side")
      ->check(CLI::Range(kLeastMapSide_px, kMostMapSide_px))
      ->capture_default_str();
  app.add_option("--pcf", options.mode.shadow_maps.pcf_radius,
                 "local: texels that a shadow's edge is filtered over")
      ->check(CLI::Range(0u, kMostPcfRadius))
      ->capture_default_str();
  app.add_option("--clock", options.pace,
                 "virtual: every display time gets its frame, repeatable; real: as it comes")
      ->transform(CLI::CheckedTransformer(
          std::map<std::string, Pace>{{"virtual", Pace::Virtual}, {"real", Pace::Real}}));
  app.add_option("--delay", options.delay_ms, "virtual clock: ms from a request to its masks")
      ->check(within(0, 500))
      ->capture_default_str();
  app.add_option("--mask-wait", options.mask_wait_ms, "ms that a frame waits for its own masks")
      ->check(within(0, 1000))
      ->capture_default_str();
  app.add_option("--predictor", predictor,
                 "how views are predicted for the time their masks are used; hold: as shown")
      ->check(CLI::IsMember(predictors()))
      ->capture_default_str();
  app.add_option("--guard-band", options.request.guard_band,
                 "trace beyond the views' borders by what prediction was seen to miss")
      ->transform(CLI::CheckedTransformer(std::map<std::string, GuardBandUse>{
          {"measured", GuardBandUse::Measured}, {"off", GuardBandUse::Off}}));
  app.add_option("--mask-every", options.request.every, "ask for masks on every Nth frame")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  app.add_option("--reprojection", options.carry_over.lookup,
                 "off: show stale masks as they are, which is what reprojection is measured against")
      ->transform(CLI::CheckedTransformer(
          std::map<std::string, Lookup>{{"on", Lookup::Reproject}, {"off", Lookup::Direct}}));
  app.add_option("--eyes", options.carry_over.eyes, "whose masks an eye may take from")
      ->transform(
          CLI::CheckedTransformer(std::map<std::string, Eyes>{{"both", Eyes::Both}, {"this", Eyes::This}}));
  app.add_option("--gaps", options.carry_over.gaps, "what a point gets that no traced view saw")
      ->transform(CLI::CheckedTransformer(
          std::map<std::string, Gaps>{{"neighbours", Gaps::Neighbours}, {"unknown", Gaps::Unknown}}));
  app.add_option("--edges", options.carry_over.edges, "between a mask's pixels at shadow edges")
      ->transform(CLI::CheckedTransformer(
          std::map<std::string, Edges>{{"filtered", Edges::Filtered}, {"nearest", Edges::Nearest}}));
  app.add_option("--reference-every", options.reference_every,
                 "compare every Nth frame with a full trace; 0 = never (run times only)")
      ->capture_default_str();
  app.add_option("--pictures", options.pictures, "instants of which both eyes are written")
      ->capture_default_str();
  app.add_option("--dump", options.dump,
                 "frames (1 = first) to dump for other programs to check, such as 10,20")
      ->delimiter(',');
  CLI::Option* const preview =
      app.add_flag("--preview", options.preview,
                   "show it in a window: mouse and keys are the head (or --trace), F1 tells the keys");
  app.add_option("--record", options.record, "write the session to this file, for --replay");
  app.add_option(
         "--replay", options.replay,
         "show the session on this file again, without head, server or key, and compare every request "
         "and picture")
      ->excludes("--record")
      ->excludes("--trace");
  app.add_option(
      "--timeline", options.timeline,
      "write the stages of client and server on one time axis, as JSON that ui.perfetto.dev opens");
  app.add_option("--out", options.out, "output folder")->capture_default_str();
  app.add_option("--gpu", options.device.name_contains, "use only a device whose name contains this");
  app.add_option("--export-trace", options.export_trace,
                 "only write the recording in metres: .csv EuRoC/ASL, .tum or .txt TUM");
  app.add_option_function<std::string>(
         "--plan", [&options](const std::string& text) { options.plan = parse_plan_options(text); },
         "say what the scene needs and what is left out, and nothing else; --plan=everything leaves nothing "
         "out, to compare with (the server likewise)")
      ->expected(0, 1)
      ->check(CLI::IsMember({"", "needed", "everything"}));
  // What a window shows is paced by the machine, and measured and kept as its viewer wants.
  for (const char* of_replays :
       {"--clock", "--delay", "--pictures", "--dump", "--reference-every", "--replay"})
    app.get_option(of_replays)->excludes(preview);
  app.add_flag("--validate", validate, "run with Vulkan validation layers; any message is an error");

  try {
    app.parse(argc, argv);
    if (app.got_subcommand("doctor")) {
      options.doctor = examined;
      return options;
    }
    if (options.trace.empty() && !options.preview && options.replay.empty() && !options.plan.only_told)
      throw CLI::RequiredError("--trace");
    if (options.scene.empty() && options.export_trace.empty()) throw CLI::RequiredError("--scene");
    const Expected<Extent> parsed = parse_size(size);
    if (!parsed) throw CLI::ValidationError("--size", parsed.error().what);
    options.size = *parsed;
    options.request.predictor = parse_predictor(predictor).value();
    options.mode.bits_per_second = static_cast<std::uint32_t>(std::lround(video_megabits * 1e6));
    if (!options.dump.empty() && (answers_for(options.mode.mode) & kDrawnAnswers) != 0)
      throw CLI::ValidationError("--dump", "what is shown in mode " +
                                               std::string(name_of(options.mode.mode)) +
                                               " is a server's picture, which no mask explains");
    const bool recordable = options.mode.mode == Mode::Hybrid || options.mode.mode == Mode::Full;
    if (!options.record.empty() && !recordable)
      throw CLI::ValidationError("--record", "sessions of hybrid and full can be recorded, not of " +
                                                 std::string(name_of(options.mode.mode)));
  } catch (const CLI::ParseError& error) {
    return tl::unexpected(EarlyExit{app.exit(error) == 0 ? 0 : 2});
  }
  if (validate) options.device.validation = gpu::Validation::On;
  return options;
}

}  // namespace farshade
