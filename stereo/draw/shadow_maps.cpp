#include "stereo/draw/shadow_maps.h"

#include <algorithm>

namespace farshade {
namespace {

using Layout = vk::ImageLayout;

/// The layers of all lights, rounded up to pairs.
std::uint32_t layer_count(const Scene& scene) {
  std::uint32_t layers = 0;
  for (const LightSource& light : scene.lights) layers += map_layers(light.kind, light.outer_cone_rad);
  return std::max(layers + layers % 2, 2u);
}

gpu::Image make_maps(const gpu::Device& device, const Scene& scene, const ShadowMapSettings& settings) {
  check(shadow_map_bytes(scene, settings).has_value(), "shadow_map_bytes accepts the settings");
  return gpu::make_image(
      device,
      {.size = {settings.side_px, settings.side_px},
       .layers = layer_count(scene),
       .format = kDepthFormat,
       .usage = vk::ImageUsageFlagBits::eDepthStencilAttachment | vk::ImageUsageFlagBits::eSampled,
       .use = gpu::Use::ShadowMaps},
      "shadow maps");
}

const std::vector<gpu::BindingKind> kMapSet{
    {vk::DescriptorType::eCombinedImageSampler, vk::ShaderStageFlagBits::eCompute},
    {vk::DescriptorType::eUniformBuffer, vk::ShaderStageFlagBits::eCompute}};

}  // namespace

ShadowMaps::ShadowMaps(const gpu::Device& device, const Scene& scene, const DrawPlan& plan,
                       const SceneBuffers& buffers, const gpu::Buffer& frame,
                       const ShadowMapSettings& settings)
    : scene_(scene),
      buffers_(buffers),
      settings_(settings),
      maps_(make_maps(device, scene, settings)),
      map_data_(gpu::make_mapped_buffer(device, (scene.lights.size() + 1) * sizeof(gpu::ShadowMapData),
                                        vk::BufferUsageFlagBits::eUniformBuffer, "shadow map views",
                                        gpu::Use::ShadowMaps)),
      nearest_(device.logical.createSampler({})),
      bindings_(gpu::make_bindings(device, kMapSet, "shadow maps")),
      pass_(device, scene, plan, buffers, frame, Outputs::Casters, maps_.spec.layers / 2) {
  for (std::uint32_t first = 0; first < maps_.spec.layers; first += 2)
    pairs_.push_back(gpu::view_layers(device, maps_, {first, 2}));
  gpu::bind_image(device, bindings_, 0, {*maps_.view, Layout::eShaderReadOnlyOptimal, *nearest_});
  gpu::bind_buffer(device, bindings_, 1, map_data_);
}

std::vector<Point<Stage>> ShadowMaps::corners(const SceneState& state) const {
  std::vector<Point<Stage>> result;
  for (std::size_t i = 0; i < scene_.instances.size(); ++i) {
    const DeviceMesh& mesh = buffers_.meshes[scene_.instances[i].mesh];
    for (int corner = 0; corner < 8; ++corner)
      result.push_back(state.stage_from_object[i](Point<Object>{mesh.center + mesh.box.corner(corner)}));
  }
  return result;
}

void ShadowMaps::prepare(const StereoView& shown, const SceneState& state) {
  const std::vector<Light>& lights = state.light_set.lights;
  check_eq(lights.size(), scene_.lights.size(), "lights of the scene and of its state");
  ShadowMapViews views = shadow_map_views(lights, corners(state), settings_);
  for (std::size_t i = 0; i < lights.size(); ++i)
    map_data_.as<gpu::ShadowMapData>()[i] = shadow_map_data(shown, views.lights[i]);
  views.layer_clip.resize(maps_.spec.layers, clip_from_stage({}));
  Content needed{std::move(views.layer_clip), state.stage_from_object};
  due_ = settings_.redraw == Redraw::Always || needed != drawn_;
  if (!due_) return;
  drawn_ = std::move(needed);
  std::vector<PerEye<glm::dmat4>> pairs;
  for (std::size_t layer = 0; layer < drawn_.layer_clip.size(); layer += 2)
    pairs.push_back({drawn_.layer_clip[layer], drawn_.layer_clip[layer + 1]});
  pass_.prepare(pairs, maps_.spec.size, state);
}

void ShadowMaps::record(const vk::raii::CommandBuffer& commands) {
  if (!due_) return;
  gpu::transition(commands, maps_, Layout::eUndefined, Layout::eDepthAttachmentOptimal);
  for (std::size_t pair = 0; pair < pairs_.size(); ++pair)
    pass_.record(commands, maps_.spec.size, {}, cleared(*pairs_[pair], Layout::eDepthAttachmentOptimal),
                 pair);
  gpu::transition(commands, maps_, Layout::eDepthAttachmentOptimal, Layout::eShaderReadOnlyOptimal);
}

}  // namespace farshade
