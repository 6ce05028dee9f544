#include "vr_client/frame/frame_loop.h"

#include "vr_client/frame/mode_pipeline.h"

namespace farshade {
namespace {

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

}  // namespace

Expected<void> run(const RunContext& context, const FrameWatcher& watch, const std::function<bool()>& stop) {
  const SteadyClock clock;
  const std::unique_ptr<ModePipeline> pipeline = make_pipeline(context);
  FrameId frame;
  SceneTime scene_time;
  while (!stop()) {
    const std::optional<FrameTiming> timing = context.runtime.wait_frame();
    if (!timing) break;
    const FrameSettings steering = context.steering;
    StageTimes times;
    StageStarts starts;

    starts.request = clock.now();
    frame = next(frame);
    const FrameRequest shown{frame, timing->display_time, scene_time.at(timing->display_time, steering.scene),
                             context.runtime.locate_views(timing->display_time), steering.lights};
    const SceneState state = state_at(context.scene, shown.scene_time, shown.lights);
    const FrameInputs inputs{shown, state, timing->period, steering};
    const FrameRequest* const asked = pipeline->request(inputs);

    starts.collect = clock.now();
    const Duration busy = context.link ? context.link->busy() : Duration::zero();
    pipeline->collect(inputs);
    if (context.link && context.link->refused()) return tl::unexpected(*context.link->refused());

    starts.draw = clock.now();
    const DrawnFrame seen = pipeline->draw(inputs);
    context.runtime.end_frame(timing->display_time);
    starts.end = clock.now();

    times.request = starts.collect - starts.request;
    times.collect = context.link ? context.link->busy() - busy + seen.decoding : starts.draw - starts.collect;
    times.gbuffer = seen.drawn.gbuffer;
    times.depth = seen.drawn.depth;
    times.maps = seen.drawn.maps;
    times.shade = seen.drawn.shade;
    times.turn = seen.drawn.turn;
    times.draw = seen.drawn.total;
    times.frame = times.request + times.collect + times.draw;
    watch({.shown = shown,
           .asked = asked,
           .state = state,
           .masks = seen.masks,
           .newest = seen.newest,
           .age = seen.age,
           .times = times,
           .starts = starts,
           .steering = steering,
           .timing = *timing,
           .as = seen.as,
           .start_up = seen.start_up,
           .black = seen.black});
  }
  return {};
}

}  // namespace farshade
