#include "stereo/edge_rays/edge_rays.h"

#include <algorithm>
#include <bit>
#include <chrono>

#include "stereo/gpu/upload.h"

namespace farshade {
namespace {

constexpr std::size_t kStaging_bytes = 16 << 20;

const std::vector<gpu::BindingKind> kRaySet{
    {vk::DescriptorType::eUniformTexelBuffer, vk::ShaderStageFlagBits::eCompute},
    {vk::DescriptorType::eUniformTexelBuffer, vk::ShaderStageFlagBits::eCompute},
    {vk::DescriptorType::eUniformTexelBuffer, vk::ShaderStageFlagBits::eCompute},
    {vk::DescriptorType::eUniformTexelBuffer, vk::ShaderStageFlagBits::eCompute}};

/// Whether rays to `now` may use the buffer that was made for `then`.
bool same_place(const Light& then, const Light& now) {
  if (now.kind == LightKind::Directional) return then.direction == now.direction;
  return then.position == now.position && (now.kind == LightKind::Point || then.direction == now.direction);
}

/// A buffer has a size, even without content.
template <class T>
EdgeRays::Texels on_device(const gpu::Device& device, const std::vector<T>& content, vk::Format format,
                           const char* name) {
  const std::span<const std::byte> bytes = std::as_bytes(std::span(content));
  EdgeRays::Texels texels;
  texels.buffer = gpu::make_device_buffer(
      device, std::max(bytes.size(), sizeof(T)),
      vk::BufferUsageFlagBits::eUniformTexelBuffer | vk::BufferUsageFlagBits::eTransferDst, name,
      gpu::Use::EdgeRays);
  texels.view = gpu::view_texels(device, texels.buffer, format);
  gpu::BufferUpload upload(device, std::min(texels.buffer.bytes, kStaging_bytes));
  upload.write(texels.buffer, 0, bytes);
  upload.flush();
  return texels;
}

}  // namespace

EdgeRays::EdgeRays(gpu::FramesInFlight& frames, std::size_t lights, FutureEdgeRayData data)
    : device_(frames.device()),
      data_(std::move(data)),
      places_(gpu::make_upload_buffer(frames, (lights + 1) * sizeof(gpu::ShadowMapData),
                                      vk::BufferUsageFlagBits::eUniformTexelBuffer, "places of ray lights",
                                      gpu::Use::EdgeRays)),
      places_view_(gpu::view_texels(device_, places_.buffer(), vk::Format::eR32G32B32A32Sfloat)),
      bindings_(gpu::make_bindings(device_, kRaySet, "edge rays")) {
  gpu::bind_texels(device_, bindings_, 0, *places_view_);
  load({});
}

void EdgeRays::load(const EdgeRayData& data) {
  Texels words = on_device(device_, data.words, vk::Format::eR32Uint, "light buffers");
  Texels triangles =
      on_device(device_, data.texels.triangles, vk::Format::eR32G32B32A32Sfloat, "caster triangles");
  Texels alphas = on_device(device_, data.texels.alphas, vk::Format::eR8Unorm, "alpha of casters");
  words_ = std::move(words);
  triangles_ = std::move(triangles);
  alphas_ = std::move(alphas);
  gpu::bind_texels(device_, bindings_, 1, *words_.view);
  gpu::bind_texels(device_, bindings_, 2, *triangles_.view);
  gpu::bind_texels(device_, bindings_, 3, *alphas_.view);
}

/// No frame on the device reads the set, because no ray has been traced so far.
void EdgeRays::take_if_ready() {
  if (is_loaded_ || !data_.valid() || data_.wait_for(std::chrono::seconds(0)) != std::future_status::ready)
    return;
  const EdgeRayData& data = data_.get();
  is_loaded_ = data.buffers() > 0 && std::max({data.words.size(), data.texels.triangles.size(),
                                               data.texels.alphas.size()}) <= device_.max_texels;
  try {
    if (is_loaded_) load(data);
  } catch (const vk::DeviceLostError&) {
    throw;
  } catch (const std::exception&) {  // no memory, or beyond a limit of the device
    is_loaded_ = false;
  }
  if (!is_loaded_) data_ = {};
}

LightBits EdgeRays::prepare(const StereoView& shown, const LightSet& lights) {
  take_if_ready();
  if (!is_loaded_) return {};
  const EdgeRayData& data = data_.get();
  LightBits usable{};
  for (std::size_t i = 0; i < data.lights.size(); ++i) {
    const EdgeRayData::Buffered& light = data.lights[i];
    gpu::ShadowMapData place = shadow_map_data(shown, light.projection);
    place.ahead.w = static_cast<float>(light.depths.first_m);
    place.place.z = light.depths.number_bits;
    place.place.w = std::bit_cast<std::uint32_t>(static_cast<float>(light.depths.step_m));
    places_.write(i, place);
    if (light.projection.view.kind != FARSHADE_MAP_NONE && same_place(light.light, lights.lights[i]))
      usable[i / 32] |= 1u << i % 32;
  }
  LightShadowMaps origin;
  origin.view.origin = data.origin;
  places_.write(data.lights.size(), shadow_map_data(shown, origin));
  return usable;
}

}  // namespace farshade
