// Where instances that have moved may change shadows: on lines to a light that pass their bounding spheres.

bool passes(vec4 sphere, vec3 p, vec3 to_light, float distance) {
  vec3 c = sphere.xyz - p;
  c -= clamp(dot(c, to_light), 0.0, distance) * to_light;
  return dot(c, c) <= sphere.w;
}

// The index is constant in each case, because lavapipe reads a uniform once if it is, and once per lane otherwise.
vec4 moved_sphere(uint since, uint i) {
  const uint eye = shown_eye * FARSHADE_MAX_MOVED, group = 2 * FARSHADE_MAX_MOVED;
  vec4 sphere = frame.moved[FARSHADE_SINCE_NEWEST * group + eye + i];
  if (since == FARSHADE_SINCE_OLDER) sphere = frame.moved[FARSHADE_SINCE_OLDER * group + eye + i];
  if (since == FARSHADE_SINCE_CUBE_MASK) sphere = frame.moved[FARSHADE_SINCE_CUBE_MASK * group + eye + i];
  return sphere;
}

// Bit i: an instance that has moved may be, or may have been, between the point `p` (eye-relative, stage axes) and
// light 32 * plane + i.
uint swept_bits(uint since, vec3 p, uint plane) {
  uint crossed = 0u;
  vec4 spheres[FARSHADE_MAX_MOVED];
  [[unroll]] for (uint i = 0; i < FARSHADE_MAX_MOVED; ++i) spheres[i] = moved_sphere(since, i);
  [[unroll]] for (uint i = plane * 32; i < min(kLights, plane * 32 + 32); ++i) {
    vec4 place = lights[i].position[shown_eye];
    vec3 to_light = place.xyz - p * place.w;
    float distance = length(to_light);
    to_light /= distance;
    if (place.w == 0.0) distance = 1e30;
    uint passed = 0u;
    [[unroll]] for (uint sphere = 0; sphere < FARSHADE_MAX_MOVED; ++sphere)
      passed |= uint(passes(spheres[sphere], p, to_light, distance));
    crossed |= passed << (i % 32);
  }
  return crossed;
}
