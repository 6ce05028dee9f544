#include "stereo/gltf/gltf.h"
#include <exception>
#include "stereo/base/files.h"
#include "stereo/gltf/gltf_files.h"
#include "stereo/gltf/gltf_stages.h"
#include "stereo/scene/scene_hash.h"

namespace farshade {
namespace {

/// Makes everything that a file may describe in other ways plain, and mends it.
gltf::Checked prepare(gltf::Document& document, const SceneLimits& limits, const SceneChoice& choice) {
  return gltf::decompress(document)
      .and_then([&] {
        gltf::validate_accessors(document);
        return gltf::expand_instances(document);
      })
      .and_then([&] { return gltf::choose_scene(document, choice); })
      .and_then([&] {
        gltf::validate_lights(document);
        return gltf::validate_meshes(document);
      })
      .and_then([&] { return gltf::validate_nodes(document, limits); })
      .and_then([&] { return gltf::validate_deformations(document); })
      .and_then([&] { return gltf::validate_animations(document); })
      .and_then([&] { return gltf::validate_reach(document); })
      .and_then([&] { return gltf::choose_camera(document, choice); });
}

Expected<Scene> load(std::span<const std::byte> file, const std::filesystem::path& folder,
                     const SceneLimits& limits, const SceneChoice& choice, ListFiles list) {
  if (file.size() > limits.file_bytes || file.size() > std::uint64_t{1} << 31)
    return fail(Fault::OutOfRange,
                std::to_string(file.size()) + " bytes are more than a scene file may have");
  gltf::SceneFolder files(folder, limits.external_bytes, list);
  return gltf::open_container(file).and_then([&](const gltf::Container& container) {
    return gltf::check_json_depth(container.json, limits.json_depth)
        .and_then([&] { return gltf::read_document(container, files); })
        .and_then([&](gltf::Document&& document) -> Expected<Scene> {
          if (auto ready = prepare(document, limits, choice); !ready) return tl::unexpected(ready.error());
          return gltf::convert(document, limits);
        })
        .map([&](Scene scene) {
          scene.files = files.files();
          scene.hash = hash_of(scene);
          return scene;
        });
  });
}

}  // namespace

Expected<Scene> load_scene_from_memory(std::span<const std::byte> file, const std::filesystem::path& folder,
                                       const SceneLimits& limits, const SceneChoice& choice, ListFiles list) {
  // The libraries and the allocator report errors by exceptions. No exception leaves this function.
  try {
    return load(file, folder, limits, choice, list);
  } catch (const std::exception& refusal) {
    return fail(Fault::Malformed, "cannot be loaded: " + printable(refusal.what()));
  }
}

Expected<Scene> load_scene(const std::filesystem::path& path, const SceneLimits& limits,
                           const SceneChoice& choice, ListFiles list) {
  const std::int64_t changed_ns = changed_at(path);
  const auto bytes = read_file(path, limits.file_bytes);
  if (!bytes) return tl::unexpected(bytes.error());
  const auto folder = path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
  auto scene = load_scene_from_memory(*bytes, folder, limits, choice, list);
  if (!scene) return fail(scene.error().fault, path.string() + ": " + scene.error().what);
  scene->name = path.filename().string();
  if (list == ListFiles::No) return scene;
  std::erase_if(scene->files, [&](const SceneFile& file) { return file.name == scene->name; });
  scene->files.insert(scene->files.begin(), {scene->name, bytes->size(), digest_of(*bytes), changed_ns});
  return scene;
}

}  // namespace farshade
