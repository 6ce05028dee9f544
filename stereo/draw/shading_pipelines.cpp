#include "stereo/draw/shading_pipelines.h"

#include <bit>

#include "shaders/shade.comp.spv.h"
#include "shaders/shade_direct.comp.spv.h"
#include "shaders/shade_direct_report.comp.spv.h"
#include "shaders/shade_maps.comp.spv.h"
#include "shaders/shade_maps_report.comp.spv.h"
#include "shaders/shade_motion.comp.spv.h"
#include "shaders/shade_motion_report.comp.spv.h"
#include "shaders/shade_report.comp.spv.h"
#include "stereo/draw/shading.h"

namespace farshade {
namespace {

std::span<const std::uint32_t> shader_of(const ShadingKey& key, bool motion) {
  using SpirvWords = std::span<const std::uint32_t>;
  if (key.uses_maps()) return key.reports ? SpirvWords(shade_maps_report_comp_spv) : shade_maps_comp_spv;
  if (key.pass == FARSHADE_PASS_DIRECT)
    return key.reports ? SpirvWords(shade_direct_report_comp_spv) : shade_direct_comp_spv;
  if (motion) return key.reports ? SpirvWords(shade_motion_report_comp_spv) : shade_motion_comp_spv;
  return key.reports ? SpirvWords(shade_report_comp_spv) : shade_comp_spv;
}

gpu::Specialization constants_of(const ShadingKey& key, const DrawPlan& plan) {
  const auto word_of = [](float value) { return std::bit_cast<std::uint32_t>(value); };
  std::vector<std::uint32_t> constants(FARSHADE_CONSTANTS);
  constants[FARSHADE_CONSTANT_LIGHTS] = plan.mask.lights;
  constants[FARSHADE_CONSTANT_WORD_BYTES] = device_mask(plan).word_bytes();
  constants[FARSHADE_CONSTANT_PASS] = key.pass;
  constants[FARSHADE_CONSTANT_OTHER_EYE] = key.other_eye;
  constants[FARSHADE_CONSTANT_RANGES_AND_CONES] = plan.ranges_and_cones;
  constants[FARSHADE_CONSTANT_NEAR] = word_of(static_cast<float>(kNearPlane_m));
  constants[FARSHADE_CONSTANT_UNKNOWN_VISIBILITY] = word_of(kUnknownVisibility);
  constants[FARSHADE_CONSTANT_EYE] = key.eye;
  constants[FARSHADE_CONSTANT_WHOLE] = key.whole;
  constants[FARSHADE_CONSTANT_MOVED] = key.moved;
  constants[FARSHADE_CONSTANT_NEIGHBOURS] = key.neighbours;
  constants[FARSHADE_CONSTANT_EDGES] = key.filters_edges;
  constants[FARSHADE_CONSTANT_SHARPNESS] = word_of(key.sharpness);
  constants[FARSHADE_CONSTANT_EDGE_BIT] = first_edge_bit(plan.mask.lights);
  constants[FARSHADE_CONSTANT_MAP_SIDE] = key.map_side_px;
  constants[FARSHADE_CONSTANT_PCF_RADIUS] = key.pcf_radius;
  constants[FARSHADE_CONSTANT_DETAIL] = word_of(plan.detail_px);
  constants[FARSHADE_CONSTANT_SURROUND] = plan.surround;
  return gpu::Specialization(std::move(constants));
}

}  // namespace

const vk::raii::Pipeline& ShadingPipelines::need(const ShadingKey& key,
                                                 const vk::raii::PipelineLayout& layout) {
  const auto found = pipelines_.find(key);
  if (found != pipelines_.end()) return found->second;
  const vk::raii::ShaderModule shader = gpu::make_shader(device_, shader_of(key, motion_), "shade.comp");
  return pipelines_
      .emplace(key, gpu::make_compute_pipeline(device_, layout, shader, constants_of(key, plan_), "shade"))
      .first->second;
}

}  // namespace farshade
