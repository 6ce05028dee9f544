#include "stereo/draw/scene_buffers.h"

#include <algorithm>

namespace farshade {
namespace {

using Usage = vk::BufferUsageFlagBits;

template <class T>
gpu::Buffer stream(const gpu::Device& device, const std::vector<T>& values, vk::BufferUsageFlags usage,
                   const std::string& name) {
  return gpu::make_filled_buffer(device, std::as_bytes(std::span(values)), usage, name, gpu::Use::Vertices);
}

/// A stream that the plan wants of a mesh without it, filled so that nothing changes by it.
template <class T>
std::vector<T> filled(const std::vector<T>& values, std::size_t count, T neutral) {
  return values.empty() ? std::vector<T>(count, neutral) : values;
}

/// What a mesh's vertices are sent relative to. One that lies far from its own origin, as in map coordinates,
/// would lose its digits where the device adds up float products; all others stay as they are. (The
/// relative-to-centre method: P. Cozzi, K. Ring, "3D Engine Design for Virtual Globes", 2011, chapter 5.)
glm::dvec3 center_of(const std::vector<glm::vec3>& positions) {
  constexpr double kFar = 16;  // times its own half size
  glm::dvec3 low(positions.front()), high(low);
  for (const glm::vec3& p : positions)
    low = glm::min(low, glm::dvec3(p)), high = glm::max(high, glm::dvec3(p));
  const glm::dvec3 center = (low + high) * 0.5;
  return glm::length(center) > kFar * 0.5 * glm::length(high - low) ? center : glm::dvec3(0.0);
}

std::vector<glm::vec3> relative_to(const glm::dvec3& center, std::vector<glm::vec3> positions) {
  for (glm::vec3& p : positions) p = glm::vec3(glm::dvec3(p) - center);
  return positions;
}

MeshBuffers make_mesh(const gpu::Device& device, const Scene& scene, const Mesh& mesh,
                      const SurfaceNeeds& needs) {
  const std::size_t count = mesh.positions.size();
  MeshBuffers buffers;
  buffers.bytes = stream_bytes(mesh, needs);
  buffers.texture = texture_of(scene, mesh, needs);
  buffers.center = center_of(mesh.positions);
  const std::vector<glm::vec3> positions = relative_to(buffers.center, mesh.positions);
  buffers.positions = stream(device, positions, Usage::eVertexBuffer, mesh.name + " positions");
  buffers.normals = stream(device, mesh.normals, Usage::eVertexBuffer, mesh.name + " normals");
  if (needs.texture)
    buffers.uvs =
        stream(device, filled(mesh.uvs, count, glm::vec2(0)), Usage::eVertexBuffer, mesh.name + " uvs");
  if (needs.vertex_color)
    buffers.colors = stream(device, filled(mesh.colors, count, glm::u8vec4(255)), Usage::eVertexBuffer,
                            mesh.name + " colors");
  buffers.indices = stream(device, mesh.triangles, Usage::eIndexBuffer, mesh.name + " indices");
  buffers.index_count = narrow<std::uint32_t>(mesh.triangles.size() * 3);
  buffers.low = buffers.high = positions.front();
  for (const glm::vec3& p : positions) {
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

const Texture& white_pixel() {
  static const Texture white = [] {
    Texture texture{.image = Image<Rgba8>({1, 1})};
    texture.image.pixels[0] = Rgba8(255);
    return texture;
  }();
  return white;
}

}  // namespace

StreamBytes stream_bytes(const Mesh& mesh, const SurfaceNeeds& needs) {
  const std::size_t count = mesh.positions.size();
  return {.positions = count * sizeof(glm::vec3),
          .normals = count * sizeof(glm::vec3),
          .uvs = needs.texture ? count * sizeof(glm::vec2) : 0,
          .colors = needs.vertex_color ? count * sizeof(glm::u8vec4) : 0,
          .indices = mesh.triangles.size() * sizeof(glm::uvec3)};
}

std::optional<std::size_t> texture_of(const Scene& scene, const Mesh& mesh, const SurfaceNeeds& needs) {
  if (!needs.texture) return std::nullopt;
  const std::optional<std::uint32_t> texture = scene.materials[mesh.material].texture;
  return texture && !mesh.uvs.empty() ? *texture : scene.textures.size();
}

std::vector<bool> textures_read(const Scene& scene, const DrawPlan& plan) {
  std::vector<bool> read(scene.textures.size() + 1, false);
  for (std::size_t mesh = 0; mesh < scene.meshes.size(); ++mesh)
    if (const auto texture = texture_of(scene, scene.meshes[mesh], plan.surfaces[mesh]))
      read[*texture] = true;
  return read;
}

SceneBuffers make_scene_buffers(const gpu::Device& device, const Scene& scene, const DrawPlan& plan) {
  check_eq(plan.surfaces.size(), scene.meshes.size(), "the plan is the scene's");
  SceneBuffers buffers;
  for (std::size_t mesh = 0; mesh < scene.meshes.size(); ++mesh)
    buffers.meshes.push_back(make_mesh(device, scene, scene.meshes[mesh], plan.surfaces[mesh]));
  const std::vector<bool> read = textures_read(scene, plan);
  for (std::size_t i = 0; i < read.size(); ++i)
    buffers.textures.push_back(
        read[i] ? make_texture(device, i < scene.textures.size() ? scene.textures[i] : white_pixel(),
                               "texture " + std::to_string(i))
                : TextureBuffers{});
  if (std::ranges::find(read, true) != read.end())
    buffers.texture_layout = gpu::make_layout(device, kTextureSet);
  return buffers;
}

}  // namespace farshade
