#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <set>
#include <sstream>

#include "stereo/head/reader.h"
#include "stereo/math/rotation.h"
#include "stereo/video/video.h"
#include "tests/preview/preview_desk.h"
#include "tests/support/image_reader.h"
#include "vr_client/frame/mode.h"
#include "vr_client/preview/head.h"
#include "vr_client/preview/layout.h"
#include "vr_client/preview/remembered.h"

namespace farshade {
namespace {

using PreviewProgram = PreviewDesk;

/// In this window, each eye is shown unscaled in the middle of its half.
constexpr Extent kSnug{220, 110};

EyePictures halves(const Image<Rgb8>& window, std::uint32_t side) {
  const std::uint32_t half = window.size.width / 2, top = (window.size.height - side) / 2;
  const std::uint32_t margin = (half - side) / 2;
  return {crop(window, margin, top, {side, side}), crop(window, half + margin, top, {side, side}), window};
}

std::vector<Image<Rgb8>> pictures_in(const std::filesystem::path& folder, const std::string& ending) {
  std::vector<Image<Rgb8>> pictures;
  for (const std::string& file : files_below(folder))
    if (file.starts_with("frame_") && file.ends_with(ending))
      pictures.push_back(read_png(folder / file).value());
  return pictures;
}

/// What vr_client wrote for each frame of a replayed capture.
struct Replayed {
  std::vector<Image<Rgb8>> left, right;
};

Replayed replay(const std::filesystem::path& capture, const std::filesystem::path& out) {
  ChildProgram program({"/usr/bin/env", "LSAN_OPTIONS=detect_leaks=0", VR_CLIENT, "--scene", kRoom,
                        "--replay", capture.string(), "--out", out.string(), "--pictures", "100000",
                        "--reference-every", "0"});
  const std::string errors = program.errors();
  EXPECT_EQ(program.wait(), 0) << errors;
  return {pictures_in(out, "_left.png"), pictures_in(out, "_right.png")};
}

/// Are `frames` (both eyes side by side) equal to the replayed frames from frame `first` on?
bool are_from(std::size_t first, const std::vector<Image<Rgb8>>& frames, const Replayed& replayed) {
  for (std::size_t i = 0; i < frames.size(); ++i)
    if (crop(frames[i], 0, 0, kDeskEye) != replayed.left[first + i] ||
        crop(frames[i], kDeskEye.width, 0, kDeskEye) != replayed.right[first + i])
      return false;
  return true;
}

TEST_F(PreviewProgram, ShowsThePicturesThatAReplayDraws) {
  open();
  resize(kSnug);
  screen_.tap("F8");
  ASSERT_TRUE(appears(out_ / "capture_0001.farshade"));
  screen_.tap("F10");
  screen_.press("d");
  ASSERT_TRUE(appears(out_ / "frames_0001/frame_00012.png"));
  screen_.release("d");
  screen_.tap("F10");
  EyePictures taken, seen;
  EXPECT_TRUE(patiently([&] {
    taken = take_screenshot();
    seen = halves(screen_.screenshot(window_), kDeskEye.width);
    return seen.window == taken.window;
  }));
  screen_.tap("Escape");
  ASSERT_EQ(end(), 0) << errors_;

  EXPECT_EQ(seen.left, taken.left);
  EXPECT_EQ(seen.right, taken.right);
  EXPECT_NE(taken.left, taken.right);
  const Replayed replayed = replay(out_ / "capture_0001.farshade", out_ / "replay");
  std::vector<Image<Rgb8>> frames = pictures_in(out_ / "frames_0001", ".png");
  ASSERT_GE(frames.size(), 12);
  // A replay writes no pictures from before the first answer, which F10 may have written.
  const auto is_replayed = [&](const Image<Rgb8>& frame) {
    return std::ranges::find(replayed.left, crop(frame, 0, 0, kDeskEye)) != replayed.left.end();
  };
  frames.erase(frames.begin(), std::find_if(frames.begin(), frames.end() - 6, is_replayed));
  ASSERT_GE(replayed.left.size(), frames.size());
  EXPECT_NE(frames.front(), frames.back()) << "the head moved";
  std::size_t first = 0;
  while (first + frames.size() < replayed.left.size() && !are_from(first, frames, replayed)) ++first;
  EXPECT_TRUE(are_from(first, frames, replayed)) << "written frames are not among those replayed";
  const auto still = std::ranges::find(replayed.left, seen.left);
  ASSERT_NE(still, replayed.left.end()) << "the picture on the screen is not among the replayed frames";
  EXPECT_EQ(seen.right, replayed.right[static_cast<std::size_t>(still - replayed.left.begin())]);
}

/// The steps of a recorded head. Each step is either a step ahead at walking speed or no movement. Counts the
/// steps that moved, and the number of uninterrupted walks.
struct Walk {
  int steps = 0, goes = 0;
};

Walk check_walk(const HeadRecording& recording) {
  constexpr double as_written = 1e-6;
  Walk walk;
  bool walked = false;
  for (std::size_t i = 1; i < recording.samples.size(); ++i) {
    const auto& [before, from] = recording.samples[i - 1];
    const auto& [now, to] = recording.samples[i];
    const glm::dvec3 step = to.translation - from.translation;
    const double heading = heading_rad(from.rotation);
    const double turn = std::remainder(heading_rad(to.rotation) - heading, 2 * std::numbers::pi);
    const bool walks = glm::length(step) > as_written;
    walk.goes += walks && !walked;
    walked = walks;
    EXPECT_NEAR((to.rotation * glm::dvec3(1, 0, 0)).y, 0, as_written) << "a head without roll, sample " << i;
    if (!walks) continue;
    ++walk.steps;
    const double arc = kWalkingSpeed_m_per_s * seconds_of(std::min(now - before, kLongestStep));
    const double chord = turn == 0 ? arc : arc * std::sin(turn / 2) / (turn / 2);
    const glm::dvec3 ahead{-std::sin(heading + turn / 2), 0, -std::cos(heading + turn / 2)};
    EXPECT_LT(glm::distance(step, chord * ahead), as_written)
        << "sample " << i << ": walked " << glm::length(step) << " m in " << seconds_of(now - before) << " s";
  }
  return walk;
}

double pitch_rad(const glm::dquat& rotation) {
  const glm::dvec3 ahead = rotation * glm::dvec3(0, 0, -1);
  return std::atan2(ahead.y, std::hypot(ahead.x, ahead.z));
}

TEST_F(PreviewProgram, KeysAndMouseMoveTheHead) {
  constexpr int dragged_right = 60, dragged_up = 24;
  open();
  screen_.move_mouse(window_, 200, 300);
  screen_.tap("F9");
  screen_.press("w");
  ASSERT_TRUE(changes(3));
  screen_.press_button();
  screen_.move_mouse(window_, 200 + dragged_right, 300 - dragged_up);
  screen_.release_button();
  screen_.move_mouse(window_, 100, 100);
  ASSERT_TRUE(changes(3));
  screen_.release("w");
  screen_.tap("F9");
  ASSERT_TRUE(appears(out_ / "head_0001.csv"));
  screen_.tap("Escape");
  ASSERT_EQ(end(), 0) << errors_;

  const auto recording = load_head_recording(out_ / "head_0001.csv");
  ASSERT_TRUE(recording) << recording.error().what;
  const Walk walk = check_walk(*recording);
  EXPECT_EQ(walk.goes, 1);
  EXPECT_GE(walk.steps, 3);
  const glm::dquat first = recording->samples.front().recorded_from_head.rotation,
                   last = recording->samples.back().recorded_from_head.rotation;
  EXPECT_NEAR(std::remainder(heading_rad(last) - heading_rad(first), 2 * std::numbers::pi),
              -dragged_right * kTurn_rad_per_px, 1e-6);
  EXPECT_NEAR(pitch_rad(last) - pitch_rad(first), dragged_up * kTurn_rad_per_px, 1e-6);
}

/// The largest difference of any channel from `eye`, scaled to that size with bilinear filtering.
double difference_to_resized(const Image<Rgb8>& seen, const Image<Rgb8>& eye) {
  double largest = 0;
  const auto at = [&](double x, double y) {
    const auto held = [](double value, std::uint32_t side) {
      return static_cast<std::uint32_t>(std::clamp(value, 0.0, side - 1.0));
    };
    return glm::dvec3(eye.at(held(x, eye.size.width), held(y, eye.size.height)));
  };
  for (std::uint32_t row = 0; row < seen.size.height; ++row)
    for (std::uint32_t column = 0; column < seen.size.width; ++column) {
      const double x = (column + 0.5) * eye.size.width / seen.size.width - 0.5;
      const double y = (row + 0.5) * eye.size.height / seen.size.height - 0.5;
      const double left = std::floor(x), top = std::floor(y);
      const glm::dvec3 above = glm::mix(at(left, top), at(left + 1, top), x - left);
      const glm::dvec3 below = glm::mix(at(left, top + 1), at(left + 1, top + 1), x - left);
      const glm::dvec3 off = glm::abs(glm::dvec3(seen.at(column, row)) - glm::mix(above, below, y - top));
      largest = std::max({largest, off.x, off.y, off.z});
    }
  return largest;
}

std::uint64_t light_of(const Image<Rgb8>& image) {
  std::uint64_t sum = 0;
  for (const Rgb8 pixel : image.pixels) sum += pixel.r + 0u + pixel.g + pixel.b;
  return sum;
}

TEST_F(PreviewProgram, FollowsTheSizeOfItsWindowAndKeepsTheAspectRatio) {
  open();
  struct Sized {
    Extent window;
    std::uint32_t eye;
  };
  for (const Sized& sized : {Sized{{400, 300}, 200}, {{900, 250}, 250}, {{120, 200}, 60}}) {
    const Extent size = sized.window;
    const std::uint32_t eye = sized.eye;
    resize(size);
    EyePictures taken, seen;
    ASSERT_TRUE(patiently([&] {
      taken = take_screenshot();
      seen = halves(screen_.screenshot(window_), eye);
      return seen.window == taken.window;
    })) << "window of "
        << size.width << " x " << size.height;
    EXPECT_EQ(taken.left.size, kDeskEye);
    // Devices may filter with weights of 8 bits.
    EXPECT_LE(difference_to_resized(seen.left, taken.left), 2);
    EXPECT_LE(difference_to_resized(seen.right, taken.right), 2);
    EXPECT_EQ(light_of(seen.window), light_of(seen.left) + light_of(seen.right)) << "nothing beside the eyes";
    screen_.tap("k");
    EXPECT_TRUE(changes()) << "a light was switched";
  }
  screen_.tap("Escape");
  EXPECT_EQ(end(), 0) << errors_;
}

Duration longest_interval(const HeadRecording& recording) {
  Duration longest{};
  for (std::size_t i = 1; i < recording.samples.size(); ++i)
    longest = std::max(longest, recording.samples[i].time - recording.samples[i - 1].time);
  return longest;
}

TEST_F(PreviewProgram, PausesWhileMinimisedAndRunsUntilClosed) {
  constexpr Duration rest = std::chrono::milliseconds(1500);
  const SteadyClock clock;
  screen_.manage_windows();
  open();
  screen_.tap("F9");
  screen_.press("d");
  ASSERT_TRUE(changes(3));
  screen_.release("d");
  screen_.iconify(window_);
  ASSERT_TRUE(patiently([&] { return !screen_.find("Farshade: "); }));
  const Time minimised = clock.now();
  ASSERT_TRUE(patiently([&] { return clock.now() - minimised > rest; }));
  screen_.restore(window_);
  ASSERT_TRUE(patiently([&] { return screen_.find("Farshade: ").has_value(); }));
  screen_.focus(window_);
  screen_.press("a");
  ASSERT_TRUE(changes(3));
  screen_.release("a");
  screen_.close(window_);
  ASSERT_EQ(end(), 0) << errors_;

  const auto recording = load_head_recording(out_ / "head_0001.csv");
  ASSERT_TRUE(recording) << recording.error().what;
  EXPECT_GT(longest_interval(*recording), rest * 2 / 3) << "no frames while it was minimised";
}

std::size_t pictures_below(const std::filesystem::path& folder) {
  return files_below(folder).size();
}

TEST_F(PreviewProgram, HoldsAFrameAndGoesOnFrameByFrame) {
  constexpr Duration rest = std::chrono::seconds(3);
  open({"--validate"});
  resize(kSnug);
  screen_.press("w");
  const SteadyClock clock;
  const Time began = clock.now();
  screen_.tap("F9");
  screen_.tap("F10");
  const std::filesystem::path frames = out_ / "frames_0001";
  ASSERT_TRUE(appears(frames / "frame_00003.png"));
  screen_.tap("n");
  const EyePictures held = take_screenshot();
  const Time since = clock.now();
  screen_.tap("o");
  const EyePictures source = take_screenshot();
  EXPECT_NE(source.left, held.left) << "overlays can be chosen while a frame is held";
  const std::size_t before = pictures_below(frames);
  screen_.tap("0");
  ASSERT_TRUE(patiently([&] { return clock.now() - since > rest; }));
  EXPECT_EQ(take_screenshot().left, held.left);
  EXPECT_EQ(pictures_below(frames), before) << "no frames are drawn";
  const Duration held_for = clock.now() - since;

  std::vector<Image<Rgb8>> steps{held.left};
  for (std::size_t step = 1; step <= 3; ++step) {
    screen_.tap("n");
    EXPECT_TRUE(patiently([&] { return pictures_below(frames) > before + step - 1; }));
    steps.push_back(take_screenshot().left);
    EXPECT_NE(steps[step], steps[step - 1]) << "the head walked";
    EXPECT_EQ(pictures_below(frames), before + step) << "one frame";
  }
  screen_.tap("Return");
  EXPECT_TRUE(changes(3));
  screen_.release("w");
  screen_.tap("F9");
  ASSERT_TRUE(appears(out_ / "head_0001.csv"));
  const Duration passed = clock.now() - began;
  screen_.tap("Escape");
  ASSERT_EQ(end(), 0) << errors_;

  const auto recording = load_head_recording(out_ / "head_0001.csv");
  ASSERT_TRUE(recording) << recording.error().what;
  EXPECT_EQ(check_walk(*recording).goes, 1) << "no step is longer than its frame";
  const Duration recorded = recording->samples.back().time - recording->samples.front().time;
  EXPECT_LT(recorded + held_for, passed) << "the time stood still";
}

/// The part of the window that the panel covers.
Image<Rgb8> panel_of(const Image<Rgb8>& window) {
  const auto width = static_cast<std::uint32_t>(kPanelWidth_px);
  return crop(window, window.size.width - width, 0, {width, window.size.height});
}

TEST_F(PreviewProgram, InspectsThePixelUnderTheMouse) {
  open({"--validate"});
  resize({1280, 720});
  screen_.tap("i");
  screen_.tap("Return");
  screen_.move_mouse(window_, 1, 1);
  // The panel of a held frame stands still once its tab is open.
  const auto settled = [&] {
    constexpr Duration still = std::chrono::seconds(1);
    const SteadyClock clock;
    Image<Rgb8> last = screen_.screenshot(window_);
    Time since = clock.now();
    EXPECT_TRUE(patiently([&] {
      Image<Rgb8> now = screen_.screenshot(window_);
      if (now != last) since = clock.now();
      last = std::move(now);
      return clock.now() - since > still;
    }));
    return last;
  };
  Image<Rgb8> last = settled();
  const auto move_to = [&](int x, int y) {
    screen_.move_mouse(window_, x, y);
    EXPECT_TRUE(patiently([&] { return panel_of(screen_.screenshot(window_)) != panel_of(last); })) << x;
    last = settled();
  };
  for (const int x : {230, 240, 640}) move_to(x, 400);
  move_to(1, 1);
  const Image<Rgb8> beside = last;
  move_to(640, 400);
  screen_.move_mouse(window_, 1, 1);
  EXPECT_TRUE(patiently([&] { return screen_.screenshot(window_) == beside; }));
  screen_.tap("Escape");
  EXPECT_EQ(end(), 0) << errors_;
}

/// Without caches the compiler takes seconds; without a server the eyes stay dark.
TEST_F(PreviewProgram, SaysInItsTitleWhatItWaitsFor) {
  start({"--mode", "hybrid"});
  server_->program().send(SIGSTOP);  // long before the client says hello
  std::set<std::string> titles;
  EXPECT_TRUE(patiently([&] {
    window_ = screen_.find("Farshade").value_or(window_);
    if (window_ != 0) titles.insert(screen_.title_of(window_));
    return window_ != 0 &&
           titles.rbegin()->find("hybrid, waiting for the first answer of 127.0.0.1:") != std::string::npos;
  })) << (titles.empty() ? "no window" : *titles.rbegin());
  const auto before =
      std::ranges::find_if(titles, [](const std::string& title) { return title.starts_with("Farshade ("); });
  EXPECT_NE(before, titles.end());
  server_->program().send(SIGCONT);
  EXPECT_TRUE(
      patiently([&] { return screen_.title_of(window_).find("frames per second") != std::string::npos; }));
  screen_.focus(window_);
  screen_.tap("Escape");
  EXPECT_EQ(end(), 0) << errors_;
}

TEST_F(PreviewProgram, ShowsEveryModeAndComesBackToTheFirst) {
  open();
  resize(kSnug);
  const auto shows = [&](std::string_view mode) {
    return patiently([&] { return screen_.title_of(window_).find(mode) != std::string::npos; });
  };
  ASSERT_TRUE(shows(", hybrid,"));
  for (const ModeName& next : kModes) {
    const bool can_run = has_video() || (next.mode != Mode::Remote && next.mode != Mode::Delta);
    if (next.mode == Mode::Hybrid || !can_run) continue;
    screen_.tap("m");
    ASSERT_TRUE(shows(fmt::format(", {},", next.name))) << next.name;
    EXPECT_TRUE(patiently([&] { return take_screenshot().left != Image<Rgb8>(kDeskEye); })) << next.name;
    screen_.press("d");
    EXPECT_TRUE(changes(2)) << next.name;
    screen_.release("d");
  }
  screen_.tap("m");
  ASSERT_TRUE(shows(", hybrid,"));
  screen_.press("d");
  EXPECT_TRUE(changes(2));
  screen_.release("d");
  screen_.tap("Escape");
  EXPECT_EQ(end(), 0) << errors_;
}

TEST_F(PreviewProgram, GoesBackToItsModeIfTheServerRefusesAnother) {
  server_ = std::make_unique<RunningServer>(FARSHADE_ASSETS "/box_over_plane.gltf");
  open({"--mode", "full", "--validate"});
  screen_.tap("m");
  EXPECT_EQ(take_screenshot().left.size, kDeskEye);
  EXPECT_TRUE(patiently([&] { return screen_.title_of(window_).find(", full,") != std::string::npos; }))
      << screen_.title_of(window_);
  screen_.press("d");
  EXPECT_TRUE(changes(2));
  screen_.release("d");
  screen_.tap("Escape");
  EXPECT_EQ(end(), 0) << errors_;
  EXPECT_NE(errors_.find("no mode hybrid: "), std::string::npos) << errors_;
}

TEST_F(PreviewProgram, FinishesItsRecordingsWhenInterrupted) {
  open();
  screen_.tap("F9");
  screen_.tap("F8");
  ASSERT_TRUE(appears(out_ / "capture_0001.farshade"));
  screen_.press("d");
  ASSERT_TRUE(changes(3));
  program_->send(SIGINT);
  ASSERT_EQ(end(), 130) << errors_;
  const auto recording = load_head_recording(out_ / "head_0001.csv");
  ASSERT_TRUE(recording) << recording.error().what;
  EXPECT_GE(recording->samples.size(), 3);
  replay(out_ / "capture_0001.farshade", out_ / "replay");
  EXPECT_GE(read_csv(out_ / "replay" / "frames.csv").at("frame").size(), 3u);
}

TEST_F(PreviewProgram, EndsWith143AfterSIGTERM) {
  open();
  program_->send(SIGTERM);
  EXPECT_EQ(end(), 143) << errors_;
  EXPECT_NE(errors_.find("interrupted; recordings are finished in " + out_.string()), std::string::npos)
      << errors_;
}

TEST_F(PreviewProgram, CapturesAndTimesItsFirstMessages) {
  const std::filesystem::path capture = out_ / "whole.farshade", timeline = out_ / "timeline.json";
  const std::string walk = FARSHADE_ASSETS "/walk.csv";
  std::filesystem::create_directories(remembered().parent_path());
  std::ofstream(remembered()) << "broken";
  start({"--trace", walk, "--skip", "1", "--net", "wifi", "--frames", "12", "--record", capture.string(),
         "--timeline", timeline.string()});
  ASSERT_EQ(end(), 0) << errors_;
  EXPECT_NE(errors_.find("the remembered layout of the preview is ignored"), std::string::npos) << errors_;
  EXPECT_GT(replay(capture, out_ / "replay").left.size(), 6u)
      << "frames from before the first answer have no picture";
  EXPECT_EQ(read_csv(out_ / "replay" / "frames.csv").at("frame").size(), 12u);
  std::stringstream events;
  events << std::ifstream(timeline).rdbuf();
  for (const char* told : {"rt_server", "\"shadow\"", "\"shade\"", "\"frame\":12"})
    EXPECT_NE(events.str().find(told), std::string::npos) << told;
}

TEST_F(PreviewProgram, FailsAtOnceOnInvalidOptions) {
  for (const std::vector<std::string>& wrong : {std::vector<std::string>{"--record", "/nowhere/capture"},
                                                {"--timeline", "/nowhere/timeline"},
                                                {"--net", "nonsense"}}) {
    start(wrong);
    EXPECT_EQ(end(), 1) << wrong[0];
    EXPECT_NE(errors_.find(wrong[1]), std::string::npos) << errors_;
  }
}

TEST_F(PreviewProgram, ContinuesAfterItsServerEnds) {
  open();
  server_->program().send(SIGKILL);
  server_->program().wait();
  screen_.press("d");
  EXPECT_TRUE(changes(10));
  screen_.release("d");
  EXPECT_EQ(take_screenshot().left.size, kDeskEye);
  resize({900, 500});
  screen_.press("d");
  EXPECT_TRUE(changes(3));
  screen_.release("d");
  screen_.tap("Escape");
  EXPECT_EQ(end(), 0) << errors_;
  EXPECT_EQ(load_remembered(remembered()).value(), (Remembered{.window = Extent{900, 500}, .panel = false}));
}

TEST_F(PreviewProgram, EndsWhenTheServerHasAnotherScene) {
  server_ = std::make_unique<RunningServer>(FARSHADE_ASSETS "/box_over_plane.gltf");
  start();
  EXPECT_EQ(end(), 1);
  EXPECT_NE(errors_.find("scene"), std::string::npos) << errors_;
}

TEST_F(PreviewProgram, EndsWhenItsServerRestartsWithAnotherScene) {
  open();
  const std::string address = server_->address();
  server_->program().send(SIGKILL);
  server_->program().wait();
  server_ = std::make_unique<RunningServer>(FARSHADE_ASSETS "/box_over_plane.gltf", address);
  EXPECT_EQ(end(), 1);
  EXPECT_NE(errors_.find("scene"), std::string::npos) << errors_;
}

/// A key takes effect before the F12 that follows it.
TEST_F(PreviewProgram, EveryDisplayModeAndOverlayGivesAnotherPicture) {
  open({"--validate"});
  resize({400, 200});
  std::vector<EyePictures> overlays{take_screenshot()};
  for (const char* overlay : {"source", "age", "unknown", "error", "light", "guard-band", "rays"}) {
    screen_.tap("o");
    overlays.push_back(take_screenshot());
    for (std::size_t i = 0; i + 1 < overlays.size(); ++i) {
      EXPECT_NE(overlays[i].left, overlays.back().left) << i << ", " << overlay;
      EXPECT_NE(overlays[i].right, overlays.back().right) << i << ", " << overlay;
    }
  }
  screen_.tap("o");
  std::vector<EyePictures> looks{take_screenshot()};
  screen_.tap("f");
  for (const char* look : {"cross-eyed", "mono", "anaglyph", "difference"}) {
    screen_.tap("v");
    looks.push_back(take_screenshot());
    for (std::size_t i = 0; i + 1 < looks.size(); ++i)
      EXPECT_NE(looks[i].window, looks.back().window) << i << ", " << look;
  }
  screen_.tap("v");
  EXPECT_TRUE(patiently([&] { return take_screenshot().window == looks.front().window; }))
      << "back at the first look";
  screen_.tap("Escape");
  EXPECT_EQ(end(), 0) << errors_;
}

TEST_F(PreviewProgram, F1ShowsAndHidesTheKeys) {
  open();
  resize({1200, 800});
  Image<Rgb8> bare, with_keys;
  ASSERT_TRUE(patiently([&] {
    bare = screen_.screenshot(window_);
    return bare == take_screenshot().window;
  }));
  screen_.tap("F1");
  EXPECT_TRUE(patiently([&] { return (with_keys = screen_.screenshot(window_)) != bare; }));
  screen_.tap("F1");
  EXPECT_TRUE(patiently([&] { return screen_.screenshot(window_) == bare; }));
  screen_.tap("Escape");
  EXPECT_EQ(end(), 0) << errors_;
}

TEST_F(PreviewProgram, NamesTheCureWithoutADesktop) {
  program_ = std::make_unique<ChildProgram>(std::vector<std::string>{
      "/usr/bin/env", "-u", "DISPLAY", "-u", "WAYLAND_DISPLAY", "LSAN_OPTIONS=detect_leaks=0", VR_CLIENT,
      "--preview", "--scene", kRoom, "--out", out_});
  EXPECT_EQ(end(), 1);
  for (const char* cure : {"DISPLAY", "ssh -X", "xvfb-run -a"})
    EXPECT_NE(errors_.find(cure), std::string::npos) << cure << ": " << errors_;
}

}  // namespace
}  // namespace farshade
