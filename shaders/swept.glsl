// Where instances that have moved may change shadows: on lines to a light that pass their bounding spheres.

bool passes(vec4 sphere, vec3 p, vec3 to_light, float distance) {
  vec3 c = sphere.xyz - p;
  c -= clamp(dot(c, to_light), 0.0, distance) * to_light;
  return dot(c, c) <= sphere.w;
}

// Bit i: an instance that has moved may be, or may have been, between the point `p` (eye-relative, stage axes) and
// light 32 * plane + i. The loops are unrolled, because lavapipe reads a uniform once if its index is constant, and once
// per lane otherwise.
uint swept_bits(uint since, vec3 p, uint plane) {
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
  return crossed;
}
