/// The sizes and layouts of the buffers of ShadingPass. Pure; the pass and the prediction of its memory use
/// the same figures.
#pragma once

#include <algorithm>
#include <array>

#include "shaders/shade_data.h"
#include "shaders/shared.h"
#include "stereo/frame/cube_mask.h"
#include "stereo/frame/requested_blocks.h"
#include "stereo/plan/plan_masks.h"
#include "stereo/plan/scene_plan.h"
#include "stereo/reproject/mask_edges.h"

namespace farshade {

/// `plan`; if masks are not reprojected, without the features that only serve to reproject them.
[[nodiscard]] DrawPlan settled(DrawPlan plan);

/// The layout of a mask on the device: with edge bits, if masks are reprojected.
[[nodiscard]] constexpr MaskLayout device_mask(const DrawPlan& plan) {
  return reprojects_masks(plan) ? with_edge_bits(plan.mask) : plan.mask;
}

/// Whether masks of views have their cells on the device, for edge rays. Faces of the cube mask have none.
[[nodiscard]] constexpr bool has_cells(const DrawPlan& plan) {
  return reprojects_masks(plan) && plan.edge_rays;
}
[[nodiscard]] constexpr std::size_t device_mask_bytes(const DrawPlan& plan, Extent size, bool with_cells) {
  return with_cells ? mask_and_cell_bytes(size, plan.mask) : mask_bytes(size, device_mask(plan));
}

/// The number of masks that the device holds.
[[nodiscard]] constexpr std::size_t most_masks(const DrawPlan& plan) {
  return plan.mask.lights == 0 ? 0 : reprojects_masks(plan) ? FARSHADE_MAX_MASKS : 1;
}

/// The size of the dispatch and the length of each list (lists.glsl).
inline constexpr std::size_t kListHeads_bytes = kEyes * FARSHADE_LISTS * sizeof(glm::uvec4);

/// Bytes of one eye's mask and of its bitmap of known blocks; multiples of 4.
struct MaskBytes {
  std::size_t words = 0, known = 0;
};

/// Bytes of the pass's buffers.
struct ShadingBytes {
  std::size_t lights = 0;
  MaskBytes mask{}, face{};            ///< of a traced view, and of a face of the cube mask
  std::size_t slots = 0, motions = 0;  ///< 0 if nothing moves
  std::size_t lists = 0;               ///< 0 if masks are not reprojected, or all pixels in a single pass
  /// Where the arguments of the dispatches over lists begin. They lie behind what shaders see of `lists`.
  std::size_t arguments = 0;
  std::size_t report = 0;  ///< allocated when a report is first requested

  /// The words of all masks that the device holds, and their known blocks.
  [[nodiscard]] std::size_t all_words(const DrawPlan& plan) const {
    return kEyes * (most_masks(plan) * mask.words + most_cube_mask_pairs(plan) * face.words);
  }
  [[nodiscard]] std::size_t all_known(const DrawPlan& plan) const {
    return kEyes * (most_masks(plan) * mask.known + most_cube_mask_pairs(plan) * face.known);
  }
};

/// Bytes of the buffers of RequestReprojectionPass: 0 if masks are not reprojected.
struct RequestReprojectionBytes {
  std::size_t quads = 0;        ///< of one eye (mask_quads.h); a multiple of 4
  std::size_t reprojected = 0;  ///< of both eyes: planes of rows of whole blocks
  std::size_t unknown = 0;      ///< a word for each block of both eyes
};
[[nodiscard]] RequestReprojectionBytes request_reprojection_bytes(const DrawPlan& plan, Extent traced_size);

/// The number of blocks of a picture along its sides.
[[nodiscard]] constexpr Extent blocks_of(Extent size) {
  return {(size.width + kBlockSide_px - 1) / kBlockSide_px,
          (size.height + kBlockSide_px - 1) / kBlockSide_px};
}

/// Workgroups in a row of a dispatch over listed pixels, on a device that allows `most` along x.
[[nodiscard]] constexpr std::uint32_t row_groups(std::uint32_t most) {
  return std::min<std::uint32_t>(most, FARSHADE_ROW_GROUPS);
}
/// The size of a dispatch of shade.comp, in workgroups.
using GroupCounts = std::array<std::uint32_t, 2>;
[[nodiscard]] constexpr GroupCounts picture_groups(Extent size) {
  return {(size.width + FARSHADE_SHADE_GROUP - 1) / FARSHADE_SHADE_GROUP, size.height};
}
[[nodiscard]] constexpr GroupCounts listed_groups(std::size_t pixels, std::uint32_t row_groups) {
  const std::size_t groups = (pixels + FARSHADE_SHADE_GROUP - 1) / FARSHADE_SHADE_GROUP;
  return {static_cast<std::uint32_t>(std::min<std::size_t>(groups, row_groups)),
          static_cast<std::uint32_t>((groups + row_groups - 1) / row_groups)};
}
/// Whether a device that allows `most` groups shades an eye of `size`, also if all pixels are listed.
[[nodiscard]] constexpr bool fits_dispatches(Extent size, const GroupCounts& most) {
  const GroupCounts picture = picture_groups(size),
                    listed = listed_groups(size.pixels(), row_groups(most[0]));
  return picture[0] <= most[0] && picture[1] <= most[1] && listed[1] <= most[1];
}

/// The edges that fit into an eye's list.
[[nodiscard]] constexpr std::size_t edge_capacity(Extent size) {
  const std::size_t share = (size.pixels() + FARSHADE_PIXELS_PER_EDGE - 1) / FARSHADE_PIXELS_PER_EDGE;
  return std::max(share, std::min<std::size_t>(size.pixels(), FARSHADE_FEWEST_EDGES));
}

/// For shown eyes of `size` and masks of at most `traced_size` pixels.
[[nodiscard]] ShadingBytes shading_bytes(const DrawPlan& plan, Extent size, Extent traced_size);

}  // namespace farshade
