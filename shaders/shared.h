/// The structs that C++ and GLSL share, written once. Members are mat4, vec4 or 32-bit words, so that std140,
/// std430 and C++ lay them out alike. All positions are relative to an eye and float; C++ composed them in
/// double.
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

/// Where one instance is: clip space of each eye, and its normals in stage axes.
struct InstanceData {
  mat4 clip_from_object[2];
  mat4 stage_from_object_normal;  // inverse transpose of the upper 3x3
};

/// What a draw call says about its material.
struct DrawData {
  vec4 base_color;  // linear RGBA factor
  uint instance;
  float alpha_cutoff;
};

/// An eye's window on the plane z = -1: a pixel position p looks along (origin + p * step, -1).
struct WindowData {
  vec4 origin_step;  // origin.xy, step.xy
};

/// One eye that is shown.
struct EyeData {
  WindowData window;
  mat4 stage_from_eye;  // rotation only: eye-relative, stage axes
  vec4 size_px;         // width, height, 1/width, 1/height
};

/// One light, its place relative to each eye in stage axes.
struct LightData {
  vec4 position[2];     // xyz; w = 1 point or spot, 0 directional (xyz then points towards the light)
  vec4 intensity;       // rgb; w = 1/range^2, 0 = unlimited
  vec4 spot_direction;  // unit, the way the light travels; w unused
  vec4 spot_cone;       // x = scale, y = offset of the cone's falloff (KHR_lights_punctual); 0, 1 = no cone
};

// How a light's shadow map sees: not at all, through the six faces of a cube (+x, -x, +y, -y, +z, -z),
// through one window, or along one direction.
#define FARSHADE_MAP_NONE 0u
#define FARSHADE_MAP_CUBE 1u
#define FARSHADE_MAP_WINDOW 2u
#define FARSHADE_MAP_PARALLEL 3u

/// One light's shadow map. Its middle texel looks along `ahead` from `origin`; a cube has no axes of its own.
struct ShadowMapData {
  vec4 right, up;  // unit, stage axes; w = texels per unit: of the window at distance 1, parallel: per metre
  vec4 ahead;      // the same; w = depth per metre, parallel only
  vec4 origin[2];  // relative to each eye, stage axes; parallel: where depth is 0; w unused
  uvec4 place;     // x = FARSHADE_MAP_*, y = its first layer; z, w unused
};

#define FARSHADE_MAX_MASKS 4
#define FARSHADE_MAX_SOURCES 8  // each mask as traced for this eye, newest first, then each as for the other
#define FARSHADE_MAX_MOVED 4
#define FARSHADE_TILE_PX 16

#define FARSHADE_PASS_DIRECT 0
#define FARSHADE_PASS_EASY 1
#define FARSHADE_PASS_HARD 2
#define FARSHADE_PASS_MOVING 3

/// One traced view, as one shown eye looks a point up in it. The window's pixels are those of the traced
/// view.
struct SourceData {
  mat4 traced_from_shown;
  vec4 origin_step;  // of the window: origin.xy, step.xy
  vec4 per_step;     // 1 / step.xy, size in pixels
  uvec4 place;       // x = layer of its depth, y = first word of its mask, z = of its known tiles; w unused
};

// What a pixel was shown with, as the report states it: the source that gave it, FARSHADE_NEIGHBOUR added
// where the source's view saw only the surface beside the point.
#define FARSHADE_NEIGHBOUR 64u
#define FARSHADE_SOURCE_UNKNOWN 254u
#define FARSHADE_SOURCE_UNCOVERED 255u

struct FrameData {
  EyeData eye[2];
  SourceData sources[2 * FARSHADE_MAX_SOURCES];  // the left eye's, then the right eye's
  // What the newest mask may no longer know, then what all older ones may not: lights that have moved since
  // (256 bits) and spheres about things that have, where they were and where they are (relative to each eye,
  // stage axes; w = radius^2, negative where there is none).
  uvec4 stale_lights[2 * 2];
  uvec4 changed_lights[2];                 // those that the viewer has changed since a mask in use was traced
  vec4 moved[2 * 2 * FARSHADE_MAX_MOVED];  // since, eye, sphere
  vec4 background;                         // linear
  vec4 ambient;                            // linear factor of the base colour; 0 unless asked for
  uvec4 counts;  // x = masks in use, y = layer of the left eye's shown depth, z = whether the newest mask
                 // still tells something about the shown pixels themselves; w unused
  vec4 direct;   // the newest mask's pixel position at a shown one in the same direction: * xy + zw
};

#ifdef __cplusplus
}  // namespace farshade::gpu
#endif
#endif
