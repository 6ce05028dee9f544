// Timewarp: shows a picture that was made for other views in the directions that its pixels had, as if everything were
// infinitely far away (rotational timewarp: van Waveren, "The asynchronous time warp for virtual reality on consumer
// hardware", VRST 2016). Colours are interpolated in linear light. With kAdds the picture is a difference, which is added
// to the shown picture.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shaders/timewarp_data.h"

layout(local_size_x = FARSHADE_TIMEWARP_GROUP) in;

layout(constant_id = FARSHADE_TIMEWARP_CONSTANT_ADDS) const bool kAdds = false;

layout(std430, binding = 0) readonly buffer Picture { uint picture[]; };  // the left eye's rows, then the right eye's
layout(binding = 1, rgba8) uniform image2DArray shown;
layout(std430, binding = 2) readonly buffer Light { float light_of[256]; };  // linear light of each sRGB level
layout(push_constant) uniform Timewarp { TimewarpData timewarp; };

const float kNoDifference = 128.0 / 255.0;

vec3 srgb(vec3 c) {
  return mix(1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, 12.92 * c, lessThanEqual(c, vec3(0.0031308)));
}

// The colour of a pixel, or of the nearest border pixel: linear light, or the level of a difference.
vec3 texel(ivec2 at, uint eye) {
  uvec2 inside = uvec2(clamp(at, ivec2(0), ivec2(timewarp.size.zw) - 1));
  uint value = picture[(eye * timewarp.size.w + inside.y) * timewarp.size.z + inside.x];
  if (kAdds) return unpackUnorm4x8(value).rgb;
  return vec3(light_of[value & 255u], light_of[value >> 8 & 255u], light_of[value >> 16 & 255u]);
}

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  uint eye = gl_GlobalInvocationID.z;
  if (uint(pixel.x) >= timewarp.size.x) return;
  vec4 column[3] = {timewarp.from_shown[eye * 3], timewarp.from_shown[eye * 3 + 1], timewarp.from_shown[eye * 3 + 2]};
  vec3 place = (column[0] * (pixel.x + 0.5) + column[1] * (pixel.y + 0.5) + column[2]).xyz;
  vec2 at = place.xy / place.z;
  // Also false if `at` is NaN.
  bool covered = place.z > 0.0 && all(greaterThanEqual(at, vec2(0.0))) && all(lessThanEqual(at, vec2(timewarp.size.zw)));
  // A scalar constant, because Mesa 22.3 folds a choice between constant vectors to the first component of each.
  vec3 result = vec3(kAdds ? kNoDifference : 0.0);
  if (covered) {
    vec2 corner = floor(at - 0.5), part = at - 0.5 - corner;
    ivec2 first = ivec2(corner);
    vec3 above = mix(texel(first, eye), texel(first + ivec2(1, 0), eye), part.x);
    vec3 below = mix(texel(first + ivec2(0, 1), eye), texel(first + ivec2(1, 1), eye), part.x);
    result = mix(above, below, part.y);
  }
  result = kAdds ? imageLoad(shown, ivec3(pixel, eye)).rgb + 2.0 * (result - kNoDifference) : srgb(result);
  imageStore(shown, ivec3(pixel, eye), vec4(clamp(result, 0.0, 1.0), 1.0));
}
