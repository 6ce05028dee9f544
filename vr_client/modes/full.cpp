// Full: traces every pixel of the shown views itself. Slow, and right: what every other mode is measured
// against.
#include "vr_client/modes/way.h"

namespace farshade {
namespace {

class Full final : public Way {
 public:
  explicit Full(const Session& session) : session_(session) {}

  const TraceRequest* request(const Moment&) override { return nullptr; }

  void collect(const Moment& moment) override {
    mask_.reset();
    if (session_.own_tracer != nullptr) mask_.emplace(session_.own_tracer->trace(moment.shown));
  }

  Seen draw(const Moment& moment) override {
    CarryOver carry_over = moment.steering.carry_over;
    carry_over.lookup = Lookup::Direct;
    const std::span<const MaskInHand> masks(mask_ ? &*mask_ : nullptr, mask_ ? 1 : 0);
    return {.drawn = session_.renderer.draw({.views = moment.shown.views,
                                             .state = moment.state,
                                             .masks = masks,
                                             .carry_over = carry_over,
                                             .report = moment.steering.report}),
            .masks = masks};
  }

 private:
  const Session& session_;
  std::optional<MaskInHand> mask_;
};

}  // namespace

std::unique_ptr<Way> make_full(const Session& session) {
  return std::make_unique<Full>(session);
}

}  // namespace farshade
