#include "vr_client/session.h"

#include "vr_client/modes/way.h"

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

Expected<void> run(const Session& session, const FrameWatcher& watch, const std::function<bool()>& stop) {
  const SteadyClock clock;
  const std::unique_ptr<Way> way = make_way(session);
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
    const Moment moment{shown, state, timing->period, steering};
    const TraceRequest* const asked = way->request(moment);

    starts.collect = clock.now();
    const Duration busy = session.link ? session.link->busy() : Duration::zero();
    way->collect(moment);
    if (session.link && session.link->refused()) return tl::unexpected(*session.link->refused());

    starts.draw = clock.now();
    const Seen seen = way->draw(moment);
    session.runtime.end_frame(timing->display_time);
    starts.end = clock.now();

    times.request = starts.collect - starts.request;
    times.collect = session.link ? session.link->busy() - busy + seen.decoding : starts.draw - starts.collect;
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
