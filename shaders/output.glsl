// A pass writes the picture. With VISIBILITY it writes the visibility of each light instead, for a renderer that shades
// by itself (docs/embedding.md). Light i is channel i % 4 of layer eye * FARSHADE_QUADS(lights) + i / 4. The value equals
// that in the report; it is 0 where no surface is, and for a light of intensity 0. Both images have one binding,
// FARSHADE_BINDING_OUTPUT.

#ifdef VISIBILITY
layout(binding = FARSHADE_BINDING_OUTPUT, rgba8) uniform writeonly image2DArray visibilities;

bool is_on(uint i) { return i < kLights && any(greaterThan(lights[min(i, kLights)].intensity.rgb, vec3(0.0))); }

void write_quad(ivec2 pixel, uint quad, vec4 k) {
  bvec4 on = bvec4(is_on(quad * 4), is_on(quad * 4 + 1), is_on(quad * 4 + 2), is_on(quad * 4 + 3));
  imageStore(visibilities, ivec3(pixel, shown_eye * kQuads + quad), mix(vec4(0.0), k, on));
}

void write_visibility(ivec2 pixel, bool wanted, uint group, Visibility8 k) {
  if (!wanted) return;
  write_quad(pixel, group * 2, k.low);
  if (group * 2 + 1 < kQuads) write_quad(pixel, group * 2 + 1, k.high);
}

void write_uncovered(ivec2 pixel, bool wanted) {
  for (uint quad = 0; wanted && quad < kQuads; ++quad)
    imageStore(visibilities, ivec3(pixel, shown_eye * kQuads + quad), vec4(0.0));
}

vec3 base_color(ivec2 pixel) { return vec3(0.0); }
void write_picture(ivec2 pixel, bool wanted, vec3 color) {}
#else
layout(binding = FARSHADE_BINDING_BASE_COLORS) uniform sampler2DArray base_colors;
layout(binding = FARSHADE_BINDING_OUTPUT, rgba8) uniform writeonly image2DArray shown;

vec3 base_color(ivec2 pixel) { return texelFetch(base_colors, ivec3(pixel, shown_eye), 0).rgb; }

void write_picture(ivec2 pixel, bool wanted, vec3 color) {
  if (wanted) imageStore(shown, ivec3(pixel, shown_eye), vec4(color, 1.0));
}

void write_visibility(ivec2 pixel, bool wanted, uint group, Visibility8 k) {}
void write_uncovered(ivec2 pixel, bool wanted) {}
#endif
