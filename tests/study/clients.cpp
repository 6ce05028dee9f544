#include "tests/study/clients.h"
#include "tests/support/manual_clock.h"

#include <memory>

#include "rt_server/answers/answers.h"
#include "stereo/base/check.h"
#include "stereo/partial_request/partial_request.h"
#include "stereo/requests/guard_band.h"
#include "stereo/requests/request_plan.h"
#include "stereo/scene/viewpoint.h"
#include "stereo/tracer/tracer.h"
#include "tests/study/figures.h"
#include "vr_client/runtime/recorded_head_runtime.h"

namespace farshade::study {
namespace {

constexpr Duration kApart = std::chrono::milliseconds(100);
constexpr Duration kPatience = std::chrono::seconds(3);
constexpr std::size_t kRemembered = 32;

/// Draws the depth of requested views and finds what to ask for.
struct Drawing {
  explicit Drawing(const Play& play)
      : renderer(make_renderer(play.device, play.scene, plan_for(play.scene, {.all_lights = true}).draw,
                               RendererLimits{.size = play.size,
                                              .traced_size = largest_traced(play.size),
                                              .depth_frames = narrow<std::uint32_t>(kRemembered)})) {}

  /// Sets what `request` asks for.
  void prepare(FrameRequest& request, const FrameReceiver& receiver, Time now) {
    const RequestRecord* base = nullptr;
    for (const RequestRecord* record : receiver.received(now))
      if (base == nullptr && receiver.is_settled(*record)) base = record;
    const std::size_t slot = receiver.next_slot();
    partial_request.begin(request, slot, base);
    partial_request.complete(request);
    if (!partial_request.has_begun()) renderer->keep_depth(request, slot, distances);
  }

  std::unique_ptr<Renderer> renderer;
  PartialRequest partial_request{*renderer};
  PerEye<Image<float>> distances;
};

/// A client that sends requests and receives the answers.
struct Head {
  Head(const Play& play, Duration ahead, VirtualLink& wire, std::size_t number, const Clock& clock,
       const LinkTarget& target)
      : runtime(play.head, {.stage_from_recorded = place(play.head, viewpoint_of(play.scene)),
                            .eye_size = play.size,
                            .refresh_hz = play.refresh_hz,
                            .skip = play.skip + ahead,
                            .frames = play.frames}),
        link(wire.client(number), clock, target, kRemembered) {
    if (play.request.asks == Asks::Unknown) drawing = std::make_unique<Drawing>(play);
  }

  RecordedHeadRuntime runtime;
  NetworkLink link;
  std::unique_ptr<Drawing> drawing;  ///< null: asks for whole views
  RequestPlan plan{RequestSettings{}};
  FrameId frame;

  /// Returns false at the end of the recording.
  bool ask() {
    const std::optional<FrameTiming> timing = runtime.wait_frame();
    if (!timing) return false;
    frame = next(frame);
    const Time at = timing->display_time;
    FrameRequest request =
        plan.ask({frame, at, at, runtime.locate_views(at), LightChanges{}}, timing->period).value();
    if (drawing) drawing->prepare(request, link.receiver(), at);
    link.request(request, at, drawing ? drawing->partial_request.parts() : RequestParts{});
    return true;
  }
};

}  // namespace

nlohmann::json measure_clients(const Play& play, std::uint32_t clients, std::uint32_t warm_up) {
  ManualClock clock;
  VirtualLink wire(clock, {}, clients);
  Expected<Tracer> tracer = Tracer::create(play.scene);
  if (!tracer) throw std::runtime_error(tracer.error().what);
  const auto lights = narrow<std::uint32_t>(play.scene.lights.size());
  const SharedKey key{.name = "study", .secret = {1}};
  RequestHandlers answers;
  answers.add(Answer::Masks, make_masks(*tracer));
  ServerCore core({play.scene.hash, lights}, {key}, std::move(answers), wire.server(), clock, play.limits);
  const SteadyClock real;
  Duration busy{};
  wire.while_waiting(
      [&] {
        const Time begun = real.now();
        while (core.receive(Duration::zero())) {
        }
        while (core.work()) {
        }
        core.send_due();
        busy += real.now() - begun;
      },
      [&] { return core.next_due(); });

  std::vector<std::unique_ptr<Head>> heads;
  for (std::size_t i = 0; i < clients; ++i) {
    heads.push_back(std::make_unique<Head>(
        play, i * kApart, wire, i, clock, LinkTarget{wire.server().local(), key, play.scene.hash, {lights}}));
    if (const Expected<void> connected = heads.back()->link.connect(kPatience); !connected)
      throw std::runtime_error(connected.error().what);
  }
  const auto period = Duration(static_cast<std::int64_t>(1e9 / play.refresh_hz));
  Figures figures;
  for (std::uint32_t i = 0; i < play.frames; ++i) {
    busy = {};
    for (const auto& head : heads)
      if (!head->ask()) throw std::runtime_error("the recording is too short for so many clients");
    heads[0]->link.listen(period);
    for (const auto& head : heads) head->link.poll();
    if (i >= warm_up) figures.add(Group::Time, "server_frame", ms_of(busy));
  }
  figures.add(Group::Wire, "answers",
              static_cast<double>(core.counters().frames) / (1.0 * play.frames * clients));
  return figures.json();
}

}  // namespace farshade::study
