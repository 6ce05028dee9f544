/// Validation of meshes with their attributes and indices, of skins and morph targets, of materials,
/// textures, images and lights.
#include <cmath>
#include <numbers>

#include "stereo/gltf/gltf_accessor.h"
#include "stereo/gltf/gltf_lights.h"
#include "stereo/gltf/gltf_materials.h"
#include "stereo/gltf/gltf_validate.h"

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
  const Component c = component_of(accessor);
  if (c == Component::Float) return true;
  if (c == Component::UInt32) return false;
  if (integers == Integers::Any) return true;
  const bool is_signed = c == Component::Int8 || c == Component::Int16;
  return accessor.normalized && is_signed == (integers == Integers::NormalizedSigned);
}

Checked check_attribute(const Document& document, const std::string& name,
                        const std::map<std::string, int>& attributes, const Attribute& expected,
                        std::uint64_t vertices) {
  const Index index = attribute(attributes, expected.semantic);
  if (!index) return {};
  const std::string subject = name + ": " + printable(expected.semantic) + " " + label("accessor", *index);
  if (*index >= document.accessors.size()) return malformed(subject + " is not there");
  const Accessor& accessor = document.accessors[*index];
  const Shape shape = shape_of(accessor);
  if (shape.columns != 1 || shape.rows < expected.least_rows || shape.rows > expected.most_rows ||
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

Checked check_index_count(const std::string& name, int mode, std::uint64_t count) {
  const bool whole = mode == TINYGLTF_MODE_TRIANGLES ? count % 3 == 0 : count >= 3;
  if (whole) return {};
  return malformed(name + ": " + std::to_string(count) + " vertices do not make whole triangles");
}

Checked check_indices(const Document& document, const std::string& name, std::uint32_t index,
                      std::uint64_t vertices) {
  const std::string subject = name + ": index " + label("accessor", index);
  if (index >= document.accessors.size()) return malformed(subject + " is not there");
  const Accessor& accessor = document.accessors[index];
  const Component c = component_of(accessor);
  const bool is_unsigned = c == Component::UInt8 || c == Component::UInt16 || c == Component::UInt32;
  if (!is_unsigned || !has_shape(accessor, 1) || accessor.normalized)
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
  const auto texture = texture_of(document, primitive);
  return texture ? "TEXCOORD_" + std::to_string(texture->texcoord) : "";
}

Checked check_primitive(const Document& document, const std::string& name, const Primitive& primitive,
                        std::uint64_t& left) {
  if (primitive.mode > TINYGLTF_MODE_TRIANGLE_FAN)
    return malformed(name + ": unknown mode " + std::to_string(primitive.mode));
  if (!points_into(document.materials, primitive.material))
    return malformed(name + ": there is no " + label("material", primitive.material));
  const Index position = attribute(primitive, "POSITION"), index = index_of(primitive.indices);
  if (!position || !draws_triangles(primitive)) return {};
  if (*position >= document.accessors.size())
    return malformed(name + ": POSITION " + label("accessor", *position) + " is not there");
  const std::uint64_t vertices = document.accessors[*position].count;
  const std::uint64_t indices =
      index && *index < document.accessors.size() ? document.accessors[*index].count : vertices;
  if (vertices + indices > left)
    return fail(Fault::OutOfRange, name + ": more vertices than a file of this size should have");
  left -= vertices + indices;
  const Attribute attributes[] = {{"POSITION", 3, 3, Integers::Any},
                                  {"NORMAL", 3, 3, Integers::NormalizedSigned},
                                  {"COLOR_0", 3, 4, Integers::NormalizedUnsigned},
                                  {texcoord_semantic(document, primitive), 2, 2, Integers::Any}};
  for (const Attribute& expected : attributes)
    if (auto checked = check_attribute(document, name, primitive.attributes, expected, vertices); !checked)
      return checked;
  return check_positions(document, name, *position)
      .and_then([&] { return index ? check_indices(document, name, *index, vertices) : Checked{}; })
      .and_then([&] { return check_index_count(name, primitive.mode, indices); });
}

/// Morph targets, and the joints and weights of a skin.
Checked check_deforming(const Document& document, const std::string& name, const Primitive& primitive) {
  const Index position = attribute(primitive, "POSITION");
  if (!position || !draws_triangles(primitive)) return {};
  const std::uint64_t vertices = document.accessors[*position].count;
  for (const auto& target : primitive.targets)
    for (const char* semantic : {"POSITION", "NORMAL"})
      if (auto checked = check_attribute(document, name + ", morph target", target,
                                         {semantic, 3, 3, Integers::Any}, vertices);
          !checked)
        return checked;
  return check_attribute(document, name, primitive.attributes,
                         {"WEIGHTS_0", 4, 4, Integers::NormalizedUnsigned}, vertices)
      .and_then([&]() -> Checked {
        const Index joints = attribute(primitive, "JOINTS_0");
        if (!joints) return {};
        const std::string subject = name + ": JOINTS_0 " + label("accessor", *joints);
        if (*joints >= document.accessors.size()) return malformed(subject + " is not there");
        const Accessor& accessor = document.accessors[*joints];
        const Component component = component_of(accessor);
        const bool whole = component == Component::UInt8 || component == Component::UInt16;
        if (!whole || accessor.normalized || !has_shape(accessor, 4) || accessor.count != vertices)
          return malformed(subject + " should have four unsigned integers for each vertex");
        return {};
      });
}

/// `left`: the numbers that all skins together may still have.
Checked check_skin(const Document& document, std::size_t index, const Skin& skin, std::uint64_t& left) {
  const std::string name = label("skin", index, skin.name);
  if (skin.joints.empty()) return malformed(name + " has no joints");
  for (const int joint : skin.joints)
    if (!points_into(document.nodes, joint)) return malformed(name + ": there is no " + label("node", joint));
  std::uint64_t matrices = skin.joints.size();
  const Index inverse_bind = index_of(skin.inverseBindMatrices);
  if (inverse_bind) {
    const std::string subject = name + ": inverse bind matrices, " + label("accessor", *inverse_bind);
    if (*inverse_bind >= document.accessors.size()) return malformed(subject + " is not there");
    const Accessor& accessor = document.accessors[*inverse_bind];
    if (component_of(accessor) != Component::Float || !has_shape(accessor, 4, 4) ||
        accessor.count < skin.joints.size())
      return malformed(subject + " should have a matrix of floats for each joint");
    matrices += accessor.count;
  }
  if (16 * matrices > left)
    return fail(Fault::OutOfRange, name + ": more joints than a file of this size should have");
  left -= 16 * matrices;
  if (!inverse_bind) return {};
  const auto is_near = [](const glm::vec4& v) {
    return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z), std::abs(v.w)}) <= kMaxCoordinate;
  };
  for (const glm::mat4& m : read_matrices(document, *inverse_bind))
    if (!is_near(m[0]) || !is_near(m[1]) || !is_near(m[2]) || !is_near(m[3]))
      return fail(Fault::OutOfRange, name + ": an inverse bind matrix has numbers beyond 1e9");
  return {};
}

/// What a node reads and makes: instances, and if it deforms its mesh, joints, vertices and indices of its
/// own. Flat triangles and parts (stereo/scene/mesh_parts.h) may have three vertices for each triangle.
std::uint64_t cost_of(const Document& document, const Node& node, bool has_track) {
  const Mesh& mesh = at(document.meshes, node.mesh);
  const bool deforms = node.skin >= 0 || has_track || !node.weights.empty() || !mesh.weights.empty();
  std::uint64_t cost = 1 + mesh.primitives.size() + node.weights.size() + mesh.weights.size();
  for (const Primitive& primitive : mesh.primitives) {
    const Index position = attribute(primitive, "POSITION"), index = index_of(primitive.indices);
    if (!deforms || !position || !draws_triangles(primitive)) continue;
    const std::uint64_t vertices = document.accessors[*position].count;
    const std::uint64_t indices = index ? document.accessors[*index].count : vertices;
    const std::uint64_t corners = primitive.mode == TINYGLTF_MODE_TRIANGLES ? indices : 3 * indices;
    cost += (vertices + corners) * (1 + primitive.targets.size());
  }
  if (node.skin >= 0) cost += 16 * at(document.skins, node.skin).joints.size();
  return cost;
}

Checked check_joints(const Document& document, const std::string& name, const Node& node) {
  if (node.skin < 0) return {};
  const auto joints = static_cast<float>(at(document.skins, node.skin).joints.size());
  for (const Primitive& primitive : at(document.meshes, node.mesh).primitives) {
    const Index named = attribute(primitive, "JOINTS_0");
    if (!attribute(primitive, "POSITION") || !draws_triangles(primitive) || !named) continue;
    for (const glm::vec4& of_vertex : read_vectors<4>(document, *named))
      if (std::max({of_vertex.x, of_vertex.y, of_vertex.z, of_vertex.w}) >= joints)
        return malformed(name + ": a vertex names a joint that its skin does not have");
  }
  return {};
}

/// Bounds what nodes make of meshes that they share, and checks the joints that skinned meshes name.
Checked check_mesh_nodes(const Document& document) {
  std::uint64_t left = element_budget(document);
  const std::set<int> tracks = nodes_with_moving(document, "weights");
  return check_each(document.nodes, [&](std::size_t index, const Node& node) -> Checked {
    if (node.mesh < 0) return {};
    const std::string name = label("node", index, node.name);
    const std::uint64_t cost = cost_of(document, node, tracks.contains(static_cast<int>(index)));
    if (cost > left)
      return fail(Fault::OutOfRange,
                  name + ": its mesh is shown or deformed more often than in a file of this size should be");
    left -= cost;
    return check_joints(document, name, node);
  });
}

Checked check_image(const Document& document, std::size_t index, const tinygltf::Image& image) {
  if (points_into(document.bufferViews, image.bufferView)) return {};
  return malformed(label("image", index, image.name) + ": there is no " +
                   label("buffer view", image.bufferView));
}

bool is_wrap(int wrap) {
  return wrap == TINYGLTF_TEXTURE_WRAP_REPEAT || wrap == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT ||
         wrap == TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE;
}

Checked check_texture(const Document& document, std::size_t index, const tinygltf::Texture& texture) {
  const std::string name = label("texture", index, texture.name);
  if (const Index image = image_of(texture); image && *image >= document.images.size())
    return malformed(name + ": there is no " + label("image", *image));
  if (!points_into(document.samplers, texture.sampler))
    return malformed(name + ": there is no " + label("sampler", texture.sampler));
  if (texture.sampler < 0) return {};
  const tinygltf::Sampler& sampler = at(document.samplers, texture.sampler);
  if (!is_wrap(sampler.wrapS) || !is_wrap(sampler.wrapT))
    return malformed(label("sampler", texture.sampler) + ": unknown wrap mode");
  return {};
}

Checked check_material(const Document& document, std::size_t index, const Material& material) {
  const std::string name = label("material", index, material.name);
  if (const auto use = texture_of(material); use && use->texture >= document.textures.size())
    return malformed(name + ": there is no " + label("texture", use->texture));
  const glm::dvec4 color = base_color_of(material);
  if (std::min({color.x, color.y, color.z, color.w}) < 0 ||
      std::max({color.x, color.y, color.z, color.w}) > 1)
    return malformed(name + ": the base colour factor is outside of 0 to 1");
  if (material.alphaMode != "OPAQUE" && material.alphaMode != "MASK" && material.alphaMode != "BLEND")
    return malformed(name + ": unknown alpha mode '" + printable(material.alphaMode) + "'");
  return {};
}

Checked check_light(std::size_t index, const Light& light) {
  const std::string name = label("light", index, light.name);
  if (light.type != "point" && light.type != "spot" && light.type != "directional")
    return malformed(name + ": unknown type '" + printable(light.type) + "'");
  const LightValues values = values_of(light);
  if (std::min({values.color.x, values.color.y, values.color.z}) < 0.0)
    return malformed(name + ": its colour is negative");
  if (light.type == "spot" && !(values.inner_cone_rad < values.outer_cone_rad &&
                                values.outer_cone_rad <= std::numbers::pi / 2 + 1e-6))
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
