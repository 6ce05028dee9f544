#include "vr_client/session.h"

#include <algorithm>

namespace farshade {
namespace {

/// In virtual time a frame's masks are awaited in real time before it is drawn, so that what is shown depends
/// on the set delay alone. This is how long a reply may really take before it counts as lost.
constexpr Duration kVirtualPatience = std::chrono::seconds(5);

/// Sends requests and gathers the masks that a frame may use.
class MaskSource {
 public:
  explicit MaskSource(const Session& session) : session_(session) {}

  void request(const TraceRequest& request) const {
    if (session_.link) session_.link->request(request);
  }

  std::span<const MaskInHand> collect(const TraceRequest& request) {
    masks_.clear();
    if (session_.own_tracer) masks_.push_back(session_.own_tracer->trace(request));
    if (!session_.link) return masks_;
    answering_ = session_.link->wait_for(request.frame, patience()) || is_whole(asked_before_);
    asked_before_ = request.frame;
    const std::vector<const ReceivedFrame*> received =
        session_.link->masks(usable_until(request.display_time));
    newest_ = received.empty() ? nullptr : received.front();
    for (const ReceivedFrame* frame : received)
      masks_.push_back({frame->request.frame, frame->request.display_time, frame->request.views, frame->masks,
                        frame->known_tiles,
                        std::uint64_t{frame->tiles_known[0]} << 32 | frame->tiles_known[1]});
    return masks_;
  }

  /// What the newest mask in hand came from; null if no server sent it.
  [[nodiscard]] const ReceivedFrame* newest() const { return newest_; }

 private:
  /// A server that once let the patience run out is not waited for again until it has answered.
  [[nodiscard]] Duration patience() const {
    if (session_.policy.pace == Pace::Real) return session_.policy.mask_wait;
    return answering_ ? kVirtualPatience : Duration::zero();
  }

  [[nodiscard]] bool is_whole(FrameId frame) const {
    const ReceivedFrame* const received = session_.link->find(frame);
    return received != nullptr && received->complete();
  }

  [[nodiscard]] Time usable_until(Time display_time) const {
    if (session_.policy.pace == Pace::Real) return Time::max();
    return display_time - session_.policy.delay + session_.policy.mask_wait;
  }

  const Session& session_;
  std::vector<MaskInHand> masks_;
  const ReceivedFrame* newest_ = nullptr;
  FrameId asked_before_;
  bool answering_ = true;
};

/// Traced for these very views, and whole: nothing needs to be carried over.
bool is_direct(const MaskInHand& mask, const StereoView& shown) {
  const auto whole = [&](std::size_t eye) {
    return is_whole(mask.known_tiles[eye], mask.masks[eye].layout());
  };
  return mask.views == shown && whole(0) && whole(1);
}

}  // namespace

Expected<void> run(const Session& session, const FrameWatcher& watch, const std::function<bool()>& stop) {
  MaskSource source(session);
  FrameId frame;
  std::optional<Time> first;
  while (!stop()) {
    const std::optional<FrameTiming> timing = session.runtime.wait_frame();
    if (!timing) break;
    StageTimes times;

    const Stopwatch requesting;
    frame = next(frame);
    first = first.value_or(timing->display_time);
    const TraceRequest request{frame, timing->display_time, Time(timing->display_time - *first),
                               session.runtime.locate_views(timing->display_time)};
    const SceneState state = state_at(session.scene, request.scene_time);
    source.request(request);
    times.request = requesting.elapsed();

    const Stopwatch collecting;
    const Duration busy = session.link ? session.link->busy() : Duration::zero();
    const std::span<const MaskInHand> masks = source.collect(request);
    times.collect = session.link ? session.link->busy() - busy : collecting.elapsed();
    if (session.link && session.link->refused()) return tl::unexpected(*session.link->refused());

    const Lookup lookup =
        !masks.empty() && is_direct(masks[0], request.views) ? Lookup::Direct : Lookup::Reproject;
    const DrawTimes drawn =
        session.renderer.draw({frame, request.views, state, masks, lookup, session.report});
    session.runtime.end_frame(timing->display_time);

    times.gbuffer = drawn.gbuffer;
    times.shade = drawn.shade;
    times.draw = drawn.total;
    times.frame = times.request + times.collect + times.draw;
    watch({request, state, masks, source.newest(), times});
  }
  return {};
}

}  // namespace farshade
