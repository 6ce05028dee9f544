#include "tests/network/rehearsal.h"
#include "tests/support/fixed_random.h"
#include "tests/support/manual_clock.h"
#include "tests/support/smooth_reference.h"

#include <malloc.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "rt_server/answers/answers.h"
#include "stereo/base/check.h"
#include "stereo/gpu/device.h"
#include "stereo/tracer/tracer.h"
#include "vr_client/modes/make_pipeline.h"
#include "vr_client/modes/run_frames.h"
#include "vr_client/report/run_report.h"
#include "vr_client/runtime/recorded_head_runtime.h"

namespace farshade {
namespace {

constexpr std::uint32_t kLongestRoundTrip_frames = 24;
constexpr Duration kPatience = std::chrono::seconds(3);

/// Plays a recorded head. Frames begin at times of the link's clock.
class LinkRuntime final : public Runtime {
 public:
  LinkRuntime(RecordedHeadRuntime& head, const Play& play, NetworkLink& link, ManualClock& clock,
              std::function<void()> before_frame)
      : play_(play),
        head_(head),
        link_(link),
        clock_(clock),
        begun_(clock.now()),
        before_frame_(std::move(before_frame)) {}

  [[nodiscard]] std::optional<FrameTiming> wait_frame() override {
    const std::optional<FrameTiming> timing = head_.wait_frame();
    if (!timing) return timing;
    first_ = first_.value_or(timing->display_time);
    link_.listen(begun_ + (timing->display_time - *first_) - clock_.now());
    before_frame_();
    if (++frame_; play_.loss && frame_ == play_.loss->frame)
      play_.loss->device.timeout_ns = 1;  // as a device that hangs
    submissions_ = play_.device.use->submissions;
    return timing;
  }
  [[nodiscard]] StereoView locate_views(Time display_time) override {
    return head_.locate_views(display_time);
  }
  [[nodiscard]] const PerEye<HiddenArea>* hidden() const override { return play_.hidden; }
  void end_frame(Time display_time) override {
    most_submissions_ = std::max(most_submissions_, play_.device.use->submissions - submissions_);
    head_.end_frame(display_time);
  }
  [[nodiscard]] std::uint64_t most_submissions() const { return most_submissions_; }

 private:
  const Play& play_;
  RecordedHeadRuntime& head_;
  std::uint32_t frame_ = 0;
  std::uint64_t submissions_ = 0, most_submissions_ = 0;
  NetworkLink& link_;
  ManualClock& clock_;
  Time begun_;
  std::optional<Time> first_;
  std::function<void()> before_frame_;
};

double known_share(const RequestRecord& frame) {
  std::size_t known = 0, all = 0;
  for (std::size_t eye = 0; eye < kEyes; ++eye) {
    known += frame.tiles_known[eye];
    all += frame.tiles_requested[eye] * frame.masks[eye].layout().planes();
  }
  return static_cast<double>(known) / static_cast<double>(all);
}

/// The share of the newest mask's tiles that are known in it or in the next older mask.
double recent_share(std::span<const TracedMask> masks) {
  std::size_t known = 0, all = 0;
  for (std::size_t eye = 0; eye < kEyes; ++eye) {
    const bool comparable = masks.size() > 1 && masks[1].views[eye].size == masks[0].views[eye].size;
    const TracedMask& before = comparable ? masks[1] : masks[0];
    const std::size_t tiles = masks[0].received_tiles[eye].size();
    for (std::size_t tile = 0; tile < tiles; ++tile)
      known += (known_blocks(masks[0], eye, tile) | known_blocks(before, eye, tile)) == kAllBlocks;
    all += tiles;
  }
  return static_cast<double>(known) / static_cast<double>(all);
}

template <class T>
T value_of(Expected<T> value) {
  if (!value) throw std::runtime_error(value.error().what);
  return std::move(*value);
}

/// The server at its end of the link. It answers a request when the request arrives; its work takes no
/// virtual time.
struct LinkServer {
  LinkServer(const Play& play, VirtualLink& wire, const Clock& clock)
      : lights(narrow<std::uint32_t>(play.scene.lights.size())),
        tracer(value_of(Tracer::create(play.scene))),
        plan(plan_for(play.scene, {.all_lights = true})),
        core({play.scene.hash, lights}, {key},
             make_answers({.scene = play.scene, .plan = plan, .tracer = tracer}), wire.server(), clock,
             play.limits) {
    wire.while_waiting(
        [this] {
          while (core.receive(Duration::zero())) {
          }
          while (core.work()) {
          }
          core.send_due();
        },
        [this] { return core.next_due(); });
  }

  SharedKey key{.name = "rehearsal", .secret = {1}};
  std::uint32_t lights;
  Tracer tracer;
  ScenePlan plan;
  ServerCore core;
};

/// Adds every report that the client receives to `played`.
void collect_reports(NetworkLink& link, Played& played) {
  link.tell({.received =
                 [&played](std::span<const std::byte> bytes, Time) {
                   const Decoded<ServerMessage> message = decode_server(bytes);
                   if (const auto* report = message ? std::get_if<FrameReport>(&*message) : nullptr)
                     played.reports.push_back(*report);
                 },
             .sent = {}});
}

RecordedHeadRuntime recorded_head(const Play& play) {
  return {play.head,
          {.stage_from_recorded =
               play.scene.camera ? place(play.head, *play.scene.camera) : Rigid<Stage, Recorded>{},
           .eye_size = play.size,
           .refresh_hz = play.refresh_hz,
           .skip = play.skip,
           .frames = play.frames,
           .pace = Pace::Virtual}};
}

PlayedFrame played_frame(const FrameView& view, const Clock& clock, const NetworkLink& link,
                         const Renderer& renderer) {
  PlayedFrame frame{.at = clock.now(),
                    .view_scale = link.receiver().view_scale(),
                    .pipelines = renderer.counters().pipelines};
  if (view.newest == nullptr) return frame;
  frame.newest = view.newest->request.frame;
  frame.newest_asked = clock.now() - view.age.value();
  frame.tiles_current = known_share(*view.newest);
  if (!view.masks.empty()) frame.tiles_recent = recent_share(view.masks);
  return frame;
}

}  // namespace

std::vector<Network> named_networks() {
  std::vector<Network> networks;
  for (const NamedNetwork& named : kNetworks) networks.push_back({std::string(named.name), named.model});
  networks.push_back({"moving", {.delay = std::chrono::milliseconds(5)}, std::chrono::seconds(5)});
  return networks;
}

Expected<Network> network_from(const std::string& text) {
  for (const Network& network : named_networks())
    if (network.name == text) return network;
  return parse_link_model(text).map([&](const LinkModel& model) { return Network{text, model}; });
}

std::vector<double> Played::worse_eye(double EyeErrors::*figure) const {
  std::vector<double> values;
  for (std::size_t i = 0; i < log.records().size(); ++i) {
    const FrameRecord& record = log.records()[i];
    if (!record.errors || !frames[i].newest) continue;
    const double left = (*record.errors)[0].*figure, right = (*record.errors)[1].*figure;
    values.push_back(figure == &EyeErrors::psnr_db ? std::min(left, right) : std::max(left, right));
  }
  return values;
}

double Played::mean_of(double PlayedFrame::*share) const {
  double sum = 0;
  std::size_t shown = 0;
  for (const PlayedFrame& frame : frames)
    if (frame.newest) sum += frame.*share, ++shown;
  return shown == 0 ? 0 : sum / static_cast<double>(shown);
}

namespace {

std::unique_ptr<Renderer> renderer_for(const Play& play, std::uint32_t in_flight) {
  const float detail_px =
      play.levels == nullptr ? 0 : play.detail_px.value_or(default_detail_px(play.mode.mode));
  return make_renderer(
      play.device, play.scene, plan_for(play.scene, {.all_lights = true, .detail_px = detail_px}).draw,
      RendererLimits{.size = play.size, .traced_size = largest_traced(play.size), .depth_frames = in_flight},
      detail_px > 0 ? *play.levels : SceneLevels{});
}

RunReportOptions measuring_of(const Play& play) {
  return {.out = {},
          .frame_count = play.frames,
          .reference_every = play.reference_every,
          .pictures = 0,
          .dump = {}};
}

/// What the client does before a real clock begins.
void prepare(const Play& play, const RunContext& context) {
  if (play.start != Play::Start::DrawnAhead) return;
  if (draws_scene(play.mode.mode))
    for (const auto& step :
         context.renderer.compile_steps(play.reprojection, context.settings.report, Changes::Never))
      step();
  draw_ahead(context, play.head.start() + play.skip);
}

Expected<void> reopen(gpu::Device& device) {
  return gpu::open_device({.name_contains = device.name}).map([&](gpu::Device&& opened) {
    static_cast<void>(std::exchange(device, std::move(opened)));
  });
}

/// The device of a play; without a loss it is not opened again. Keeps the references.
FrameDevice device_of(const Play& play, std::unique_ptr<Renderer>& renderer, std::uint32_t in_flight,
                      std::function<RunContext()> context) {
  FrameDevice device{.context = std::move(context), .clear = [&renderer] { renderer.reset(); }};
  if (play.loss)
    device.reopen = [&play, &renderer, in_flight] {
      return reopen(play.loss->device).map([&] { renderer = renderer_for(play, in_flight); });
    };
  return device;
}

}  // namespace

Played play(const Play& play, const Network& network) {
  fix_random(1);
  ManualClock clock;
  VirtualLink wire(clock, {.to_server = network.model, .to_client = network.model});
  LinkServer server(play, wire, clock);
  std::optional<Reference> reference, own_tracer;
  if (play.reference_every > 0) reference.emplace(value_of(Tracer::create_reference(play.scene)));
  if (play.mode.mode == Mode::Full) own_tracer.emplace(value_of(Tracer::create(play.scene)));
  const std::uint32_t in_flight = kLongestRoundTrip_frames + narrow<std::uint32_t>(kMaxMasks) + 4;
  std::unique_ptr<Renderer> renderer = renderer_for(play, in_flight);
  NetworkLink link(
      wire.client(), clock,
      {wire.server().local(), server.key, play.scene.hash, {server.lights}, answers_for(play.mode.mode)},
      in_flight);
  Played played;
  collect_reports(link, played);
  const Duration round_trip = link.connect(kPatience) ? (clock.now() - Time{}) / 2 : Duration::zero();

  RecordedHeadRuntime head = recorded_head(play);
  Time moved = clock.now();
  LinkRuntime runtime(head, play, link, clock, [&] {
    if (network.moves_every == Duration::zero() || clock.now() - moved < network.moves_every) return;
    moved = clock.now();
    wire.move_client(0);
  });
  const RunReportOptions measuring = measuring_of(play);
  RunReport report(measuring, renderer, reference ? &*reference : nullptr);
  const FrameSettings settings{.request = play.request,
                               .reprojection = play.reprojection,
                               .report = measuring.measures_any() ? PixelReport::On : PixelReport::Off};
  const auto context = [&] {
    return RunContext{.scene = play.scene,
                      .runtime = runtime,
                      .renderer = *renderer,
                      .mode = play.mode,
                      .link = answers_for(play.mode.mode) != 0 ? &link : nullptr,
                      .own_tracer = own_tracer ? &*own_tracer : nullptr,
                      .settings = settings,
                      .policy = {.pace = Pace::Real, .round_trip = round_trip, .mask_wait = play.mask_wait}};
  };
  const auto watch = [&](const FrameView& view) {
    report.watch(view);
    const FrameRecord& record = report.log().records().back();
    if (play.watch) play.watch(view, record, record.errors ? &report.measured() : nullptr);
    if (play.watch_smooth && record.errors && play.reference_samples > 1)
      play.watch_smooth(
          view, record, report.measured(),
          smooth_reference(view.shown, view.state, play.reference_samples, *renderer, *reference));
    played.frames.push_back(played_frame(view, clock, link, *renderer));
    const std::size_t half = played.frames.size() * 2 <= play.frames ? 0 : 1;
    played.heap_peak[half] = std::max<std::size_t>(played.heap_peak[half], mallinfo2().uordblks);
  };
  prepare(play, context());
  const Expected<void> shown =
      run_frames(device_of(play, renderer, in_flight, context), watch, [] { return false; });
  if (!shown) throw std::runtime_error(shown.error().what);
  played.log = report.log(), played.most_submissions = runtime.most_submissions();
  played.client = link.counters(), played.server = server.core.counters();
  return played;
}

}  // namespace farshade
