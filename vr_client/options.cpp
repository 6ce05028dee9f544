#include "vr_client/options.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <array>
#include <charconv>
#include <cmath>

#include "stereo/about/about.h"
#include "stereo/base/user_folders.h"
#include "stereo/frame/view.h"
#include "stereo/gpu/loader.h"
#include "stereo/options/command_line.h"
#include "stereo/options/completion.h"
#include "stereo/options/config_file.h"
#include "stereo/options/lighting_options.h"
#include "stereo/options/start_pose_option.h"
#include "stereo/options/within.h"
#include "stereo/sealing/key_file.h"
#include "stereo/video/video.h"
#include "vr_client/record/capture_file.h"
#include "vr_client/report/figures.h"

namespace farshade {
namespace {

constexpr const char* kAbout =
    "Shows a scene to both eyes along a recorded head, with shadows that an rt_server traces.\n"
    "Writes pictures, summary.csv and frames.csv to the output folder, and prints a summary.";

constexpr const char* kFooter =
    "Exit status:\n"
    "  0    the run is complete\n"
    "  1    the run failed, or no answer of the server came; standard error says why\n"
    "  2    the command line or the configuration file is wrong\n"
    "  130  Ctrl-C (SIGINT) ended the run\n"
    "  143  SIGTERM ended the run\n"
    "\n"
    "Examples:\n"
    "  vr_client --scene assets/room.glb --trace assets/walk.csv --server 127.0.0.1:7447\n\n"
    "  vr_client --trace assets/walk.csv --server HOST:7447    (the scene comes from the server)\n\n"
    "  vr_client --scene assets/room.glb --trace assets/walk.csv --mode full --frames 10";

/// Frames have 32-bit numbers.
constexpr double kMostFrames = 4294967295.0;

/// Values as they are on the command line, before they are checked and converted.
struct CommandLine {
  Options options;
  ClientDoctorOptions doctor;
  DeviceFactsOptions facts;
  ClientPairOptions pair;
  std::string size = "512x512";
  std::optional<Edges> edges;  ///< empty: exact where it fits
  double video_megabits = Options{}.mode.bits_per_second * 1e-6;
  bool validate = false;
  std::optional<std::string> explained;  ///< the figure that --explain names, or empty text: all
};

Words<PredictorKind> predictors() {
  Words<PredictorKind> named;
  for (const PredictorKind kind : kPredictorKinds) named.emplace_back(to_string(kind), kind);
  return named;
}

Words<Mode> modes() {
  Words<Mode> named;
  for (const ModeName& mode : kModes) named.emplace_back(mode.name, mode.mode);
  return named;
}

/// What a head recording does not state itself, or states wrongly.
void add_trace_reading_options(CLI::App& app, HeadFileOptions& reading) {
  app.add_option("--trace-scale", reading.units_a_metre,
                 "units per metre of the head recording, if its format does not define them")
      ->check(within(1e-6, 1e6));
  app.add_option_function<std::string>(
         "--trace-axes",
         [&reading](const std::string& name) {
           Expected<Axes> axes = parse_axes(name);
           if (!axes) throw CLI::ValidationError("--trace-axes", axes.error().what);
           reading.axes = std::move(*axes);
         },
         "axes of the head recording: openxr, ros, optical, euroc-imu, unity, unreal or ned, or WORLD/HEAD, "
         "as in "
         "ros/optical (default: openxr, and recordings that are tilted on the whole are levelled)")
      ->type_name("AXES");
  add_words<std::optional<TimeUnit>>(
      app, "--trace-units", reading.unit,
      {{"s", TimeUnit::Seconds},
       {"ms", TimeUnit::Milliseconds},
       {"us", TimeUnit::Microseconds},
       {"ns", TimeUnit::Nanoseconds}},
      "unit of the head recording's time stamps (default: as it states, or by its sample rate)");
  add_words<std::optional<QuaternionOrder>>(
      app, "--trace-quaternion", reading.order,
      {{"wxyz", QuaternionOrder::Wxyz}, {"xyzw", QuaternionOrder::Xyzw}},
      "order of the head recording's quaternions (default: as its layout has it)");
}

void add_scene_options(CLI::App& app, CommandLine& line) {
  Options& options = line.options;
  app.add_option("--scene", options.scene,
                 "glTF scene (.gltf or .glb); without it, the client fetches the server's scene");
  app.add_option("--trace", options.trace,
                 "head recording: EuRoC/ASL CSV, TUM, EyeNavGS CSV, or a table with column names "
                 "(docs/head-recordings.md)");
  add_trace_reading_options(app, options.trace_reading);
  add_words<Place>(
      app, "--place", options.place,
      {{"auto", Place::Auto}, {"camera", Place::Camera}, {"recorded", Place::Recorded}, {"fit", Place::Fit}},
      "where the head starts: auto: camera, or fit if the head would be inside geometry or see nothing "
      "there, "
      "and --stand is not given; camera: at the scene's reference camera (without one, in the middle "
      "of a room, or in front of an object); fit: near it, where the recorded walk fits, which is "
      "scaled down if it must be; recorded: where it was recorded");
  add_start_pose_option(app, options.start_pose);
  add_lighting_options(app, options.lighting);
  app.add_option("--size", line.size, "pixels of each eye")->capture_default_str();
  app.add_option(
         "--detail-px", options.detail_px,
         "draw each mesh with the fewest triangles whose error is at most this many pixels; 0: draw all "
         "(default: 0.125; 0 in modes full, remote and server-gbuffer)")
      ->check(within(0, double{kMostDetail_px}));
  app.add_option("--frames", options.frames, "number of frames to show (default: the whole recording)")
      ->check(within(1, kMostFrames));
  app.add_option("--skip", options.skip_s, "seconds to skip at the beginning of the recording")
      ->check(within(0, 1e6));
  app.add_option("--refresh", options.refresh_hz, "refresh rate of the display, Hz")
      ->check(within(1, 1000))
      ->capture_default_str();
}

void add_link_options(CLI::App& app, Options& options) {
  app.add_option("--server", options.server,
                 "address of the rt_server, or auto: the one that announces itself on the local network "
                 "(auto/NAME: the one of this name)")
      ->capture_default_str();
  app.add_option("--key", options.key,
                 "key file, which vr_client pair or rt_server keygen made (default: " +
                     default_key_path().string() + ")");
  app.add_flag("--insecure", options.insecure,
               "use no key and no encryption; only for a server on this machine");
  app.add_option("--net", options.net,
                 "simulate a bad network on received datagrams: poor, or loss=2%,delay=25ms,jitter=5ms, ...");
  app.add_option(
         "--path-rate", options.path_mbit_s,
         "Mbit/s that your network carries down, or down,up: the summary says whether the traffic fits "
         "(default: what the server measures down)")
      ->delimiter(',')
      ->expected(1, 2)
      ->check(within(0.001, 1e6));
}

void add_mode_options(CLI::App& app, CommandLine& line) {
  ModeSettings& mode = line.options.mode;
  add_words(app, "--mode", mode.mode, modes(),
            "how client and server share the work (docs/modes.md): hybrid shades with masks from the "
            "server, full traces everything in the client");
  add_words<MaskCode>(
      app, "--mask-code", mode.mask_code, {{"range", MaskCode::Range}, {"lz4", MaskCode::Lz4}},
      "hybrid: how the server codes masks: range: parts that each decode alone; lz4: one LZ4 block of whole "
      "views, of which all must arrive, without a cube mask, as a baseline to compare with");
  app.add_option("--bitrate", line.video_megabits, "remote, delta: bit rate of the server's video, Mbit/s")
      ->check(within(kLeastVideo_bits * 1e-6, kMostVideo_bits * 1e-6))
      ->capture_default_str();
  app.add_option("--shadow-maps", mode.shadow_maps.side_px, "local: width and height of a shadow map, pixels")
      ->check(within(kLeastMapSide_px, kMostMapSide_px))
      ->capture_default_str();
}

void add_request_options(CLI::App& app, CommandLine& line) {
  Options& options = line.options;
  add_words<Pace>(app, "--clock", options.pace, {{"virtual", Pace::Virtual}, {"real", Pace::Real}},
                  "virtual: show every frame and repeat exactly; real: skip frames that are too late");
  app.add_option("--delay", options.delay_ms, "virtual clock: ms from a request until its masks are used")
      ->check(within(0, 500))
      ->capture_default_str();
  app.add_option("--frames-in-flight", options.frames_in_flight,
                 "frames that client and GPU work on at one time (default: 2; 1 with the virtual clock and "
                 "where the processor draws)")
      ->check(within(1, 3));
  add_words(app, "--predictor", options.request.predictor, predictors(),
            "how the client predicts the head pose at which masks will be used; hold: no prediction");
  add_words<GuardBandUse>(app, "--guard-band", options.request.guard_band,
                          {{"measured", GuardBandUse::Measured}, {"off", GuardBandUse::Off}},
                          "measured: request views wider than shown, by the measured prediction error");
  add_words<Asks>(
      app, "--ask", options.request.asks, {{"unknown", Asks::Unknown}, {"whole", Asks::Whole}},
      "the part of a mask to request: unknown: what earlier masks leave unknown; whole: all of it");
  app.add_option(
         "--mask-every", options.request.every,
         "request masks in every Nth frame (default: every frame; every 28 ms if nothing in the scene "
         "moves and masks come later than that)")
      ->check(within(1, 64))
      ->default_str("");
}

void add_reprojection_options(CLI::App& app, CommandLine& line) {
  Reprojection& reprojection = line.options.reprojection;
  add_words<Lookup>(app, "--reprojection", reprojection.lookup,
                    {{"on", Lookup::Reproject}, {"off", Lookup::Direct}},
                    "off: show old masks without reprojection, as a baseline to compare with");
  add_words<std::optional<Edges>>(
      app, "--edges", line.edges,
      {{"exact", Edges::Exact},
       {"line", Edges::Line},
       {"nearest", Edges::Nearest},
       {"coverage", Edges::Coverage}},
      "the visibility at shadow edges: exact traces a ray of the client's own to each light "
      "that rests; line guesses "
      "from masks on which side of the edge the pixel's centre lies; coverage is the lit part "
      "of the pixel, for smooth "
      "edges; nearest is the bit of one mask pixel (default: exact; line with --record or --passes single)");
}

void add_output_options(CLI::App& app, Options& options) {
  app.add_option("--reference-every", options.reference_every,
                 "compare every Nth frame with a full trace; 0: never, measure run times only")
      ->capture_default_str();
  app.add_option("--pictures", options.pictures, "number of frames whose pictures are written")
      ->capture_default_str();
  app.add_option("--dump", options.dump,
                 "frames to dump for other programs to check, such as 10,20; the first frame is 1")
      ->delimiter(',');
  app.add_option("--record", options.record, "write a capture of the run to this new file, for --replay");
  app.add_option("--replay", options.replay,
                 "replay this capture without head recording, server or key, and compare every request and "
                 "picture")
      ->excludes("--record")
      ->excludes("--trace");
  app.add_option("--timeline", options.timeline,
                 "write a timeline of the stages of client and server, as JSON for ui.perfetto.dev");
  app.add_option(
      "--json", options.json,
      "write the summary with all figures, units and definitions to this JSON file; -: to standard "
      "output, and the readable summary to standard error");
  app.add_option("--out", options.out, "output folder")->capture_default_str();
  CLI::Option* const preview =
      app.add_flag("--preview", options.preview,
                   "show the eyes in a window; mouse and keys, or --trace, move the head; F1 lists the keys");
  // A window runs on the machine's clock, and its viewer chooses what is measured and written.
  for (const char* without_window :
       {"--clock", "--delay", "--pictures", "--dump", "--reference-every", "--replay", "--json"})
    app.get_option(without_window)->excludes(preview);
}

void add_headset_options(CLI::App& app, Options& options) {
  add_words<Xr>(
      app, "--xr", options.xr, {{"none", Xr::None}, {"openxr", Xr::OpenXr}, {"auto", Xr::Auto}},
      "openxr: show the scene in a headset, through the machine's OpenXR runtime; auto: if there is one, "
      "and otherwise along --trace or in a window (docs/openxr.md)");
  app.add_option("--xr-scale", options.xr_scale,
                 "size of an eye in a headset, as a multiple of the size that its runtime recommends")
      ->check(within(0.1, 2))
      ->capture_default_str();
  app.add_option("--record-head", options.record_head,
                 "write the poses of the headset to this file, as a head recording (EuRoC/ASL) for --trace");
}

void add_other_options(CLI::App& app, CommandLine& line) {
  Options& options = line.options;
  app.add_option("--gpu", options.device.name_contains, "use only a device whose name contains this text");
  app.add_option("--export-trace", options.export_trace,
                 "only convert the head recording to metres: .csv writes EuRoC/ASL, .tum or .txt writes TUM");
  app.add_option_function<std::string>(
         "--plan", [&options](const std::string& text) { options.plan = parse_plan_options(text); },
         "print what the scene needs and what the programs leave out, and exit; --plan=everything leaves "
         "nothing out, for comparison (give the server the same option)")
      ->expected(0, 1)
      ->type_name("needed|everything")
      ->check(one_of({"", "needed", "everything"}));
  add_words<std::optional<ShadingPasses>>(
      app, "--passes", options.passes, {{"sorted", ShadingPasses::Sorted}, {"single", ShadingPasses::Single}},
      "passes that shade with masks, to compare their times; with --edges line pictures are the same "
      "(default: sorted with --edges exact or if the processor draws, else single)");
  app.add_option_function<std::string>(
         "--explain", [&line](const std::string& figure) { line.explained = figure; },
         "print definition, unit and way of measuring of a figure such as \"mask error\", or a line for "
         "every figure, and exit")
      ->expected(0, 1)
      ->type_name("FIGURE");
  app.add_flag("--validate", line.validate, "use the Vulkan validation layers; any message is an error");
}

/// Throws a CLI::ParseError if these options need --scene.
void check_fetch(const Options& options) {
  if (!options.replay.empty()) throw CLI::RequiredError("--scene");
  const Lighting& lighting = options.lighting;
  const SceneChoice& choice = lighting.choice;
  if (!lighting.lights.empty() || lighting.ambient || lighting.exposure)
    throw CLI::ValidationError("--scene",
                               "a scene from the server is lit as the server says; --light, --sun, --ambient "
                               "and --exposure are for a scene that --scene names");
  if (choice.scene || !choice.camera.empty() || !choice.variant.empty() || !choice.animation.empty())
    throw CLI::ValidationError(
        "--scene",
        "the server has chosen among its file's scenes, cameras, variants and animations; --scene-index, "
        "--camera, --variant and --animation are for a file that --scene names");
}

/// A replay takes these options from its capture, or does not need them.
constexpr std::array kNotInReplay{"--trace-scale",
                                  "--trace-axes",
                                  "--trace-units",
                                  "--trace-quaternion",
                                  "--place",
                                  "--stand",
                                  "--size",
                                  "--detail-px",
                                  "--frames",
                                  "--skip",
                                  "--refresh",
                                  "--server",
                                  "--key",
                                  "--insecure",
                                  "--net",
                                  "--mode",
                                  "--bitrate",
                                  "--shadow-maps",
                                  "--clock",
                                  "--delay",
                                  "--predictor",
                                  "--guard-band",
                                  "--ask",
                                  "--mask-every",
                                  "--reprojection",
                                  "--edges",
                                  "--xr",
                                  "--xr-scale",
                                  "--record-head",
                                  "--mask-code",
                                  "--frames-in-flight"};

/// The headset or its runtime gives these.
constexpr std::array kNotInHeadset{
    "--trace", "--trace-scale", "--trace-axes", "--trace-units", "--trace-quaternion",
    "--place", "--size",        "--skip",       "--refresh",     "--clock",
    "--delay", "--preview",     "--replay",     "--export-trace"};

/// Throws a CLI::ParseError if an option does not go with --xr.
void check_headset(const CLI::App& app, Options& options) {
  if (options.xr == Xr::OpenXr)
    for (const char* option : kNotInHeadset)
      if (app.count(option) > 0)
        throw CLI::ValidationError(option, "it does not go with --xr openxr: omit one of them");
  if (options.xr == Xr::None && (app.count("--xr-scale") > 0 || app.count("--record-head") > 0))
    throw CLI::ValidationError("--xr", "--xr-scale and --record-head are for --xr openxr or --xr auto");
  // A display that does not wait has no time for comparisons, unless the user asks for them.
  if (options.xr != Xr::OpenXr) return;
  if (app.count("--reference-every") == 0) options.reference_every = 0;
  if (!options.frames && options.reference_every > 0)
    throw CLI::ValidationError("--frames", "figures of a session need its number of frames");
}

/// Throws a CLI::ParseError if an option does not go with --mask-code lz4.
void check_mask_code(const CLI::App& app, Options& options) {
  if (options.mode.mask_code == MaskCode::Range) return;
  const auto refuse = [](const char* option, const std::string& why) {
    throw CLI::ValidationError(option, "--mask-code lz4 " + why);
  };
  if (options.mode.mode != Mode::Hybrid) refuse("--mask-code", "is for mode hybrid");
  if (!options.record.empty()) refuse("--record", "cannot be captured: captures hold range coded masks");
  if (app.count("--ask") > 0 && options.request.asks == Asks::Unknown)
    refuse("--ask", "asks for whole masks: omit --ask unknown");
  options.request.asks = Asks::Whole;
}

/// The edges of the options; by default exact where it fits. Throws a CLI::ParseError if exact is asked for
/// where it does not fit.
Edges chosen_edges(const CommandLine& line) {
  const Options& options = line.options;
  const bool is_single = options.passes == ShadingPasses::Single, captures = !options.record.empty();
  if (line.edges == Edges::Exact && is_single)
    throw CLI::ValidationError("--edges", "exact takes sorted passes: omit --passes single");
  if (line.edges == Edges::Exact && captures)
    throw CLI::ValidationError("--edges", "exact cannot be captured: omit --record, or choose line");
  const bool fits = !is_single && !captures && options.replay.empty();
  return line.edges.value_or(fits ? Edges::Exact : Edges::Line);
}

/// Throws a CLI::ParseError if one of these options is given.
void check_replay(const CLI::App& app) {
  for (const char* option : kNotInReplay)
    if (app.count(option) > 0)
      throw CLI::ValidationError(option, "a replay repeats the captured run as it was: omit this option");
}

/// Throws a CLI::ParseError if there is no such figure.
void print_explanation(const std::string& figure) {
  const Expected<std::string> text = explain(figure);
  if (!text) throw CLI::ValidationError("--explain", text.error().what);
  fmt::print("{}", *text);
}

/// Throws a CLI::ParseError if options are missing or contradict each other.
Options checked(CommandLine line, const CLI::App& app) {
  Options& options = line.options;
  if (!options.replay.empty()) check_replay(app);
  check_headset(app, options);
  const bool may_move_itself = options.preview || options.xr != Xr::None;
  if (options.trace.empty() && !may_move_itself && options.replay.empty() && !options.plan.prints_only)
    throw CLI::RequiredError("--trace");
  if (options.scene.empty()) check_fetch(options);
  if (options.start_pose && options.place == Place::Recorded)
    throw CLI::ValidationError("--stand", "--place recorded keeps the recorded place: omit one of them");
  const Expected<Extent> size = parse_size(line.size);
  if (!size) throw CLI::ValidationError("--size", size.error().what);
  options.size = *size;
  options.mode.bits_per_second = static_cast<std::uint32_t>(std::lround(line.video_megabits * 1e6));
  if (line.validate) options.device.validation = gpu::Validation::On;
  check_mask_code(app, options);
  options.reprojection.edges = chosen_edges(line);
  const std::string mode(name_of(options.mode.mode));
  if (!options.dump.empty() && (answers_for(options.mode.mode) & kDrawnAnswers) != 0)
    throw CLI::ValidationError("--dump",
                               "mode " + mode + " shows pictures of the server; there is no mask to dump");
  if (!options.record.empty() && !can_be_captured(options.mode.mode))
    throw CLI::ValidationError("--record", "only modes hybrid and full can be captured, not mode " + mode);
  return std::move(options);
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

namespace {

std::string about_client() {
  return about("vr_client",
               {fmt::format("client and server {}", kProtocolVersion),
                fmt::format("capture files {}", kCaptureVersion)},
               {"Vulkan loader " + gpu::loader_version(), has_video() ? video_version() : "no video"});
}

}  // namespace

tl::expected<Options, EarlyExit> read_options(int argc, char** argv) {
  CommandLine line;
  CLI::App app{kAbout, "vr_client"};
  app.footer(kFooter);
  app.set_version_flag("--version", about_client,
                       "print versions of program, protocols and libraries, and exit");
  make_readable(app);
  app.require_subcommand(0, 1);
  add_doctor(app, line.doctor);
  add_device_facts(app, line.facts);
  add_pair(app, line.pair);
  add_scene_options(app, line);
  add_link_options(app, line.options);
  add_mode_options(app, line);
  add_request_options(app, line);
  add_reprojection_options(app, line);
  add_output_options(app, line.options);
  add_headset_options(app, line.options);
  add_other_options(app, line);
  const ConfigRules config{config_folder() / "vr_client.ini",
                           {{"--replay", "", kNotInReplay}, {"--xr", "openxr", kNotInHeadset}}};
  add_config_option(app, config);
  add_completion_option(app);
  try {
    parse_with_config(app, argc, argv, config);
    if (line.explained) {
      print_explanation(*line.explained);
      return tl::unexpected(EarlyExit{0});
    }
    if (app.got_subcommand("doctor")) line.options.doctor = line.doctor;
    if (app.got_subcommand("device")) line.options.facts = line.facts;
    if (app.got_subcommand("pair")) line.options.pair = line.pair;
    const bool has_subcommand = !app.get_subcommands().empty();
    return has_subcommand ? std::move(line.options) : checked(std::move(line), app);
  } catch (const CLI::ParseError& error) {
    return tl::unexpected(EarlyExit{app.exit(error) == 0 ? 0 : 2});
  }
}

}  // namespace farshade
