/// Setting: the input of a stability case: a scene as a glTF file, a head recording with its headset, and
/// options of the client. It is written to disk and run through the real programs.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "stereo/head/head_recording.h"
#include "stereo/scene/scene.h"
#include "tests/unit/gltf/gltf_builder.h"

namespace farshade::stability {

/// A glTF scene under construction. Nodes are in double, vertices in float, as glTF has them.
class SceneFile {
 public:
  /// Material 0 is white and double-sided.
  SceneFile();

  std::uint32_t material(const nlohmann::json& material);
  /// Adds a mesh with material `mesh.material`. Returns its index.
  std::uint32_t mesh(const Mesh& mesh);
  /// Adds a node with a mesh; `place` holds translation, rotation, scale or matrix. Returns its index.
  std::uint32_t show(std::uint32_t mesh, nlohmann::json place = nlohmann::json::object());
  /// Adds a mesh and a node that shows it.
  std::uint32_t add(const Mesh& shape, nlohmann::json place = nlohmann::json::object()) {
    return show(mesh(shape), std::move(place));
  }

  void point_light(const glm::dvec3& position, double candela, double range_m = 0);
  void spot_light(const glm::dvec3& position, const glm::dvec3& direction, double candela, double cone_rad);
  void sun(const glm::dvec3& direction, double lux);
  /// Animates `node` by `travel` within a second, repeated.
  void move(std::uint32_t node, const glm::dvec3& from, const glm::dvec3& travel);

  [[nodiscard]] GltfBuilder& file() { return file_; }
  [[nodiscard]] std::vector<std::byte> glb() const { return file_.glb(); }

 private:
  GltfBuilder file_;
};

[[nodiscard]] nlohmann::json vector3(const glm::dvec3& v);
[[nodiscard]] nlohmann::json at(const glm::dvec3& translation);
[[nodiscard]] nlohmann::json at(const glm::dvec3& translation, const glm::dvec3& scale);
/// The glTF matrix with the columns of a 3x3 matrix and a translation.
[[nodiscard]] nlohmann::json by_matrix(const glm::dmat3& linear, const glm::dvec3& translation);

/// The motion of a recorded head: it starts at `from`, looks at `target`, turns about its own y axis and
/// drifts.
struct Motion {
  glm::dvec3 from{0.5, 1.6, 2.5}, target{0, 0.4, 0};
  double turn_degrees_s = 20;
  glm::dvec3 drift_m_s{0.25, 0.1, -0.15};
  double faces_at_s = 0;  ///< time at which it looks at `target`
};

/// 200 samples per second for `length_s`, starting at stamp 1 s.
[[nodiscard]] HeadRecording recorded(const Motion& motion, double length_s);

/// Time in the recording, s, at which the last of `frames` frames is shown.
[[nodiscard]] double last_shown_s(std::uint32_t frames);

[[nodiscard]] EyeFov degrees(double left, double right, double up, double down);

struct Setting {
  SceneFile scene;
  HeadRecording head;  ///< rows for the file, with any stamps
  Extent size{96, 96};
  double delay_ms = 20;
  std::uint32_t frames = 8;
  std::vector<std::string> options{};  ///< further options of the client

  void set_fov(const EyeFov& fov) { head.fov = {fov, fov}; }
};

/// Position and scale of a whole scene with head and lights.
struct Frame {
  double scale = 1;
  glm::dvec3 origin{0.0};
};

/// The ordinary case in `frame`: a floor of 4 m, a box that floats above it, a post, three lights (point,
/// spot, sun) and a head that looks at them.
[[nodiscard]] Setting ordinary(const Frame& frame = {});

/// The same without its lights.
[[nodiscard]] Setting unlit(const Frame& frame = {});

}  // namespace farshade::stability
