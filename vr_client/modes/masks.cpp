// Hybrid: the client requests masks for predicted views, draws its own G-buffer and reprojects the masks. It
// reprojects its newest mask to the predicted views first, and asks only for what that leaves unknown.
//
// Client-positions: the client draws the depth of the views it asks for and sends the positions of their
// pixels. The server traces shadow rays from these positions and draws nothing. The client reprojects the
// masks as in mode hybrid.
#include "vr_client/modes/masks.h"

#include <algorithm>

#include "stereo/base/check.h"
#include "stereo/codec/plane_codec.h"
#include "stereo/frame/position_grid.h"
#include "stereo/partial_request/partial_request.h"
#include "stereo/raster/frame_data.h"
#include "stereo/reproject/motion.h"
#include "stereo/scene/moving_bounds.h"
#include "vr_client/modes/make_pipeline.h"

namespace farshade {
namespace {

SceneMotion motion_of(const Renderer& renderer) {
  return renderer.anything_moves() ? SceneMotion::Moving : SceneMotion::Still;
}

/// What the lenses hide of the views of a request.
PerEye<HiddenArea> hidden_in(const FrameRequest& request, const FrameInputs& inputs) {
  if (inputs.hidden == nullptr) return {};
  return hidden_in_request(*inputs.hidden, inputs.shown.views, request.views);
}

class Hybrid final : public ModePipeline {
 public:
  explicit Hybrid(const RunContext& context)
      : renderer_(context.renderer),
        coding_(context.mode.mask_code == MaskCode::Lz4 ? Coding::Lz4 : Coding::AfterLast),
        mask_stream_(context.link, context.policy, context.settings.request, motion_of(context.renderer)),
        cube_mask_(asks_for_parts() ? context.link : nullptr, context.policy, motion_of(context.renderer)),
        is_sent_late_(context.policy.pace == Pace::Real && context.policy.mask_wait == Duration::zero()),
        partial_request_(context.renderer),
        masks_(context.renderer.anything_moves()) {}

  std::optional<FrameRequest> request(const FrameInputs& inputs) override {
    std::optional<FrameRequest> request =
        mask_stream_.plan(inputs, {.kind = Answer::Masks, .coding = coding_});
    if (cube_mask_.plan(inputs, mask_stream_.lead(inputs.period))) cube_mask_.send(inputs);
    partial_request_.skip();
    if (request && asks_for_parts() && mask_stream_.takes_parts()) {
      // Receives first: what has come decides which slot is next.
      const RequestRecord* const newest = mask_stream_.newest_settled(inputs);
      const RequestRecord* const base = inputs.settings.request.asks == Asks::Unknown ? newest : nullptr;
      partial_request_.begin(*request, mask_stream_.next_slot(), base, hidden_in(*request, inputs));
    }
    requested_ = request ? std::optional(request->frame) : std::nullopt;
    late_.reset();
    // A pair of the cube mask that is not urgent leaves after the request for the views.
    if (is_sent_late_ && partial_request_.has_begun() && !cube_mask_.is_planned())
      late_ = std::exchange(request, std::nullopt);
    else if (request)
      complete_and_send(inputs, *request);
    cube_mask_.send(inputs);
    return request;
  }

  std::optional<FrameRequest> request_late(const FrameInputs& inputs) override {
    if (late_) complete_and_send(inputs, *late_);
    return std::exchange(late_, std::nullopt);
  }

  void collect(const FrameInputs& inputs) override {
    const auto usable = mask_stream_.receive(inputs);
    masks_.take(usable, mask_stream_.settled());
    cube_mask_.receive(inputs);
  }

  DrawnFrame draw(const FrameInputs& inputs) override {
    const RequestRecord* const undrawn =
        partial_request_.has_begun() ? nullptr : mask_stream_.record(requested_);
    return masks_.draw(renderer_, inputs, undrawn, mask_stream_, &cube_mask_);
  }

 private:
  void complete_and_send(const FrameInputs& inputs, FrameRequest& request) {
    partial_request_.complete(request);
    mask_stream_.send(inputs, request, partial_request_.parts());
  }
  /// A block of masks holds whole views, and none of the cube mask.
  [[nodiscard]] bool asks_for_parts() const { return coding_ != Coding::Lz4; }

  Renderer& renderer_;
  Coding coding_;
  MaskStream mask_stream_;
  CubeMask cube_mask_;
  /// Requests may be sent after their frame was submitted: not in virtual time, and not if frames wait for
  /// their own answers.
  bool is_sent_late_;
  PartialRequest partial_request_;
  MaskSources masks_;
  std::optional<FrameRequest> late_;  ///< waits for what its frame leaves unknown
  std::optional<FrameId> requested_;  ///< in this frame
};

/// The number of slices that a request can announce. Tiles in further slices stay unknown.
constexpr std::size_t kMostSlices = 65535;

constexpr std::array kPositionKinds{PlaneKind::PositionX, PlaneKind::PositionY, PlaneKind::PositionZ};

class ClientPositions final : public ModePipeline {
 public:
  explicit ClientPositions(const RunContext& context)
      : context_(context),
        mask_stream_(context.link, context.policy, context.settings.request, motion_of(context.renderer)),
        masks_(context.renderer.anything_moves()),
        bounds_(context.scene) {}

  std::optional<FrameRequest> request(const FrameInputs& inputs) override {
    std::optional<FrameRequest> request = mask_stream_.plan(inputs, answer());
    if (!request) return request;
    pack(*request, hidden_in(*request, inputs));
    request->answer.slices = narrow<std::uint32_t>(messages_used_);
    mask_stream_.send(inputs, *request, {.messages = std::span(messages_).first(messages_used_)});
    return request;
  }

  void collect(const FrameInputs& inputs) override {
    const auto usable = mask_stream_.receive(inputs);
    masks_.take(usable, mask_stream_.settled());
  }

  DrawnFrame draw(const FrameInputs& inputs) override {
    // pack() has kept the depth of the requested views.
    return masks_.draw(context_.renderer, inputs, nullptr, mask_stream_);
  }

 private:
  [[nodiscard]] AnswerSpec answer() const {
    return {.kind = Answer::MasksOfPositions, .position_bits = context_.mode.position_bits};
  }

  /// Writes the positions of the pixels of the requested views into messages.
  void pack(const FrameRequest& request, const PerEye<HiddenArea>& hidden) {
    context_.renderer.keep_depth(request, mask_stream_.next_slot(), distances_, &hidden);
    const Bounds bounds = bounds_.at(request.scene_time);
    const PositionGrid grid = grid_of({bounds.low}, {bounds.high}, context_.mode.position_bits);
    messages_used_ = 0;
    for (const Side side : kSides) {
      const std::size_t eye = index_of(side);
      positions_of(request.views[eye], distances_[eye].pixels, grid, planes_);
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
  MaskStream mask_stream_;
  MaskSources masks_;
  MovingBounds bounds_;
  PerEye<Image<float>> distances_;
  PositionPlanes planes_;
  PlanePacker packer_;
  std::vector<std::vector<std::byte>> messages_;
  std::size_t messages_used_ = 0;
};

}  // namespace

std::unique_ptr<ModePipeline> make_hybrid(const RunContext& context) {
  return std::make_unique<Hybrid>(context);
}

std::unique_ptr<ModePipeline> make_client_positions(const RunContext& context) {
  return std::make_unique<ClientPositions>(context);
}

void MaskSources::take(std::span<const RequestRecord* const> usable, const RequestRecord* settled) {
  records_.assign(usable.begin(), usable.end());
  std::stable_partition(records_.begin(), records_.end(),
                        [&](const RequestRecord* record) { return record == settled; });
  masks_.clear();
  for (const RequestRecord* record : records_) masks_.push_back(mask_of(*record));
}

Lookup MaskSources::lookup(const FrameMoment& shown, Lookup requested) const {
  if (masks_.empty()) return requested;
  const TracedMask& first = masks_[0];
  const auto is_same = [&](std::size_t eye) {
    return shares_pixels(shown.views[eye], first.views[eye]) && records_[0]->complete(kSides[eye]);
  };
  const bool is_exact = is_same(0) && is_same(1) && first.light_set_revision == shown.lights.revision &&
                        (!anything_moves_ || same_instant(first.scene_time, shown.scene_time));
  return is_exact ? Lookup::Direct : requested;
}

DrawnFrame MaskSources::draw(Renderer& renderer, const FrameInputs& inputs, const RequestRecord* record,
                             MaskStream& mask_stream, const CubeMask* cube_mask) {
  Reprojection reprojection = inputs.settings.reprojection;
  reprojection.lookup = lookup(inputs.shown, reprojection.lookup);
  const std::vector<FaceRequest> faces = cube_mask ? cube_mask->requested() : std::vector<FaceRequest>{};
  const auto around = cube_mask ? cube_mask->masks() : std::span<const TracedMask>{};
  renderer.draw({.views = inputs.shown.views,
                 .state = inputs.state,
                 .request = record ? &record->request : nullptr,
                 .masks = masks_,
                 .cube_mask = around,
                 .reprojection = reprojection,
                 .report = inputs.settings.report,
                 .request_slot = record ? record->slot : 0,
                 .faces = faces,
                 .hidden = inputs.hidden});
  DrawnFrame drawn{.cube_mask = around, .cube_mask_cost = cube_mask ? cube_mask->cost() : CubeMaskCost{}};
  // The renderer passes over masks without depth.
  const RequestRecord* first = nullptr;
  drawn_with_.clear();
  for (std::size_t i = 0; i < masks_.size(); ++i) {
    if (reprojection.lookup != Lookup::Direct && !renderer.has_depth(masks_[i].frame)) continue;
    if (first == nullptr) first = records_[i];
    drawn_with_.push_back(masks_[i]);
  }
  if (first != nullptr) mask_stream.drawn_with(inputs, *first);
  drawn.start_up = drawn_with_.empty();
  drawn.masks = drawn_with_;
  if (!records_.empty()) {
    drawn.newest = records_[0];
    drawn.age = age_of(*records_[0], inputs);
  }
  return drawn;
}

}  // namespace farshade
