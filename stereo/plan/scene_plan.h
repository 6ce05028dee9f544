/// ScenePlan: what a scene, its lights and a session need - and so what is left out, and why.
///
/// One value, made once and read by everything on both sides: tracer, packer, renderer. What only a frame can
/// tell, such as two views that coincide, is found where the frame is. `Everything` leaves nothing out, so
/// that the saving can be measured.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "stereo/frame/eye_mask.h"
#include "stereo/scene/scene.h"

namespace farshade {

enum class PlanKind : std::uint8_t {
  Needed,      ///< what the scene needs
  Everything,  ///< every feature on, whether or not the scene has any use for it
};

/// What a session may come to ask for. The defaults are those of a server, which plans for any session.
struct SessionNeeds {
  PlanKind kind = PlanKind::Needed;
  bool two_views = true;     ///< the eyes look from different places
  bool carries_over = true;  ///< masks of one view are carried to another; false: they fit the shown views
  bool all_lights = false;   ///< lights that reach nothing keep their bits too
  friend bool operator==(const SessionNeeds&, const SessionNeeds&) = default;
};

/// What becomes of a light of the file.
enum class LightFate : std::uint8_t {
  Casts,       ///< has a bit in every mask
  Dark,        ///< shines with no intensity at all
  OutOfReach,  ///< its range or its cone ends before the scene begins, and neither ever moves
};

/// What drawing and tracing one mesh takes.
struct SurfaceNeeds {
  bool texture = false;       ///< reads a base colour texture: texture coordinates, a binding
  bool vertex_color = false;  ///< reads a colour a vertex
  bool alpha_test = false;    ///< has holes, in pictures and for rays
  bool back_test = false;     ///< is not seen from behind: rays of eyes pass it from there
  friend auto operator<=>(const SurfaceNeeds&, const SurfaceNeeds&) = default;
};

/// What the tracer does for the scene.
struct TracePlan {
  std::vector<SurfaceNeeds> surfaces;  ///< one a mesh
  std::vector<bool> moves;             ///< one an instance: placed anew whenever the scene's time changes
  bool skips_rays = true;    ///< no ray where a light cannot matter, or where it is proved to be in sight
  bool shares_views = true;  ///< views that coincide are traced once
  MaskLayout mask;
};

/// What the client does for the scene and the session.
struct DrawPlan {
  std::vector<SurfaceNeeds> surfaces;  ///< one a mesh, for pictures
  std::vector<bool> moves;             ///< one an instance: points on it are carried back by its motion
  bool lights_move = true;             ///< by animation; what a viewer changes is always followed
  bool ranges_and_cones = true;        ///< some light has a range or a cone
  bool other_eye = true;               ///< the other eye's masks are looked up
  bool depth_pass = true;              ///< requested views may be others than the shown ones
  bool builds_late = true;             ///< pipelines are made when first needed
  MaskLayout mask;

  [[nodiscard]] bool anything_moves() const;
};

struct ScenePlan {
  PlanKind kind = PlanKind::Needed;
  std::vector<LightFate> lights;  ///< one a light of the file
  bool server = true;             ///< some light casts shadows: masks are asked for
  bool one_value_tiles = true;    ///< a light that is the same all over a tile is sent as one value
  TracePlan trace;
  DrawPlan draw;
};

/// What `scene`, as it came from its file, needs. Pure.
[[nodiscard]] ScenePlan plan_for(const Scene& scene, const SessionNeeds& needs = {});

/// A scene with only the lights that its plan keeps, so that light i of it is bit i of every mask.
struct PlannedScene {
  Scene scene;
  ScenePlan plan;
};

/// Plans for `scene` and takes from it the lights that are left out: no picture changes by that.
[[nodiscard]] PlannedScene plan_scene(Scene scene, const SessionNeeds& needs = {});

/// The plan in words, a line each: what is on, what is left out and why, and what that saves.
[[nodiscard]] std::string in_words(const ScenePlan& plan, const Scene& scene);

/// What a user asks of a program's plan.
struct PlanOptions {
  PlanKind kind = PlanKind::Needed;
  bool only_told = false;  ///< in words, and nothing else is done
};

/// As --plan has it: "" tells the plan, "needed" and "everything" choose one.
[[nodiscard]] PlanOptions parse_plan_options(std::string_view text);

}  // namespace farshade
