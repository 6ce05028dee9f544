// Composes two pictures to an anaglyph: the colour that looks, through red and cyan glasses, most like what each eye
// should see. The least-squares solution in linear light is a 3x6 matrix (E. Dubois, "A projection method to generate
// anaglyph stereo images", ICASSP 2001). The pictures and the window are sRGB-coded.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shaders/anaglyph_data.h"

layout(constant_id = 0) const bool kFiltered = false;

layout(set = 0, binding = 0, rgba8) readonly uniform image2DArray drawn;
layout(set = 0, binding = 1, rgba8) readonly uniform image2DArray uploaded;
layout(push_constant) uniform Push { AnaglyphData panel; };

layout(location = 0) out vec4 color;

// The columns are the contributions of a picture's red, green and blue.
const mat3 kLeft = mat3(0.456100, -0.0400822, -0.0152161,
                        0.500484, -0.0378246, -0.0205971,
                        0.176381, -0.0157589, -0.00546856);
const mat3 kRight = mat3(-0.0434706, 0.378476, -0.0721527,
                         -0.0879388, 0.733640, -0.112961,
                         -0.00155529, -0.0184503, 1.22640);

vec3 load(ivec2 at, uint picture) {
  if (picture < 2u) return imageLoad(drawn, ivec3(at, int(picture))).rgb;
  return imageLoad(uploaded, ivec3(at, int(picture) - 2)).rgb;
}

vec3 picture_color(vec2 window, uint picture, uint first_column) {
  const vec2 first = vec2(first_column, 0);
  if (!kFiltered) return load(ivec2(window - panel.place.xy + first), picture);
  const ivec2 last = imageSize(drawn).xy - 1;
  const vec2 at = clamp((window - panel.place.xy) * panel.place.zw + first - 0.5, vec2(0.0), vec2(last));
  const ivec2 low = ivec2(at), high = min(low + 1, last);
  const vec2 part = at - vec2(low);
  return mix(mix(load(low, picture), load(ivec2(high.x, low.y), picture), part.x),
             mix(load(ivec2(low.x, high.y), picture), load(high, picture), part.x), part.y);
}

vec3 linear_of(vec3 srgb) {
  return mix(pow((srgb + 0.055) / 1.055, vec3(2.4)), srgb / 12.92, lessThanEqual(srgb, vec3(0.04045)));
}

vec3 srgb_of(vec3 light) {
  return mix(1.055 * pow(light, vec3(1.0 / 2.4)) - 0.055, light * 12.92,
             lessThanEqual(light, vec3(0.0031308)));
}

void main() {
  const vec3 light = kLeft * linear_of(picture_color(gl_FragCoord.xy, panel.pictures.x, panel.pictures.z)) +
                     kRight * linear_of(picture_color(gl_FragCoord.xy, panel.pictures.y, panel.pictures.w));
  color = vec4(srgb_of(clamp(light, 0.0, 1.0)), 1.0);
}
