#include "stereo/scene/scene_hash.h"

#include <sodium.h>

#include <bit>
#include <type_traits>

#include "stereo/base/check.h"

namespace farshade {
namespace {

static_assert(std::endian::native == std::endian::little, "numbers are hashed as they lie in memory");

/// Hashes numbers, vectors of numbers, and lists and optionals of them.
class Hasher {
 public:
  Hasher() {
    check(sodium_init() >= 0, "libsodium starts");
    crypto_generichash_init(&state_, nullptr, 0, SceneHash{}.size());
  }

  SceneHash finish() {
    SceneHash hash{};
    crypto_generichash_final(&state_, hash.data(), hash.size());
    return hash;
  }

  template <class... Fields>
  void fields(const Fields&... all) {
    (put(all), ...);
  }

  void count(std::size_t size) { put(static_cast<std::uint64_t>(size)); }

 private:
  template <class T>
  requires std::is_arithmetic_v<T> || std::is_enum_v<T>
  void put(T value) { bytes(&value, sizeof value); }
  template <int N, class T>
  void put(const glm::vec<N, T>& v) {
    static_assert(sizeof v == N * sizeof(T));
    bytes(&v, sizeof v);
  }
  void put(const glm::dquat& q) { fields(q.x, q.y, q.z, q.w); }
  void put(const glm::dmat4& m) { fields(m[0], m[1], m[2], m[3]); }
  template <class T>
  void put(const std::optional<T>& value) {
    put(value.has_value());
    if (value) put(*value);
  }
  template <class T>
  void put(const std::vector<T>& list) {
    static_assert(std::is_trivially_copyable_v<T> && alignof(T) <= 4, "no padding between or inside");
    count(list.size());
    bytes(list.data(), list.size() * sizeof(T));
  }
  void bytes(const void* data, std::size_t size) {
    crypto_generichash_update(&state_, static_cast<const unsigned char*>(data), size);
  }

  crypto_generichash_state state_;
};

void put_materials(Hasher& hasher, const Scene& scene) {
  hasher.count(scene.textures.size());
  for (const Texture& t : scene.textures)
    hasher.fields(t.image.size.width, t.image.size.height, t.image.pixels, t.wrap_u, t.wrap_v);
  hasher.count(scene.materials.size());
  for (const Material& m : scene.materials)
    hasher.fields(m.base_color, m.texture, m.alpha_cutoff, m.double_sided);
}

void put_shapes(Hasher& hasher, const Scene& scene) {
  hasher.count(scene.meshes.size());
  for (const Mesh& m : scene.meshes)
    hasher.fields(m.material, m.positions, m.normals, m.uvs, m.colors, m.triangles);
  hasher.count(scene.instances.size());
  for (const Instance& i : scene.instances) hasher.fields(i.mesh, i.node);
}

/// What casts no shadow. Scenes without a sky keep the hash that they had before there was one.
void put_sky(Hasher& hasher, const Scene& scene) {
  for (std::uint32_t i = 0; i < scene.instances.size(); ++i)
    if (!scene.instances[i].casts) hasher.fields(i);
}

/// What deforms. Scenes without rigs keep the hash that they had before there were rigs.
void put_rigs(Hasher& hasher, const Scene& scene) {
  if (scene.rigs.empty()) return;
  hasher.count(scene.rigs.size());
  for (const Rig& rig : scene.rigs) {
    hasher.count(rig.joints.size());
    for (const Joint& joint : rig.joints) hasher.fields(joint.node, joint.joint_from_bind);
    hasher.fields(rig.weights, rig.track.has_value());
    if (rig.track) hasher.fields(rig.track->interpolation, rig.track->keys_s, rig.track->values);
  }
  for (const Instance& i : scene.instances) hasher.fields(i.rig);
  for (const Mesh& m : scene.meshes) {
    hasher.fields(m.deformable.has_value());
    if (!m.deformable) continue;
    hasher.fields(m.deformable->positions, m.deformable->normals, m.deformable->influences);
    hasher.count(m.deformable->targets.size());
    for (const Deformable::Target& target : m.deformable->targets)
      hasher.fields(target.positions, target.normals);
  }
}

/// Scenes without animated lights keep the hash that they had before there were any.
void put_light_animations(Hasher& hasher, const Scene& scene) {
  for (std::uint32_t i = 0; i < scene.lights.size(); ++i) {
    const std::optional<LightAnimation>& animation = scene.lights[i].animation;
    if (!animation) continue;
    hasher.fields(i, animation->color, animation->intensity, animation->exposure);
    hasher.count(animation->tracks.size());
    for (const LightTrack& track : animation->tracks)
      hasher.fields(track.property, track.interpolation, track.keys_s, track.values);
  }
}

/// What animations hide. Scenes without it keep the hash that they had before it was read.
void put_hiding(Hasher& hasher, const Scene& scene) {
  for (std::uint32_t i = 0; i < scene.instances.size(); ++i)
    if (const auto& node = scene.instances[i].shown_with) hasher.fields('i', i, *node);
  for (std::uint32_t i = 0; i < scene.lights.size(); ++i)
    if (scene.lights[i].hides) hasher.fields('l', i);
}

void put_places(Hasher& hasher, const Scene& scene) {
  hasher.count(scene.nodes.size());
  for (const Node& n : scene.nodes)
    hasher.fields(n.parent, n.rest.translation, n.rest.rotation, n.rest.scale, n.rest.matrix);
  hasher.count(scene.lights.size());
  for (const LightSource& l : scene.lights)
    hasher.fields(l.kind, l.node, l.intensity, l.range_m, l.inner_cone_rad, l.outer_cone_rad);
  hasher.count(scene.channels.size());
  for (const Channel& c : scene.channels) hasher.fields(c.node, c.path, c.interpolation, c.keys_s, c.values);
  hasher.fields(scene.animation_length_s, scene.camera.has_value());
  if (scene.camera) hasher.fields(scene.camera->rotation, scene.camera->translation);
  if (scene.ambient != 0) hasher.fields(scene.ambient);
}

}  // namespace

SceneHash hash_of(const Scene& scene) {
  Hasher hasher;
  put_materials(hasher, scene);
  put_shapes(hasher, scene);
  put_sky(hasher, scene);
  put_rigs(hasher, scene);
  put_places(hasher, scene);
  put_light_animations(hasher, scene);
  put_hiding(hasher, scene);
  return hasher.finish();
}

}  // namespace farshade
