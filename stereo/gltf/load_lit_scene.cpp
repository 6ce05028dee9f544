#include "stereo/gltf/load_lit_scene.h"

#include <new>

namespace farshade {

Expected<LitScene> load_lit_scene(const std::filesystem::path& path, const Lighting& lighting,
                                  ListFiles list) try {
  return load_scene(path, {}, lighting.choice, list).and_then([&](Scene scene) {
    return light_scene(std::move(scene), lighting);
  });
} catch (const std::bad_alloc&) {
  return fail(Fault::Unavailable, path.string() + ": there is not enough memory for this scene");
}

}  // namespace farshade
