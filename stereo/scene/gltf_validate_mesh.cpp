/// Validation of meshes with their attributes and indices, of skins and morph targets, of materials,
/// textures, images and lights.
#include <cmath>
#include <numbers>
#include <set>

#include "stereo/scene/gltf_accessor.h"
#include "stereo/scene/gltf_validate.h"

namespace farshade::gltf {
namespace {

/// Largest coordinate of a vertex, in units of its space. Its square is far below the largest float.
constexpr float kMaxCoordinate = 1e9f;

/// Component types that an attribute may have. `integers` says which integers KHR_mesh_quantization allows.
enum class Integers { NormalizedUnsigned, NormalizedSigned, Any };

struct Attribute {
  std::string semantic;
  std::uint32_t least_rows, most_rows;
  Integers integers;
};

bool is_allowed(const Accessor& accessor, Integers integers) {
  const Component c = accessor.component;
  if (c == Component::Float) return true;
  if (c == Component::UInt32) return false;
  if (integers == Integers::Any) return true;
  const bool is_signed = c == Component::Int8 || c == Component::Int16;
  return accessor.normalized && is_signed == (integers == Integers::NormalizedSigned);
}

Checked check_attribute(const Document& document, const std::string& name, const Primitive& primitive,
                        const Attribute& expected, std::uint64_t vertices) {
  const Index index = primitive.attribute(expected.semantic);
  if (!index) return {};
  const std::string subject = name + ": " + printable(expected.semantic) + " " + label("accessor", *index);
  if (*index >= document.accessors.size()) return malformed(subject + " is not there");
  const Accessor& accessor = document.accessors[*index];
  if (accessor.columns != 1 || accessor.rows < expected.least_rows || accessor.rows > expected.most_rows ||
      !is_allowed(accessor, expected.integers))
    return malformed(subject + " has a type that this attribute cannot have");
  if (accessor.count != vertices)
    return malformed(subject + " has " + std::to_string(accessor.count) + " elements for " +
                     std::to_string(vertices) + " vertices");
  return {};
}

Checked check_positions(const Document& document, const std::string& name, std::uint32_t index) {
  const auto positions = read_vectors<3>(document, index);
  const auto is_far = [](glm::vec3 p) {
    return std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}) > kMaxCoordinate;
  };
  const auto far = std::find_if(positions.begin(), positions.end(), is_far);
  if (far == positions.end()) return {};
  return fail(Fault::OutOfRange, name + ": POSITION " + label("accessor", index) + ": vertex " +
                                     std::to_string(far - positions.begin()) + " lies beyond 1e9");
}

Checked check_index_count(const std::string& name, Mode mode, std::uint64_t count) {
  const bool whole = mode == Mode::Triangles ? count % 3 == 0 : count >= 3;
  if (whole) return {};
  return malformed(name + ": " + std::to_string(count) + " vertices do not make whole triangles");
}

Checked check_indices(const Document& document, const std::string& name, std::uint32_t index,
                      std::uint64_t vertices) {
  const std::string subject = name + ": index " + label("accessor", index);
  if (index >= document.accessors.size()) return malformed(subject + " is not there");
  const Accessor& accessor = document.accessors[index];
  const Component c = accessor.component;
  const bool is_unsigned = c == Component::UInt8 || c == Component::UInt16 || c == Component::UInt32;
  if (!is_unsigned || accessor.rows != 1 || accessor.columns != 1 || accessor.normalized)
    return malformed(subject + " should hold unsigned integers");
  const auto indices = read_indices(document, index);
  const auto worst = std::max_element(indices.begin(), indices.end());
  if (*worst >= vertices)
    return malformed(subject + ": index " + std::to_string(*worst) + " is beyond the " +
                     std::to_string(vertices) + " vertices");
  return {};
}

/// The texture coordinates that the material of a primitive reads. Other TEXCOORD_n are not read.
std::string texcoord_semantic(const Document& document, const Primitive& primitive) {
  const auto* material = primitive.material ? &document.materials[*primitive.material] : nullptr;
  return material && material->texture ? "TEXCOORD_" + std::to_string(material->texture->texcoord) : "";
}

Checked check_primitive(const Document& document, const std::string& name, const Primitive& primitive,
                        std::uint64_t& left) {
  if (static_cast<std::uint32_t>(primitive.mode) > 6)
    return malformed(name + ": unknown mode " + std::to_string(static_cast<std::uint32_t>(primitive.mode)));
  if (!points_into(document.materials, primitive.material))
    return malformed(name + ": there is no " + label("material", *primitive.material));
  const Index position = primitive.attribute("POSITION");
  if (!position || !primitive.draws_triangles()) return {};
  if (*position >= document.accessors.size())
    return malformed(name + ": POSITION " + label("accessor", *position) + " is not there");
  const std::uint64_t vertices = document.accessors[*position].count;
  const std::uint64_t indices = primitive.indices && *primitive.indices < document.accessors.size()
                                    ? document.accessors[*primitive.indices].count
                                    : vertices;
  if (vertices + indices > left)
    return fail(Fault::OutOfRange, name + ": more vertices than a file of this size should have");
  left -= vertices + indices;
  const Attribute attributes[] = {{"POSITION", 3, 3, Integers::Any},
                                  {"NORMAL", 3, 3, Integers::NormalizedSigned},
                                  {"COLOR_0", 3, 4, Integers::NormalizedUnsigned},
                                  {texcoord_semantic(document, primitive), 2, 2, Integers::Any}};
  for (const Attribute& attribute : attributes)
    if (auto checked = check_attribute(document, name, primitive, attribute, vertices); !checked)
      return checked;
  return check_positions(document, name, *position)
      .and_then([&] {
        return primitive.indices ? check_indices(document, name, *primitive.indices, vertices) : Checked{};
      })
      .and_then([&] { return check_index_count(name, primitive.mode, indices); });
}

/// Morph targets, and the joints and weights of a skin.
Checked check_deforming(const Document& document, const std::string& name, const Primitive& primitive) {
  const Index position = primitive.attribute("POSITION");
  if (!position || !primitive.draws_triangles()) return {};
  const std::uint64_t vertices = document.accessors[*position].count;
  for (const MorphTarget& target : primitive.targets) {
    Primitive differences;
    if (target.position) differences.attributes["POSITION"] = *target.position;
    if (target.normal) differences.attributes["NORMAL"] = *target.normal;
    for (const char* semantic : {"POSITION", "NORMAL"})
      if (auto checked = check_attribute(document, name + ", morph target", differences,
                                         {semantic, 3, 3, Integers::Any}, vertices);
          !checked)
        return checked;
  }
  return check_attribute(document, name, primitive, {"WEIGHTS_0", 4, 4, Integers::NormalizedUnsigned},
                         vertices)
      .and_then([&]() -> Checked {
        const Index joints = primitive.attribute("JOINTS_0");
        if (!joints) return {};
        const std::string subject = name + ": JOINTS_0 " + label("accessor", *joints);
        if (*joints >= document.accessors.size()) return malformed(subject + " is not there");
        const Accessor& accessor = document.accessors[*joints];
        const bool whole = accessor.component == Component::UInt8 || accessor.component == Component::UInt16;
        if (!whole || accessor.normalized || accessor.rows != 4 || accessor.columns != 1 ||
            accessor.count != vertices)
          return malformed(subject + " should have four unsigned integers for each vertex");
        return {};
      });
}

/// `left`: the numbers that all skins together may still have.
Checked check_skin(const Document& document, std::size_t index, const Skin& skin, std::uint64_t& left) {
  const std::string name = label("skin", index, skin.name);
  if (skin.joints.empty()) return malformed(name + " has no joints");
  for (const std::uint32_t joint : skin.joints)
    if (joint >= document.nodes.size()) return malformed(name + ": there is no " + label("node", joint));
  std::uint64_t matrices = skin.joints.size();
  if (skin.inverse_bind) {
    const std::string subject = name + ": inverse bind matrices, " + label("accessor", *skin.inverse_bind);
    if (*skin.inverse_bind >= document.accessors.size()) return malformed(subject + " is not there");
    const Accessor& accessor = document.accessors[*skin.inverse_bind];
    if (accessor.component != Component::Float || accessor.rows != 4 || accessor.columns != 4 ||
        accessor.count < skin.joints.size())
      return malformed(subject + " should have a matrix of floats for each joint");
    matrices += accessor.count;
  }
  if (16 * matrices > left)
    return fail(Fault::OutOfRange, name + ": more joints than a file of this size should have");
  left -= 16 * matrices;
  if (!skin.inverse_bind) return {};
  const auto is_near = [](const glm::vec4& v) {
    return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z), std::abs(v.w)}) <= kMaxCoordinate;
  };
  for (const glm::mat4& m : read_matrices(document, *skin.inverse_bind))
    if (!is_near(m[0]) || !is_near(m[1]) || !is_near(m[2]) || !is_near(m[3]))
      return fail(Fault::OutOfRange, name + ": an inverse bind matrix has numbers beyond 1e9");
  return {};
}

/// The nodes whose weights an animation moves.
std::set<std::uint32_t> nodes_with_tracks(const Document& document) {
  std::set<std::uint32_t> nodes;
  for (const Animation& animation : document.animations)
    for (const AnimationChannel& channel : animation.channels)
      if (channel.path == "weights") nodes.insert(channel.node);
  return nodes;
}

/// What a node reads and makes: instances, and if it deforms its mesh, joints, vertices and indices of its
/// own. Flat triangles and parts (mesh_parts.h) may have three vertices for each triangle.
std::uint64_t cost_of(const Document& document, const Node& node, bool has_track) {
  const Mesh& mesh = document.meshes[*node.mesh];
  const bool deforms = node.skin || has_track || !node.weights.empty() || !mesh.weights.empty();
  std::uint64_t cost = 1 + mesh.primitives.size() + node.weights.size() + mesh.weights.size();
  for (const Primitive& primitive : mesh.primitives) {
    const Index position = primitive.attribute("POSITION");
    if (!deforms || !position || !primitive.draws_triangles()) continue;
    const std::uint64_t vertices = document.accessors[*position].count;
    const std::uint64_t indices = primitive.indices ? document.accessors[*primitive.indices].count : vertices;
    const std::uint64_t corners = primitive.mode == Mode::Triangles ? indices : 3 * indices;
    cost += (vertices + corners) * (1 + primitive.targets.size());
  }
  if (node.skin) cost += 16 * document.skins[*node.skin].joints.size();
  return cost;
}

Checked check_joints(const Document& document, const std::string& name, const Node& node) {
  if (!node.skin) return {};
  const auto joints = static_cast<float>(document.skins[*node.skin].joints.size());
  for (const Primitive& primitive : document.meshes[*node.mesh].primitives) {
    const Index named = primitive.attribute("JOINTS_0");
    if (!primitive.attribute("POSITION") || !primitive.draws_triangles() || !named) continue;
    for (const glm::vec4& of_vertex : read_vectors<4>(document, *named))
      if (std::max({of_vertex.x, of_vertex.y, of_vertex.z, of_vertex.w}) >= joints)
        return malformed(name + ": a vertex names a joint that its skin does not have");
  }
  return {};
}

/// Bounds what nodes make of meshes that they share, and checks the joints that skinned meshes name.
Checked check_mesh_nodes(const Document& document) {
  std::uint64_t left = element_budget(document);
  const std::set<std::uint32_t> tracks = nodes_with_tracks(document);
  return check_each(document.nodes, [&](std::size_t index, const Node& node) -> Checked {
    if (!node.mesh) return {};
    const std::string name = label("node", index, node.name);
    const std::uint64_t cost = cost_of(document, node, tracks.contains(static_cast<std::uint32_t>(index)));
    if (cost > left)
      return fail(Fault::OutOfRange,
                  name + ": its mesh is shown or deformed more often than in a file of this size should be");
    left -= cost;
    return check_joints(document, name, node);
  });
}

Checked check_image(const Document& document, std::size_t index, const Image& image) {
  if (points_into(document.views, image.view)) return {};
  return malformed(label("image", index, image.name) + ": there is no " + label("buffer view", *image.view));
}

bool is_wrap(std::uint32_t wrap) {
  return wrap == 10497 || wrap == 33648 || wrap == 33071;
}

Checked check_texture(const Document& document, std::size_t index, const Texture& texture) {
  const std::string name = label("texture", index, texture.name);
  if (!points_into(document.images, texture.image))
    return malformed(name + ": there is no " + label("image", *texture.image));
  if (!points_into(document.texture_samplers, texture.sampler))
    return malformed(name + ": there is no " + label("sampler", *texture.sampler));
  if (!texture.sampler) return {};
  const TextureSampler& sampler = document.texture_samplers[*texture.sampler];
  if (!is_wrap(sampler.wrap_s) || !is_wrap(sampler.wrap_t))
    return malformed(label("sampler", *texture.sampler) + ": unknown wrap mode");
  return {};
}

Checked check_material(const Document& document, std::size_t index, const Material& material) {
  const std::string name = label("material", index, material.name);
  if (material.texture && material.texture->texture >= document.textures.size())
    return malformed(name + ": there is no " + label("texture", material.texture->texture));
  for (int i = 0; i < 4; ++i)
    if (material.base_color[i] < 0.0 || material.base_color[i] > 1.0)
      return malformed(name + ": the base colour factor is outside of 0 to 1");
  if (material.alpha_mode != "OPAQUE" && material.alpha_mode != "MASK" && material.alpha_mode != "BLEND")
    return malformed(name + ": unknown alpha mode '" + printable(material.alpha_mode) + "'");
  return {};
}

Checked check_light(std::size_t index, const Light& light) {
  const std::string name = label("light", index, light.name);
  if (light.type != "point" && light.type != "spot" && light.type != "directional")
    return malformed(name + ": unknown type '" + printable(light.type) + "'");
  if (std::min({light.color.x, light.color.y, light.color.z}) < 0.0)
    return malformed(name + ": its colour is negative");
  if (light.type == "spot" &&
      !(light.inner_cone_rad < light.outer_cone_rad && light.outer_cone_rad <= std::numbers::pi / 2 + 1e-6))
    return malformed(name + ": the cone should be 0 <= inner < outer <= pi/2");
  return {};
}

}  // namespace

Checked validate_meshes(const Document& document) {
  std::uint64_t left = element_budget(document);
  return check_each(document.meshes, [&](std::size_t m, const Mesh& mesh) {
    return check_each(mesh.primitives, [&](std::size_t p, const Primitive& primitive) {
      const std::string name = label("mesh", m, mesh.name) + ", " + label("primitive", p);
      return check_primitive(document, name, primitive, left).and_then([&] {
        return check_deforming(document, name, primitive);
      });
    });
  });
}

Checked validate_deformations(const Document& document) {
  std::uint64_t left = element_budget(document);
  return check_each(document.skins,
                    [&](std::size_t i, const Skin& skin) { return check_skin(document, i, skin, left); })
      .and_then([&] { return check_mesh_nodes(document); });
}

Checked validate_materials(const Document& document) {
  return check_each(document.images,
                    [&](auto i, const auto& image) { return check_image(document, i, image); })
      .and_then([&] {
        return check_each(document.textures,
                          [&](auto i, const auto& texture) { return check_texture(document, i, texture); });
      })
      .and_then([&] {
        return check_each(document.materials, [&](auto i, const auto& material) {
          return check_material(document, i, material);
        });
      })
      .and_then([&] { return check_each(document.lights, check_light); });
}

}  // namespace farshade::gltf
