// Client-positions: the client draws the depth of the views it asks for and sends the positions of their
// pixels. The server traces shadow rays from these positions and draws nothing. The client reprojects the
// masks as in mode hybrid.
#include "stereo/base/check.h"
#include "stereo/frame/position_grid.h"
#include "stereo/wire/plane_codec.h"
#include "vr_client/modes/make_pipeline.h"
#include "vr_client/modes/mask_sources.h"

namespace farshade {
namespace {

/// The number of slices that a request can announce. Tiles in further slices stay unknown.
constexpr std::size_t kMostSlices = 65535;

constexpr std::array kPositionKinds{PlaneKind::PositionX, PlaneKind::PositionY, PlaneKind::PositionZ};

class ClientPositions final : public ModePipeline {
 public:
  explicit ClientPositions(const RunContext& context)
      : context_(context),
        exchange_(context.link, context.policy, context.settings.request),
        masks_(context.scene.animation_length_s > 0),
        grid_(grid_of({context.scene.bounds.low}, {context.scene.bounds.high}, context.mode.position_bits)) {}

  const FrameRequest* request(const FrameInputs& inputs) override {
    drawn_ = {};
    const FrameRequest* const request = exchange_.plan(inputs, answer());
    if (request == nullptr) return nullptr;
    pack(*request);
    const FrameRequest* const complete = exchange_.complete(narrow<std::uint32_t>(messages_used_));
    exchange_.send(inputs, std::span(messages_).first(messages_used_));
    return complete;
  }

  void collect(const FrameInputs& inputs) override {
    const auto usable = exchange_.receive(inputs);
    masks_.take(usable, exchange_.settled());
  }

  DrawnFrame draw(const FrameInputs& inputs) override {
    // pack() has kept the depth of the requested views.
    DrawnFrame drawn = masks_.draw(context_.renderer, inputs, nullptr, exchange_);
    drawn.drawn.depth += drawn_.depth;
    return drawn;
  }

 private:
  [[nodiscard]] AnswerSpec answer() const {
    return {.kind = Answer::MasksOfPositions, .position_bits = context_.mode.position_bits};
  }

  /// Writes the positions of the pixels of the requested views into messages.
  void pack(const FrameRequest& request) {
    drawn_ = context_.renderer.keep_depth(request, exchange_.next_slot(), distances_);
    messages_used_ = 0;
    for (const Side side : kSides) {
      const std::size_t eye = index_of(side);
      positions_of(request.views[eye], distances_[eye].pixels, grid_, planes_);
      for (std::size_t axis = 0; axis < planes_.size(); ++axis) {
        packer_.start(request.frame, side, kPositionKinds[axis], planes_[axis]);
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
  MaskSources masks_;
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
