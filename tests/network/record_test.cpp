// Complete runs that are written to a capture file and replayed: every request and every picture is equal.
#include <gtest/gtest.h>

#include <map>

#include "rt_server/answers/answers.h"
#include "rt_server/work/server_core.h"
#include "stereo/gltf/gltf.h"
#include "stereo/gpu/device.h"
#include "stereo/head/reader.h"
#include "tests/support/manual_clock.h"
#include "tests/support/test_place.h"
#include "tests/support/virtual_link.h"
#include "tests/unit/scratch_folder.h"
#include "vr_client/modes/make_pipeline.h"
#include "vr_client/record/capture_writer.h"
#include "vr_client/record/replay.h"
#include "vr_client/runtime/recorded_head_runtime.h"

namespace farshade {
namespace {

using namespace std::chrono_literals;

constexpr Extent kEye{64, 64};
constexpr std::uint32_t kFrames = 110, kInFlight = 24;
constexpr RendererLimits limits_of(Extent traced) {
  return {.size = kEye, .traced_size = traced, .depth_frames = kInFlight};
}

struct Setup {
  gpu::Device device = gpu::open_device({.name_contains = test_gpu()}).value();
  Scene scene = load_scene(asset("room.glb")).value();
  HeadRecording head = load_head_recording(asset("walk.csv"), {}).value();
};

/// Scene and device for all tests of this program.
const Setup& setup() {
  static const Setup shared;
  return shared;
}

/// A server that can be restarted, behind a network with loss and delay.
struct FarServer {
  explicit FarServer(ManualClock& its_clock)
      : clock(its_clock), wire(clock, {.to_server = kBad, .to_client = kBad}) {
    start();
    wire.while_waiting(
        [this] {
          while (core->receive(Duration::zero())) {
          }
          while (core->work()) {
          }
          core->send_due();
        },
        [this] { return core->next_due(); });
  }
  void start() {
    RequestHandlers answers;
    answers.add(Answer::Masks, make_masks(tracer));
    core.emplace(Welcome{setup().scene.hash, lights()}, std::vector{key}, std::move(answers), wire.server(),
                 clock);
  }
  static std::uint32_t lights() { return static_cast<std::uint32_t>(setup().scene.lights.size()); }

  static constexpr LinkModel kBad{.delay = 15ms, .jitter = 20ms, .loss = 0.05};
  const SharedKey key{.name = "record", .secret = {1}};
  ManualClock& clock;
  Tracer tracer = Tracer::create(setup().scene).value();
  VirtualLink wire;
  std::optional<ServerCore> core;
};

/// A recorded head on the server's clock, with events at given frames.
class Stage final : public Runtime {
 public:
  Stage(Pace pace, ManualClock& clock, NetworkLink* link, std::function<void(std::uint32_t frame)> happens)
      : pace_(pace), clock_(clock), link_(link), begun_(clock.now()), happens_(std::move(happens)) {}

  [[nodiscard]] std::optional<FrameTiming> wait_frame() override {
    const std::optional<FrameTiming> timing = head_.wait_frame();
    if (!timing) return timing;
    first_ = first_.value_or(timing->display_time);
    if (link_ && pace_ == Pace::Real) link_->listen(begun_ + (timing->display_time - *first_) - clock_.now());
    happens_(++frame_);
    return timing;
  }
  [[nodiscard]] StereoView locate_views(Time display_time) override {
    return head_.locate_views(display_time);
  }
  void end_frame(Time display_time) override { head_.end_frame(display_time); }

 private:
  RecordedHeadRuntime head_{setup().head,
                            {.stage_from_recorded = place(setup().head, setup().scene.camera.value()),
                             .eye_size = kEye,
                             .frames = kFrames}};
  Pace pace_;
  ManualClock& clock_;
  NetworkLink* link_;
  Time begun_;
  std::optional<Time> first_;
  std::function<void(std::uint32_t)> happens_;
  std::uint32_t frame_ = 0;
};

/// All settings that can change during a run.
void steer(std::uint32_t frame, FrameSettings& settings) {
  const LightPose lamp{.position = {{0.3, 1.9, -0.4}}, .direction = {{0, -1, 0}}};
  if (frame == 12) settings.request.predictor = PredictorKind::Hold;
  if (frame == 20) change(settings.lights, 0, false, {});
  if (frame == 24) change(settings.lights, 1, true, lamp);
  if (frame == 28) settings.request.every = 3;
  if (frame == 34) settings.reprojection = {Lookup::Direct, Eyes::This, Gaps::Unknown, Edges::Nearest};
  if (frame == 40) settings.reprojection = {};
  if (frame == 42) settings.scene = SceneClock::Paused;
  if (frame == 56) settings.scene = SceneClock::Running;
  if (frame == 60) settings.request = {PredictorKind::Kalman, GuardBandUse::Off, 1};
  if (frame == 95) settings.request = {}, change(settings.lights, 0, true, {});
}

CaptureHeader header_of(MaskOrigin origin, const MaskPolicy& policy) {
  return {.scene = "room.glb",
          .scene_hash = setup().scene.hash,
          .lights = FarServer::lights(),
          .origin = origin,
          .limits = limits_of(largest_traced(kEye)),
          .requests = kInFlight,
          .refresh_hz = 72,
          .policy = policy,
          .device = setup().device.name};
}

/// Changed settings and lights over a bad network, with a server that is restarted at frame 44.
void record(const std::filesystem::path& file, MaskPolicy policy) {
  ManualClock clock;
  FarServer server(clock);
  CaptureWriter recorder(clock);
  NetworkLink link(server.wire.client(), clock,
                   {server.wire.server().local(), server.key, setup().scene.hash, {FarServer::lights()}},
                   kInFlight);
  link.tell(recorder.listener());
  ASSERT_TRUE(link.connect(3s).has_value());
  policy.round_trip = (clock.now() - Time{}) / 2;
  ASSERT_TRUE(recorder.open(file, header_of(MaskOrigin::Server, policy)).has_value());
  FrameSettings settings;
  Stage stage(policy.pace, clock, &link, [&](std::uint32_t frame) {
    steer(frame, settings);
    if (frame == 44) server.start();
  });
  const std::unique_ptr<Renderer> renderer_owner =
      make_renderer(setup().device, setup().scene, limits_of(largest_traced(kEye)));
  Renderer& renderer = *renderer_owner;
  const RunContext context{.scene = setup().scene,
                           .runtime = stage,
                           .renderer = renderer,
                           .link = &link,
                           .settings = settings,
                           .policy = policy};
  const auto watch = [&](const FrameView& view) { recorder.watch(view, renderer.read_shown()); };
  ASSERT_TRUE(run(context, *make_pipeline(context), watch, [] { return false; }).has_value());
  ASSERT_TRUE(recorder.finish().has_value());
  ASSERT_EQ(recorder.frames(), kFrames);
}

/// Replays with reports, which the captured run did not have.
Expected<ReplayVerdict> replayed(CaptureReader reader) {
  const CaptureHeader header = reader.header();
  Replay replay(std::move(reader), PixelReport::On);
  std::optional<Reference> tracer;
  if (header.origin == MaskOrigin::OwnTracer) tracer.emplace(Tracer::create(setup().scene).value());
  const std::unique_ptr<Renderer> renderer_owner =
      make_renderer(setup().device, setup().scene, header.limits);
  Renderer& renderer = *renderer_owner;
  const RunContext context{.scene = setup().scene,
                           .runtime = replay,
                           .renderer = renderer,
                           .link = replay.link(),
                           .own_tracer = tracer ? &*tracer : nullptr,
                           .settings = replay.settings(),
                           .policy = header.policy};
  const auto watch = [&](const FrameView& view) { replay.watch(view, renderer.read_shown()); };
  const Expected<void> shown = run(context, *make_pipeline(context), watch, [] { return false; });
  EXPECT_TRUE(shown.has_value());
  return replay.verdict();
}

std::vector<CapturedFrame> frames_of(const std::filesystem::path& file) {
  std::vector<CapturedFrame> frames;
  CaptureReader reader = CaptureReader::open(file).value();
  while (std::optional<CapturedFrame> frame = reader.next().value()) frames.push_back(std::move(*frame));
  return frames;
}

CaptureReader reader_of(const CaptureHeader& header, const std::vector<CapturedFrame>& frames) {
  std::vector<std::byte> bytes;
  append(header, bytes);
  for (const CapturedFrame& frame : frames) append(frame, bytes);
  return CaptureReader::over(std::make_unique<std::istringstream>(
                                 std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size())),
                             "edited")
      .value();
}

template <class Message>
bool is_a(const CapturedMessage& received) {
  const Decoded<ServerMessage> message = decode_server(received.bytes);
  return message && std::holds_alternative<Message>(*message);
}

template <class Message>
std::ptrdiff_t count_received(const std::vector<CapturedFrame>& frames) {
  std::ptrdiff_t count = 0;
  for (const CapturedFrame& frame : frames)
    count += std::ranges::count_if(frame.before, is_a<Message>) +
             std::ranges::count_if(frame.after, is_a<Message>);
  return count;
}

/// For frames with a report: the number of slices that did not arrive.
std::uint32_t lost_slices(const std::vector<CapturedFrame>& frames) {
  std::map<std::uint32_t, std::uint32_t> came, sent;
  for (const CapturedFrame& frame : frames)
    for (const auto* messages : {&frame.before, &frame.after})
      for (const CapturedMessage& each : *messages) {
        const ServerMessage message = decode_server(each.bytes).value();
        if (const auto* const slice = std::get_if<Slice>(&message)) ++came[slice->frame.value];
        if (const auto* const report = std::get_if<FrameReport>(&message))
          sent[report->frame.value] = report->slices;
      }
  std::uint32_t lost = 0;
  for (const auto& [frame, slices] : sent) lost += slices - came[frame];
  return lost;
}

/// A capture of each pace, made once.
const std::filesystem::path& recorded(const MaskPolicy& policy) {
  static const ScratchFolder folder;
  static std::map<Pace, std::filesystem::path> made;
  std::filesystem::path& file = made[policy.pace];
  if (!file.empty()) return file;
  file = folder.path() / (policy.pace == Pace::Real ? "real.capture" : "virtual.capture");
  record(file, policy);
  return file;
}

class CapturedRun : public testing::TestWithParam<MaskPolicy> {
 protected:
  const std::filesystem::path file = recorded(GetParam());
};

TEST_P(CapturedRun, AsksAndShowsTheSameAgain) {
  const Expected<ReplayVerdict> verdict = replayed(CaptureReader::open(file).value());
  ASSERT_TRUE(verdict.has_value()) << verdict.error().what;
  EXPECT_EQ(to_string(*verdict), "110 frames, all requests and pictures as captured");

  // Check that the capture contains what these tests are about.
  const std::vector<CapturedFrame> frames = frames_of(file);
  EXPECT_EQ(count_received<Welcome>(frames), 2) << "the server was restarted";
  EXPECT_GT(count_received<Slice>(frames), 40);
  EXPECT_GT(lost_slices(frames), 0u);
  const auto changes = [](const CapturedFrame& f) {
    return f.request && !f.request->request.lights.lights.empty();
  };
  EXPECT_GT(std::ranges::count_if(frames, changes), 3);
  EXPECT_GT(std::ranges::count_if(frames, [](const CapturedFrame& f) { return !f.request; }), 10);
  const auto shows = [](const CapturedFrame& f) { return f.pictures; };
  EXPECT_EQ(std::ranges::adjacent_find(frames, {}, shows), frames.end()) << "consecutive pictures differ";
}

TEST_P(CapturedRun, DiffersWhereASliceWasDropped) {
  std::vector<CapturedFrame> frames = frames_of(file);
  const CaptureHeader header = CaptureReader::open(file)->header();
  for (const std::size_t from : {8u, 30u}) {
    std::vector<CapturedFrame> edited = frames;
    std::size_t at = from;
    const auto dropped = [&](std::vector<CapturedMessage>& messages) {
      const auto slice = std::ranges::find_if(messages, is_a<Slice>);
      if (slice == messages.end()) return false;
      messages.erase(slice);
      return true;
    };
    while (!dropped(edited.at(at).before) && !dropped(edited.at(at).after)) ++at;
    edited.resize(at + 6);  // it differs before
    const ReplayVerdict verdict = replayed(reader_of(header, edited)).value();
    ASSERT_TRUE(verdict.first.has_value());
    // In virtual time a mask is used when the configured delay after its request is over.
    const auto latest = static_cast<std::uint32_t>(at + 1) + (GetParam().pace == Pace::Virtual ? 2 : 0);
    EXPECT_GE(verdict.first->frame.value, at + 1);
    EXPECT_LE(verdict.first->frame.value, latest) << to_string(verdict);
  }
}

TEST_P(CapturedRun, DiffersWhereAnInputIsAnother) {
  std::vector<CapturedFrame> frames = frames_of(file);
  const CaptureHeader header = CaptureReader::open(file)->header();
  // The copies end a few frames after the change.
  std::vector<CapturedFrame> moved(frames.begin(), frames.begin() + 53),
      steered(frames.begin(), frames.begin() + 17);
  moved.at(49).input.views[0].stage_from_eye.translation.x += 0.02;
  const ReplayVerdict by_pose = replayed(reader_of(header, moved)).value();
  ASSERT_TRUE(by_pose.first.has_value());
  EXPECT_EQ(by_pose.first->frame, FrameId{50}) << to_string(by_pose);
  for (std::size_t i = 12; i < steered.size(); ++i)
    steered[i].input.settings.request.predictor = PredictorKind::Kalman;
  const ReplayVerdict by_settings = replayed(reader_of(header, steered)).value();
  ASSERT_TRUE(by_settings.first.has_value());
  EXPECT_TRUE(by_settings.first->what.starts_with("requests")) << to_string(by_settings);
  EXPECT_EQ(by_settings.first->frame, FrameId{13}) << to_string(by_settings);
}

INSTANTIATE_TEST_SUITE_P(Pace, CapturedRun,
                         testing::Values(MaskPolicy{.pace = Pace::Real},
                                         MaskPolicy{.pace = Pace::Virtual, .delay = 20ms}),
                         [](const auto& each) { return each.param.pace == Pace::Real ? "Real" : "Virtual"; });

TEST(CapturedRunWithoutServer, ShowsTheSameAgain) {
  for (const MaskOrigin origin : {MaskOrigin::OwnTracer, MaskOrigin::Nobody}) {
    const ScratchFolder folder;
    const std::filesystem::path file = folder.path() / "a.capture";
    ManualClock clock;
    CaptureWriter recorder(clock);
    const MaskPolicy policy{.pace = Pace::Virtual};
    ASSERT_TRUE(recorder.open(file, header_of(origin, policy)).has_value());
    FrameSettings settings;
    Stage stage(policy.pace, clock, nullptr, [&](std::uint32_t frame) { steer(frame, settings); });
    const std::unique_ptr<Renderer> renderer_owner =
        make_renderer(setup().device, setup().scene, limits_of(largest_traced(kEye)));
    Renderer& renderer = *renderer_owner;
    std::optional<Reference> tracer;
    if (origin == MaskOrigin::OwnTracer) tracer.emplace(Tracer::create(setup().scene).value());
    const RunContext context{.scene = setup().scene,
                             .runtime = stage,
                             .renderer = renderer,
                             .own_tracer = tracer ? &*tracer : nullptr,
                             .settings = settings,
                             .policy = policy};
    const auto watch = [&](const FrameView& view) { recorder.watch(view, renderer.read_shown()); };
    ASSERT_TRUE(
        run(context, *make_pipeline(context), watch, [&] { return recorder.frames() == 30; }).has_value());
    ASSERT_TRUE(recorder.finish().has_value());
    EXPECT_EQ(to_string(replayed(CaptureReader::open(file).value()).value()),
              "30 frames, all requests and pictures as captured");
  }
}

}  // namespace
}  // namespace farshade
