/// Scene: the content of a glTF file, after all indices, ranges and numbers were checked. A Scene is
/// immutable. SceneState (scene_state.h) holds the positions of its instances and lights at one time.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <glm/gtc/quaternion.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "stereo/base/clock.h"
#include "stereo/base/digest.h"
#include "stereo/base/expected.h"
#include "stereo/image/image.h"
#include "stereo/math/spaces.h"
#include "stereo/scene/deformable.h"

namespace farshade {

enum class Wrap : std::uint8_t { Repeat, MirroredRepeat, ClampToEdge };

struct Texture {
  Image<Rgba8> image;  ///< sRGB-coded colour, linear alpha
  Wrap wrap_u = Wrap::Repeat, wrap_v = Wrap::Repeat;
};

struct Material {
  std::string name;
  glm::vec4 base_color{1.0f};            ///< linear RGBA factor
  std::optional<std::uint32_t> texture;  ///< base colour, into Scene::textures
  std::optional<float>
      alpha_cutoff;           ///< if set, a point with less alpha is a hole (MASK; BLEND is MASK at 0.5)
  bool double_sided = false;  ///< if false, only the counter-clockwise side is visible; both cast shadows
  bool unlit = false;         ///< KHR_materials_unlit
  bool glows = false;         ///< emits light; only the search for a sky (sky.h) asks
};

/// Triangles of one material, in object space. Each stream has one entry per vertex or is empty.
struct Mesh {
  std::string name;
  std::uint32_t material = 0;  ///< into Scene::materials
  std::vector<glm::vec3> positions;
  std::vector<glm::vec3> normals;     ///< unit; never empty
  std::vector<glm::vec2> uvs;         ///< KHR_texture_transform applied; empty without a texture
  std::vector<glm::u8vec4> colors;    ///< linear RGBA, 255 = 1; empty if the file has none
  std::vector<glm::uvec3> triangles;  ///< vertex indices, counter-clockwise from outside
  /// If set, a rig moves the vertices; `positions` and `normals` are those at time 0.
  std::optional<Deformable> deformable = std::nullopt;
};

/// Translation, rotation and scale, or a matrix if the file has one.
struct NodeTransform {
  glm::dvec3 translation{0.0};
  glm::dquat rotation{1.0, 0.0, 0.0, 0.0};
  glm::dvec3 scale{1.0};
  std::optional<glm::dmat4> matrix;
  bool visible = true;  ///< KHR_node_visibility: false hides the node and all below it
};

struct Node {
  std::string name;
  std::optional<std::uint32_t> parent;  ///< into Scene::nodes, always before this node
  NodeTransform rest;
  bool moving = false;  ///< it or an ancestor is animated
};

enum class Path : std::uint8_t { Translation, Rotation, Scale, Visible };
enum class Interpolation : std::uint8_t { Step, Linear, CubicSpline };

/// A joint of a skin: its node, and where the node was when the skin was bound to it.
struct Joint {
  std::uint32_t node = 0;  ///< into Scene::nodes
  glm::dmat4 joint_from_bind{1.0};
};

/// Weights of morph targets over time: `rest.size()` values a key, three times as many for cubic splines.
struct WeightTrack {
  Interpolation interpolation = Interpolation::Linear;
  std::vector<float> keys_s, values;
};

/// What deforms the meshes of one node of the file. At least one joint moves, or the weights do.
struct Rig {
  std::vector<Joint> joints;   ///< empty: no skin
  std::vector<float> weights;  ///< of the morph targets at rest; empty: none
  std::optional<WeightTrack> track = std::nullopt;
};

struct Instance {
  std::uint32_t mesh = 0, node = 0;
  std::optional<std::uint32_t> rig = std::nullopt;  ///< into Scene::rigs, if the mesh is deformable
  bool casts = true;                                ///< a sky (sky.h) casts no shadow
  /// The node with which an animation hides and shows the instance; none: it is always shown.
  std::optional<std::uint32_t> shown_with = std::nullopt;
};

enum class LightKind : std::uint8_t { Point, Spot, Directional };

enum class LightProperty : std::uint8_t { Color, Intensity, Range, InnerCone, OuterCone };

/// One property of a light over time: xyz of a colour, otherwise x. Cubic splines as in a Channel.
struct LightTrack {
  LightProperty property = LightProperty::Intensity;
  Interpolation interpolation = Interpolation::Linear;
  std::vector<float> keys_s;
  std::vector<glm::vec4> values;
};

/// What changes in an animated light.
struct LightAnimation {
  glm::vec3 color{1.0f};           ///< unless a track changes it
  float intensity = 1;             ///< unless a track changes it
  float exposure = 1;              ///< factor of all light (lighting.h)
  std::vector<LightTrack> tracks;  ///< at least one; at most one a property
};

/// A light of KHR_lights_punctual. It shines along the -z axis of its node. Of an animated light,
/// `intensity`, `range_m` and `outer_cone_rad` are the largest that they become.
struct LightSource {
  std::string name;
  LightKind kind = LightKind::Point;
  std::uint32_t node = 0;
  glm::vec3 intensity{1.0f};     ///< colour times intensity: candela (point, spot) or lux (directional)
  std::optional<float> range_m;  ///< no light beyond this distance
  float inner_cone_rad = 0, outer_cone_rad = 0;  ///< spot only
  std::optional<LightAnimation> animation = std::nullopt;
  bool hides = false;  ///< an animation hides and shows it with its node
};

/// One animated property of one node. The keys increase strictly. Values are xyz0 or quaternions xyzw, and x
/// of Visible is 0 or 1. Cubic splines have three values per key: in-tangent, value, out-tangent.
struct Channel {
  std::uint32_t node = 0;
  Path path = Path::Translation;
  Interpolation interpolation = Interpolation::Linear;
  std::vector<float> keys_s;
  std::vector<glm::vec4> values;
};

struct Bounds {
  glm::dvec3 low{0.0}, high{0.0};

  /// Corner `index`, 0 to 7.
  [[nodiscard]] glm::dvec3 corner(int index) const {
    return {index & 1 ? high.x : low.x, index & 2 ? high.y : low.y, index & 4 ? high.z : low.z};
  }
  friend bool operator==(const Bounds&, const Bounds&) = default;
};

/// Holds nothing: the neutral element of joined().
inline constexpr Bounds kNoPoint{glm::dvec3(std::numeric_limits<double>::max()),
                                 glm::dvec3(std::numeric_limits<double>::lowest())};

[[nodiscard]] inline Bounds joined(const Bounds& a, const Bounds& b) {
  return {glm::min(a.low, b.low), glm::max(a.high, b.high)};
}

/// The box around the transformed corners of a box.
[[nodiscard]] inline Bounds moved(const glm::dmat4& transform, const Bounds& box) {
  Bounds result = kNoPoint;
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec3 p(transform * glm::dvec4(box.corner(corner), 1.0));
    result = joined(result, {p, p});
  }
  return result;
}

/// The box around some points; the origin if there are none.
[[nodiscard]] inline Bounds bounds_of(const std::vector<glm::vec3>& points) {
  if (points.empty()) return {};
  glm::vec3 low = points.front(), high = low;
  for (const glm::vec3& p : points) low = glm::min(low, p), high = glm::max(high, p);
  return {glm::dvec3(low), glm::dvec3(high)};
}

/// What a file offers to choose from (scene_choice.h), by name.
struct FileContents {
  std::vector<std::string> scenes, cameras, variants, animations;
  std::uint32_t scene = 0;  ///< the one that is shown
};

/// A file that a scene was loaded from.
struct SceneFile {
  std::string name;  ///< relative to the folder of the scene
  std::uint64_t bytes = 0;
  Digest digest{};              ///< of the bytes that were loaded
  std::int64_t changed_ns = 0;  ///< when it was changed last, before it was read (changed_at)
};

/// BLAKE2b-256 of everything that the picture depends on (scene_hash.h). Client and server compare it.
using SceneHash = std::array<std::uint8_t, 32>;

struct Scene {
  std::string name;              ///< file name, for messages only
  std::vector<SceneFile> files;  ///< its own file, then those that it names, if they were asked for (gltf.h)
  std::vector<std::string> warnings;  ///< what is not drawn as the file says, one sentence each
  FileContents contents;              ///< for messages only
  std::vector<Texture> textures;
  std::vector<Material> materials;
  std::vector<Mesh> meshes;
  std::vector<Node> nodes;
  std::vector<Instance> instances;
  std::vector<Rig> rigs;
  std::vector<LightSource> lights;  ///< light i has bit i of every mask; by light of the file, then node
  float ambient = 0;                ///< linear factor of the base colour everywhere (lighting.h)
  std::vector<Channel> channels;
  double animation_length_s = 0;            ///< the animation repeats after this time; 0 = no animation
  std::optional<Rigid<Stage, Eye>> camera;  ///< reference camera at time 0, if the file has one
  Bounds bounds;                            ///< boxes of all meshes at time 0, stage space
  std::uint64_t triangle_count = 0;         ///< of all instances together
  SceneHash hash{};
};

/// Whether an animation changes what the light reaches, apart from its place: its range or its outer cone.
[[nodiscard]] bool changes_reach(const LightSource& light);

/// Whether an animation places, deforms or hides the instance.
[[nodiscard]] inline bool can_move(const Scene& scene, const Instance& instance) {
  return instance.rig.has_value() || scene.nodes[instance.node].moving || instance.shown_with.has_value();
}

}  // namespace farshade
