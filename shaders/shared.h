/// The structs that C++ and GLSL share. All members are mat4, vec4 or 32-bit words, so that their layout is
/// the same in std140, std430 and C++. All positions are float and relative to an eye; C++ computes them in
/// double first.
#ifndef FARSHADE_SHADERS_SHARED_H
#define FARSHADE_SHADERS_SHARED_H

#ifdef __cplusplus
#include <cstdint>
#include <glm/mat4x4.hpp>
#include <glm/vec4.hpp>
namespace farshade::gpu {
using glm::mat4;
using glm::uvec4;
using glm::vec4;
using uint = std::uint32_t;
#endif

/// One instance. A draw binds it as a uniform block, so its size is a multiple of the largest alignment that
/// a device may ask for.
struct InstanceData {
  mat4 clip_from_object[2];       // of each eye
  mat4 stage_from_object_normal;  // inverse transpose of the upper 3x3
  vec4 base_color;                // linear RGBA factor
  uint index;
  float alpha_cutoff;
  uint unused_x, unused_y;
  vec4 unused[2];
};

/// An eye's window on the plane z = -1. The ray through pixel position p has direction (origin + p * step,
/// -1).
struct WindowData {
  vec4 origin_step;  // origin.xy, step.xy
};

/// One shown eye.
struct EyeData {
  WindowData window;
  mat4 stage_from_eye;  // rotation only
  vec4 size_px;         // width, height, 1/width, 1/height
};

/// One light. Positions are relative to each eye, in stage axes.
struct LightData {
  vec4 position[2];     // xyz; w = 1 point or spot, 0 directional (xyz then points towards the light)
  vec4 intensity;       // rgb; w = 1/range^2, 0 = unlimited
  vec4 spot_direction;  // unit, the direction in which the light shines; w unused
  vec4 spot_cone;       // x = scale, y = offset of the cone's falloff (KHR_lights_punctual); 0, 1 = no cone
};

// The projection of a light's shadow map: none, the six faces of a cube (+x, -x, +y, -y, +z, -z), one
// perspective, or parallel.
#define FARSHADE_MAP_NONE 0u
#define FARSHADE_MAP_CUBE 1u
#define FARSHADE_MAP_WINDOW 2u
#define FARSHADE_MAP_PARALLEL 3u

/// One light's shadow map. The ray through the centre of the map starts at `origin` and has direction
/// `ahead`. A cube uses the axes of the stage.
struct ShadowMapData {
  vec4 right, up;  // unit, stage axes; w = texels per unit at distance 1, or per metre if parallel
  vec4 ahead;      // unit, stage axes; w = depth per metre, parallel only; of a light buffer: the depth of step 0, metres
  vec4 origin[2];  // relative to each eye, stage axes; parallel: the point with depth 0; w unused
  uvec4 place;     // x = FARSHADE_MAP_*, y = its first layer. Of a light buffer: y = its first word, z = bits of a
                   // triangle's number, w = float bits: metres of a step of the depths of triangles
};

#define FARSHADE_MAX_MASKS 4            // of views
#define FARSHADE_MAX_CUBE_MASK_PAIRS 3  // masks of the cube's faces, of two opposite faces each
#define FARSHADE_MAX_TRACED 7           // masks of both kinds
// The masks traced for this eye, in order, those for the other eye, and the faces of the cube mask.
#define FARSHADE_FIRST_FACE 8
#define FARSHADE_MAX_SOURCES 14
#define FARSHADE_MAX_MOVED 4  // bounding spheres of moved instances
// Groups of masks: the newest, older ones, and those of the cube mask.
#define FARSHADE_SINCE_NEWEST 0
#define FARSHADE_SINCE_OLDER 1
#define FARSHADE_SINCE_CUBE_MASK 2
#define FARSHADE_SINCE_GROUPS 3
#define FARSHADE_TILE_PX 16
#define FARSHADE_BLOCK_PX 4

/// One traced view, for lookups of one shown eye's points.
struct SourceData {
  mat4 traced_from_shown;
  vec4 origin_step;  // of the traced window: origin.xy, step.xy
  vec4 per_step;     // 1 / step.xy, size in pixels
  uvec4 place;       // x = layer of its depth in its image; first word: y = of its mask, z = of its known blocks; w unused
};

struct FrameData {
  EyeData eye[2];
  SourceData sources[2 * FARSHADE_MAX_SOURCES];  // the left eye's, then the right eye's
  // What has changed since the masks of each group (FARSHADE_SINCE_*) were traced: lights that have moved
  // (256 bits), and bounding spheres of instances that have, at their old and new places (relative to each
  // eye, stage axes; w = radius^2, negative if unused).
  uvec4 stale_lights[FARSHADE_SINCE_GROUPS * 2];
  uvec4 changed_lights[2];  // lights that the viewer has changed since a mask in use was traced
  vec4 moved[FARSHADE_SINCE_GROUPS * 2 * FARSHADE_MAX_MOVED];  // [group][eye][sphere]
  // Bounding spheres of all instances that can move, where they are now, [eye][sphere], as in `moved`.
  vec4 movable[2 * FARSHADE_MAX_MOVED];
  uvec4 ray_lights[2];  // lights that edge rays can be traced to
  vec4 background;                                             // linear
  vec4 ambient;  // linear factor of the base colour; 0 if the scene has lights of its own
  uvec4 counts;  // x = masks in use, y = 1 if edge rays can be traced to all lights, z = 1 if the newest mask's view
                 // is close enough to the shown view to guess from; w = faces of the cube mask in use
  vec4 direct;   // position in the newest mask of a shown position in the same direction: * xy + zw
};

#ifdef __cplusplus
}  // namespace farshade::gpu
#endif
#endif
