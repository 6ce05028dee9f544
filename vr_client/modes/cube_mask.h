/// CubeMask: requests the pairs of faces of the cube mask, and holds their masks (docs/cube-mask.md).
#pragma once

#include "stereo/requests/cube_mask_plan.h"
#include "vr_client/modes/mask_stream.h"

namespace farshade {

class CubeMask {
 public:
  /// `link` may be null: then there are no requests and no masks.
  CubeMask(ServerConnection* link, const MaskPolicy& policy, SceneMotion motion);

  /// Plans this frame's requests for pairs, if any are due. Returns whether they should leave before all
  /// others.
  bool plan(const FrameInputs& inputs, Duration lead);
  /// Sends the planned requests; once. Nothing if there are none.
  void send(const FrameInputs& inputs);
  /// A pair is planned and not sent.
  [[nodiscard]] bool is_planned() const { return !requests_.empty(); }

  /// Waits where the policy says so, then takes the masks that this frame may use.
  void receive(const FrameInputs& inputs);

  /// Of each pair the newest mask, if there is one.
  [[nodiscard]] std::span<const TracedMask> masks() const { return masks_; }
  /// This frame's requests, as they were recorded.
  [[nodiscard]] std::vector<FaceRequest> requested() const;
  /// What the answers that have come since the last frame took.
  [[nodiscard]] const CubeMaskCost& cost() const { return cost_; }

 private:
  [[nodiscard]] bool is_under_way() const;
  void add_costs();

  ServerConnection* link_;
  MaskPolicy policy_;
  SceneMotion motion_;
  CubeMaskPlan plan_;
  std::vector<FrameRequest> requests_;  ///< planned, not sent
  std::vector<FrameId> sent_;           ///< in this frame
  std::optional<Time> counted_until_;   ///< arrival of the newest report in `cost_` so far
  bool is_answering_ = true;
  std::vector<TracedMask> masks_;
  CubeMaskCost cost_;
};

}  // namespace farshade
