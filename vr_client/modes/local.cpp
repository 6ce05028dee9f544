// Local: the client draws shadow maps and needs no server.
#include "vr_client/modes/make_pipeline.h"

namespace farshade {
namespace {

class Local final : public ModePipeline {
 public:
  explicit Local(const RunContext& context) : context_(context) {}

  const FrameRequest* request(const FrameInputs&) override { return nullptr; }
  void collect(const FrameInputs&) override {}

  DrawnFrame draw(const FrameInputs& inputs) override {
    return {.drawn = context_.renderer.draw({.views = inputs.shown.views,
                                             .state = inputs.state,
                                             .masks = {},
                                             .carry_over = {},
                                             .report = inputs.steering.report,
                                             .shadow_maps = &context_.mode.shadow_maps})};
  }

 private:
  const RunContext& context_;
};

}  // namespace

std::unique_ptr<ModePipeline> make_local(const RunContext& context) {
  return std::make_unique<Local>(context);
}

}  // namespace farshade
