#include "stereo/scene/gltf_materials.h"

#include <algorithm>
#include <set>

#include "stereo/image/codec.h"

namespace farshade::gltf {
namespace {

Wrap wrap_from(std::uint32_t code) {
  return code == 33648 ? Wrap::MirroredRepeat : code == 33071 ? Wrap::ClampToEdge : Wrap::Repeat;
}

std::optional<float> cutoff_from(const Material& material) {
  if (material.alpha_mode == "BLEND") return 0.5f;
  if (material.alpha_mode == "OPAQUE") return {};
  return static_cast<float>(material.alpha_cutoff);
}

std::span<const std::uint8_t> file_of(const Document& document, const Image& image) {
  if (!image.view) return image.file;
  const BufferView& view = document.views[*image.view];
  return std::span(document.buffers[view.buffer]).subspan(view.offset, view.bytes);
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

MaterialConverter::MaterialConverter(const Document& document, const SceneLimits& limits, Scene& scene)
    : document_(document), limits_(limits), scene_(scene), pixels_left_(limits.image_pixels) {
  std::set<std::uint32_t> views;  // a file counts once, whatever number of images it is
  for (const Image& image : document.images)
    if (!image.view || views.insert(*image.view).second)
      pixels_left_ += kMostPixelsPerByte * file_of(document, image).size();
  pixels_left_ = std::min(pixels_left_, limits.all_image_pixels);
}

Expected<std::uint32_t> MaterialConverter::material(Index index) {
  if (const auto known = materials_.find(index); known != materials_.end()) return known->second;
  farshade::Material result;
  if (index) {
    const Material& from = document_.materials[*index];
    result.name = from.name;
    result.base_color = glm::vec4(from.base_color);
    result.alpha_cutoff = cutoff_from(from);
    result.double_sided = from.double_sided;
    result.unlit = from.unlit;
    const bool has_image = from.texture && is_readable(document_.textures[from.texture->texture].image);
    if (from.texture && !has_image) leave_out_texture();
    if (has_image) {
      const auto number = texture(from.texture->texture);
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
  const Texture& from = document_.textures[index];
  const TextureSampler sampler = from.sampler ? document_.texture_samplers[*from.sampler] : TextureSampler{};
  const TextureKey key{*from.image, wrap_from(sampler.wrap_s), wrap_from(sampler.wrap_t)};
  if (const auto known = textures_.find(key); known != textures_.end()) return known->second;
  auto image = decode(*from.image);
  if (!image) return tl::unexpected(image.error());
  scene_.textures.push_back({std::move(*image), std::get<1>(key), std::get<2>(key)});
  return textures_[key] = static_cast<std::uint32_t>(scene_.textures.size() - 1);
}

Expected<farshade::Image<Rgba8>> MaterialConverter::decode(std::uint32_t index) {
  const Image& from = document_.images[index];
  const std::string name = label("image", index, from.name);
  if (from.unreadable) return fail(from.unreadable->fault, name + ": " + from.unreadable->what);
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
