// The modes without a server.
#include "vr_client/modes/make_pipeline.h"

namespace farshade {
namespace {

/// Traces every pixel of the shown views. This is slow and exact; all other modes are measured against it.
class Full final : public ModePipeline {
 public:
  explicit Full(const RunContext& context) : context_(context) {}

  const FrameRequest* request(const FrameInputs&) override { return nullptr; }

  void collect(const FrameInputs& inputs) override {
    mask_.reset();
    if (context_.own_tracer != nullptr) mask_.emplace(context_.own_tracer->trace(inputs.shown));
  }

  DrawnFrame draw(const FrameInputs& inputs) override {
    CarryOver carry_over = inputs.settings.carry_over;
    carry_over.lookup = Lookup::Direct;
    const std::span<const TracedMask> masks(mask_ ? &*mask_ : nullptr, mask_ ? 1 : 0);
    return {.drawn = context_.renderer.draw({.views = inputs.shown.views,
                                             .state = inputs.state,
                                             .masks = masks,
                                             .carry_over = carry_over,
                                             .report = inputs.settings.report}),
            .masks = masks};
  }

 private:
  const RunContext& context_;
  std::optional<TracedMask> mask_;
};

/// Draws shadow maps.
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
                                             .report = inputs.settings.report,
                                             .shadow_maps = &context_.mode.shadow_maps})};
  }

 private:
  const RunContext& context_;
};

}  // namespace

std::unique_ptr<ModePipeline> make_full(const RunContext& context) {
  return std::make_unique<Full>(context);
}

std::unique_ptr<ModePipeline> make_local(const RunContext& context) {
  return std::make_unique<Local>(context);
}

}  // namespace farshade
