#include "vr_client/draw/scene_buffers.h"

namespace farshade {
namespace {

using Usage = vk::BufferUsageFlagBits;

template <class T>
gpu::Buffer stream(const gpu::Device& device, const std::vector<T>& values, vk::BufferUsageFlags usage,
                   const std::string& name) {
  if (values.empty()) return {};
  return gpu::make_filled_buffer(device, std::as_bytes(std::span(values)), usage, name);
}

MeshBuffers make_mesh(const gpu::Device& device, const Mesh& mesh) {
  MeshBuffers buffers;
  buffers.positions = stream(device, mesh.positions, Usage::eVertexBuffer, mesh.name + " positions");
  buffers.normals = stream(device, mesh.normals, Usage::eVertexBuffer, mesh.name + " normals");
  buffers.uvs = stream(device, mesh.uvs, Usage::eVertexBuffer, mesh.name + " uvs");
  buffers.colors = stream(device, mesh.colors, Usage::eVertexBuffer, mesh.name + " colors");
  buffers.indices = stream(device, mesh.triangles, Usage::eIndexBuffer, mesh.name + " indices");
  buffers.index_count = narrow<std::uint32_t>(mesh.triangles.size() * 3);
  buffers.low = buffers.high = mesh.positions.front();
  for (const glm::vec3& p : mesh.positions) {
    buffers.low = glm::min(buffers.low, p);
    buffers.high = glm::max(buffers.high, p);
  }
  return buffers;
}

vk::SamplerAddressMode address_mode(Wrap wrap) {
  switch (wrap) {
    case Wrap::MirroredRepeat:
      return vk::SamplerAddressMode::eMirroredRepeat;
    case Wrap::ClampToEdge:
      return vk::SamplerAddressMode::eClampToEdge;
    default:
      return vk::SamplerAddressMode::eRepeat;
  }
}

const std::vector<gpu::BindingKind> kTextureSet{
    {vk::DescriptorType::eCombinedImageSampler, vk::ShaderStageFlagBits::eFragment}};

TextureBuffers make_texture(const gpu::Device& device, const Texture& texture, const std::string& name) {
  TextureBuffers buffers;
  buffers.image =
      gpu::make_texture(device, texture.image.size, std::as_bytes(std::span(texture.image.pixels)), name);
  buffers.sampler = device.logical.createSampler({.magFilter = vk::Filter::eLinear,
                                                  .minFilter = vk::Filter::eLinear,
                                                  .mipmapMode = vk::SamplerMipmapMode::eLinear,
                                                  .addressModeU = address_mode(texture.wrap_u),
                                                  .addressModeV = address_mode(texture.wrap_v),
                                                  .maxLod = VK_LOD_CLAMP_NONE});
  buffers.bindings = gpu::make_bindings(device, kTextureSet, name);
  gpu::bind_image(device, buffers.bindings, 0,
                  {*buffers.image.view, vk::ImageLayout::eShaderReadOnlyOptimal, *buffers.sampler});
  return buffers;
}

}  // namespace

SceneBuffers make_scene_buffers(const gpu::Device& device, const Scene& scene) {
  SceneBuffers buffers;
  for (const Mesh& mesh : scene.meshes) buffers.meshes.push_back(make_mesh(device, mesh));
  for (const Texture& texture : scene.textures)
    buffers.textures.push_back(
        make_texture(device, texture, "texture " + std::to_string(buffers.textures.size())));
  buffers.texture_layout = gpu::make_layout(device, kTextureSet);
  return buffers;
}

}  // namespace farshade
