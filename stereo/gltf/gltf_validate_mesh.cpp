/// Validation of meshes with their attributes and indices, of skins and morph targets, and of lights.
#include <cmath>
#include <numbers>
#include <utility>

#include "stereo/gltf/gltf_accessor.h"
#include "stereo/gltf/gltf_materials.h"
#include "stereo/gltf/gltf_stages.h"

namespace farshade::gltf {
namespace {

/// Largest coordinate of a vertex, in units of its space. Its square is far below the largest float.
constexpr double kMaxCoordinate = 1e9;

/// An attribute, and the elements that it may have with KHR_mesh_quantization.
struct Attribute {
  std::string semantic;
  Elements elements;
};

Checked check_positions(const Document& document, const std::string& name, std::uint32_t index) {
  const auto positions = read_vectors<3>(document, index);
  const auto is_far = [](const glm::vec3& p) { return !lies_within(kMaxCoordinate, p); };
  const auto far = std::find_if(positions.begin(), positions.end(), is_far);
  if (far == positions.end()) return {};
  return malformed(name + ": POSITION " + label("accessor", index) + ": vertex " +
                   std::to_string(far - positions.begin()) + " lies beyond 1e9");
}

Checked check_indices(Document& document, const std::string& name, const Primitive& primitive,
                      std::uint64_t vertices) {
  if (primitive.indices < 0) return {};
  const auto found = accessor_of(document, name + ": index", primitive.indices, {kUnsigned | kUnsigned32, 1},
                                 "should hold unsigned integers");
  if (!found) return tl::unexpected(found.error());
  const auto indices = read_indices(document, static_cast<std::uint32_t>(primitive.indices));
  const auto worst = std::max_element(indices.begin(), indices.end());
  if (*worst >= vertices)
    document.repairs.add("its triangles are not drawn",
                         name + ": index " + label("accessor", primitive.indices) + ": index " +
                             std::to_string(*worst) + " is beyond the " + std::to_string(vertices) +
                             " vertices");
  return {};
}

const Attribute kPosition{"POSITION", {kFloatsOrShort, 3}};

/// What no triangle can do without: vertices and indices.
Checked check_shape(Document& document, const std::string& name, const Primitive& primitive, Budget& left) {
  const auto found = accessor_at(document, name + ": POSITION", primitive.attributes.at("POSITION"));
  if (!found) return tl::unexpected(found.error());
  const std::uint64_t vertices = (*found)->count;
  const std::uint64_t indices = primitive.indices >= 0 && points_into(document.accessors, primitive.indices)
                                    ? at(document.accessors, primitive.indices).count
                                    : vertices;
  const auto position = static_cast<std::uint32_t>(primitive.attributes.at("POSITION"));
  const Checked checked =
      left.take(vertices + indices, name + ": more vertices than a file of this size should have")
          .and_then([&] {
            return attribute_of(document, name + ": POSITION", position, kPosition.elements, vertices,
                                "vertices");
          })
          .and_then([&](const Accessor*) { return check_positions(document, name, position); })
          .and_then([&] { return check_indices(document, name, primitive, vertices); });
  const std::string few = name + ": " + std::to_string(indices) + " vertices do not make whole triangles";
  if (checked && indices < 3) return malformed(few);
  if (checked && primitive.mode == TINYGLTF_MODE_TRIANGLES && indices % 3 != 0)
    document.repairs.add("the last ones are not drawn", few);
  return checked;
}

/// Removes the attributes, of a primitive or of a morph target, that do not fit what is expected of them.
void keep_attributes(Document& document, const std::string& name, std::span<const Attribute> expected,
                     std::uint64_t vertices, std::map<std::string, int>& attributes) {
  for (const Attribute& one : expected) {
    const Index index = attribute(attributes, one.semantic);
    if (!index) continue;
    const auto found = attribute_of(document, name + ": " + printable(one.semantic), *index, one.elements,
                                    vertices, "vertices");
    if (found) continue;
    document.repairs.add("it is drawn without this attribute", found.error());
    attributes.erase(one.semantic);
  }
}

Checked check_primitive(Document& document, const std::string& name, Primitive& primitive, Budget& left) {
  if (!points_into(document.materials, primitive.material)) {
    document.repairs.add("it has the default material",
                         name + ": there is no " + label("material", primitive.material));
    primitive.material = -1;
  }
  Checked shape = primitive.mode > TINYGLTF_MODE_TRIANGLE_FAN
                      ? Checked(malformed(name + ": unknown mode " + std::to_string(primitive.mode)))
                      : Checked{};
  if (shape && (!has_triangles(primitive))) return {};
  shape = shape.and_then([&] { return check_shape(document, name, primitive, left); });
  if (!shape) return mended(std::move(shape), document.repairs, kNotDrawn, [&] { primitive = {}; });
  const std::uint64_t vertices = at(document.accessors, primitive.attributes.at("POSITION")).count;
  const auto texture = texture_of(document, primitive);  // other TEXCOORD_n are not read
  const Attribute attributes[] = {{"NORMAL", {kFloats | kNormalizedSigned, 3}},
                                  {"COLOR_0", {kFloats | kNormalizedUnsigned, 3, 4}},
                                  {texture ? texture->semantic() : "", {kFloatsOrShort, 2}},
                                  {"WEIGHTS_0", {kFloats | kNormalizedUnsigned, 4}},
                                  {"JOINTS_0", {kUnsigned, 4}}};
  keep_attributes(document, name, attributes, vertices, primitive.attributes);
  const Attribute moved[] = {kPosition, {"NORMAL", {kFloatsOrShort, 3}}};
  for (auto& target : primitive.targets)
    keep_attributes(document, name + ", morph target", moved, vertices, target);
  return {};
}

/// `left`: the numbers that all skins together may still have.
Checked check_skin(const Document& document, std::size_t index, const Skin& skin, Budget& left) {
  const std::string name = label("skin", index, skin.name);
  for (const int joint : skin.joints)
    if (!points_into(document.nodes, joint)) return malformed(name + ": there is no " + label("node", joint));
  std::uint64_t matrices = skin.joints.size();
  const Index inverse_bind = index_of(skin.inverseBindMatrices);
  if (inverse_bind) {
    const std::string user = name + ": inverse bind", fault = "should have a matrix of floats for each joint";
    const auto found = accessor_of(document, user, skin.inverseBindMatrices, {kFloats, 4, 4, 4}, fault);
    if (!found) return tl::unexpected(found.error());
    if ((*found)->count < skin.joints.size())
      return malformed(user + " " + label("accessor", *inverse_bind) + " " + fault);
    matrices += (*found)->count;
  }
  const Checked taken = left.take(16 * matrices, name + ": more joints than a file of this size should have");
  if (!taken || !inverse_bind) return taken;
  for (const glm::mat4& m : read_matrices(document, *inverse_bind))
    for (int column = 0; column < 4; ++column)
      if (!lies_within(kMaxCoordinate, m[column]))
        return malformed(name + ": an inverse bind matrix has numbers beyond 1e9");
  return {};
}

/// What a node reads and makes: instances, and if it deforms its mesh, joints, vertices and indices of its
/// own. Flat triangles and parts (stereo/scene/mesh_parts.h) may have three vertices for each triangle.
std::uint64_t cost_of(const Document& document, const Node& node, bool has_track) {
  const Mesh& mesh = at(document.meshes, node.mesh);
  const bool deforms = node.skin >= 0 || has_track || !node.weights.empty() || !mesh.weights.empty();
  std::uint64_t cost = 1 + mesh.primitives.size() + node.weights.size() + mesh.weights.size();
  for (const Primitive& primitive : mesh.primitives) {
    const Index index = index_of(primitive.indices);
    if (!deforms) break;
    const std::uint64_t vertices = document.accessors[*attribute(primitive, "POSITION")].count;
    const std::uint64_t indices = index ? document.accessors[*index].count : vertices;
    const std::uint64_t corners = primitive.mode == TINYGLTF_MODE_TRIANGLES ? indices : 3 * indices;
    cost += (vertices + corners) * (1 + primitive.targets.size());
  }
  if (node.skin >= 0) cost += 16 * at(document.skins, node.skin).joints.size();
  return cost;
}

Checked check_joints(const Document& document, const std::string& name, const Node& node) {
  if (node.skin < 0) return {};
  const auto has_both = [](const Primitive& p) {
    return attribute(p, "JOINTS_0") && attribute(p, "WEIGHTS_0");
  };
  if (std::ranges::none_of(at(document.meshes, node.mesh).primitives, has_both))
    return malformed(name + ": its mesh has no joints and weights for its skin");
  const auto joints = static_cast<float>(at(document.skins, node.skin).joints.size());
  for (const Primitive& primitive : at(document.meshes, node.mesh).primitives) {
    const Index named = attribute(primitive, "JOINTS_0");
    if (!named) continue;
    for (const glm::vec4& of_vertex : read_vectors<4>(document, *named))
      if (std::max({of_vertex.x, of_vertex.y, of_vertex.z, of_vertex.w}) >= joints)
        return malformed(name + ": a vertex names a joint that its skin does not have");
  }
  return {};
}

constexpr const char* kUnskinned = "meshes are drawn without it";

/// Bounds what nodes make of meshes that they share, and checks the joints that skinned meshes name.
Checked check_mesh_nodes(Document& document) {
  Budget left(element_budget(document));
  const std::set<int> tracks = nodes_with_moving(document, "weights");
  return check_each(document.nodes, [&](std::size_t index, Node& node) -> Checked {
    if (node.mesh < 0) return {};
    const std::string name = label("node", index, node.name);
    const std::uint64_t cost = cost_of(document, node, tracks.contains(static_cast<int>(index)));
    return left
        .take(cost, name + ": its mesh is shown or deformed more often than in a file of this size should be")
        .and_then([&] {
          return mended(check_joints(document, name, node), document.repairs, kUnskinned,
                        [&] { node.skin = -1; });
        });
  });
}

/// Brings the values of a light into their limits. A light of no kind gets an empty type.
void mend_light(std::size_t index, Light& light, Repairs& repairs) {
  constexpr double kWidest_rad = std::numbers::pi / 2;
  const std::string name = label("light", index, light.name);
  if (light.type != "point" && light.type != "spot" && light.type != "directional") {
    if (!light.type.empty())
      repairs.add("it is left out", name + ": unknown type '" + printable(light.type) + "'");
    light.type.clear();
    return;
  }
  const bool is_negative = std::ranges::any_of(light.color, [](double c) { return c < 0; });
  if (is_negative) repairs.add("negative parts become 0", name + ": its colour is negative");
  for (double& c : light.color) c = std::max(c, 0.0);
  double &inner = light.spot.innerConeAngle, &outer = light.spot.outerConeAngle;
  if (light.type != "spot" || (inner < outer && outer <= kWidest_rad + 1e-6)) return;
  repairs.add("it is cut off", name + ": the cone should be 0 <= inner < outer <= pi/2");
  outer = outer > 0 ? std::min(outer, kWidest_rad) : tinygltf::SpotLight().outerConeAngle;
  inner = std::min(inner, 0.999 * outer);
}

}  // namespace

void validate_lights(Document& document) {
  for (std::size_t i = 0; i < document.lights.size(); ++i)
    mend_light(i, document.lights[i], document.repairs);
}

Checked validate_meshes(Document& document) {
  Budget left(element_budget(document));
  return check_each(document.meshes, [&](std::size_t m, Mesh& mesh) {
    const Checked checked = check_each(mesh.primitives, [&](std::size_t p, Primitive& primitive) {
      const std::string name = label("mesh", m, mesh.name) + ", " + label("primitive", p);
      return check_primitive(document, name, primitive, left);
    });
    std::erase_if(mesh.primitives, [](const Primitive& primitive) { return !has_triangles(primitive); });
    return checked;
  });
}

Checked validate_deformations(Document& document) {
  Budget left(element_budget(document));
  return check_each(document.skins,
                    [&](std::size_t i, Skin& skin) {
                      return mended(check_skin(document, i, skin, left), document.repairs, kUnskinned,
                                    [&] { skin.joints.clear(); });
                    })
      .and_then([&] {
        for (Node& node : document.nodes)
          if (node.skin >= 0 && at(document.skins, node.skin).joints.empty()) node.skin = -1;
        return check_mesh_nodes(document);
      });
}

}  // namespace farshade::gltf
