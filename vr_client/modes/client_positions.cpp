// Client-positions: draws the depth of the views it asks for and sends where their pixels lie; the server
// traces these points and needs to draw nothing. The masks that come are carried over as in hybrid.
#include "stereo/base/check.h"
#include "stereo/frame/position_grid.h"
#include "stereo/wire/plane_codec.h"
#include "vr_client/modes/masks.h"

namespace farshade {
namespace {

/// That a request can announce. Tiles of what does not fit stay unknown.
constexpr std::size_t kMostSlices = 65535;

constexpr std::array kPositionKinds{PlaneKind::PositionX, PlaneKind::PositionY, PlaneKind::PositionZ};

class ClientPositions final : public ModePipeline {
 public:
  explicit ClientPositions(const RunContext& context)
      : context_(context),
        exchange_(context),
        masks_(context),
        grid_(grid_of({context.scene.bounds.low}, {context.scene.bounds.high}, context.mode.position_bits)) {}

  const FrameRequest* request(const FrameInputs& inputs) override {
    drawn_ = {};
    const FrameRequest* const asked = exchange_.plan(inputs, wanted());
    if (asked == nullptr) return nullptr;
    pack(*asked);
    const FrameRequest* const complete = exchange_.complete(narrow<std::uint32_t>(messages_used_));
    exchange_.send(inputs, std::span(messages_).first(messages_used_));
    return complete;
  }

  void collect(const FrameInputs& inputs) override { masks_.take(exchange_.receive(inputs)); }

  DrawnFrame draw(const FrameInputs& inputs) override {
    // The depth that the request's masks will need is kept already; what it took is part of the request.
    DrawnFrame seen = masks_.draw(inputs, nullptr, exchange_);
    seen.drawn.depth += drawn_.depth;
    return seen;
  }

 private:
  [[nodiscard]] AnswerSpec wanted() const {
    return {.answer = Answer::MasksOfPositions, .position_bits = context_.mode.position_bits};
  }

  /// The positions of what `asked` sees, as messages.
  void pack(const FrameRequest& asked) {
    drawn_ = context_.renderer.keep_depth(asked, masks_.frames(), distances_);
    messages_used_ = 0;
    for (const Side side : kSides) {
      const std::size_t eye = index_of(side);
      positions_of(asked.views[eye], distances_[eye].pixels, grid_, planes_);
      for (std::size_t axis = 0; axis < planes_.size(); ++axis) {
        packer_.start(asked.frame, side, kPositionKinds[axis], planes_[axis]);
        while (const std::optional<PlaneSlice> slice = packer_.next()) {
          if (messages_used_ == kMostSlices) return;
          if (messages_used_ == messages_.size()) messages_.emplace_back();
          encode(ClientMessage(*slice), messages_[messages_used_++]);
        }
      }
    }
  }

  const RunContext& context_;
  Exchange exchange_;
  MasksInHand masks_;
  PositionGrid grid_;
  DrawTimes drawn_;
  PerEye<Image<float>> distances_;
  PositionPlanes planes_;
  PlanePacker packer_;
  std::vector<std::vector<std::byte>> messages_;
  std::size_t messages_used_ = 0;
};

}  // namespace

std::unique_ptr<ModePipeline> make_client_positions(const RunContext& context) {
  return std::make_unique<ClientPositions>(context);
}

}  // namespace farshade
