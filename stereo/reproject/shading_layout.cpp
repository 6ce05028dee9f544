#include "stereo/reproject/shading_layout.h"

#include <algorithm>

#include "stereo/frame/view.h"
#include "stereo/plan/plan_masks.h"
#include "stereo/reproject/mask_quads.h"
#include "stereo/reproject/shading_motion.h"

namespace farshade {
namespace {

constexpr std::size_t whole_words(std::size_t bytes) {
  return (bytes + 3) / 4 * 4;
}

MaskBytes mask_bytes_on_device(const DrawPlan& plan, Extent size, bool with_cells) {
  return {whole_words(device_mask_bytes(plan, size, with_cells)),
          whole_words(TileGrid{size}.count() * sizeof(BlockBits))};
}

}  // namespace

DrawPlan settled(DrawPlan plan) {
  if (reprojects_masks(plan)) return plan;
  plan.moves.assign(plan.moves.size(), false);
  plan.lights_move = plan.other_eye = plan.depth_pass = false;
  return plan;
}

RequestReprojectionBytes request_reprojection_bytes(const DrawPlan& plan, Extent traced_size) {
  if (!reprojects_masks(plan)) return {};
  const std::size_t blocks = kEyes * blocks_of(traced_size).pixels();
  return {whole_words(quad_bytes(traced_size, plan.mask)),
          blocks * kBlockSide_px * kBlockSide_px * plan.mask.planes() * plan.mask.word_bytes(),
          blocks * sizeof(std::uint32_t)};
}

ShadingBytes shading_bytes(const DrawPlan& plan, Extent size, Extent traced_size) {
  const auto moving = static_cast<std::size_t>(std::ranges::count(plan.moves, true));
  ShadingBytes bytes{.lights = (plan.mask.lights + 1) * sizeof(gpu::LightData)};
  bytes.report = kEyes * size.pixels() * std::size_t{FARSHADE_REPORT_WORDS(plan.mask.lights)} * 4;
  if (most_masks(plan) > 0) {
    bytes.mask = mask_bytes_on_device(plan, traced_size, has_cells(plan));
    if (most_cube_mask_pairs(plan) > 0) bytes.face = mask_bytes_on_device(plan, face_size(size), false);
  }
  if (moving > 0) {
    bytes.slots = plan.moves.size() * 4;
    bytes.motions = motion_index(moving, 0, 0) * sizeof(glm::mat4);
  }
  if (reprojects_masks(plan) && plan.passes == ShadingPasses::Sorted) {
    std::size_t words = size.pixels();
    if (plan.edge_rays) words += edge_capacity(size) * (2 + plan.mask.planes());
    bytes.arguments = kListHeads_bytes + kEyes * words * 4;
    bytes.lists = bytes.arguments + kListHeads_bytes;
  }
  return bytes;
}

}  // namespace farshade
