#include "stereo/gltf/gltf_materials.h"

#include <algorithm>
#include <set>

#include "stereo/gltf/gltf_accessor.h"
#include "stereo/image/codec.h"

namespace farshade::gltf {
namespace {

using tinygltf::Value;

/// The alpha test of a material, whose mode must be known.
std::optional<float> cutoff_from(const Material& material) {
  if (material.alphaMode == "BLEND") return 0.5f;
  if (material.alphaMode != "MASK") return {};
  return static_cast<float>(std::min(material.alphaCutoff, 1e30));
}

/// The bytes of an image's file, or why they cannot be read.
Expected<ByteSpan> file_of(const Document& document, std::uint32_t index) {
  const tinygltf::Image& image = document.images[index];
  if (image.bufferView >= 0) return bytes_of_view(document, image.bufferView);
  if (const auto& why = document.unreadable[index]) return tl::unexpected(*why);
  return ByteSpan(image.image);
}

/// False for a format that no library of Debian decodes.
bool is_known(ByteSpan file) {
  using namespace std::string_view_literals;
  const std::string_view text(reinterpret_cast<const char*>(file.data()), file.size());
  return !text.starts_with("\xabKTX 20\xbb"sv) && !(text.size() > 12 && text.substr(4, 8) == "ftypavif"sv);
}

/// Light passes through a material that transmits more than this, and so do eyes, as with BLEND.
constexpr double kOpaqueTransmission = 0.5;

bool lets_light_through(const Material& material) {
  const Value* factor =
      member(extension(material.extensions, "KHR_materials_transmission"), "transmissionFactor");
  return factor && factor->GetNumberAsDouble() > kOpaqueTransmission;
}

/// SceneLimits::all_image_pixels says why.
constexpr std::uint64_t kMostPixelsPerByte = 16;
/// Damaged images up to SceneLimits::image_pixels that a file may have. They cost as much time as others.
constexpr std::uint32_t kMostDamaged = 8;

/// The smallest alpha of a texture, 0 to 1.
float least_alpha(const farshade::Texture& texture) {
  std::uint8_t least = 255;
  for (const Rgba8 pixel : texture.image.pixels) least = std::min(least, pixel.a);
  return static_cast<float>(least) / 255.0f;
}

}  // namespace

glm::dvec4 base_color_of(const Material& material) {
  const auto color = vector_of(material.pbrMetallicRoughness.baseColorFactor, glm::dvec4(1.0));
  return vector_member(extension(material.extensions, "KHR_materials_pbrSpecularGlossiness"), "diffuseFactor",
                       color);
}

std::optional<TextureUse> texture_of(const Material& material) {
  const auto& base_color = material.pbrMetallicRoughness.baseColorTexture;
  const Value* diffuse =
      member(extension(material.extensions, "KHR_materials_pbrSpecularGlossiness"), "diffuseTexture");
  const Index texture = diffuse ? index_member(diffuse, "index") : index_of(base_color.index);
  if (!texture) return std::nullopt;
  const Index texcoord = diffuse ? index_member(diffuse, "texCoord") : index_of(base_color.texCoord);
  const Value* transform = diffuse ? member(member(diffuse, "extensions"), "KHR_texture_transform")
                                   : extension(base_color.extensions, "KHR_texture_transform");
  TextureUse use{.texture = *texture, .texcoord = texcoord.value_or(0)};
  use.texcoord = index_member(transform, "texCoord").value_or(use.texcoord);
  use.offset = vector_member(transform, "offset", use.offset);
  use.scale = vector_member(transform, "scale", use.scale);
  if (const Value* rotation = member(transform, "rotation")) use.rotation_rad = rotation->GetNumberAsDouble();
  return use;
}

MaterialConverter::MaterialConverter(Document& document, const SceneLimits& limits, Scene& scene)
    : document_(document), limits_(limits), scene_(scene), pixels_left_(limits.image_pixels) {
  std::set<int> views;  // a file counts once, whatever number of images it is
  for (std::uint32_t i = 0; i < document.images.size(); ++i) {
    const int view = document.images[i].bufferView;
    if (view >= 0 && !views.insert(view).second) continue;
    if (const auto file = file_of(document, i)) pixels_left_ += kMostPixelsPerByte * file->size();
  }
  pixels_left_ = std::min(pixels_left_, limits.all_image_pixels);
}

std::uint32_t MaterialConverter::material(Index index) {
  if (const auto known = materials_.find(index); known != materials_.end()) return known->second;
  farshade::Material result;
  if (index) {
    const Material& from = document_.materials[*index];
    const std::string name = label("material", *index, from.name);
    const glm::dvec4 color = base_color_of(from), within = glm::clamp(color, 0.0, 1.0);
    if (color != within)
      document_.repairs.add("it is cut off", name + ": the base colour factor is outside of 0 to 1");
    if (from.alphaMode != "OPAQUE" && from.alphaMode != "MASK" && from.alphaMode != "BLEND")
      document_.repairs.add("it is opaque",
                            name + ": unknown alpha mode '" + printable(from.alphaMode) + "'");
    result.name = from.name;
    result.base_color = glm::vec4(within);
    result.alpha_cutoff = cutoff_from(from);
    if (lets_light_through(from)) result.base_color.a = 0, result.alpha_cutoff = 0.5f;
    result.double_sided = from.doubleSided;
    result.unlit = extension(from.extensions, "KHR_materials_unlit") != nullptr;
    result.glows = vector_of(from.emissiveFactor, glm::dvec3(0.0)) != glm::dvec3(0.0);
    const auto use = texture_of(from);
    const Expected<Index> texture_index = use ? texture(name, use->texture) : Index{};
    if (!texture_index) document_.repairs.add("the base colour factor is drawn", texture_index.error());
    result.texture = texture_index.value_or(Index{});
  }
  scene_.materials.push_back(std::move(result));
  return materials_[index] = static_cast<std::uint32_t>(scene_.materials.size() - 1);
}

Wrap MaterialConverter::wrap_from(int sampler, int code) {
  if (code == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT) return Wrap::MirroredRepeat;
  if (code == TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE) return Wrap::ClampToEdge;
  if (code != TINYGLTF_TEXTURE_WRAP_REPEAT)
    document_.repairs.add("it repeats",
                          label("sampler", sampler) + ": unknown wrap mode " + std::to_string(code));
  return Wrap::Repeat;
}

/// `user` names the material.
Expected<Index> MaterialConverter::texture(const std::string& user, std::uint32_t index) {
  if (index >= document_.textures.size()) return malformed(user + ": there is no " + label("texture", index));
  const tinygltf::Texture& from = document_.textures[index];
  const std::string name = label("texture", index, from.name);
  // That of EXT_texture_webp, else the one that every program can read.
  const Index webp = index_member(extension(from.extensions, "EXT_texture_webp"), "source"),
              source = webp ? webp : index_of(from.source);
  if (source && *source >= document_.images.size())
    return malformed(name + ": there is no " + label("image", *source));
  const auto file = source ? file_of(document_, *source) : Expected<ByteSpan>();
  if (!source || (file && !is_known(*file))) {
    const std::string warning = "textures without a PNG, JPEG or WebP image are left out";
    if (std::ranges::find(scene_.warnings, warning) == scene_.warnings.end())
      scene_.warnings.push_back(warning);
    return Index{};
  }
  int sampler = from.sampler;
  if (!points_into(document_.samplers, sampler)) {
    document_.repairs.add("it repeats", name + ": there is no " + label("sampler", sampler));
    sampler = -1;
  }
  const auto wraps = sampler < 0 ? tinygltf::Sampler{} : at(document_.samplers, sampler);
  const TextureKey key{*source, wrap_from(sampler, wraps.wrapS), wrap_from(sampler, wraps.wrapT)};
  if (const auto known = textures_.find(key); known != textures_.end()) return known->second;
  auto image = decode(*source);
  textures_[key] = image ? Index{static_cast<std::uint32_t>(scene_.textures.size())} : Index{};
  if (!image)
    return fail(image.error().fault,
                label("image", *source, document_.images[*source].name) + ": " + image.error().what);
  scene_.textures.push_back({std::move(*image), std::get<1>(key), std::get<2>(key)});
  return textures_[key];
}

Expected<farshade::Image<Rgba8>> MaterialConverter::decode(std::uint32_t index) {
  const auto file = file_of(document_, index);
  if (!file) return tl::unexpected(file.error());
  const std::uint64_t usual = kMostPixelsPerByte * file->size();
  const std::uint64_t most = damaged_ < kMostDamaged ? limits_.image_pixels : usual;
  auto image = decode_image(std::as_bytes(*file), std::min({limits_.image_pixels, most, pixels_left_}));
  const bool is_damaged = !image && image.error().fault == Fault::Malformed;
  damaged_ += is_damaged;
  pixels_left_ -= std::min(pixels_left_, image ? image->size.pixels() : is_damaged ? usual : 0);
  return image;
}

void remove_needless_alpha_tests(Scene& scene) {
  std::vector<std::uint8_t> least_color(scene.materials.size(), 255);
  for (const farshade::Mesh& mesh : scene.meshes)
    for (const glm::u8vec4 color : mesh.colors)
      least_color[mesh.material] = std::min(least_color[mesh.material], color.a);
  for (std::size_t i = 0; i < least_color.size(); ++i) {
    farshade::Material& material = scene.materials[i];
    if (!material.alpha_cutoff) continue;
    const float of_texture = material.texture ? least_alpha(scene.textures[*material.texture]) : 1.0f,
                least = material.base_color.a * of_texture * static_cast<float>(least_color[i]) / 255.0f;
    if (least >= *material.alpha_cutoff) material.alpha_cutoff.reset();
  }
}

}  // namespace farshade::gltf
