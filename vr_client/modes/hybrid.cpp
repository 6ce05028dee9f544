// Hybrid: asks for masks of predicted views, draws its own G-buffer, carries the newest masks over to it.
#include "vr_client/modes/masks.h"

namespace farshade {
namespace {

class Hybrid final : public ModePipeline {
 public:
  explicit Hybrid(const RunContext& context) : exchange_(context), masks_(context) {}

  const FrameRequest* request(const FrameInputs& inputs) override {
    asked_ = exchange_.plan(inputs, {.answer = Answer::Masks});
    exchange_.send(inputs);
    return asked_;
  }

  void collect(const FrameInputs& inputs) override { masks_.take(exchange_.receive(inputs)); }

  DrawnFrame draw(const FrameInputs& inputs) override { return masks_.draw(inputs, asked_, exchange_); }

 private:
  Exchange exchange_;
  MasksInHand masks_;
  const FrameRequest* asked_ = nullptr;
};

}  // namespace

std::unique_ptr<ModePipeline> make_hybrid(const RunContext& context) {
  return std::make_unique<Hybrid>(context);
}

}  // namespace farshade
