#include "stereo/gltf/gltf_materials.h"

#include <algorithm>
#include <set>

#include "stereo/image/codec.h"

namespace farshade::gltf {
namespace {

using tinygltf::Value;

Wrap wrap_from(int code) {
  return code == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT ? Wrap::MirroredRepeat
         : code == TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE ? Wrap::ClampToEdge
                                                       : Wrap::Repeat;
}

std::optional<float> cutoff_from(const Material& material) {
  if (material.alphaMode == "BLEND") return 0.5f;
  if (material.alphaMode == "OPAQUE") return {};
  return static_cast<float>(material.alphaCutoff);
}

std::span<const std::uint8_t> file_of(const Document& document, const tinygltf::Image& image) {
  if (image.bufferView < 0) return image.image;
  const BufferView& view = at(document.bufferViews, image.bufferView);
  return std::span(at(document.buffers, view.buffer).data).subspan(view.byteOffset, view.byteLength);
}

TextureUse texture_use(std::uint32_t texture, std::uint32_t texcoord, const Value* transform) {
  TextureUse use{.texture = texture, .texcoord = texcoord};
  if (!transform) return use;
  use.offset = vector_member(*transform, "offset", use.offset);
  use.scale = vector_member(*transform, "scale", use.scale);
  if (const Value* rotation = member(*transform, "rotation"))
    use.rotation_rad = rotation->GetNumberAsDouble();
  use.texcoord = index_member(*transform, "texCoord").value_or(texcoord);
  return use;
}

/// SceneLimits::all_image_pixels says why.
constexpr std::uint64_t kMostPixelsPerByte = 16;

/// The smallest alpha of a texture, 0 to 1.
float least_alpha(const farshade::Texture& texture) {
  std::uint8_t least = 255;
  for (const Rgba8 pixel : texture.image.pixels) least = std::min(least, pixel.a);
  return static_cast<float>(least) / 255.0f;
}

}  // namespace

glm::dvec4 base_color_of(const Material& material) {
  const auto color = vector_of(material.pbrMetallicRoughness.baseColorFactor, glm::dvec4(1.0));
  const Value* diffuse = extension(material.extensions, "KHR_materials_pbrSpecularGlossiness");
  return diffuse ? vector_member(*diffuse, "diffuseFactor", color) : color;
}

std::optional<TextureUse> texture_of(const Material& material) {
  const Value* diffuse = extension(material.extensions, "KHR_materials_pbrSpecularGlossiness");
  if (const Value* from = diffuse ? member(*diffuse, "diffuseTexture") : nullptr) {
    const Value* extensions = member(*from, "extensions");
    return texture_use(index_member(*from, "index").value_or(0), index_member(*from, "texCoord").value_or(0),
                       extensions ? member(*extensions, "KHR_texture_transform") : nullptr);
  }
  const tinygltf::TextureInfo& from = material.pbrMetallicRoughness.baseColorTexture;
  const Index texture = index_of(from.index);
  if (!texture) return std::nullopt;
  return texture_use(*texture, static_cast<std::uint32_t>(from.texCoord),
                     extension(from.extensions, "KHR_texture_transform"));
}

MaterialConverter::MaterialConverter(const Document& document, const SceneLimits& limits, Scene& scene)
    : document_(document), limits_(limits), scene_(scene), pixels_left_(limits.image_pixels) {
  std::set<int> views;  // a file counts once, whatever number of images it is
  for (const tinygltf::Image& image : document.images)
    if (image.bufferView < 0 || views.insert(image.bufferView).second)
      pixels_left_ += kMostPixelsPerByte * file_of(document, image).size();
  pixels_left_ = std::min(pixels_left_, limits.all_image_pixels);
}

Expected<std::uint32_t> MaterialConverter::material(Index index) {
  if (const auto known = materials_.find(index); known != materials_.end()) return known->second;
  farshade::Material result;
  if (index) {
    const Material& from = document_.materials[*index];
    result.name = from.name;
    result.base_color = glm::vec4(base_color_of(from));
    result.alpha_cutoff = cutoff_from(from);
    result.double_sided = from.doubleSided;
    result.unlit = extension(from.extensions, "KHR_materials_unlit") != nullptr;
    const std::optional<TextureUse> use = texture_of(from);
    const bool has_image = use && is_readable(image_of(document_.textures[use->texture]));
    if (use && !has_image) leave_out_texture();
    if (has_image) {
      const auto number = texture(use->texture);
      if (!number) return tl::unexpected(number.error());
      result.texture = *number;
    }
  }
  scene_.materials.push_back(std::move(result));
  return materials_[index] = static_cast<std::uint32_t>(scene_.materials.size() - 1);
}

/// False for no image, and for a format that no library of Debian decodes: the base colour factor is drawn.
bool MaterialConverter::is_readable(Index image) const {
  using namespace std::string_view_literals;
  if (!image) return false;
  const auto file = file_of(document_, document_.images[*image]);
  const std::string_view text(reinterpret_cast<const char*>(file.data()), file.size());
  return !text.starts_with("\xabKTX 20\xbb"sv) && !(text.size() > 12 && text.substr(4, 8) == "ftypavif"sv);
}

void MaterialConverter::leave_out_texture() {
  if (leaves_out_texture_) return;
  leaves_out_texture_ = true;
  scene_.warnings.emplace_back("textures without a PNG, JPEG or WebP image are left out");
}

Expected<std::uint32_t> MaterialConverter::texture(std::uint32_t index) {
  const tinygltf::Texture& from = document_.textures[index];
  const std::uint32_t source = *image_of(from);
  const auto sampler = from.sampler < 0 ? tinygltf::Sampler{} : at(document_.samplers, from.sampler);
  const TextureKey key{source, wrap_from(sampler.wrapS), wrap_from(sampler.wrapT)};
  if (const auto known = textures_.find(key); known != textures_.end()) return known->second;
  auto image = decode(source);
  if (!image) return tl::unexpected(image.error());
  scene_.textures.push_back({std::move(*image), std::get<1>(key), std::get<2>(key)});
  return textures_[key] = static_cast<std::uint32_t>(scene_.textures.size() - 1);
}

Expected<farshade::Image<Rgba8>> MaterialConverter::decode(std::uint32_t index) {
  const tinygltf::Image& from = document_.images[index];
  const std::string name = label("image", index, from.name);
  if (const auto& why = document_.unreadable[index]) return fail(why->fault, name + ": " + why->what);
  auto image =
      decode_image(std::as_bytes(file_of(document_, from)), std::min(limits_.image_pixels, pixels_left_));
  if (!image) return fail(image.error().fault, name + ": " + image.error().what);
  pixels_left_ -= image->size.pixels();
  return image;
}

void remove_needless_alpha_tests(Scene& scene) {
  std::vector<float> least(scene.materials.size());
  for (std::size_t i = 0; i < least.size(); ++i) {
    const farshade::Material& material = scene.materials[i];
    if (!material.alpha_cutoff) continue;
    least[i] =
        material.base_color.a * (material.texture ? least_alpha(scene.textures[*material.texture]) : 1.0f);
  }
  std::vector<std::uint8_t> least_color(scene.materials.size(), 255);
  for (const farshade::Mesh& mesh : scene.meshes)
    for (const glm::u8vec4 color : mesh.colors)
      least_color[mesh.material] = std::min(least_color[mesh.material], color.a);
  for (std::size_t i = 0; i < least.size(); ++i) {
    auto& cutoff = scene.materials[i].alpha_cutoff;
    if (cutoff && least[i] * static_cast<float>(least_color[i]) / 255.0f >= *cutoff) cutoff.reset();
  }
}

}  // namespace farshade::gltf
