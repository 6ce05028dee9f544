/// The content of a glTF file as plain values. gltf_parse.cpp fills a Document; indices and ranges may still
/// be wrong. gltf_validate.cpp checks it before it is converted to a Scene.
#pragma once

#include <algorithm>
#include <cstdint>
#include <glm/gtc/quaternion.hpp>
#include <glm/mat4x4.hpp>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "stereo/base/expected.h"
#include "stereo/base/printable.h"

namespace farshade::gltf {

using Index = std::optional<std::uint32_t>;
using Checked = Expected<void>;

enum class Component : std::uint32_t {
  Int8 = 5120,
  UInt8 = 5121,
  Int16 = 5122,
  UInt16 = 5123,
  UInt32 = 5125,
  Float = 5126
};
enum class Mode : std::uint32_t { Triangles = 4, TriangleStrip = 5, TriangleFan = 6 };

/// Size of a component in bytes; 0 for an unknown component type.
constexpr std::uint64_t bytes_of(Component c) {
  switch (c) {
    case Component::Int8:
    case Component::UInt8:
      return 1;
    case Component::Int16:
    case Component::UInt16:
      return 2;
    case Component::UInt32:
    case Component::Float:
      return 4;
  }
  return 0;
}

struct MeshoptView;

struct BufferView {
  std::uint32_t buffer = 0;
  std::uint64_t offset = 0, bytes = 0;
  std::uint64_t stride = 0;                      ///< 0 = elements are packed without gaps
  std::shared_ptr<const MeshoptView> meshopt{};  ///< if set, the bytes are still compressed (decompress)
};

/// EXT_meshopt_compression of a view. Mode and filter are as the extension spells them.
struct MeshoptView {
  BufferView source;  ///< the compressed bytes
  std::uint64_t stride = 0, count = 0;
  std::string mode, filter;
};

struct Sparse {
  std::uint64_t count = 0;
  std::uint32_t index_view = 0, value_view = 0;
  std::uint64_t index_offset = 0, value_offset = 0;
  Component index_component{};
};

struct Accessor {
  Index view;  ///< without a view, all elements are zero
  std::uint64_t offset = 0, count = 0;
  Component component{};
  std::uint32_t rows = 1, columns = 1;  ///< a vector has one column
  bool normalized = false;
  std::optional<Sparse> sparse;

  /// Columns of a matrix are aligned to four bytes.
  [[nodiscard]] std::uint64_t element_bytes() const {
    const std::uint64_t column = rows * bytes_of(component);
    return columns == 1 ? column : columns * ((column + 3) / 4 * 4);
  }
};

struct Image {
  std::string name;
  Index view;                       ///< the buffer view that holds the image file
  std::vector<std::uint8_t> file;   ///< without a view: the image file, from a data URI or an external file
  std::optional<Error> unreadable;  ///< why the external file could not be read
};

struct TextureSampler {
  std::uint32_t wrap_s = 10497, wrap_t = 10497;
};

struct Texture {
  std::string name;
  Index image, sampler;
};

/// A reference to a texture, with KHR_texture_transform.
struct TextureUse {
  std::uint32_t texture = 0, texcoord = 0;
  glm::dvec2 offset{0.0}, scale{1.0};
  double rotation_rad = 0;
};

struct Material {
  std::string name, alpha_mode;
  glm::dvec4 base_color{1.0};
  double alpha_cutoff = 0.5;
  bool double_sided = false, unlit = false;
  std::optional<TextureUse> texture;
};

/// Accessors of differences to a primitive's attributes.
struct MorphTarget {
  Index position, normal;
};

/// KHR_draco_mesh_compression of a primitive.
struct DracoMesh {
  std::uint32_t view = 0;
  std::map<std::string, std::uint32_t> ids;  ///< semantic -> the attribute's id in the Draco mesh
};

struct Primitive {
  std::map<std::string, std::uint32_t> attributes;  ///< semantic -> accessor
  std::vector<MorphTarget> targets;
  Index indices, material;
  Mode mode = Mode::Triangles;
  std::map<std::uint32_t, std::uint32_t> variants{};  ///< variant -> material
  std::shared_ptr<const DracoMesh> draco{};  ///< if set, the accessors have no bytes yet (decompress)

  [[nodiscard]] bool draws_triangles() const { return mode >= Mode::Triangles && mode <= Mode::TriangleFan; }
  [[nodiscard]] Index attribute(const std::string& semantic) const {
    const auto found = attributes.find(semantic);
    return found == attributes.end() ? Index{} : Index{found->second};
  }
};

struct Mesh {
  std::string name;
  std::vector<Primitive> primitives;
  std::vector<double> weights;  ///< of the morph targets; empty: 0

  /// The morph targets of the primitive that has most.
  [[nodiscard]] std::size_t targets() const {
    std::size_t most = 0;
    for (const Primitive& primitive : primitives) most = std::max(most, primitive.targets.size());
    return most;
  }
};

struct Skin {
  std::string name;
  std::vector<std::uint32_t> joints;  ///< nodes
  Index inverse_bind;                 ///< accessor of one matrix per joint; none: identity
};

/// EXT_mesh_gpu_instancing of a node: accessors with one value per instance.
struct Instancing {
  Index translation, rotation, scale;
};

struct Node {
  std::string name;
  std::vector<std::uint32_t> children;
  Index mesh, camera, light, skin;
  std::optional<glm::dvec3> translation, scale;
  std::optional<glm::dquat> rotation;
  std::optional<glm::dmat4> matrix;
  std::vector<double> weights;                     ///< of the mesh's morph targets; empty: those of the mesh
  std::shared_ptr<const Instancing> instancing{};  ///< until expand_instances
};

struct Light {
  std::string name, type;
  glm::dvec3 color{1.0};
  double intensity = 1, inner_cone_rad = 0, outer_cone_rad = 0;
  std::optional<double> range_m;
};

struct AnimationSampler {
  std::uint32_t input = 0, output = 0;
  std::string interpolation;
};

struct AnimationChannel {
  std::uint32_t sampler = 0, node = 0;
  std::string path;
};

/// What a pointer to a light means, such as "/extensions/KHR_lights_punctual/lights/0/intensity".
struct LightChannel {
  std::uint32_t sampler = 0, light = 0;
  std::string property;  ///< such as "color" or "spot/outerConeAngle"
};

struct Animation {
  std::string name;
  std::vector<AnimationChannel> channels{};
  std::vector<AnimationSampler> samplers{};
  std::vector<LightChannel> lights{};
  std::vector<std::string> still{};  ///< what KHR_animation_pointer points to and stands still here
};

struct Document {
  std::vector<std::vector<std::uint8_t>> buffers;
  std::vector<BufferView> views;
  std::vector<Accessor> accessors;
  std::vector<Image> images;
  std::vector<TextureSampler> texture_samplers;
  std::vector<Texture> textures;
  std::vector<Material> materials;
  std::vector<Mesh> meshes;
  std::vector<Node> nodes;
  std::vector<Skin> skins;
  std::vector<Light> lights;
  std::vector<Animation> animations;
  std::vector<std::vector<std::uint32_t>> scenes;  ///< the root nodes of each scene
  Index default_scene;
  std::vector<std::string> scene_names;
  std::vector<std::string> cameras;   ///< their names
  std::vector<std::string> variants;  ///< names of KHR_materials_variants
  Index chosen_camera;                ///< node (choose_camera); none: the reference camera
  std::vector<std::string> warnings;  ///< what is not drawn as the file says, one sentence each
};

/// "mesh 3 'chair'", or "mesh 3" without a name.
[[nodiscard]] inline std::string label(std::string_view kind, std::size_t index, std::string_view name = {}) {
  std::string result = std::string(kind) + ' ' + std::to_string(index);
  if (!name.empty()) result += " '" + printable(name) + "'";
  return result;
}

[[nodiscard]] inline tl::unexpected<Error> malformed(std::string what) {
  return fail(Fault::Malformed, std::move(what));
}

}  // namespace farshade::gltf
