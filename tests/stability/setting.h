/// Setting: all that a case of extremes is made of - a scene as a glTF file, a recorded head with its
/// headset, and what the client is asked - before it is written to disk and run through the real programs.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "stereo/head/head_recording.h"
#include "stereo/scene/scene.h"
#include "tests/unit/scene/gltf_builder.h"

namespace farshade::stability {

/// A glTF scene under construction. Nodes are in double, vertices in float, as glTF has them.
class SceneFile {
 public:
  /// Material 0 is white and double-sided.
  SceneFile();

  std::uint32_t material(const nlohmann::json& material);
  /// The mesh's number; `mesh.material` is its material.
  std::uint32_t mesh(const Mesh& mesh);
  /// A node that shows a mesh; `place` holds its translation, rotation, scale or matrix. Returns its number.
  std::uint32_t show(std::uint32_t mesh, nlohmann::json place = nlohmann::json::object());
  /// Both at once.
  std::uint32_t add(const Mesh& shape, nlohmann::json place = nlohmann::json::object()) {
    return show(mesh(shape), std::move(place));
  }

  void point_light(const glm::dvec3& position, double candela, double range_m = 0);
  void spot_light(const glm::dvec3& position, const glm::dvec3& direction, double candela, double cone_rad);
  void sun(const glm::dvec3& direction, double lux);
  /// `node` travels by `travel` within a second, again and again.
  void move(std::uint32_t node, const glm::dvec3& from, const glm::dvec3& travel);

  [[nodiscard]] GltfBuilder& file() { return file_; }
  [[nodiscard]] std::vector<std::byte> glb() const { return file_.glb(); }

 private:
  GltfBuilder file_;
};

[[nodiscard]] nlohmann::json vector3(const glm::dvec3& v);
[[nodiscard]] nlohmann::json at(const glm::dvec3& translation);
[[nodiscard]] nlohmann::json at(const glm::dvec3& translation, const glm::dvec3& scale);
/// Of the upper 3x3's columns and a translation.
[[nodiscard]] nlohmann::json by_matrix(const glm::dmat3& linear, const glm::dvec3& translation);

/// How a head that a setting records moves: from `from`, looking at `target`, it turns about its own y and
/// drifts.
struct Motion {
  glm::dvec3 from{0.5, 1.6, 2.5}, target{0, 0.4, 0};
  double turn_degrees_s = 20;
  glm::dvec3 drift_m_s{0.25, 0.1, -0.15};
  double faces_at_s = 0;  ///< when it looks at `target`
};

/// 200 samples a second for `length_s`, from stamp 1 s on.
[[nodiscard]] HeadRecording recorded(const Motion& motion, double length_s);

/// When the last of so many frames is shown, seconds into the recording.
[[nodiscard]] double last_shown_s(std::uint32_t frames);

[[nodiscard]] EyeFov degrees(double left, double right, double up, double down);

struct Setting {
  SceneFile scene;
  HeadRecording head;  ///< rows as they are to stand in the file, whatever their stamps
  Extent size{96, 96};
  double delay_ms = 20;
  std::uint32_t frames = 8;
  std::vector<std::string> options{};  ///< of the client, beside those above

  void set_fov(const EyeFov& fov) { head.fov = {fov, fov}; }
};

/// Where a scene lies and how large it is: all of it, head and lights, by these.
struct Frame {
  double scale = 1;
  glm::dvec3 origin{0.0};
};

/// A floor of 4 m, a box that floats over it, a post, three lights (point, spot, sun) and a head that looks
/// at them: what is ordinary. Within `frame`.
[[nodiscard]] Setting ordinary(const Frame& frame = {});

/// The same without its lights.
[[nodiscard]] Setting unlit(const Frame& frame = {});

}  // namespace farshade::stability
