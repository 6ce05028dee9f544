// Masks of positions: traces from the surface points that the client sends. Tiles that lack a coordinate are
// not sent.
#include "rt_server/answers/answers.h"
#include "stereo/frame/position_grid.h"
#include "stereo/frame/tiles.h"
#include "stereo/scene/moving_bounds.h"

namespace farshade {
namespace {

class PositionMasks final : public RequestHandler {
 public:
  explicit PositionMasks(const AnswerContext& context) : bounds_(context.scene), tracer_(context.tracer) {}

  AnswerCost answer(const Job& job, FramePacker& packer) override {
    const Bounds bounds = bounds_.at(job.request.scene_time);
    const PositionGrid grid = grid_of({bounds.low}, {bounds.high}, job.request.answer.position_bits);
    clear(job.request.views, grid);
    for (const std::vector<std::byte>& message : job.parts) {
      go_on_with(job);
      unpack(message, job.version);
    }
    const AnswerCost cost{.traced = tracer_.trace(job.request, positions_, grid, frame_, job.is_given_up)};
    packer.add(frame_, {}, sent_tiles());
    return cost;
  }

 private:
  void clear(const StereoView& views, const PositionGrid& grid) {
    for (std::size_t eye = 0; eye < kEyes; ++eye)
      for (std::size_t axis = 0; axis < 3; ++axis) {
        PixelPlane& plane = positions_[eye][axis];
        plane.size = views[eye].size;
        plane.word_bytes = grid.word_bytes();
        plane.words.assign(plane.size.pixels(), 0);
        known_[eye][axis].assign(TileGrid{plane.size}.count(), 0);
      }
  }

  void unpack(std::span<const std::byte> message, ProtocolVersion version) {
    const Decoded<ClientMessage> decoded = decode_client(message, version);
    if (!decoded) return;
    const auto* const slice = std::get_if<PlaneSlice>(&*decoded);
    if (slice == nullptr || slice->kind < PlaneKind::PositionX) return;
    const std::size_t eye = index_of(slice->eye);
    const auto axis = static_cast<std::size_t>(slice->kind) - static_cast<std::size_t>(PlaneKind::PositionX);
    // A slice that does not fit the plane leaves its tiles unknown.
    static_cast<void>(decode_plane_tiles(*slice, positions_[eye][axis], known_[eye][axis]));
  }

  /// Marks the tiles of which all three coordinates have arrived. The tracer treats the pixels of the others
  /// as background.
  PerEye<std::span<const std::uint8_t>> sent_tiles() {
    for (std::size_t eye = 0; eye < kEyes; ++eye) {
      sent_[eye] = known_[eye][0];
      for (std::size_t tile = 0; tile < sent_[eye].size(); ++tile)
        if (known_[eye][1][tile] == 0 || known_[eye][2][tile] == 0) sent_[eye][tile] = 0;
    }
    return {sent_[0], sent_[1]};
  }

  MovingBounds bounds_;
  Tracer& tracer_;
  PerEye<PositionPlanes> positions_;
  PerEye<std::array<ReceivedTiles, 3>> known_;
  PerEye<ReceivedTiles> sent_;
  ShadowFrame frame_;
};

}  // namespace

std::unique_ptr<RequestHandler> make_position_masks(const AnswerContext& context) {
  return std::make_unique<PositionMasks>(context);
}

}  // namespace farshade
