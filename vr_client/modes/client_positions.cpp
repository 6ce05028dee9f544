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

class ClientPositions final : public Way {
 public:
  explicit ClientPositions(const Session& session)
      : session_(session),
        exchange_(session),
        masks_(session),
        grid_(grid_of({session.scene.bounds.low}, {session.scene.bounds.high}, session.mode.position_bits)) {}

  const TraceRequest* request(const Moment& moment) override {
    drawn_ = {};
    const TraceRequest* const asked = exchange_.plan(moment, wanted());
    if (asked == nullptr) return nullptr;
    pack(*asked);
    const TraceRequest* const complete = exchange_.complete(narrow<std::uint32_t>(messages_used_));
    exchange_.send(moment, std::span(messages_).first(messages_used_));
    return complete;
  }

  void collect(const Moment& moment) override { masks_.take(exchange_.receive(moment)); }

  Seen draw(const Moment& moment) override {
    // The depth that the request's masks will need is kept already; what it took is part of the request.
    Seen seen = masks_.draw(moment, nullptr, exchange_);
    seen.drawn.depth += drawn_.depth;
    return seen;
  }

 private:
  [[nodiscard]] Wanted wanted() const {
    return {.answer = Answer::MasksOfPositions, .position_bits = session_.mode.position_bits};
  }

  /// The positions of what `asked` sees, as messages.
  void pack(const TraceRequest& asked) {
    drawn_ = session_.renderer.keep_depth(asked, masks_.frames(), distances_);
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

  const Session& session_;
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

std::unique_ptr<Way> make_client_positions(const Session& session) {
  return std::make_unique<ClientPositions>(session);
}

}  // namespace farshade
