// Motion: where a surface point was when a mask was traced, and which bits of that mask are stale.
// The bits of a light that has moved are stale. For any other light, a pixel's bit is stale in two cases: the line to
// the light passes the bounding sphere of an instance that has moved, at its old or its new place; or the pixel itself
// shows such an instance.

// Compiled without MOTION, for scenes whose instances cannot move, only bits of lights that have moved are stale.

#ifdef MOTION
layout(std430, binding = 9) readonly buffer MotionSlots { uint motion_slots[]; };  // [instance]; 0 = cannot move
layout(std430, binding = 10) readonly buffer Motions { mat4 motions[]; };          // [slot - 1][mask][eye]

uint slot_of(uint instance) { return motion_slots[instance]; }

// Whether an instance has moved since the newest mask (`since` = 0) or since any older mask (1).
bool has_moved(uint since, uint slot) {
  return slot != 0u && motions[((slot - 1) * FARSHADE_MAX_MASKS + since) * 2 + kEye][0][3] != 0.0;
}

// Moves a point on an instance that can move to where it was for `mask`. Both points are in the shown eye's space.
// Slot 0, of invocations without a listed pixel, is read as slot 1.
void carry_back(uint mask, uint slot, inout vec3 p, inout vec3 n) {
  mat4 carry = motions[((max(slot, 1u) - 1) * FARSHADE_MAX_MASKS + mask) * 2 + kEye];
  p = (carry * vec4(p, 1.0)).xyz;
  n = mat3(carry) * n;  // exact for rigid motions; others find fewer known pixels
}

bool passes(vec4 sphere, vec3 p, vec3 to_light, float distance) {
  vec3 c = sphere.xyz - p;
  c -= clamp(dot(c, to_light), 0.0, distance) * to_light;
  return dot(c, c) <= sphere.w;
}

// Bit i: an instance that has moved may be, or may have been, between the point `p` and light 32 * plane + i. The loops
// are unrolled, because lavapipe reads a uniform once if its index is constant, and once per lane otherwise.
uint crossed_bits(uint since, uint slot, vec3 p, uint plane) {
  uint crossed = 0u;
  [[unroll]] for (uint i = plane * 32; i < min(kLights, plane * 32 + 32); ++i) {
    vec4 place = lights[i].position[kEye];
    vec3 to_light = place.xyz - p * place.w;
    float distance = length(to_light);
    to_light /= distance;
    if (place.w == 0.0) distance = 1e30;
    uint passed = 0u;
    [[unroll]] for (uint sphere = 0; sphere < FARSHADE_MAX_MOVED; ++sphere)
      passed |= uint(passes(frame.moved[(since * 2 + kEye) * FARSHADE_MAX_MOVED + sphere], p, to_light, distance));
    crossed |= passed << (i % 32);
  }
  return kPass == FARSHADE_PASS_MOVING && has_moved(since, slot) ? ~0u : crossed;
}
#else
uint slot_of(uint instance) { return 0u; }
bool has_moved(uint since, uint slot) { return false; }
void carry_back(uint mask, uint slot, inout vec3 p, inout vec3 n) {}
uint crossed_bits(uint since, uint slot, vec3 p, uint plane) { return 0u; }
#endif

// Bit i: the visibility of light 32 * plane + i at the point `p` (eye-relative, stage axes) may have changed.
uint stale_bits(uint since, uint slot, vec3 p, uint plane) {
  return frame.stale_lights[since * 2 + plane / 4][plane % 4] | crossed_bits(since, slot, p, plane);
}
