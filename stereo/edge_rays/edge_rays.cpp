#include "stereo/edge_rays/edge_rays.h"

#include "stereo/edge_rays/caster_texels.h"
#include "stereo/gpu/upload.h"

namespace farshade {
namespace {

constexpr std::size_t kStaging_bytes = 16 << 20;

const std::vector<gpu::BindingKind> kRaySet{
    {vk::DescriptorType::eUniformTexelBuffer, vk::ShaderStageFlagBits::eCompute},
    {vk::DescriptorType::eUniformTexelBuffer, vk::ShaderStageFlagBits::eCompute},
    {vk::DescriptorType::eUniformTexelBuffer, vk::ShaderStageFlagBits::eCompute},
    {vk::DescriptorType::eUniformTexelBuffer, vk::ShaderStageFlagBits::eCompute}};

template <class T>
gpu::Buffer on_device(const gpu::Device& device, const std::vector<T>& content, const char* name) {
  const std::span<const std::byte> bytes = std::as_bytes(std::span(content));
  gpu::Buffer buffer = gpu::make_device_buffer(
      device, bytes.size(),
      vk::BufferUsageFlagBits::eUniformTexelBuffer | vk::BufferUsageFlagBits::eTransferDst, name,
      gpu::Use::EdgeRays);
  gpu::BufferUpload upload(device, kStaging_bytes);
  upload.write(buffer, 0, bytes);
  upload.flush();
  return buffer;
}

/// The projection of the light buffer of each light, also of those that are off.
std::vector<LightShadowMaps> light_projections(const Scene& scene, std::vector<Light> lights) {
  for (Light& light : lights) light.on = true;
  std::vector<Point<Stage>> corners;
  for (int corner = 0; corner < 8; ++corner) corners.push_back({scene.bounds.corner(corner)});
  ShadowMapSettings settings;
  settings.side_px = FARSHADE_LIGHT_BUFFER_SIDE;
  settings.pcf_radius = 0;
  return shadow_map_views(lights, corners, settings).lights;
}

/// Whether rays to `now` may use the buffer that was made for `then`.
bool same_place(const Light& then, const Light& now) {
  if (now.kind == LightKind::Directional) return then.direction == now.direction;
  return then.position == now.position && (now.kind == LightKind::Point || then.direction == now.direction);
}

}  // namespace

EdgeRays::EdgeRays(gpu::FramesInFlight& frames, const Scene& scene, const DrawPlan& plan)
    : places_(gpu::make_upload_buffer(frames, (scene.lights.size() + 1) * sizeof(gpu::ShadowMapData),
                                      vk::BufferUsageFlagBits::eUniformTexelBuffer, "places of ray lights",
                                      gpu::Use::EdgeRays)) {
  const gpu::Device& device = frames.device();
  const CasterTriangles casters = caster_triangles(scene, plan);
  origin_ = casters.origin;
  CasterTexels texels = caster_texels(scene, casters, kMostEdgeRayBytes, device.max_texels);
  const bool fits = texels.bytes() <= kMostEdgeRayBytes && texels.triangles.size() <= device.max_texels;
  if (!fits) texels.triangles.resize(1);
  const std::uint64_t words_left = fits ? (kMostEdgeRayBytes - texels.bytes()) / sizeof(std::uint32_t) : 0;
  const std::vector<std::uint32_t> words =
      make_buffers(scene, casters, std::min(words_left, device.max_texels));
  words_ = on_device(device, words, "light buffers");
  triangles_ = on_device(device, texels.triangles, "caster triangles");
  alphas_ = on_device(device, texels.alphas, "alpha of casters");
  words_view_ = gpu::view_texels(device, words_, vk::Format::eR32Uint);
  triangles_view_ = gpu::view_texels(device, triangles_, vk::Format::eR32G32B32A32Sfloat);
  alphas_view_ = gpu::view_texels(device, alphas_, vk::Format::eR8Unorm);
  bindings_ = gpu::make_bindings(device, kRaySet, "edge rays");
  places_view_ = gpu::view_texels(device, places_.buffer(), vk::Format::eR32G32B32A32Sfloat);
  gpu::bind_texels(device, bindings_, 0, *places_view_);
  gpu::bind_texels(device, bindings_, 1, *words_view_);
  gpu::bind_texels(device, bindings_, 2, *triangles_view_);
  gpu::bind_texels(device, bindings_, 3, *alphas_view_);
}

/// Fills lights_, and returns the words of all buffers: one at least, because a buffer of the device has a
/// size.
std::vector<std::uint32_t> EdgeRays::make_buffers(const Scene& scene, const CasterTriangles& casters,
                                                  std::size_t most_words) {
  const SceneState state = state_at(scene, {});
  const std::vector<LightShadowMaps> projections = light_projections(scene, state.light_set.lights);
  std::vector<std::uint32_t> words{0};
  bool full = false;
  for (std::size_t i = 0; i < projections.size(); ++i) {
    Buffered light{state.light_set.lights[i], projections[i]};
    MapView& view = light.projection.view;
    light.projection.first_layer = narrow<std::uint32_t>(words.size());
    if (scene.nodes[scene.lights[i].node].moving || full) view.kind = FARSHADE_MAP_NONE;
    LightBuffer buffer;
    if (view.kind != FARSHADE_MAP_NONE) buffer = make_light_buffer(view, casters);
    if (words.size() + buffer.size() > most_words) {
      full = true;
      view.kind = FARSHADE_MAP_NONE;
      buffer.clear();
    }
    words.insert(words.end(), buffer.begin(), buffer.end());
    lights_.push_back(std::move(light));
  }
  return words;
}

LightBits EdgeRays::prepare(const StereoView& shown, const LightSet& lights) {
  LightBits usable{};
  for (std::size_t i = 0; i < lights_.size(); ++i) {
    places_.write(i, shadow_map_data(shown, lights_[i].projection));
    if (lights_[i].projection.view.kind != FARSHADE_MAP_NONE &&
        same_place(lights_[i].light, lights.lights[i]))
      usable[i / 32] |= 1u << i % 32;
  }
  LightShadowMaps origin;
  origin.view.origin = origin_;
  places_.write(lights_.size(), shadow_map_data(shown, origin));
  return usable;
}

}  // namespace farshade
