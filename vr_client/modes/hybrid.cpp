// Hybrid: the client requests masks for predicted views, draws its own G-buffer and reprojects the masks.
#include "vr_client/modes/make_pipeline.h"
#include "vr_client/modes/mask_sources.h"

namespace farshade {
namespace {

class Hybrid final : public ModePipeline {
 public:
  explicit Hybrid(const RunContext& context)
      : renderer_(context.renderer),
        exchange_(context.link, context.policy, context.settings.request),
        masks_(context.scene.animation_length_s > 0) {}

  const FrameRequest* request(const FrameInputs& inputs) override {
    request_ = exchange_.plan(inputs, {.kind = Answer::Masks});
    exchange_.send(inputs);
    return request_;
  }

  void collect(const FrameInputs& inputs) override {
    const auto usable = exchange_.receive(inputs);
    masks_.take(usable, exchange_.settled());
  }

  DrawnFrame draw(const FrameInputs& inputs) override {
    return masks_.draw(renderer_, inputs, exchange_.record(request_), exchange_);
  }

 private:
  Renderer& renderer_;
  Exchange exchange_;
  MaskSources masks_;
  const FrameRequest* request_ = nullptr;
};

}  // namespace

std::unique_ptr<ModePipeline> make_hybrid(const RunContext& context) {
  return std::make_unique<Hybrid>(context);
}

}  // namespace farshade
