#include "vr_client/modes/make_pipeline.h"

#include "stereo/base/check.h"

namespace farshade {
namespace {

// The modes without a server.

/// Traces every pixel of the shown views. This is slow and exact; all other modes are measured against it.
class Full final : public ModePipeline {
 public:
  explicit Full(const RunContext& context) : context_(context) {}

  void draw_ahead(const FrameInputs& inputs) override {
    collect(inputs);
    static_cast<void>(draw(inputs));
  }

  void collect(const FrameInputs& inputs) override {
    mask_.reset();
    if (context_.own_tracer != nullptr) mask_.emplace(context_.own_tracer->trace(inputs.shown));
  }

  /// The mask was traced for them.
  [[nodiscard]] bool keeps_views() const override { return true; }

  DrawnFrame draw(const FrameInputs& inputs) override {
    Reprojection reprojection = inputs.settings.reprojection;
    reprojection.lookup = Lookup::Direct;
    const std::span<const TracedMask> masks(mask_ ? &*mask_ : nullptr, mask_ ? 1 : 0);
    context_.renderer.draw({.views = inputs.shown.views,
                            .state = inputs.state,
                            .masks = masks,
                            .reprojection = reprojection,
                            .report = inputs.settings.report,
                            .hidden = inputs.hidden});
    return {.masks = masks};
  }

 private:
  const RunContext& context_;
  std::optional<TracedMask> mask_;
};

/// Draws shadow maps.
class Local final : public ModePipeline {
 public:
  explicit Local(const RunContext& context) : context_(context) {}

  void draw_ahead(const FrameInputs& inputs) override { static_cast<void>(draw(inputs)); }

  DrawnFrame draw(const FrameInputs& inputs) override {
    context_.renderer.draw({.views = inputs.shown.views,
                            .state = inputs.state,
                            .masks = {},
                            .reprojection = {},
                            .report = inputs.settings.report,
                            .shadow_maps = &context_.mode.shadow_maps,
                            .hidden = inputs.hidden});
    return {};
  }

 private:
  const RunContext& context_;
};

}  // namespace

std::unique_ptr<ModePipeline> make_pipeline(const RunContext& context) {
  // If no light casts shadows, there is no link, and hybrid draws the scene without masks.
  if (context.link == nullptr && answers_for(context.mode.mode) != 0) return make_hybrid(context);
  switch (context.mode.mode) {
    case Mode::Hybrid:
      return make_hybrid(context);
    case Mode::ClientPositions:
      return make_client_positions(context);
    case Mode::ServerGBuffer:
      return make_server_gbuffer(context);
    case Mode::Remote:
      return make_remote(context);
    case Mode::Delta:
      return make_delta(context);
    case Mode::Local:
      return std::make_unique<Local>(context);
    case Mode::Full:
      return std::make_unique<Full>(context);
  }
  check(false, "every mode has a pipeline");
  return nullptr;
}

void draw_ahead(const RunContext& context, Time first_display_time) {
  const FrameMoment shown{FrameId{}, first_display_time, Time{},
                          context.runtime.locate_views(first_display_time), context.settings.lights};
  const SceneState state = state_at(context.scene, shown.scene_time, shown.lights);
  make_pipeline(context)->draw_ahead({shown, state, Duration{}, context.settings});
  context.renderer.discard_times();
}

}  // namespace farshade
