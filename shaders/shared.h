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

/// One traced mask, for each eye: how shown eye space becomes traced eye space and pixels there.
struct MaskData {
  mat4 traced_from_shown[2];
  WindowData window[2];
  uvec4 place;  // of the left eye: x = layer of its depth, y = first word of its mask, z = of its known tiles
};

#define FARSHADE_MAX_MASKS 4
#define FARSHADE_TILE_PX 16

// Sources of a pixel's shadow, as the report states them: 0..FARSHADE_MAX_MASKS-1 = that mask, newest first.
#define FARSHADE_SOURCE_UNKNOWN 254u
#define FARSHADE_SOURCE_UNCOVERED 255u

struct FrameData {
  EyeData eye[2];
  MaskData masks[FARSHADE_MAX_MASKS];
  vec4 background;  // linear
  vec4 ambient;     // linear factor of the base colour; 0 unless asked for
  uvec4 counts;     // x = masks in use, y = layer of the left eye's shown depth
  uvec4 traced;     // x = width, y = height in pixels, z = words of an eye's mask, w = of its known tiles
};

#ifdef __cplusplus
}  // namespace farshade::gpu
#endif
#endif
