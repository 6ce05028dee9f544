#include "tests/stability/setting.h"

#include <cmath>
#include <glm/gtc/type_ptr.hpp>
#include <numbers>

#include "stereo/head/reader.h"
#include "stereo/math/rotation.h"
#include "tests/oracle/scene_builder.h"

namespace farshade::stability {
namespace {

using nlohmann::json;

constexpr double kDegree = std::numbers::pi / 180;

json rotation_json(const glm::dquat& q) {
  return {q.x, q.y, q.z, q.w};
}

}  // namespace

json vector3(const glm::dvec3& v) {
  return {v.x, v.y, v.z};
}

json at(const glm::dvec3& translation) {
  return {{"translation", vector3(translation)}};
}

json at(const glm::dvec3& translation, const glm::dvec3& scale) {
  return {{"translation", vector3(translation)}, {"scale", vector3(scale)}};
}

json by_matrix(const glm::dmat3& linear, const glm::dvec3& translation) {
  glm::dmat4 m(linear);
  m[3] = glm::dvec4(translation, 1.0);
  return {{"matrix", std::vector<double>(glm::value_ptr(m), glm::value_ptr(m) + 16)}};
}

SceneFile::SceneFile() {
  material({{"doubleSided", true}});
}

std::uint32_t SceneFile::material(const json& material) {
  file_.json["materials"].push_back(material);
  return static_cast<std::uint32_t>(file_.json["materials"].size() - 1);
}

std::uint32_t SceneFile::mesh(const Mesh& mesh) {
  const auto count = mesh.positions.size();
  std::vector<std::uint32_t> indices;
  for (const glm::uvec3& t : mesh.triangles) indices.insert(indices.end(), {t.x, t.y, t.z});
  const json primitive{{"attributes",
                        {{"POSITION", file_.positions(mesh.positions)},
                         {"NORMAL", file_.accessor(file_.view(mesh.normals), 5126, "VEC3", count)}}},
                       {"indices", file_.accessor(file_.view(indices), 5125, "SCALAR", indices.size())},
                       {"material", mesh.material}};
  file_.json["meshes"].push_back({{"primitives", {primitive}}});
  return static_cast<std::uint32_t>(file_.json["meshes"].size() - 1);
}

std::uint32_t SceneFile::show(std::uint32_t mesh, json place) {
  place["mesh"] = mesh;
  return file_.node(place);
}

void SceneFile::point_light(const glm::dvec3& position, double candela, double range_m) {
  json light{{"type", "point"}, {"intensity", candela}};
  if (range_m > 0) light["range"] = range_m;
  file_.node({{"translation", vector3(position)}, {"extensions", file_.light(light)}});
}

void SceneFile::spot_light(const glm::dvec3& position, const glm::dvec3& direction, double candela,
                           double cone_rad) {
  const json light{{"type", "spot"},
                   {"intensity", candela},
                   {"spot", {{"innerConeAngle", 0.8 * cone_rad}, {"outerConeAngle", cone_rad}}}};
  file_.node({{"translation", vector3(position)},
              {"rotation", rotation_json(toward(direction))},
              {"extensions", file_.light(light)}});
}

void SceneFile::sun(const glm::dvec3& direction, double lux) {
  const json light{{"type", "directional"}, {"intensity", lux}};
  file_.node({{"rotation", rotation_json(toward(direction))}, {"extensions", file_.light(light)}});
}

void SceneFile::move(std::uint32_t node, const glm::dvec3& from, const glm::dvec3& travel) {
  const auto keys = file_.accessor(file_.view<float>({0, 1}), 5126, "SCALAR", 2);
  const auto places =
      file_.accessor(file_.view<glm::vec3>({glm::vec3(from), glm::vec3(from + travel)}), 5126, "VEC3", 2);
  json& animation = file_.json["animations"][0];
  animation["channels"].push_back(
      {{"sampler", animation["samplers"].size()}, {"target", {{"node", node}, {"path", "translation"}}}});
  animation["samplers"].push_back({{"input", keys}, {"output", places}});
}

HeadRecording recorded(const Motion& motion, double length_s) {
  constexpr double kRate_hz = 200;
  HeadRecording recording;
  recording.fov = kDefaultFov;
  recording.eye_distance_m = kDefaultEyeDistance_m;
  const glm::dquat first = toward(motion.target - motion.from);
  for (int i = 0; i <= static_cast<int>(length_s * kRate_hz); ++i) {
    const double t = i / kRate_hz;
    const glm::dquat turn = rotation_exp({0, motion.turn_degrees_s * kDegree * (t - motion.faces_at_s), 0});
    recording.samples.push_back({time_from_ns(std::llround(1e9 + t * 1e9)),
                                 {glm::normalize(turn * first), motion.from + motion.drift_m_s * t}});
  }
  return recording;
}

double last_shown_s(std::uint32_t frames) {
  return (frames - 1) / 72.0;
}

EyeFov degrees(double left, double right, double up, double down) {
  return {left * kDegree, right * kDegree, up * kDegree, down * kDegree};
}

Setting unlit(const Frame& frame) {
  const double s = frame.scale;
  Setting setting;
  setting.scene.add(quad({0, 0, 0}, {0, 0, 2}, {2, 0, 0}), at(frame.origin, glm::dvec3(s)));
  setting.scene.add(box({0, 0.6f, 0}, {0.3f, 0.2f, 0.3f}), at(frame.origin, glm::dvec3(s)));
  setting.scene.add(box({0.7f, 0.35f, 0.4f}, {0.04f, 0.35f, 0.04f}), at(frame.origin, glm::dvec3(s)));
  Motion motion;
  motion.from = frame.origin + motion.from * s;
  motion.target = frame.origin + motion.target * s;
  motion.drift_m_s *= std::min(s, 10.0);  // no head moves at 20 m/s: predictors treat that as a jump
  setting.head = recorded(motion, 1);
  setting.head.eye_distance_m *= std::min(s, 1.0);
  setting.set_fov(degrees(-42, 35, 36, -40));
  return setting;
}

Setting ordinary(const Frame& frame) {
  const double s = frame.scale;
  Setting setting = unlit(frame);
  setting.scene.point_light(frame.origin + glm::dvec3(0.8, 2, 0.5) * s, 4 * s * s);
  setting.scene.spot_light(frame.origin + glm::dvec3(-1.2, 1.8, 0.9) * s, {1.1, -1.5, -0.8}, 5 * s * s, 0.6);
  setting.scene.sun({0.3, -1, -0.6}, 0.8);
  return setting;
}

}  // namespace farshade::stability
