#include "vr_client/frame/frame_loop.h"

#include <deque>

namespace farshade {
namespace {

/// The traffic of a link between two calls.
class TrafficMeter {
 public:
  explicit TrafficMeter(const ServerConnection* link) : link_(link) { static_cast<void>(since_last()); }

  std::optional<LinkTraffic> since_last() {
    const std::optional<LinkTraffic> now = link_ ? link_->traffic() : std::nullopt;
    if (!now) return std::nullopt;
    const LinkTraffic before = std::exchange(last_, *now);
    return LinkTraffic{now->up - before.up, now->down - before.down};
  }

 private:
  const ServerConnection* link_;
  LinkTraffic last_;
};

/// The frames that were shown last, until the device has finished them.
class FramesUnderWay {
 public:
  /// A frame has ended with these times.
  std::optional<FinishedPicture> end(FrameId frame, const StageStarts& starts, const DrawTimes& drawn) {
    frames_.push_back({frame, starts});
    if (frames_.size() <= drawn.frames_ago) return std::nullopt;
    const Begun oldest = frames_.front();
    frames_.pop_front();
    // Nothing has waited for a frame in flight when it ended. The device begins it when it is submitted, or
    // when the frame before it is done.
    ready_ = drawn.frames_ago == 0
                 ? starts.end
                 : std::min(std::max(oldest.starts.submitted, ready_) + drawn.on_device(), starts.end);
    return FinishedPicture{oldest.frame, oldest.starts.request, ready_};
  }

 private:
  struct Begun {
    FrameId frame;
    StageStarts starts;
  };
  std::deque<Begun> frames_;
  Time ready_{};  ///< the last picture
};

Exposure exposure_of(const RunContext& context) {
  const auto told = context.link ? context.link->receiver().exposure() : std::nullopt;
  return told.value_or(context.exposure);
}

/// Locates the views of a frame again, unless they must stay: a request for exactly these views gets their
/// depth. A request that waits for the device has a depth of its own.
void locate_for_drawing(const RunContext& context, const ModePipeline& pipeline,
                        const std::optional<FrameRequest>& request, FrameMoment& shown) {
  if (context.locate == Locate::Once || pipeline.keeps_views()) return;
  if (request && request->views == shown.views) return;
  shown.views = context.runtime.locate_views(shown.display_time);
}

/// Hands a recorded frame to the device and the display, sends its request if that waits for the device, and
/// waits for the oldest frame in flight. Returns the times of what the device did.
DrawTimes finish_frame(const RunContext& context, ModePipeline& pipeline, const FrameInputs& inputs,
                       std::optional<FrameRequest>& request, StageStarts& starts) {
  context.runtime.add_output([&](const gpu::Recording& record) { context.renderer.append(record); });
  context.renderer.submit();
  context.runtime.end_frame(inputs.shown.display_time);
  starts.submitted = context.clock.now();
  if (std::optional<FrameRequest> late = pipeline.request_late(inputs)) {
    request = std::move(late);
    starts.requested_late = context.clock.now();
  }
  const DrawTimes times = context.renderer.finish();
  starts.end = context.clock.now();
  return times;
}

/// What the client worked in a frame, apart from what the device did in `drawn`.
StageTimes stage_times(const DrawTimes& drawn, const StageStarts& starts, Duration collect,
                       const std::optional<FinishedPicture>& finished) {
  StageTimes times{drawn};
  times.request = starts.collect - starts.request;
  if (starts.requested_late) times.request += *starts.requested_late - starts.submitted;
  times.collect = collect;
  times.frame = times.request + times.collect + times.total;
  if (finished) times.ready = finished->ready - finished->begun;
  return times;
}

}  // namespace

Expected<void> run(const RunContext& context, ModePipeline& pipeline, const FrameWatcher& watch,
                   const std::function<bool()>& stop) {
  RunPosition start;
  return run(context, pipeline, watch, stop, start);
}

Expected<void> run(const RunContext& context, ModePipeline& pipeline, const FrameWatcher& watch,
                   const std::function<bool()>& stop, RunPosition& position) {
  const Clock& clock = context.clock;
  TrafficMeter traffic(context.link);
  FramesUnderWay under_way;
  while (!stop()) {
    const std::optional<FrameTiming> timing = context.runtime.wait_frame();
    if (!timing) break;
    const FrameSettings settings = context.settings;
    StageStarts starts;
    context.renderer.discard_times();  // what a watcher has drawn is not of this frame

    starts.request = clock.now();
    position.frame = next(position.frame);
    FrameMoment shown{position.frame, timing->display_time,
                      position.scene_time.at(timing->display_time, settings.scene),
                      context.runtime.locate_views(timing->display_time), settings.lights};
    SceneState state = state_at(context.scene, shown.scene_time, shown.lights);
    state.light_set.exposure = exposure_of(context);
    const FrameInputs inputs{shown, state, timing->period, settings, context.runtime.hidden()};
    std::optional<FrameRequest> request = pipeline.request(inputs);

    starts.collect = clock.now();
    const Duration busy = context.link ? context.link->busy() : Duration::zero();
    pipeline.collect(inputs);
    if (context.link && context.link->refused()) return tl::unexpected(*context.link->refused());

    starts.draw = clock.now();
    locate_for_drawing(context, pipeline, request, shown);
    const DrawnFrame drawn_frame = pipeline.draw(inputs);
    const DrawTimes drawn = finish_frame(context, pipeline, inputs, request, starts);
    const std::optional<FinishedPicture> finished = under_way.end(position.frame, starts, drawn);
    const StageTimes times = stage_times(
        drawn, starts,
        context.link ? context.link->busy() - busy + drawn_frame.decoding : starts.draw - starts.collect,
        finished);
    watch({.shown = shown,
           .request = request ? &*request : nullptr,
           .state = state,
           .masks = drawn_frame.masks,
           .newest = drawn_frame.newest,
           .age = drawn_frame.age,
           .times = times,
           .starts = starts,
           .settings = settings,
           .timing = *timing,
           .as = drawn_frame.as,
           .start_up = drawn_frame.start_up,
           .black = drawn_frame.black,
           .cube_mask = drawn_frame.cube_mask,
           .cube_mask_cost = drawn_frame.cube_mask_cost,
           .silent_since = context.link ? context.link->silent_since() : std::nullopt,
           .traffic = traffic.since_last(),
           .finished = finished});
  }
  return {};
}

}  // namespace farshade
