
#include "stereo/reproject/shading.h"
#include "stereo/reproject/shown_eye.h"

namespace farshade {

/// Set 0, then the set of the shadow maps if they are used, then the set of the report if one is requested.
std::vector<const gpu::Bindings*> ShadingPass::sets(PixelReport report) const {
  std::vector<const gpu::Bindings*> result{&set_now().bindings};
  if (maps_ != nullptr) result.push_back(&maps_->bindings());
  if (report == PixelReport::On) result.push_back(&report_bindings_);
  return result;
}

const vk::raii::PipelineLayout& ShadingPass::need_layout(PixelReport report) {
  const std::size_t kind = (maps_ != nullptr ? 2u : 0u) + (report == PixelReport::On ? 1u : 0u);
  auto found = layouts_.find(kind);
  if (found == layouts_.end()) {
    std::vector<vk::DescriptorSetLayout> layouts;
    for (const gpu::Bindings* set : sets(report)) layouts.push_back(*set->layout);
    found = layouts_
                .emplace(kind, device_.logical.createPipelineLayout(
                                   {.setLayoutCount = narrow<std::uint32_t>(layouts.size()),
                                    .pSetLayouts = layouts.data(),
                                    .pushConstantRangeCount = 1,
                                    .pPushConstantRanges = &kShownEye}))
                .first;
  }
  return found->second;
}

void ShadingPass::bind_sets(const vk::raii::CommandBuffer& commands, PixelReport report) {
  std::vector<vk::DescriptorSet> bound;
  for (const gpu::Bindings* set : sets(report)) bound.push_back(*set->set);
  commands.bindDescriptorSets(vk::PipelineBindPoint::eCompute, *need_layout(report), 0, bound, {});
}

std::size_t ShadingPass::bindings() const {
  return set_now().bindings.kinds.size() + report_bindings_.kinds.size();
}

void ShadingPass::bind_texture(FrameSet& set, std::uint32_t binding, vk::ImageView view) const {
  vk::ImageView& bound = set.textures[binding];
  if (bound == view) return;
  bound = view;
  gpu::bind_image(device_, set.bindings, binding, {view, vk::ImageLayout::eShaderReadOnlyOptimal, *nearest_});
}

/// Binds the depth that the next `record` reads. The only writer of a set that was in use. Writes only what
/// differs from the last frame with this set.
void ShadingPass::bind_depths(FrameSet& set, const DepthPlace& shown,
                              std::span<const DatedMask> masks) const {
  bind_texture(set, FARSHADE_BINDING_SHOWN_DEPTH, shown.view);
  if (!reprojects_masks(plan_)) return;
  for (std::uint32_t m = 0; m < kMaxMasks; ++m) {
    const bool has_depth = m < masks.size() && depths_.views.has(masks[m].mask.frame);
    const DepthPlace& place = has_depth ? depths_.views.place_of(masks[m].mask.frame) : depths_.any;
    bind_texture(set, FARSHADE_BINDING_MASK_DEPTHS + m, place.view);
  }
}

void ShadingPass::bind_images(const ForeignImages& images) {
  check(writes_visibilities(), "the pass has no images of its own");
  // Always, because a view that was destroyed and made anew may have the same handle.
  FrameSet& set = frame_sets_[frames_.place()];
  set.textures.erase(FARSHADE_BINDING_SHOWN_DEPTH);
  set.textures.erase(FARSHADE_BINDING_SURFACES);
  bind_texture(set, FARSHADE_BINDING_SHOWN_DEPTH, images.depth);
  bind_texture(set, FARSHADE_BINDING_SURFACES, images.surfaces);
  gpu::bind_image(device_, set.bindings, FARSHADE_BINDING_OUTPUT,
                  {images.visibilities, vk::ImageLayout::eGeneral, nullptr});
}

void ShadingPass::prepare(const DepthPlace& shown, const StereoView& views, const LightSet& lights,
                          const ShadowMaps& maps) {
  check_eq(lights.lights.size(), std::size_t{plan_.mask.lights}, "lights of the scene and of the plan");
  maps_ = &maps;
  masks_ = faces_ = 0;
  reprojection_ = {.lookup = Lookup::Direct};
  other_eye_ = moved_ = traces_rays_ = false;
  whole_ = true;
  gpu::FrameData frame{};
  for (std::size_t eye = 0; eye < kEyes; ++eye) frame.eye[eye] = eye_data(views[eye]);
  bind_depths(frame_sets_[frames_.place()], shown, {});
  write_frame(views, lights, frame);
}

}  // namespace farshade
