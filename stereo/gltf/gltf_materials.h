/// Converts materials and textures of a validated Document, each at its first use.
#pragma once

#include <map>
#include <tuple>

#include "stereo/gltf/gltf.h"
#include "stereo/gltf/gltf_model.h"

namespace farshade::gltf {

/// The base colour factor: of the older description of surfaces (KHR_materials_pbrSpecularGlossiness) its
/// diffuse factor.
[[nodiscard]] glm::dvec4 base_color_of(const Material& material);

/// A reference to a texture, with KHR_texture_transform.
struct TextureUse {
  std::uint32_t texture = 0, texcoord = 0;
  glm::dvec2 offset{0.0}, scale{1.0};
  double rotation_rad = 0;

  /// Of the texture coordinates.
  [[nodiscard]] std::string semantic() const { return "TEXCOORD_" + std::to_string(texcoord); }
};

/// The texture of the base colour.
[[nodiscard]] std::optional<TextureUse> texture_of(const Material& material);
/// That of the primitive's material, which must be in range.
[[nodiscard]] inline std::optional<TextureUse> texture_of(const Document& document,
                                                          const Primitive& primitive) {
  return primitive.material < 0 ? std::nullopt : texture_of(at(document.materials, primitive.material));
}

class MaterialConverter {
 public:
  /// The arguments must outlive this object.
  MaterialConverter(Document& document, const SceneLimits& limits, Scene& scene);

  /// Index in Scene::materials of a material of the document; no index: of the default material. Decodes the
  /// texture. If that is not possible, the material has its base colour factor only.
  [[nodiscard]] std::uint32_t material(Index index);

 private:
  using TextureKey = std::tuple<std::uint32_t, Wrap, Wrap>;  ///< image, wrap modes
  Expected<Index> texture(const std::string& user, std::uint32_t index);
  Wrap wrap_from(int sampler, int code);
  Expected<farshade::Image<Rgba8>> decode(std::uint32_t index);

  Document& document_;
  const SceneLimits& limits_;
  Scene& scene_;
  std::uint64_t pixels_left_;  ///< for all images together, against small files that hold many large images
  std::uint32_t damaged_ = 0;  ///< images
  std::map<Index, std::uint32_t> materials_;
  std::map<TextureKey, Index> textures_;
};

/// Removes the alpha test of materials whose alpha is never below the cutoff.
void remove_needless_alpha_tests(Scene& scene);

}  // namespace farshade::gltf
