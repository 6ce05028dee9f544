#include "tests/oracle/scene_builder.h"

#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numbers>

#include "stereo/scene/mesh_parts.h"

namespace farshade {

Mesh triangle_soup(const std::vector<glm::vec3>& corners) {
  Mesh mesh;
  mesh.positions = corners;
  for (std::uint32_t i = 0; i + 2 < corners.size(); i += 3) {
    const glm::vec3 across = glm::cross(corners[i + 1] - corners[i], corners[i + 2] - corners[i]);
    const float size = glm::length(across);
    mesh.normals.insert(mesh.normals.end(), 3, size > 0 ? across / size : glm::vec3(0, 1, 0));
    mesh.triangles.emplace_back(i, i + 1, i + 2);
  }
  return mesh;
}

Mesh quad(const glm::vec3& center, const glm::vec3& half_u, const glm::vec3& half_v, float repeats) {
  const glm::vec3 a = center - half_u - half_v, b = center + half_u - half_v, c = center + half_u + half_v,
                  d = center - half_u + half_v;
  Mesh mesh = triangle_soup({a, b, c, a, c, d});
  mesh.uvs = {{0, repeats}, {repeats, repeats}, {repeats, 0}, {0, repeats}, {repeats, 0}, {0, 0}};
  return mesh;
}

Mesh box(const glm::vec3& center, const glm::vec3& half) {
  std::vector<glm::vec3> corners;
  for (int axis = 0; axis < 3; ++axis)
    for (const float side : {-1.0f, 1.0f}) {
      glm::vec3 out(0.0f), u(0.0f), v(0.0f);
      out[axis] = half[axis] * side;
      u[(axis + 1) % 3] = half[(axis + 1) % 3] * side;
      v[(axis + 2) % 3] = half[(axis + 2) % 3];
      const Mesh face = quad(center + out, u, v);
      corners.insert(corners.end(), face.positions.begin(), face.positions.end());
    }
  return triangle_soup(corners);
}

Mesh lampshade(float radius, float half_height) {
  std::vector<glm::vec3> corners;
  for (int i = 0; i < 3; ++i) {
    const float angle = 2 * std::numbers::pi_v<float> / 3 * static_cast<float>(i) + 0.3f;
    const glm::vec3 out(std::cos(angle), 0, std::sin(angle)), along(-out.z, 0, out.x);
    const Mesh panel = quad(out * radius, along * (radius * 0.7f), {0, half_height, 0});
    corners.insert(corners.end(), panel.positions.begin(), panel.positions.end());
  }
  return triangle_soup(corners);
}

glm::dquat toward(const glm::dvec3& direction) {
  const glm::dvec3 from(0, 0, -1), to = glm::normalize(direction);
  return glm::normalize(glm::dquat(1.0 + glm::dot(from, to), glm::cross(from, to)));
}

NodeTransform scaled(const glm::dvec3& scale) {
  NodeTransform transform;
  transform.scale = scale;
  return transform;
}

SceneBuilder::SceneBuilder(const glm::dvec3& shift) : shift_(shift) {
  Material white;
  white.double_sided = true;
  material(white);
}

std::uint32_t SceneBuilder::material(Material material) {
  scene_.materials.push_back(std::move(material));
  return static_cast<std::uint32_t>(scene_.materials.size() - 1);
}

std::uint32_t SceneBuilder::texture(Texture texture) {
  scene_.textures.push_back(std::move(texture));
  return static_cast<std::uint32_t>(scene_.textures.size() - 1);
}

std::uint32_t SceneBuilder::node(NodeTransform transform) {
  if (transform.matrix)
    (*transform.matrix)[3] += glm::dvec4(shift_, 0.0);
  else
    transform.translation += shift_;
  scene_.nodes.push_back({"", std::nullopt, transform, false});
  return static_cast<std::uint32_t>(scene_.nodes.size() - 1);
}

std::uint32_t SceneBuilder::add(Mesh mesh, std::uint32_t material, NodeTransform transform) {
  mesh.material = material;
  scene_.triangle_count += mesh.triangles.size();
  scene_.meshes.push_back(std::move(mesh));
  const std::uint32_t place = node(transform);
  scene_.instances.push_back({static_cast<std::uint32_t>(scene_.meshes.size() - 1), place});
  return place;
}

std::uint32_t SceneBuilder::joint(std::optional<std::uint32_t> parent, const glm::dvec3& position) {
  NodeTransform transform;
  transform.translation = parent ? position : position + shift_;
  scene_.nodes.push_back({"", parent, transform, false});
  return static_cast<std::uint32_t>(scene_.nodes.size() - 1);
}

std::uint32_t SceneBuilder::add_deformed(std::vector<Mesh> meshes, Rig rig) {
  const RigPose pose = pose_of(scene_, rig, stage_from_nodes(scene_, Time{}), Time{});
  const auto place = rig.joints.empty() ? node({}) : rig.joints[0].node;
  scene_.rigs.push_back(std::move(rig));
  const auto number = static_cast<std::uint32_t>(scene_.rigs.size() - 1);
  for (Mesh& mesh : meshes) {
    pose_at_start(pose, mesh);
    for (Mesh& part : parts_of(std::move(mesh))) {
      scene_.instances.push_back({static_cast<std::uint32_t>(scene_.meshes.size()), place, number});
      scene_.triangle_count += part.triangles.size();
      scene_.meshes.push_back(std::move(part));
    }
  }
  return number;
}

std::uint32_t SceneBuilder::light(LightSource source, const glm::dvec3& position,
                                  const glm::dvec3& direction) {
  NodeTransform transform;
  transform.translation = position;
  transform.rotation = toward(direction);
  source.node = node(transform);
  scene_.lights.push_back(source);
  return source.node;
}

std::uint32_t SceneBuilder::point_light(const glm::dvec3& position, std::optional<float> range_m) {
  LightSource source;
  source.range_m = range_m;
  return light(source, position, {0, 0, -1});
}

std::uint32_t SceneBuilder::spot_light(const glm::dvec3& position, const glm::dvec3& direction,
                                       float outer_cone_rad) {
  LightSource source;
  source.kind = LightKind::Spot;
  source.outer_cone_rad = outer_cone_rad;
  return light(source, position, direction);
}

std::uint32_t SceneBuilder::directional_light(const glm::dvec3& direction) {
  LightSource source;
  source.kind = LightKind::Directional;
  return light(source, glm::dvec3(0.0), direction);
}

void SceneBuilder::change(LightProperty property, const glm::vec4& from, const glm::vec4& to) {
  LightSource& light = scene_.lights.back();
  if (!light.animation) light.animation.emplace();
  light.animation->tracks.push_back({property, Interpolation::Linear, {0, 1}, {from, to}});
  if (property == LightProperty::Range) light.range_m = std::max(from.x, to.x);
  if (property == LightProperty::OuterCone) light.outer_cone_rad = std::max(from.x, to.x);
  if (property == LightProperty::Intensity) light.intensity = glm::vec3(std::max(from.x, to.x));
  scene_.animation_length_s = 1;
}

void SceneBuilder::move(std::uint32_t moved, const glm::dvec3& travel) {
  const glm::vec4 start(glm::vec3(scene_.nodes[moved].rest.translation), 0.0f);
  scene_.nodes[moved].moving = true;
  scene_.channels.push_back(
      {.node = moved, .keys_s = {0.0f, 1.0f}, .values = {start, start + glm::vec4(glm::vec3(travel), 0.0f)}});
  scene_.animation_length_s = 1;
}

void SceneBuilder::turn(std::uint32_t turned, double angle_rad) {
  const auto half = static_cast<float>(angle_rad / 2);
  scene_.nodes[turned].moving = true;
  scene_.channels.push_back({.node = turned,
                             .path = Path::Rotation,
                             .keys_s = {0.0f, 1.0f},
                             .values = {{0, 0, 0, 1}, {0, std::sin(half), 0, std::cos(half)}}});
  scene_.animation_length_s = 1;
}

void SceneBuilder::swing(std::uint32_t swung, double angle_rad) {
  const auto half = static_cast<float>(angle_rad / 2);
  scene_.nodes[swung].moving = true;
  scene_.channels.push_back(
      {.node = swung,
       .path = Path::Rotation,
       .keys_s = {0.0f, 1.0f},
       .values = {{-std::sin(half), 0, 0, std::cos(half)}, {std::sin(half), 0, 0, std::cos(half)}}});
  scene_.animation_length_s = 1;
}

Scene SceneBuilder::build() const {
  Scene scene = scene_;
  const SceneState state = state_at(scene, Time{});
  bool first = true;
  for (std::size_t i = 0; i < scene.instances.size(); ++i)
    for (const glm::vec3& vertex : scene.meshes[scene.instances[i].mesh].positions) {
      const glm::dvec3 p = state.stage_from_object[i](Point<Object>{vertex}).v;
      scene.bounds.low = first ? p : glm::min(scene.bounds.low, p);
      scene.bounds.high = first ? p : glm::max(scene.bounds.high, p);
      first = false;
    }
  return scene;
}

View look(const glm::dvec3& eye, const glm::dvec3& target, std::uint32_t side_px, double fov_rad) {
  const double half = fov_rad / 2;
  return {{toward(target - eye), eye}, {-half, half, half, -half}, {side_px, side_px}};
}

}  // namespace farshade
