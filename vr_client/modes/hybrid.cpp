// Hybrid: asks for masks of predicted views, draws its own G-buffer, carries the newest masks over to it.
#include "vr_client/modes/masks.h"

namespace farshade {
namespace {

class Hybrid final : public Way {
 public:
  explicit Hybrid(const Session& session) : exchange_(session), masks_(session) {}

  const TraceRequest* request(const Moment& moment) override {
    asked_ = exchange_.plan(moment, {.answer = Answer::Masks});
    exchange_.send(moment);
    return asked_;
  }

  void collect(const Moment& moment) override { masks_.take(exchange_.receive(moment)); }

  Seen draw(const Moment& moment) override { return masks_.draw(moment, asked_, exchange_); }

 private:
  Exchange exchange_;
  MasksInHand masks_;
  const TraceRequest* asked_ = nullptr;
};

}  // namespace

std::unique_ptr<Way> make_hybrid(const Session& session) {
  return std::make_unique<Hybrid>(session);
}

}  // namespace farshade
