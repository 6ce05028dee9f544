#include "vr_client/options.h"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <sstream>

#include "stereo/options/parse_start_pose.h"
#include "tests/unit/scratch_folder.h"

namespace farshade {
namespace {

struct Outcome {
  tl::expected<Options, EarlyExit> options;
  std::string out, errors;
};

Outcome read(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "vr_client");
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  auto options = read_options(static_cast<int>(argv.size()), argv.data());
  std::string out = testing::internal::GetCapturedStdout();
  return {std::move(options), std::move(out), testing::internal::GetCapturedStderr()};
}

/// Adds the required options.
Outcome read_more(const std::vector<std::string>& more) {
  std::vector<std::string> arguments{"--scene", "a.glb", "--trace", "b.csv"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return read(arguments);
}

TEST(ReadOptions, ExplainsFiguresWithoutAnyOtherOption) {
  const Outcome one = read({"--explain", "mask error"}), all = read({"--explain"});
  for (const Outcome* outcome : {&one, &all}) ASSERT_FALSE(outcome->options);
  EXPECT_EQ(one.options.error().status, 0) << one.errors;
  EXPECT_TRUE(one.out.starts_with("eye mask error, %\n")) << one.out;
  EXPECT_EQ(all.options.error().status, 0) << all.errors;
  for (const char* name : {"client frame, ms", "eye PSNR, dB", "run silent time, s"})
    EXPECT_NE(all.out.find(name), std::string::npos) << name << all.out;
  const Outcome wrong = read({"--explain", "PNSR"});
  ASSERT_FALSE(wrong.options);
  EXPECT_EQ(wrong.options.error().status, 2);
  EXPECT_NE(wrong.errors.find("did you mean psnr?"), std::string::npos) << wrong.errors;
}

TEST(ReadOptions, PrintsTheVersion) {
  const Outcome version = read({"--version"});
  ASSERT_FALSE(version.options);
  EXPECT_EQ(version.options.error().status, 0) << version.errors;
  EXPECT_TRUE(version.out.starts_with("vr_client ")) << version.out;
}

TEST(ParseSize, AcceptsWidthByHeight) {
  EXPECT_EQ(*parse_size("96x64"), (Extent{96, 64}));
  EXPECT_EQ(*parse_size("1x8192"), (Extent{1, 8192}));
}

TEST(ParseSize, RefusesEverythingElseAndStatesTheRange) {
  for (const std::string text : {"",
                                 "x",
                                 "0x0",
                                 "0x5",
                                 "5x0",
                                 "512",
                                 "512x",
                                 "x512",
                                 "512x512x3",
                                 "512x512 ",
                                 " 512x512",
                                 "-5x5",
                                 "+5x5",
                                 "5X5",
                                 "8193x1",
                                 "100000x100000",
                                 "99999999999999999999x1",
                                 "4294967297x1",
                                 "1.5x2",
                                 "0x10x10"}) {
    const Expected<Extent> size = parse_size(text);
    ASSERT_FALSE(size.has_value()) << text;
    EXPECT_EQ(size.error().fault, Fault::OutOfRange);
    EXPECT_NE(size.error().what.find("'" + text + "'"), std::string::npos);
    EXPECT_NE(size.error().what.find("1 to 8192"), std::string::npos);
  }
}

/// Every option of the client except --preview, --replay and those that end the program.
std::vector<std::string> every_option() {
  std::istringstream words(
      "--size 96x64 --frames 8 --skip 1.5 --refresh 90 --server [::1]:9 --mode full --clock real "
      "--delay 35 --pictures 2 --dump 3,5 --out there --place recorded "
      "--trace-scale 0.76 --trace-axes ros/optical --trace-units us --trace-quaternion xyzw "
      "--reference-every 0 --predictor hold --guard-band off --mask-every 3 "
      "--reprojection off --edges nearest --passes single --gpu llvm --validate");
  return {std::istream_iterator<std::string>(words), {}};
}

TEST(ReadOptions, AcceptsEveryOption) {
  const Outcome read = read_more(every_option());
  ASSERT_TRUE(read.options.has_value()) << read.errors;
  const Options& options = *read.options;
  EXPECT_EQ(options.scene, "a.glb");
  EXPECT_EQ(options.trace, "b.csv");
  EXPECT_EQ(options.size, (Extent{96, 64}));
  EXPECT_EQ(options.frames, 8u);
  EXPECT_EQ(options.skip_s, 1.5);
  EXPECT_EQ(options.refresh_hz, 90);
  EXPECT_EQ(options.server, "[::1]:9");
  EXPECT_EQ(options.mode.mode, Mode::Full);
  EXPECT_EQ(options.pace, Pace::Real);
  EXPECT_EQ(options.delay_ms, 35);
  EXPECT_EQ(options.pictures, 2u);
  EXPECT_EQ(options.dump, (std::vector<std::uint32_t>{3, 5}));
  EXPECT_EQ(options.out, "there");
  EXPECT_EQ(options.place, Place::Recorded);
  EXPECT_EQ(options.trace_reading.units_a_metre, 0.76);
  EXPECT_EQ(options.trace_reading.axes.value_or(Axes()).name, "ros/optical");
  EXPECT_EQ(options.trace_reading.unit, TimeUnit::Microseconds);
  EXPECT_EQ(options.trace_reading.order, QuaternionOrder::Xyzw);
  EXPECT_EQ(options.reference_every, 0u);
  EXPECT_EQ(options.request.predictor, PredictorKind::Hold);
  EXPECT_EQ(options.request.guard_band, GuardBandUse::Off);
  EXPECT_EQ(options.request.every, 3u);
  EXPECT_EQ(options.reprojection, (Reprojection{.lookup = Lookup::Direct, .edges = Edges::Nearest}));
  EXPECT_EQ(options.passes, ShadingPasses::Single);
  EXPECT_EQ(options.device.name_contains, "llvm");
  EXPECT_EQ(options.device.validation, gpu::Validation::On);
}

TEST(ReadOptions, EdgesAreExactWhereThatFits) {
  const auto edges_with = [](const std::vector<std::string>& arguments) {
    return read_more(arguments).options.value().reprojection.edges;
  };
  EXPECT_EQ(edges_with({}), Edges::Exact);
  EXPECT_EQ(edges_with({"--passes", "sorted"}), Edges::Exact);
  EXPECT_EQ(edges_with({"--edges", "exact"}), Edges::Exact);
  EXPECT_EQ(edges_with({"--record", "capture"}), Edges::Line);
  EXPECT_EQ(read({"--scene", "a.glb", "--replay", "capture"}).options.value().reprojection.edges,
            Edges::Line);
  EXPECT_EQ(edges_with({"--passes", "single"}), Edges::Line);
  EXPECT_EQ(edges_with({"--edges", "line"}), Edges::Line);
  EXPECT_EQ(edges_with({"--edges", "coverage", "--record", "capture"}), Edges::Coverage);
}

TEST(ReadOptions, AHeadStandsWhereTheUserSays) {
  EXPECT_FALSE(read_more({}).options->start_pose.has_value());
  const Outcome stands = read_more({"--stand", "-3.4,1.4,-4,180", "--place", "fit"});
  ASSERT_TRUE(stands.options.has_value()) << stands.errors;
  EXPECT_EQ(stands.options->start_pose, parse_start_pose("-3.4,1.4,-4,180").value());
  EXPECT_EQ(stands.options->place, Place::Fit);
  const Outcome recorded = read_more({"--stand", "1,2,3", "--place", "recorded"});
  ASSERT_FALSE(recorded.options.has_value());
  EXPECT_NE(recorded.errors.find("omit one"), std::string::npos) << recorded.errors;
}

TEST(ReadOptions, PreviewExcludesTheOptionsOfReplays) {
  EXPECT_TRUE(read_more({"--preview"}).options.has_value());
  for (const std::vector<std::string>& other : {std::vector<std::string>{"--clock", "real"},
                                                {"--delay", "5"},
                                                {"--pictures", "1"},
                                                {"--dump", "1"},
                                                {"--reference-every", "2"},
                                                {"--replay", "capture"}}) {
    std::vector<std::string> arguments{"--preview"};
    arguments.insert(arguments.end(), other.begin(), other.end());
    const Outcome read = read_more(arguments);
    ASSERT_FALSE(read.options.has_value()) << other[0];
    EXPECT_EQ(read.options.error().status, 2);
    EXPECT_NE(read.errors.find(other[0]), std::string::npos) << read.errors;
  }
}

TEST(ReadOptions, HasTheDefaultsOfTheHeader) {
  const Outcome read = read_more({});
  ASSERT_TRUE(read.options.has_value());
  EXPECT_EQ(read.options->size, (Extent{512, 512}));
  EXPECT_FALSE(read.options->frames.has_value());
  EXPECT_EQ(read.options->mode.mode, Mode::Hybrid);
  EXPECT_EQ(read.options->pace, Pace::Virtual);
  EXPECT_EQ(read.options->device.validation, gpu::Validation::Off);
  EXPECT_EQ(read.options->request.predictor, kDefaultPredictor);
  EXPECT_EQ(read.options->request.guard_band, GuardBandUse::Measured);
  EXPECT_EQ(read.options->request.every, 0u);
  EXPECT_EQ(read.options->reprojection, Reprojection{.edges = Edges::Exact});
}

TEST(ReadOptions, AcceptsEveryPredictor) {
  for (const PredictorKind kind : kPredictorKinds) {
    const Outcome read = read_more({"--predictor", std::string(to_string(kind))});
    ASSERT_TRUE(read.options.has_value()) << read.errors;
    EXPECT_EQ(read.options->request.predictor, kind);
  }
}

TEST(ReadOptions, ExitsWith0AfterHelp) {
  const Outcome help = read({"--help"});
  ASSERT_FALSE(help.options.has_value());
  EXPECT_EQ(help.options.error().status, 0);
  EXPECT_NE(help.out.find("--mask-every"), std::string::npos);
  EXPECT_NE(help.out.find("Examples:"), std::string::npos);
  EXPECT_EQ(help.errors, "");
}

TEST(ReadOptions, HelpNamesWordsRangesAndDefaultsOnly) {
  const std::string out = read({"--help"}).out;
  for (const char* said : {"hybrid|client-positions|server-gbuffer|remote|delta|local|full (default: hybrid)",
                           "virtual|real (default: virtual)", "exact|line|nearest|coverage",
                           "(default: exact; line with --record or --passes single)", "needed|everything",
                           "NUMBER (1 to 4294967295)", "NUMBER (0 to 500, default: 20)"})
    EXPECT_NE(out.find(said), std::string::npos) << said << "\n" << out;
  for (const char c : out) EXPECT_TRUE(c == '\n' || (c >= ' ' && c <= '~')) << int{c};
  for (const char* unreadable : {":{", "->", "VALUE", "UINT"})
    EXPECT_EQ(out.find(unreadable), std::string::npos) << unreadable;
}

TEST(ReadOptions, SuggestsWhatWasMeant) {
  const std::vector<std::pair<std::vector<std::string>, std::string>> misspelt{
      {{"--mode", "hybird"},
       "vr_client: --mode: 'hybird' is not one of hybrid, client-positions, server-gbuffer, remote, delta, "
       "local, full; did you mean hybrid? (see --help)\n"},
      {{"--moed", "hybrid"}, "vr_client: unknown option --moed; did you mean --mode? (see --help)\n"},
      {{"--mask-evry=2"}, "vr_client: unknown option --mask-evry; did you mean --mask-every? (see --help)\n"},
      {{"docter"}, "vr_client: unexpected argument docter; did you mean doctor? (see --help)\n"},
      {{"--xyzzy"}, "vr_client: unknown option --xyzzy (see --help)\n"},
      {{"--plan=evrything"},
       "vr_client: --plan: 'evrything' is not one of needed, everything; did you mean everything? (see "
       "--help)\n"},
      {{"--frames", "0"}, "vr_client: --frames: '0' is not within 1 to 4294967295 (see --help)\n"}};
  for (const auto& [arguments, complaint] : misspelt) EXPECT_EQ(read_more(arguments).errors, complaint);
}

TEST(ReadOptions, NamesTheFaultInOneLineAndExitsWith2) {
  const std::vector<std::pair<std::vector<std::string>, std::string>> wrong{
      {{"--size", "0x0"}, "--size"},
      {{"--size", "100000x100000"}, "--size"},
      {{"--frames", "0"}, "--frames"},
      {{"--frames", "-3"}, "--frames"},
      {{"--frames", "many"}, "--frames"},
      {{"--frames", "4294967297"}, "--frames"},
      {{"--skip", "-1"}, "--skip"},
      {{"--skip", "nan"}, "--skip"},
      {{"--skip", "1e300"}, "--skip"},
      {{"--refresh", "0"}, "--refresh"},
      {{"--refresh", "nan"}, "--refresh"},
      {{"--refresh", "1e9"}, "--refresh"},
      {{"--delay", "501"}, "--delay"},
      {{"--delay", "nan"}, "--delay"},
      {{"--mode", "magic"}, "--mode"},
      {{"--bitrate", "0"}, "--bitrate"},
      {{"--bitrate", "nan"}, "--bitrate"},
      {{"--mask-code", "zstd"}, "--mask-code"},
      {{"--mask-code", "lz4", "--mode", "client-positions"}, "--mask-code"},
      {{"--mask-code", "lz4", "--ask", "unknown"}, "--ask"},
      {{"--mask-code", "lz4", "--record", "capture"}, "--record"},
      {{"--shadow-maps", "16"}, "--shadow-maps"},
      {{"--mode", "delta", "--record", "capture"}, "--record"},
      {{"--mode", "server-gbuffer", "--dump", "3"}, "--dump"},
      {{"--clock", "wall"}, "--clock"},
      {{"--place", "here"}, "--place"},
      {{"--stand", "1,2"}, "--stand"},
      {{"--stand", "1,2,nan"}, "--stand"},
      {{"--trace-scale", "0"}, "--trace-scale"},
      {{"--trace-scale", "nan"}, "--trace-scale"},
      {{"--pictures", "-1"}, "--pictures"},
      {{"--predictor", "oracle"}, "--predictor"},
      {{"--predictor", ""}, "--predictor"},
      {{"--guard-band", "wide"}, "--guard-band"},
      {{"--mask-every", "0"}, "--mask-every"},
      {{"--mask-every", "65"}, "--mask-every"},
      {{"--mask-every", "1.5"}, "--mask-every"},
      {{"--reprojection", "maybe"}, "--reprojection"},
      {{"--edges", "soft"}, "--edges"},
      {{"--edges", "exact", "--record", "capture"}, "--edges"},
      {{"--edges", "exact", "--passes", "single"}, "--edges"},
      {{"--dump", "one"}, "--dump"},
      {{"--no-such-option"}, "--no-such-option"}};
  for (const auto& [arguments, named] : wrong) {
    const Outcome outcome = read_more(arguments);
    ASSERT_FALSE(outcome.options.has_value()) << testing::PrintToString(arguments);
    EXPECT_EQ(outcome.options.error().status, 2);
    EXPECT_NE(outcome.errors.find(named), std::string::npos) << outcome.errors;
    EXPECT_TRUE(outcome.errors.starts_with("vr_client: ")) << outcome.errors;
    EXPECT_EQ(std::count(outcome.errors.begin(), outcome.errors.end(), '\n'), 1) << outcome.errors;
  }
}

TEST(ReadOptions, RefusesUnknownWaysToReadAHeadRecording) {
  const std::vector<std::pair<std::vector<std::string>, std::string>> wrong{
      {{"--trace-axes", "zup"}, "unknown axes 'zup'"},
      {{"--trace-axes", "unity/ros"}, "left-handed"},
      {{"--trace-units", "min"}, "--trace-units"},
      {{"--trace-quaternion", "wzyx"}, "--trace-quaternion"}};
  for (const auto& [arguments, named] : wrong) {
    const Outcome outcome = read_more(arguments);
    ASSERT_FALSE(outcome.options.has_value()) << named;
    EXPECT_NE(outcome.errors.find(named), std::string::npos) << outcome.errors;
  }
}

TEST(ReadOptions, AcceptsEveryModeAndItsSettings) {
  for (const ModeName& mode : kModes) {
    const Outcome read = read_more({"--mode", std::string(mode.name)});
    ASSERT_TRUE(read.options.has_value()) << read.errors;
    EXPECT_EQ(read.options->mode, ModeSettings{.mode = mode.mode});
    EXPECT_EQ(name_of(mode.mode), mode.name);
  }
  const Outcome set = read_more({"--mode", "remote", "--bitrate", "2.5", "--shadow-maps", "512"});
  ASSERT_TRUE(set.options.has_value()) << set.errors;
  EXPECT_EQ(set.options->mode.bits_per_second, 2'500'000u);
  EXPECT_EQ(set.options->mode.shadow_maps.side_px, 512u);
}

TEST(ReadOptions, BlocksOfMasksAreAskedForAsAWhole) {
  const Outcome range = read_more({"--mask-code", "range"}), lz4 = read_more({"--mask-code", "lz4"});
  ASSERT_TRUE(range.options && lz4.options) << range.errors << lz4.errors;
  EXPECT_EQ(range.options->mode, ModeSettings{});
  EXPECT_EQ(range.options->request.asks, Asks::Unknown);
  EXPECT_EQ(lz4.options->mode.mask_code, MaskCode::Lz4);
  EXPECT_EQ(lz4.options->request.asks, Asks::Whole);
  EXPECT_TRUE(read_more({"--mask-code", "lz4", "--ask", "whole"}).options);
}

TEST(ReadOptions, PlanAndPreviewAndExportNeedLess) {
  EXPECT_TRUE(read({"--scene", "a.glb", "--plan"}).options.has_value());
  EXPECT_TRUE(read({"--scene", "a.glb", "--preview"}).options.has_value());
  EXPECT_TRUE(read({"--scene", "a.glb", "--replay", "a.farshade"}).options.has_value());
  EXPECT_TRUE(read({"--trace", "b.csv", "--export-trace", "c.tum"}).options.has_value());
  EXPECT_FALSE(read({"--scene", "a.glb", "--export-trace", "c.tum"}).options.has_value());
}

TEST(ReadOptions, AHeadsetNeedsNoHeadRecordingAndRefusesWhatItsRuntimeGives) {
  const Outcome headset = read({"--scene", "a.glb", "--xr", "openxr"});
  ASSERT_TRUE(headset.options) << headset.errors;
  EXPECT_EQ(headset.options->xr, Xr::OpenXr);
  EXPECT_EQ(headset.options->reference_every, 0u) << "a display does not wait";
  for (const auto& [option, value] :
       {std::pair{"--trace", "b.csv"}, {"--size", "64x64"}, {"--clock", "virtual"}}) {
    const Outcome outcome = read({"--scene", "a.glb", "--xr", "openxr", option, value});
    ASSERT_FALSE(outcome.options) << option;
    EXPECT_NE(outcome.errors.find("does not go with --xr openxr"), std::string::npos) << outcome.errors;
  }
  EXPECT_FALSE(read_more({"--xr-scale", "0.5"}).options) << "without --xr";
  EXPECT_FALSE(read({"--scene", "a.glb", "--xr", "openxr", "--reference-every", "1"}).options)
      << "no --frames";
  EXPECT_TRUE(
      read({"--scene", "a.glb", "--xr", "openxr", "--reference-every", "1", "--frames", "9"}).options);
}

TEST(ReadOptions, WithoutAHeadsetAWindowOrTheHeadRecordingFollows) {
  EXPECT_TRUE(preview_follows(read({"--scene", "a.glb", "--xr", "auto"}).options.value()));
  EXPECT_TRUE(preview_follows(read_more({"--xr", "auto", "--preview"}).options.value()));
  EXPECT_FALSE(preview_follows(read_more({"--xr", "auto"}).options.value()));
  EXPECT_FALSE(preview_follows(read_more({}).options.value()));
}

TEST(ReadOptions, WithoutASceneItComesFromTheServer) {
  EXPECT_TRUE(read({"--trace", "b.csv"}).options.has_value());
  EXPECT_TRUE(read({"--trace", "b.csv", "--preview"}).options.has_value());
  EXPECT_FALSE(read({"--replay", "a.farshade"}).options.has_value()) << "a replay contacts no server";
  for (const auto& [option, value] :
       {std::pair{"--sun", "145,50,3"}, {"--ambient", "0.1"}, {"--exposure", "2"}}) {
    const Outcome outcome = read({"--trace", "b.csv", option, value});
    ASSERT_FALSE(outcome.options.has_value()) << option;
    EXPECT_NE(outcome.errors.find("as the server says"), std::string::npos) << outcome.errors;
  }
}

TEST(ReadOptions, ReadsThePlan) {
  EXPECT_FALSE(read_more({}).options->plan.prints_only);
  const Outcome told = read_more({"--plan"});
  EXPECT_TRUE(told.options->plan.prints_only);
  EXPECT_EQ(told.options->plan.kind, PlanKind::Needed);
  EXPECT_EQ(read_more({"--plan=everything"}).options->plan.kind, PlanKind::Everything);
}

TEST(ReadOptions, CapturesModesWithMasksOnly) {
  for (const ModeName& mode : kModes) {
    const Outcome read = read_more({"--mode", std::string(mode.name), "--record", "a.farshade"});
    EXPECT_EQ(read.options.has_value(), mode.mode == Mode::Hybrid || mode.mode == Mode::Full) << mode.name;
  }
  EXPECT_FALSE(read_more({"--record", "a", "--replay", "b"}).options.has_value());
}

TEST(ReadOptions, AReplayRefusesWhatItTakesFromTheCapture) {
  const std::vector<std::string> replay{"--scene", "a.glb", "--replay", "b"};
  std::vector<std::string> fine = replay;
  for (const char* word : {"--out", "c", "--dump", "1", "--reference-every", "0", "--pictures", "0", "--gpu",
                           "x", "--timeline", "d", "--plan=everything", "--sun", "145,50,3"})
    fine.emplace_back(word);
  EXPECT_TRUE(read(fine).options.has_value()) << read(fine).errors;
  for (const auto& [option, value] : {std::pair{"--mode", "full"},
                                      {"--size", "512x512"},
                                      {"--predictor", "hold"},
                                      {"--frames", "2"},
                                      {"--server", "a:1"},
                                      {"--edges", "coverage"},
                                      {"--xr", "auto"}}) {
    std::vector<std::string> more = replay;
    more.insert(more.end(), {option, value});
    const Outcome outcome = read(more);
    ASSERT_FALSE(outcome.options.has_value()) << option;
    EXPECT_EQ(outcome.errors,
              std::string("vr_client: ") + option +
                  ": a replay repeats the captured run as it was: omit this option (see --help)\n");
  }
}

TEST(ReadOptions, AConfigurationFileSetsOptionsAndHindersNeitherReplayNorPreviewNorHeadset) {
  const ScratchFolder folder;
  const std::string file = (folder.path() / "vr_client.ini").string();
  std::ofstream(file)
      << "trace = b.csv\nmode = full\nsize = 96x64\nserver = there:1\ninsecure = true\nclock = real\n"
      << "xr = auto\n";
  const Outcome run = read({"--config", file, "--scene", "a.glb", "--mode", "local"});
  ASSERT_TRUE(run.options.has_value()) << run.errors;
  EXPECT_EQ(run.options->trace, "b.csv");
  EXPECT_EQ(run.options->mode.mode, Mode::Local);
  EXPECT_EQ(run.options->size, (Extent{96, 64}));
  EXPECT_TRUE(run.options->insecure);
  const Outcome replay = read({"--config", file, "--scene", "a.glb", "--replay", "b"});
  ASSERT_TRUE(replay.options.has_value()) << replay.errors;
  EXPECT_EQ(replay.options->replay, "b");
  EXPECT_TRUE(read({"--config", file, "--scene", "a.glb", "--preview"}).options.has_value());
  const Outcome headset = read({"--config", file, "--scene", "a.glb", "--xr", "openxr"});
  ASSERT_TRUE(headset.options.has_value()) << headset.errors;
  EXPECT_EQ(headset.options->server, "there:1");
  const Outcome doctor = read({"--config", file, "doctor"});
  ASSERT_TRUE(doctor.options.has_value()) << doctor.errors;
  EXPECT_EQ(doctor.options->doctor->server, "there:1");
}

TEST(ReadOptions, AnUnknownKeyOfAConfigurationFileIsNamed) {
  const ScratchFolder folder;
  const std::string file = (folder.path() / "vr_client.ini").string();
  std::ofstream(file) << "mdoe = full\n";
  const Outcome outcome = read_more({"--config", file});
  ASSERT_FALSE(outcome.options.has_value());
  EXPECT_EQ(outcome.options.error().status, 2);
  EXPECT_EQ(outcome.errors, "vr_client: " + file + ": unknown key 'mdoe'; did you mean mode? (see --help)\n");
}

TEST(ReadOptions, RunsTheDoctorWithoutOtherOptions) {
  const Outcome read = farshade::read({"doctor", "--server", "there:1", "--insecure"});
  ASSERT_TRUE(read.options.has_value()) << read.errors;
  ASSERT_TRUE(read.options->doctor.has_value());
  EXPECT_EQ(read.options->doctor->server, "there:1");
  EXPECT_TRUE(read.options->doctor->insecure);
  EXPECT_FALSE(read_more({}).options->doctor.has_value());
}

TEST(ReadOptions, DescribesADeviceWithoutOtherOptions) {
  const Outcome read = farshade::read({"device", "--gpu", "Voodoo2"});
  ASSERT_TRUE(read.options.has_value()) << read.errors;
  ASSERT_TRUE(read.options->facts.has_value());
  EXPECT_EQ(read.options->facts->gpu, "Voodoo2");
}

TEST(ReadOptions, NamesMissingOptions) {
  EXPECT_EQ(read({}).options.error().status, 2);
  const Outcome outcome = read({"--scene", "a.glb"});
  ASSERT_FALSE(outcome.options.has_value());
  EXPECT_EQ(outcome.options.error().status, 2);
  EXPECT_NE(outcome.errors.find("--trace"), std::string::npos);
}

}  // namespace
}  // namespace farshade
