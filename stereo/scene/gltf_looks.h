/// Materials and textures of a validated Document, each converted when it is first used.
#pragma once

#include <map>
#include <span>
#include <tuple>

#include "stereo/scene/gltf.h"
#include "stereo/scene/gltf_document.h"

namespace farshade::gltf {

class Looks {
 public:
  /// Both outlive this.
  Looks(const Document& document, const SceneLimits& limits, Scene& scene);

  /// The scene's number of a material, or of the default material. Decodes its texture; refuses a damaged
  /// one.
  [[nodiscard]] Expected<std::uint32_t> material(Index index);

 private:
  using TextureKey = std::tuple<std::uint32_t, Wrap, Wrap>;  ///< image and wraps
  Expected<std::uint32_t> texture(std::uint32_t index);
  Expected<farshade::Image<Rgba8>> decode(std::uint32_t index);

  const Document& document_;
  const SceneLimits& limits_;
  Scene& scene_;
  std::uint64_t pixels_left_;  ///< over all images, so that a small file cannot hold many large ones
  std::map<Index, std::uint32_t> materials_;
  std::map<TextureKey, std::uint32_t> textures_;
};

/// Takes the alpha test from materials whose alpha is never below their cutoff.
void drop_needless_cutoffs(Scene& scene);

}  // namespace farshade::gltf
