// Motion: where a surface was when a mask was traced, and what that mask may no longer know.
// A light that has moved is stale itself; of the other lights a pixel is stale where the way to the light passes
// the sphere about something that has moved - as it was then or as it is now - and on what has moved itself.

// Compiled without MOTION, for scenes whose instances stay where they are, only lights can be stale.

#ifdef MOTION
layout(std430, binding = 9) readonly buffer MotionSlots { uint motion_slots[]; };  // an instance's; 0 = never moves
layout(std430, binding = 10) readonly buffer Motions { mat4 motions[]; };          // a slot, a mask, an eye

uint slot_of(uint instance) { return motion_slots[instance]; }

// `since` is 0 for the newest mask and 1 for all older ones together.
bool has_moved(uint since, uint slot) {
  return slot != 0u && motions[((slot - 1) * FARSHADE_MAX_MASKS + since) * 2 + kEye][0][3] != 0.0;
}

// A point on an instance that can move, back to where it was for `mask`; both spaces are the shown eye's.
void carry_back(uint mask, uint slot, inout vec3 p, inout vec3 n) {
  mat4 carry = motions[((slot - 1) * FARSHADE_MAX_MASKS + mask) * 2 + kEye];
  p = (carry * vec4(p, 1.0)).xyz;
  n = mat3(carry) * n;  // right for rigid motions; others cost knowledge, not truth
}

bool passes(vec4 sphere, vec3 p, vec3 to_light, float distance) {
  vec3 c = sphere.xyz - p;
  c -= clamp(dot(c, to_light), 0.0, distance) * to_light;
  return dot(c, c) <= sphere.w;
}

// Bit i: something that has moved may stand, or have stood, between the point `p` and light 32 * plane + i. Loops are
// unrolled, since lavapipe reads uniforms at constant places once and at others lane by lane.
uint crossed_bits(uint since, uint slot, vec3 p, uint plane) {
  uint crossed = 0u;
  [[unroll]] for (uint i = plane * 32; i < min(kLights, plane * 32 + 32); ++i) {
    vec4 place = lights[i].position[kEye];
    vec3 to_light = place.xyz - p * place.w;
    float distance = length(to_light);
    to_light /= distance;
    if (place.w == 0.0) distance = 1e30;
    bool passed = false;
    [[unroll]] for (uint thing = 0; thing < FARSHADE_MAX_MOVED; ++thing)
      passed = passed || passes(frame.moved[(since * 2 + kEye) * FARSHADE_MAX_MOVED + thing], p, to_light, distance);
    crossed |= uint(passed) << (i % 32);
  }
  return kPass == FARSHADE_PASS_MOVING && has_moved(since, slot) ? ~0u : crossed;
}
#else
uint slot_of(uint instance) { return 0u; }
bool has_moved(uint since, uint slot) { return false; }
void carry_back(uint mask, uint slot, inout vec3 p, inout vec3 n) {}
uint crossed_bits(uint since, uint slot, vec3 p, uint plane) { return 0u; }
#endif

// Bit i: light 32 * plane + i may have changed at the point `p` (eye-relative, stage axes).
uint stale_bits(uint since, uint slot, vec3 p, uint plane) {
  return frame.stale_lights[since * 2 + plane / 4][plane % 4] | crossed_bits(since, slot, p, plane);
}
