/// ScenePlan: which features a scene, its lights and a session need. Everything else is left out.
///
/// The plan is one value, made once, and read by everything on both sides: tracer, packer and renderer. What
/// only a frame can tell, such as whether two views coincide, is decided per frame. The plan `Everything`
/// leaves nothing out, so that the saving can be measured.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "stereo/frame/eye_mask.h"
#include "stereo/scene/scene.h"

namespace farshade {

/// The limit of the geometric error of what a client draws, chosen by measurement (docs/detail.md).
inline constexpr float kDefaultDetail_px = 0.125f, kMostDetail_px = 16;

enum class PlanKind : std::uint8_t {
  Needed,      ///< the features that the scene needs
  Everything,  ///< every feature, whether or not the scene needs it
};

/// What a session may ask for. The defaults are those of a server, which plans for every possible session.
struct SessionNeeds {
  PlanKind kind = PlanKind::Needed;
  bool two_views = true;    ///< the eyes look from different places
  bool reprojects = true;   ///< masks are reprojected; false: they are traced for the shown views
  bool cube_mask = true;    ///< masks of all directions may be requested; only looked up if reprojected
  bool all_lights = false;  ///< lights that reach nothing keep their bits too
  float detail_px = 0;      ///< limit of the geometric error of what is drawn, pixels; 0: full detail
  friend bool operator==(const SessionNeeds&, const SessionNeeds&) = default;
};

/// Whether a light of the file is kept.
enum class LightStatus : std::uint8_t {
  Casts,       ///< kept: has a bit in every mask
  Dark,        ///< removed: its intensity is always 0
  OutOfReach,  ///< removed: its range or its cone ends before the scene begins, and neither ever moves
};

/// What drawing and tracing one mesh needs.
struct SurfaceNeeds {
  bool texture = false;       ///< a base colour texture: texture coordinates and a binding
  bool vertex_color = false;  ///< a colour per vertex
  bool alpha_test = false;    ///< the mesh has holes, in pictures and for rays
  bool back_test = false;     ///< the mesh is not seen from behind: primary rays pass its back faces
  friend auto operator<=>(const SurfaceNeeds&, const SurfaceNeeds&) = default;
};

/// What the tracer does for the scene.
struct TracePlan {
  std::vector<SurfaceNeeds> surfaces;  ///< one per mesh
  std::vector<bool> moves;   ///< one per instance: it is placed again whenever the scene's time changes
  bool skips_rays = true;    ///< no ray where a light cannot matter
  bool shares_views = true;  ///< views that coincide are traced once
  MaskLayout mask;
};

/// The dispatches that reproject masks and shade with them. Pictures are the same. What is faster depends on
/// the device (suited_passes in renderer.h).
enum class ShadingPasses : std::uint8_t {
  Sorted,  ///< one shades the easy pixels and lists the others, on which the next ones run
  Single,  ///< one shades all pixels
};

/// What the client does for the scene and the session.
struct DrawPlan {
  std::vector<SurfaceNeeds> surfaces;  ///< one per mesh, for pictures
  std::vector<bool> moves;             ///< one per instance: reprojection follows its motion
  bool lights_move = true;       ///< an animation moves lights, or changes a range or a cone. Changes by a
                                 ///< viewer are always followed.
  bool ranges_and_cones = true;  ///< some light has a range or a cone
  bool other_eye = true;         ///< the other eye's masks are looked up
  bool depth_pass = true;        ///< requested views may differ from the shown ones
  bool cube_mask = true;         ///< masks of all directions about the head are kept and looked up
  bool builds_late = true;       ///< pipelines are created when first needed
  bool edge_rays = false;        ///< the client traces its own rays at shadow edges
  float detail_px = 0;           ///< limit of the geometric error of a level of detail; 0: full detail
  float ambient = 0;             ///< of the scene
  ShadingPasses passes = ShadingPasses::Sorted;
  MaskLayout mask;

  [[nodiscard]] bool anything_moves() const;
};

struct ScenePlan {
  PlanKind kind = PlanKind::Needed;
  std::vector<LightStatus> lights;  ///< one per light of the file
  bool server = true;               ///< some light casts shadows, so masks are requested
  TracePlan trace;
  DrawPlan draw;
};

/// The plan for `scene` as loaded from its file. Pure.
[[nodiscard]] ScenePlan plan_for(const Scene& scene, const SessionNeeds& needs = {});

/// A scene with only the lights that its plan keeps. Light i of the scene is bit i of every mask.
struct PlannedScene {
  Scene scene;
  ScenePlan plan;
};

/// Plans for `scene` and removes the lights that the plan leaves out. No picture changes.
[[nodiscard]] PlannedScene plan_scene(Scene scene, const SessionNeeds& needs = {});

/// The plan as text, one line per feature: what is on, what is left out and why, and what that saves.
[[nodiscard]] std::string in_words(const ScenePlan& plan, const Scene& scene);

/// A program's option --plan.
struct PlanOptions {
  PlanKind kind = PlanKind::Needed;
  bool prints_only = false;  ///< print the plan and exit
};

/// The value of --plan: "" prints the plan; "needed" and "everything" choose one.
[[nodiscard]] PlanOptions parse_plan_options(std::string_view text);

}  // namespace farshade
