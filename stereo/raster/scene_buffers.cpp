#include "stereo/raster/scene_buffers.h"

#include <tbb/parallel_pipeline.h>

#include <algorithm>
#include <map>
#include <type_traits>
#include <utility>

#include "stereo/image/mip_levels.h"

namespace farshade {
namespace {

using Usage = vk::BufferUsageFlagBits;

/// Places each mesh's streams one after the other.
class VertexLayout {
 public:
  [[nodiscard]] StreamBytes add(const StreamBytes& bytes) {
    StreamBytes offsets;
    offsets.positions = vertex_bytes_;
    offsets.normals = offsets.positions + bytes.positions;
    offsets.uvs = offsets.normals + bytes.normals;
    offsets.colors = offsets.uvs + bytes.uvs;
    offsets.indices = index_bytes_;
    vertex_bytes_ += bytes.vertices();
    index_bytes_ += bytes.indices;
    return offsets;
  }

 private:
  std::size_t vertex_bytes_ = 0, index_bytes_ = 0;
};

/// Copies a mesh's streams to where `mesh` places them.
void upload(const MeshStreams& streams, const SceneBuffers& buffers, gpu::BufferUpload& uploads,
            const DeviceMesh& mesh) {
  const auto write = [&](const gpu::Buffer& target, std::size_t offset, const auto& values) {
    if (!values.empty()) uploads.write(target, offset, std::as_bytes(std::span(values)));
  };
  write(buffers.vertices, mesh.offsets.positions, streams.positions);
  write(buffers.vertices, mesh.offsets.normals, streams.normals);
  write(buffers.vertices, mesh.offsets.uvs, streams.uvs);
  write(buffers.vertices, mesh.offsets.colors, streams.colors);
  write(buffers.indices, mesh.offsets.indices, streams.indices);
}

/// Calls take(i, make(i)) for i from 0 to count - 1, in this order, while others are made side by side. Only
/// a few wait to be taken.
template <class Make, class Take>
void for_each_in_order(std::size_t count, Make make, Take take) {
  constexpr std::size_t kMostWaiting = 16;
  using Made = std::pair<std::size_t, std::invoke_result_t<Make, std::size_t>>;
  std::size_t next = 0;
  const auto number = [&](tbb::flow_control& flow) {
    if (next == count) flow.stop();
    return next++;
  };
  tbb::parallel_pipeline(
      kMostWaiting,
      tbb::make_filter<void, std::size_t>(tbb::filter_mode::serial_in_order, number) &
          tbb::make_filter<std::size_t, Made>(tbb::filter_mode::parallel,
                                              [&](std::size_t i) { return Made(i, make(i)); }) &
          tbb::make_filter<Made, void>(tbb::filter_mode::serial_in_order,
                                       [&](const Made& made) { take(made.first, made.second); }));
}

void make_meshes(const gpu::Device& device, const Scene& scene, const DrawPlan& plan,
                 const SceneLevels& levels, SceneBuffers& buffers) {
  const StreamBytes all = stream_bytes(scene, plan, levels);
  buffers.vertices = gpu::make_device_buffer(
      device, all.vertices(), Usage::eVertexBuffer | Usage::eTransferDst, "vertices", gpu::Use::Vertices);
  buffers.indices = gpu::make_device_buffer(device, all.indices, Usage::eIndexBuffer | Usage::eTransferDst,
                                            "indices", gpu::Use::Vertices);
  gpu::BufferUpload uploads(device, std::min(all.total(), kStagingBytes));
  VertexLayout layout;
  for_each_in_order(
      scene.meshes.size(),
      [&](std::size_t i) { return make_streams(scene.meshes[i], plan.surfaces[i], levels_of(levels, i)); },
      [&](std::size_t i, const MeshStreams& streams) {
        const Mesh& source = scene.meshes[i];
        const MeshLevels& own = levels_of(levels, i);
        DeviceMesh mesh{.bytes = stream_bytes(source, plan.surfaces[i], own),
                        .offsets = {},
                        .texture = texture_of(scene, source, plan.surfaces[i]),
                        .index_type = index_bytes(source.positions.size()) == 2 ? vk::IndexType::eUint16
                                                                                : vk::IndexType::eUint32,
                        .ranges = streams.ranges,
                        .levels = own.levels,
                        .center = streams.center,
                        .box = bounds_of(streams.positions)};
        mesh.offsets = layout.add(mesh.bytes);
        upload(streams, buffers, uploads, mesh);
        buffers.meshes.push_back(std::move(mesh));
      });
  uploads.flush();
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

vk::raii::Sampler make_sampler(const gpu::Device& device, Wrap u, Wrap v) {
  return device.logical.createSampler({.magFilter = vk::Filter::eLinear,
                                       .minFilter = vk::Filter::eLinear,
                                       .mipmapMode = vk::SamplerMipmapMode::eLinear,
                                       .addressModeU = address_mode(u),
                                       .addressModeV = address_mode(v),
                                       .maxLod = VK_LOD_CLAMP_NONE});
}

const std::vector<gpu::BindingKind> kTextureSet{
    {vk::DescriptorType::eCombinedImageSampler, vk::ShaderStageFlagBits::eFragment}};

const Texture& white_pixel() {
  static const Texture white = [] {
    Texture texture{.image = Image<Rgba8>({1, 1})};
    texture.image.pixels[0] = Rgba8(255);
    return texture;
  }();
  return white;
}

const Texture& texture_at(const Scene& scene, std::size_t i) {
  return i < scene.textures.size() ? scene.textures[i] : white_pixel();
}

/// The images of the given textures. Their mip levels are made side by side.
gpu::ImageGroup make_images(const gpu::Device& device, const Scene& scene,
                            const std::vector<std::size_t>& textures) {
  std::vector<gpu::TextureSize> sizes;
  for (const std::size_t i : textures) {
    const Extent size = texture_at(scene, i).image.size;
    sizes.push_back({size, mip_count(size)});
  }
  gpu::ImageGroup group = gpu::make_textures(device, sizes);
  for_each_in_order(
      textures.size(), [&](std::size_t i) { return smaller_levels(texture_at(scene, textures[i]).image); },
      [&](std::size_t i, const std::vector<Rgba8>& smaller) {
        gpu::fill_texture(device, group.images[i],
                          std::as_bytes(std::span(texture_at(scene, textures[i]).image.pixels)),
                          std::as_bytes(std::span(smaller)));
      });
  return group;
}

/// One sampler for each pair of wrap modes in use: Vulkan guarantees only 4,000 samplers.
void make_textures(const gpu::Device& device, const Scene& scene, const DrawPlan& plan,
                   SceneBuffers& buffers) {
  const std::vector<bool> read = textures_read(scene, plan);
  buffers.texture_sets.resize(read.size());
  std::vector<std::size_t> used;
  for (std::size_t i = 0; i < read.size(); ++i)
    if (read[i]) used.push_back(i);
  if (used.empty()) return;
  buffers.textures = make_images(device, scene, used);
  buffers.texture_layout = gpu::make_layout(device, kTextureSet);
  std::map<std::pair<Wrap, Wrap>, std::size_t> samplers;
  for (std::size_t n = 0; n < used.size(); ++n) {
    const Texture& texture = texture_at(scene, used[n]);
    const std::pair wraps(texture.wrap_u, texture.wrap_v);
    const auto [sampler, is_new] = samplers.try_emplace(wraps, buffers.samplers.size());
    if (is_new) buffers.samplers.push_back(make_sampler(device, wraps.first, wraps.second));
    gpu::Bindings& set = buffers.texture_sets[used[n]];
    set = gpu::make_bindings(device, kTextureSet, "texture " + std::to_string(used[n]));
    gpu::bind_image(device, set, 0,
                    {*buffers.textures.images[n].view, vk::ImageLayout::eShaderReadOnlyOptimal,
                     *buffers.samplers[sampler->second]});
  }
}

}  // namespace

StreamBytes stream_bytes(const Scene& scene, const DrawPlan& plan, const SceneLevels& levels) {
  check_eq(plan.surfaces.size(), scene.meshes.size(), "the plan is the scene's");
  check(levels.empty() || levels.size() == scene.meshes.size(), "the levels are the scene's");
  StreamBytes sum;
  for (std::size_t i = 0; i < scene.meshes.size(); ++i) {
    const StreamBytes bytes = stream_bytes(scene.meshes[i], plan.surfaces[i], levels_of(levels, i));
    sum.positions += bytes.positions;
    sum.normals += bytes.normals;
    sum.uvs += bytes.uvs;
    sum.colors += bytes.colors;
    sum.indices += bytes.indices;
  }
  return sum;
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

SceneBuffers make_scene_buffers(gpu::FramesInFlight& frames, const Scene& scene, const DrawPlan& plan,
                                const SceneLevels& levels) {
  SceneBuffers buffers;
  make_meshes(frames.device(), scene, plan, levels, buffers);
  buffers.deformed = std::make_unique<DeformedVertices>(frames, scene, plan);
  make_textures(frames.device(), scene, plan, buffers);
  return buffers;
}

}  // namespace farshade
