#include "stereo/reproject/shading_pipelines.h"

#include <tbb/parallel_for_each.h>

#include <algorithm>
#include <bit>
#include <iterator>

#include "shaders/edge_rays.comp.spv.h"
#include "shaders/edge_rays_motion.comp.spv.h"
#include "shaders/shade_direct.comp.spv.h"
#include "shaders/shade_direct_report.comp.spv.h"
#include "shaders/shade_direct_visibility.comp.spv.h"
#include "shaders/shade_easy.comp.spv.h"
#include "shaders/shade_easy_motion.comp.spv.h"
#include "shaders/shade_easy_motion_report.comp.spv.h"
#include "shaders/shade_easy_motion_visibility.comp.spv.h"
#include "shaders/shade_easy_report.comp.spv.h"
#include "shaders/shade_easy_visibility.comp.spv.h"
#include "shaders/shade_few.comp.spv.h"
#include "shaders/shade_few_motion.comp.spv.h"
#include "shaders/shade_few_motion_report.comp.spv.h"
#include "shaders/shade_few_motion_visibility.comp.spv.h"
#include "shaders/shade_few_report.comp.spv.h"
#include "shaders/shade_few_visibility.comp.spv.h"
#include "shaders/shade_flipped.comp.spv.h"
#include "shaders/shade_flipped_motion.comp.spv.h"
#include "shaders/shade_flipped_motion_report.comp.spv.h"
#include "shaders/shade_flipped_motion_visibility.comp.spv.h"
#include "shaders/shade_flipped_report.comp.spv.h"
#include "shaders/shade_flipped_visibility.comp.spv.h"
#include "shaders/shade_hard.comp.spv.h"
#include "shaders/shade_hard_motion.comp.spv.h"
#include "shaders/shade_hard_motion_report.comp.spv.h"
#include "shaders/shade_hard_motion_visibility.comp.spv.h"
#include "shaders/shade_hard_report.comp.spv.h"
#include "shaders/shade_hard_visibility.comp.spv.h"
#include "shaders/shade_maps.comp.spv.h"
#include "shaders/shade_maps_report.comp.spv.h"
#include "shaders/shade_single.comp.spv.h"
#include "shaders/shade_single_few.comp.spv.h"
#include "shaders/shade_single_few_motion.comp.spv.h"
#include "shaders/shade_single_few_motion_report.comp.spv.h"
#include "shaders/shade_single_few_motion_visibility.comp.spv.h"
#include "shaders/shade_single_few_report.comp.spv.h"
#include "shaders/shade_single_few_visibility.comp.spv.h"
#include "shaders/shade_single_motion.comp.spv.h"
#include "shaders/shade_single_motion_report.comp.spv.h"
#include "shaders/shade_single_motion_visibility.comp.spv.h"
#include "shaders/shade_single_report.comp.spv.h"
#include "shaders/shade_single_visibility.comp.spv.h"
#include "stereo/reproject/shading.h"

namespace farshade {
namespace {

using SpirvWords = std::span<const std::uint32_t>;

/// A shader, the same with a report, and one that writes visibilities.
struct Variants {
  SpirvWords plain, reports, visibility{};
};

/// A shader that reprojects masks, for scenes where nothing moves and for others.
struct MotionVariants {
  Variants still, moving;
};

const MotionVariants kEasy{
    {shade_easy_comp_spv, shade_easy_report_comp_spv, shade_easy_visibility_comp_spv},
    {shade_easy_motion_comp_spv, shade_easy_motion_report_comp_spv, shade_easy_motion_visibility_comp_spv}},
    kRays{{edge_rays_comp_spv, {}}, {edge_rays_motion_comp_spv, {}}},
    kFlipped{{shade_flipped_comp_spv, shade_flipped_report_comp_spv, shade_flipped_visibility_comp_spv},
             {shade_flipped_motion_comp_spv, shade_flipped_motion_report_comp_spv,
              shade_flipped_motion_visibility_comp_spv}},
    kHard{{shade_hard_comp_spv, shade_hard_report_comp_spv, shade_hard_visibility_comp_spv},
          {shade_hard_motion_comp_spv, shade_hard_motion_report_comp_spv,
           shade_hard_motion_visibility_comp_spv}},
    kFewLights{
        {shade_few_comp_spv, shade_few_report_comp_spv, shade_few_visibility_comp_spv},
        {shade_few_motion_comp_spv, shade_few_motion_report_comp_spv, shade_few_motion_visibility_comp_spv}},
    kSingle{{shade_single_comp_spv, shade_single_report_comp_spv, shade_single_visibility_comp_spv},
            {shade_single_motion_comp_spv, shade_single_motion_report_comp_spv,
             shade_single_motion_visibility_comp_spv}},
    kSingleFewLights{
        {shade_single_few_comp_spv, shade_single_few_report_comp_spv, shade_single_few_visibility_comp_spv},
        {shade_single_few_motion_comp_spv, shade_single_few_motion_report_comp_spv,
         shade_single_few_motion_visibility_comp_spv}};

/// Of a pass that reprojects masks.
const MotionVariants& motion_variants_of(std::uint32_t pass, std::uint32_t lights) {
  if (pass == FARSHADE_PASS_EASY) return kEasy;
  if (pass == FARSHADE_PASS_RAYS) return kRays;
  if (pass == FARSHADE_PASS_FLIPPED) return kFlipped;
  const bool few = lights <= FARSHADE_FEW_LIGHTS;
  if (pass == FARSHADE_PASS_SINGLE) return few ? kSingleFewLights : kSingle;
  return few ? kFewLights : kHard;
}

Variants variants_of(const ShadingKey& key, std::uint32_t lights, bool motion) {
  if (key.uses_maps()) return {shade_maps_comp_spv, shade_maps_report_comp_spv};
  if (key.pass == FARSHADE_PASS_DIRECT)
    return {shade_direct_comp_spv, shade_direct_report_comp_spv, shade_direct_visibility_comp_spv};
  const MotionVariants& pass = motion_variants_of(key.pass, lights);
  return motion ? pass.moving : pass.still;
}

SpirvWords shader_of(const ShadingKey& key, std::uint32_t lights, bool motion) {
  const Variants variants = variants_of(key, lights, motion);
  return key.visibility ? variants.visibility : key.reports ? variants.reports : variants.plain;
}

std::vector<std::uint32_t> constants_of(const ShadingKey& key, const DrawPlan& plan,
                                        const gpu::Device& device) {
  const auto word_of = [](float value) { return std::bit_cast<std::uint32_t>(value); };
  std::vector<std::uint32_t> constants(FARSHADE_CONSTANTS);
  constants[FARSHADE_CONSTANT_LIGHTS] = plan.mask.lights;
  constants[FARSHADE_CONSTANT_WORD_BYTES] = device_mask(plan).word_bytes();
  constants[FARSHADE_CONSTANT_PASS] = key.pass;
  constants[FARSHADE_CONSTANT_OTHER_EYE] = key.other_eye;
  constants[FARSHADE_CONSTANT_RANGES_AND_CONES] = plan.ranges_and_cones;
  constants[FARSHADE_CONSTANT_NEAR] = word_of(static_cast<float>(kNearPlane_m));
  constants[FARSHADE_CONSTANT_UNKNOWN_VISIBILITY] = word_of(kUnknownVisibility);
  constants[FARSHADE_CONSTANT_WHOLE] = key.whole;
  constants[FARSHADE_CONSTANT_MOVED] = key.moved;
  constants[FARSHADE_CONSTANT_NEIGHBOURS] = key.neighbours;
  constants[FARSHADE_CONSTANT_EDGES] = key.filters_edges;
  constants[FARSHADE_CONSTANT_SHARPNESS] = word_of(key.sharpness);
  constants[FARSHADE_CONSTANT_EDGE_BIT] = first_edge_bit(plan.mask.lights);
  constants[FARSHADE_CONSTANT_MAP_SIDE] = key.map_side_px;
  constants[FARSHADE_CONSTANT_PCF_RADIUS] = key.pcf_radius;
  constants[FARSHADE_CONSTANT_DETAIL] = word_of(plan.detail_px);
  constants[FARSHADE_CONSTANT_CUBE_MASK] = plan.cube_mask;
  constants[FARSHADE_CONSTANT_EDGE_RAYS] = key.edge_rays;
  constants[FARSHADE_CONSTANT_HOLES] = std::ranges::any_of(plan.surfaces, &SurfaceNeeds::alpha_test);
  constants[FARSHADE_CONSTANT_ROW_GROUPS] = row_groups(device.max_groups[0]);
  return constants;
}

}  // namespace

const vk::raii::Pipeline& ShadingPipelines::need(const ShadingKey& key,
                                                 const vk::raii::PipelineLayout& layout) {
  const auto found = pipelines_.find(key);
  if (found != pipelines_.end()) return found->second;
  return pipelines_.emplace(key, make(key, layout)).first->second;
}

void ShadingPipelines::need_all(const std::set<ShadingKey>& keys, const vk::raii::PipelineLayout& layout) {
  std::vector<std::pair<ShadingKey, vk::raii::Pipeline>> missing;
  for (const ShadingKey& key : keys)
    if (!pipelines_.contains(key)) missing.emplace_back(key, nullptr);
  tbb::parallel_for_each(missing, [&](auto& one) { one.second = make(one.first, layout); });
  pipelines_.insert(std::make_move_iterator(missing.begin()), std::make_move_iterator(missing.end()));
}

vk::raii::Pipeline ShadingPipelines::make(const ShadingKey& key,
                                          const vk::raii::PipelineLayout& layout) const {
  return gpu::make_compute_pipeline(device_, layout, shader_of(key, plan_.mask.lights, motion_),
                                    constants_of(key, plan_, device_), "shade");
}

}  // namespace farshade
