#include "vr_client/session.h"

#include <algorithm>

namespace farshade {
namespace {

/// In virtual time a frame's masks are awaited in real time before it is drawn, so that what is shown depends
/// on the set delay alone. This is how long a reply may really take before it counts as lost.
constexpr Duration kVirtualPatience = std::chrono::seconds(5);
/// What has not come for so long after some of its frame's masks have is lost.
constexpr Duration kLull = std::chrono::milliseconds(250);

/// Sends requests and gathers the masks that a frame may use.
class MaskSource {
 public:
  explicit MaskSource(const Session& session) : session_(session) {}

  void request(const TraceRequest& asked, Time asked_at) {
    asked_ = asked.frame;
    if (session_.link) session_.link->request(asked, asked_at);
  }

  std::span<const MaskInHand> collect(const TraceRequest& shown, RequestPlan& plan) {
    masks_.clear();
    if (session_.own_tracer) masks_.push_back(session_.own_tracer->trace(shown));
    if (!session_.link) return masks_;
    await();
    const std::vector<const ReceivedFrame*> received =
        session_.link->inbox().masks(usable_until(shown.display_time));
    for (const ReceivedFrame* frame : received) {
      const TraceRequest& request = frame->request;
      if (is_newer(request.frame, newest_seen_))
        plan.learn(shown.display_time - session_.link->inbox().asked_at(request.frame).value());
      masks_.push_back({request.frame, request.display_time, request.scene_time, request.views, frame->masks,
                        frame->known_tiles,
                        std::uint64_t{frame->tiles_known[0]} << 32 | frame->tiles_known[1],
                        frame->light_set_revision});
    }
    newest_ = received.empty() ? nullptr : received.front();
    if (newest_) newest_seen_ = newest_->request.frame;
    return masks_;
  }

  /// Those that a frame could really be drawn with: the others' depth has left the renderer's ring.
  std::span<const MaskInHand> drawn_with(const Renderer& renderer, Lookup lookup) {
    if (lookup == Lookup::Direct) return masks_;
    std::vector<MaskInHand> drawn;
    for (const MaskInHand& mask : masks_)
      if (renderer.has_depth(mask.frame)) drawn.push_back(mask);
    masks_.swap(drawn);
    return masks_;
  }

  /// What the newest mask in hand came from; null if no server sent it.
  [[nodiscard]] const ReceivedFrame* newest() const { return newest_; }

  [[nodiscard]] std::optional<Duration> age(Time now) const {
    if (newest_ == nullptr) return std::nullopt;
    return now - session_.link->inbox().asked_at(newest_->request.frame).value();
  }

 private:
  /// A server that once let the patience run out is not waited for again until it has answered.
  void await() {
    if (session_.policy.pace == Pace::Real) {
      session_.link->wait_for(asked_, session_.policy.mask_wait);
    } else if (asked_ != awaited_) {
      const Duration patience = answering_ ? kVirtualPatience : Duration::zero();
      answering_ = await_what_comes(patience) || is_whole(awaited_);
      awaited_ = asked_;
    }
  }

  /// True if some of the masks asked for has come.
  bool await_what_comes(Duration patience) {
    const auto known = [&] {
      const ReceivedFrame* const received = session_.link->inbox().find(asked_);
      return received == nullptr ? 0 : received->tiles_known[0] + received->tiles_known[1];
    };
    std::uint32_t before = 0;
    for (Duration waited{}; waited <= patience; waited += kLull) {
      if (session_.link->wait_for(asked_, std::min(kLull, patience - waited))) return true;
      if (known() > 0 && known() == before) return true;
      before = known();
    }
    return before > 0;
  }

  [[nodiscard]] bool is_whole(FrameId frame) const {
    const ReceivedFrame* const received = session_.link->inbox().find(frame);
    return received != nullptr && received->complete();
  }

  [[nodiscard]] Time usable_until(Time display_time) const {
    if (session_.policy.pace == Pace::Real) return Time::max();
    return display_time - session_.policy.delay + session_.policy.mask_wait;
  }

  const Session& session_;
  std::vector<MaskInHand> masks_;
  const ReceivedFrame* newest_ = nullptr;
  FrameId newest_seen_;  ///< frames count from 1
  FrameId asked_, awaited_;
  bool answering_ = true;
};

/// What the scene's clock says: it follows the display's as long as it runs.
class SceneTime {
 public:
  Time at(Time display_time, SceneClock clock) {
    if (last_ && clock == SceneClock::Runs) now_ += display_time - *last_;
    last_ = display_time;
    return now_;
  }

 private:
  Time now_{};
  std::optional<Time> last_;
};

/// Traced for these very pixels at this very time and with these very lights, and whole: nothing needs to be
/// carried over.
bool is_exact(const MaskInHand& mask, const TraceRequest& shown, const Scene& scene) {
  const auto same = [&](std::size_t eye) {
    return shares_pixels(shown.views[eye], mask.views[eye]) &&
           is_whole(mask.known_tiles[eye], mask.masks[eye].layout());
  };
  return same(0) && same(1) && mask.light_set_revision == shown.lights.revision &&
         (same_instant(mask.scene_time, shown.scene_time) || scene.animation_length_s == 0);
}

std::optional<TraceRequest> ask(const Session& session, const Steering& steering, const TraceRequest& shown,
                                Duration period, RequestPlan& plan) {
  if (session.link == nullptr) return std::nullopt;
  plan.follow(steering.wish);
  plan.shrink(session.link->inbox().scale_eighths());
  plan.limit(session.link->inbox().most_pixels());
  return plan.ask(shown, period, steering.scene);
}

}  // namespace

Expected<void> run(const Session& session, const FrameWatcher& watch, const std::function<bool()>& stop) {
  const SteadyClock clock;
  MaskSource source(session);
  RequestPlan plan(session.steering.wish);
  plan.learn(session.policy.pace == Pace::Real ? session.policy.round_trip
                                               : session.policy.delay - session.policy.mask_wait);
  FrameId frame;
  SceneTime scene_time;
  while (!stop()) {
    const std::optional<FrameTiming> timing = session.runtime.wait_frame();
    if (!timing) break;
    const Steering steering = session.steering;
    StageTimes times;
    StageStarts starts;

    starts.request = clock.now();
    frame = next(frame);
    const TraceRequest shown{frame, timing->display_time, scene_time.at(timing->display_time, steering.scene),
                             session.runtime.locate_views(timing->display_time), steering.lights};
    const SceneState state = state_at(session.scene, shown.scene_time, shown.lights);
    const std::optional<TraceRequest> asked = ask(session, steering, shown, timing->period, plan);
    if (asked) source.request(*asked, shown.display_time);

    starts.collect = clock.now();
    const Duration busy = session.link ? session.link->busy() : Duration::zero();
    const std::span<const MaskInHand> masks = source.collect(shown, plan);
    if (session.link && session.link->refused()) return tl::unexpected(*session.link->refused());

    starts.draw = clock.now();
    CarryOver carry_over = steering.carry_over;
    if (!masks.empty() && is_exact(masks[0], shown, session.scene)) carry_over.lookup = Lookup::Direct;
    const TraceRequest* const asked_now = asked ? &*asked : nullptr;
    const DrawTimes drawn =
        session.renderer.draw({shown.views, state, asked_now, masks, carry_over, steering.report});
    session.runtime.end_frame(timing->display_time);
    starts.end = clock.now();

    times.request = starts.collect - starts.request;
    times.collect = session.link ? session.link->busy() - busy : starts.draw - starts.collect;
    times.gbuffer = drawn.gbuffer;
    times.depth = drawn.depth;
    times.shade = drawn.shade;
    times.draw = drawn.total;
    times.frame = times.request + times.collect + times.draw;
    watch({shown, asked_now, state, source.drawn_with(session.renderer, carry_over.lookup), source.newest(),
           source.age(shown.display_time), times, starts, steering, *timing});
  }
  return {};
}

}  // namespace farshade
