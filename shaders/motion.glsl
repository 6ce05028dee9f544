// Motion: where a surface point was when a mask was traced, and which bits of that mask are stale.
// The bits of a light that has moved are stale. For any other light, a pixel's bit is stale in two cases: the line to
// the light passes the bounding sphere of an instance that has moved, at its old or its new place; or the pixel itself
// shows such an instance.

// Compiled without MOTION, for scenes whose instances cannot move, only bits of lights that have moved are stale.

#ifdef MOTION
#include "shaders/swept.glsl"

layout(std430, binding = 13) readonly buffer MotionSlots { uint motion_slots[]; };  // [instance]; 0 = cannot move
layout(std430, binding = 14) readonly buffer Motions { mat4 motions[]; };          // [slot - 1][mask][eye]

mat4 motion_of(uint slot, uint mask) { return motions[((slot - 1) * FARSHADE_MAX_TRACED + mask) * 2 + shown_eye]; }

uint slot_of(uint instance) { return motion_slots[instance]; }

// Whether an instance has moved since any mask of the group `since` was traced.
bool has_moved(uint since, uint slot) {
  uint first = since == FARSHADE_SINCE_CUBE_MASK ? FARSHADE_MAX_MASKS : since;
  return slot != 0u && motion_of(slot, first)[0][3] != 0.0;
}

// Whether points of the pass's pixels on an instance are moved to where they were.
bool is_carried(uint slot) { return kPass == FARSHADE_PASS_MOVING || (kPass == FARSHADE_PASS_SINGLE && slot != 0u); }

// Moves a point on an instance that can move to where it was for `mask`. Both points are in the shown eye's space.
// Slot 0, of invocations without a listed pixel, is read as slot 1.
void carry_back(uint mask, uint slot, inout vec3 p, inout vec3 n) {
  mat4 carry = motion_of(max(slot, 1u), mask);
  p = (carry * vec4(p, 1.0)).xyz;
  n = mat3(carry) * n;  // exact for rigid motions; others find fewer known pixels
}

// The same as swept_bits. All bits of a point on an instance that has moved may have changed.
uint crossed_bits(uint since, uint slot, vec3 p, uint plane) {
  uint swept = swept_bits(since, p, plane);
  return is_carried(slot) && has_moved(since, slot) ? ~0u : swept;
}
#else
uint slot_of(uint instance) { return 0u; }
bool has_moved(uint since, uint slot) { return false; }
bool is_carried(uint slot) { return false; }
void carry_back(uint mask, uint slot, inout vec3 p, inout vec3 n) {}
uint crossed_bits(uint since, uint slot, vec3 p, uint plane) { return 0u; }
#endif

// Bit i: the visibility of light 32 * plane + i at the point `p` (eye-relative, stage axes) may have changed since any
// mask of the group `since` was traced.
uint stale_bits(uint since, uint slot, vec3 p, uint plane) {
  uint moved = frame.stale_lights[FARSHADE_SINCE_NEWEST * 2 + plane / 4][plane % 4];
  if (since == FARSHADE_SINCE_OLDER) moved = frame.stale_lights[FARSHADE_SINCE_OLDER * 2 + plane / 4][plane % 4];
  if (since == FARSHADE_SINCE_CUBE_MASK) moved = frame.stale_lights[FARSHADE_SINCE_CUBE_MASK * 2 + plane / 4][plane % 4];
  return moved | crossed_bits(since, slot, p, plane);
}
