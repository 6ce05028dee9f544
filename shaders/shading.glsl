// What the shaders of the shading pass share: their specialisation constants and the bindings of set 0, and how a shown
// pixel becomes a surface point. The including shader defines kPass first.

layout(constant_id = FARSHADE_CONSTANT_LIGHTS) const uint kLights = 1;
layout(constant_id = FARSHADE_CONSTANT_WORD_BYTES) const uint kWordBytes = 1;
layout(constant_id = FARSHADE_CONSTANT_OTHER_EYE) const bool kOtherEye = false;
layout(constant_id = FARSHADE_CONSTANT_RANGES_AND_CONES) const bool kRangesAndCones = false;
layout(constant_id = FARSHADE_CONSTANT_NEAR) const float kNear = 1e-4;
layout(constant_id = FARSHADE_CONSTANT_UNKNOWN_VISIBILITY) const float kUnknownVisibility = 1.0;
layout(constant_id = FARSHADE_CONSTANT_WHOLE) const bool kWhole = false;
layout(constant_id = FARSHADE_CONSTANT_MOVED) const bool kMoved = false;
layout(constant_id = FARSHADE_CONSTANT_NEIGHBOURS) const bool kNeighbours = true;
layout(constant_id = FARSHADE_CONSTANT_EDGES) const bool kEdges = true;
layout(constant_id = FARSHADE_CONSTANT_SHARPNESS) const float kSharpness = 1.0;
layout(constant_id = FARSHADE_CONSTANT_EDGE_BIT) const uint kEdgeBit = 1;
layout(constant_id = FARSHADE_CONSTANT_MAP_SIDE) const uint kMapSide = 1;
layout(constant_id = FARSHADE_CONSTANT_PCF_RADIUS) const uint kPcfRadius = 0;
layout(constant_id = FARSHADE_CONSTANT_DETAIL) const float kDetail_px = 0.0;
layout(constant_id = FARSHADE_CONSTANT_CUBE_MASK) const bool kCubeMask = true;
layout(constant_id = FARSHADE_CONSTANT_ROW_GROUPS) const uint kRowGroups = FARSHADE_ROW_GROUPS;
layout(constant_id = FARSHADE_CONSTANT_EDGE_RAYS) const bool kEdgeRays = false;
layout(constant_id = FARSHADE_CONSTANT_HOLES) const bool kHoles = false;

// 0 left, 1 right. As a constant, it would double what drivers compile.
layout(push_constant) uniform Dispatch { uint shown_eye; };
layout(binding = 0) uniform Frame { FrameData frame; };
layout(binding = 1) uniform Lights { LightData lights[kLights + 1]; };
layout(std430, binding = 2) readonly buffer Masks { uint mask_words[]; };
layout(std430, binding = 3) readonly buffer KnownBlocks { uint known_words[]; };
layout(binding = FARSHADE_BINDING_SHOWN_DEPTH) uniform sampler2DArray shown_depths;  // layers: eyes
layout(binding = FARSHADE_BINDING_SURFACES) uniform usampler2DArray surfaces;
#ifndef DIRECT
layout(binding = 8) uniform sampler2DArray cube_mask_depths;
// Of each mask the depth of its views; layers: eyes. An array with an index that is not constant would make lavapipe
// sample once for each lane.
layout(binding = FARSHADE_BINDING_MASK_DEPTHS) uniform sampler2DArray mask_depths_0;
layout(binding = FARSHADE_BINDING_MASK_DEPTHS + 1) uniform sampler2DArray mask_depths_1;
layout(binding = FARSHADE_BINDING_MASK_DEPTHS + 2) uniform sampler2DArray mask_depths_2;
layout(binding = FARSHADE_BINDING_MASK_DEPTHS + 3) uniform sampler2DArray mask_depths_3;
#else  // not read
#define cube_mask_depths shown_depths
#define mask_depths_0 shown_depths
#define mask_depths_1 shown_depths
#define mask_depths_2 shown_depths
#define mask_depths_3 shown_depths
#endif

const uint kGroups = (kLights + 7) / 8, kQuads = FARSHADE_QUADS(kLights), kPlanes = FARSHADE_PLANES(kLights);

#include "shaders/motion.glsl"
#include "shaders/masks.glsl"
#include "shaders/reproject.glsl"

// The direction of an octahedral normal. Its length is not 1.
vec3 unfolded(vec2 p) {
  vec3 n = vec3(p, 1.0 - abs(p.x) - abs(p.y));
  float fold = max(-n.z, 0.0);
  n.xy -= vec2(n.x < 0.0 ? -fold : fold, n.y < 0.0 ? -fold : fold);
  return n;
}

Surface surface_at(ivec2 pixel, float depth, uint stored) {
  vec4 window = frame.eye[shown_eye].window.origin_step;
  Surface surface;
  surface.position = vec3(window.xy + (vec2(pixel) + 0.5) * window.zw, -1.0) * (kNear / depth);
  surface.normal = unfolded(unpackSnorm4x8(stored).xy);
  surface.slot = kMoved ? slot_of(stored >> 16) : 0u;
  return surface;
}
