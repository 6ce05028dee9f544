/// SceneBuilder: makes scenes in code, for tests whose expected results are known on paper.
#pragma once

#include <string_view>

#include "stereo/frame/view.h"
#include "stereo/scene/scene_state.h"

namespace farshade {

/// Two triangles spanned by `half_u` and `half_v` around `center`. The counter-clockwise side is the one that
/// cross(half_u, half_v) points to. Texture coordinates run from 0 to `repeats`.
[[nodiscard]] Mesh quad(const glm::vec3& center, const glm::vec3& half_u, const glm::vec3& half_v,
                        float repeats = 1.0f);

/// Closed axis-aligned box with flat normals, counter-clockwise as seen from outside.
[[nodiscard]] Mesh box(const glm::vec3& center, const glm::vec3& half);

/// Triangles of three corners each, with flat normals.
[[nodiscard]] Mesh triangle_soup(const std::vector<glm::vec3>& corners);

/// Three upright panels around the y axis, `radius` away from it and 1.4 times as wide, with gaps between
/// them. A hollow mesh: its bounding box contains the origin, and the corners of the box lie outside of the
/// panels.
[[nodiscard]] Mesh lampshade(float radius, float half_height);

/// A rotation that turns -z to `direction`, which must not be exactly +z.
[[nodiscard]] glm::dquat toward(const glm::dvec3& direction);

[[nodiscard]] NodeTransform scaled(const glm::dvec3& scale);

class SceneBuilder {
 public:
  /// Moves everything by `shift` in the stage, for scenes far from the origin.
  explicit SceneBuilder(const glm::dvec3& shift = glm::dvec3(0.0));

  std::uint32_t material(Material material);
  std::uint32_t texture(Texture texture);
  /// Returns the instance's node.
  std::uint32_t add(Mesh mesh, std::uint32_t material = 0, NodeTransform transform = {});
  /// Adds meshes with deformables, in parts, with their own materials. Returns the rig.
  std::uint32_t add_deformed(std::vector<Mesh> meshes, Rig rig);
  /// A node below `parent`, at `position` from it.
  std::uint32_t joint(std::optional<std::uint32_t> parent, const glm::dvec3& position);
  std::uint32_t point_light(const glm::dvec3& position, std::optional<float> range_m = std::nullopt);
  std::uint32_t spot_light(const glm::dvec3& position, const glm::dvec3& direction, float outer_cone_rad);
  std::uint32_t directional_light(const glm::dvec3& direction);
  /// Changes a property of the last light linearly over one second. The animation repeats.
  void change(LightProperty property, const glm::vec4& from, const glm::vec4& to);
  /// Moves `node` linearly by `travel` over one second. The animation repeats.
  void move(std::uint32_t node, const glm::dvec3& travel);
  /// Turns `node` about the y axis by `angle_rad` (less than pi) over one second. The animation repeats.
  void turn(std::uint32_t node, double angle_rad);
  /// Turns `node` about the x axis from `-angle_rad` to `angle_rad` over one second. The animation repeats.
  void swing(std::uint32_t node, double angle_rad);

  /// Material 0 is double-sided white.
  [[nodiscard]] Scene build() const;

 private:
  std::uint32_t node(NodeTransform transform);
  std::uint32_t light(LightSource source, const glm::dvec3& position, const glm::dvec3& direction);

  glm::dvec3 shift_;
  Scene scene_;
};

/// A camera at `eye` that looks at `target`, square, `fov_rad` wide.
[[nodiscard]] View look(const glm::dvec3& eye, const glm::dvec3& target, std::uint32_t side_px,
                        double fov_rad = 1.4);

}  // namespace farshade
