// Local: the client alone, with shadow maps.
#include "vr_client/modes/way.h"

namespace farshade {
namespace {

class Local final : public Way {
 public:
  explicit Local(const Session& session) : session_(session) {}

  const TraceRequest* request(const Moment&) override { return nullptr; }
  void collect(const Moment&) override {}

  Seen draw(const Moment& moment) override {
    return {.drawn = session_.renderer.draw({.views = moment.shown.views,
                                             .state = moment.state,
                                             .masks = {},
                                             .carry_over = {},
                                             .report = moment.steering.report,
                                             .shadow_maps = &session_.mode.shadow_maps})};
  }

 private:
  const Session& session_;
};

}  // namespace

std::unique_ptr<Way> make_local(const Session& session) {
  return std::make_unique<Local>(session);
}

}  // namespace farshade
