// Reproject and shade. Each shown pixel's surface point is carried into the views that the masks in hand were
// traced for, newest first. The first view that saw the same surface there, in a tile that arrived, gives the
// point's visibility bits; a point that none saw is unknown and shown by a stated rule. Then the formula:
//   I = (I_d / pi) * sum_i k_i * saturate(N . L_i) * I_i
// In direct mode the mask was traced for the very view that is shown, and pixel reads pixel.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shaders/shared.h"

layout(local_size_x = 64) in;

layout(constant_id = 0) const uint kLights = 1;
layout(constant_id = 1) const uint kWordBytes = 1;
layout(constant_id = 2) const bool kDirect = false;
layout(constant_id = 3) const bool kReport = false;
layout(constant_id = 4) const bool kRangesAndCones = false;
layout(constant_id = 5) const float kNear = 1e-4;
layout(constant_id = 6) const float kUnknownVisibility = 1.0;
layout(constant_id = 7) const uint kEye = 0;
layout(constant_id = 8) const bool kWhole = false;  // every tile of every mask in hand is known

layout(binding = 0) uniform Frame { FrameData frame; };
layout(binding = 1) uniform Lights { LightData lights[kLights + 1]; };
layout(std430, binding = 2) readonly buffer Masks { uint mask_words[]; };
layout(std430, binding = 3) readonly buffer KnownTiles { uint known_words[]; };
layout(binding = 4) uniform sampler2DArray depth_ring;
layout(binding = 5) uniform sampler2DArray base_colors;
layout(binding = 6) uniform usampler2DArray surfaces;
layout(binding = 7, rgba8) uniform writeonly image2DArray shown;
layout(std430, binding = 8) writeonly buffer ShownBits { uint shown_bits[]; };
layout(std430, binding = 9) writeonly buffer ShownSources { uint shown_sources[]; };

vec3 from_octahedral(vec2 p) {
  vec3 n = vec3(p, 1.0 - abs(p.x) - abs(p.y));
  float fold = max(-n.z, 0.0);
  n.xy -= vec2(n.x < 0.0 ? -fold : fold, n.y < 0.0 ? -fold : fold);
  return normalize(n);
}

bool tile_known(uint mask, ivec2 pixel) {
  if (kWhole) return true;
  uint columns = (frame.traced.x + FARSHADE_TILE_PX - 1) / FARSHADE_TILE_PX;
  uint tile = uint(pixel.y) / FARSHADE_TILE_PX * columns + uint(pixel.x) / FARSHADE_TILE_PX;
  uint word = known_words[frame.masks[mask].place.z + kEye * frame.traced.w + tile / 32];
  return (word >> (tile % 32) & 1u) != 0u;
}

uint mask_bits(uint mask, ivec2 pixel, uint plane) {
  uint element = (plane * frame.traced.y + uint(pixel.y)) * frame.traced.x + uint(pixel.x);
  uint first = frame.masks[mask].place.y + kEye * frame.traced.z;
  if (kWordBytes == 1) return mask_words[first + element / 4] >> (element % 4 * 8) & 0xFFu;
  if (kWordBytes == 2) return mask_words[first + element / 2] >> (element % 2 * 16) & 0xFFFFu;
  return mask_words[first + element];
}

// Same surface. On the tangent plane of p (normal n) inverse depth is linear on the traced screen, so the plane says
// what depth the centre of p's traced pixel must have. Real surfaces bend and normals are rounded: the traced depth
// may differ by half of what the plane itself changes between p and that centre, by a pixel's footprint over the
// distance, and by float rounding of the depth and of the transform.
const float kBend = 0.5, kFootprint = 1.0, kRounding = 16.0 / 16777216.0;

bool same_surface(uint mask, vec3 p_shown, vec3 n_shown, out ivec2 pixel) {
  mat4 traced_from_shown = frame.masks[mask].traced_from_shown[kEye];
  vec4 window = frame.masks[mask].window[kEye].origin_step;
  vec3 p = (traced_from_shown * vec4(p_shown, 1.0)).xyz;
  vec3 n = mat3(traced_from_shown) * n_shown;
  float facing = dot(n, p);
  float inverse_z = 1.0 / -p.z;
  pixel = ivec2(floor((p.xy * inverse_z - window.xy) / window.zw));
  if (p.z >= 0.0 || facing <= 0.0 || any(lessThan(pixel, ivec2(0))) ||
      any(greaterThanEqual(pixel, ivec2(frame.traced.xy))))
    return false;
  if (!tile_known(mask, pixel)) return false;
  float traced = texelFetch(depth_ring, ivec3(pixel, frame.masks[mask].place.x + kEye), 0).r;
  vec3 centre = vec3(window.xy + (vec2(pixel) + 0.5) * window.zw, -1.0);
  float here = kNear * inverse_z;
  float expected = kNear * dot(n, centre) / facing;
  float tolerance = kBend * abs(expected - here) + (kFootprint * max(abs(window.z), abs(window.w)) + kRounding) * here;
  return abs(traced - expected) <= tolerance;
}

vec3 radiance(uint i, vec3 p, vec3 n) {
  vec4 place = lights[i].position[kEye];
  vec3 to_light = place.xyz - p * place.w;
  float distance2 = dot(to_light, to_light);
  vec3 l = to_light * inversesqrt(distance2);
  float strength = max(dot(n, l), 0.0) * (place.w == 0.0 ? 1.0 : 1.0 / distance2);
  if (kRangesAndCones) {
    float reach = distance2 * lights[i].intensity.w;
    vec4 cone = lights[i].spot_cone;
    float falloff = clamp(-dot(lights[i].spot_direction.xyz, l) * cone.x + cone.y, 0.0, 1.0);
    strength *= clamp(1.0 - reach * reach, 0.0, 1.0) * falloff * falloff;
  }
  return lights[i].intensity.rgb * strength;
}

vec3 srgb(vec3 c) {
  return mix(1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, 12.92 * c, lessThanEqual(c, vec3(0.0031308)));
}

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  vec4 size = frame.eye[kEye].size_px;
  if (pixel.x >= int(size.x)) return;
  uint index = (kEye * uint(size.y) + uint(pixel.y)) * uint(size.x) + uint(pixel.x);
  const uint planes = (kLights + 31) / 32;

  float depth = texelFetch(depth_ring, ivec3(pixel, frame.counts.y + kEye), 0).r;
  if (depth == 0.0) {
    imageStore(shown, ivec3(pixel, kEye), vec4(srgb(frame.background.rgb), 1.0));
    if (kReport) {
      shown_sources[index] = FARSHADE_SOURCE_UNCOVERED;
      for (uint plane = 0; plane < planes; ++plane) shown_bits[index * planes + plane] = 0u;
    }
    return;
  }

  vec4 window = frame.eye[kEye].window.origin_step;
  vec3 p_eye = vec3(window.xy + (vec2(pixel) + 0.5) * window.zw, -1.0) * (kNear / depth);
  uvec2 surface = texelFetch(surfaces, ivec3(pixel, kEye), 0).xy;

  uint source = FARSHADE_SOURCE_UNKNOWN;
  ivec2 traced_pixel = pixel;
  if (kDirect) {
    source = 0;
  } else {
    vec3 n_eye = from_octahedral(unpackSnorm4x8(surface.y).xy);
    for (uint mask = 0; mask < frame.counts.x && source == FARSHADE_SOURCE_UNKNOWN; ++mask)
      if (same_surface(mask, p_eye, n_eye, traced_pixel)) source = mask;
  }

  mat3 stage_from_eye = mat3(frame.eye[kEye].stage_from_eye);
  vec3 p_stage = stage_from_eye * p_eye;
  vec3 n_stage = from_octahedral(unpackSnorm2x16(surface.x));
  vec3 irradiance = vec3(0.0);
  for (uint plane = 0; plane < planes; ++plane) {
    bool known = source != FARSHADE_SOURCE_UNKNOWN;
    uint bits = known ? mask_bits(source, traced_pixel, plane) : kUnknownVisibility >= 0.5 ? ~0u : 0u;
    for (uint i = plane * 32; i < min(kLights, plane * 32 + 32); ++i) {
      float lit = float(bits >> (i % 32) & 1u);
      irradiance += (known ? lit : kUnknownVisibility) * radiance(i, p_stage, n_stage);
    }
    if (kReport) shown_bits[index * planes + plane] = bits;
  }
  if (kReport) shown_sources[index] = source;

  const float kInversePi = 0.31830988618;
  vec3 color = texelFetch(base_colors, ivec3(pixel, kEye), 0).rgb * (irradiance * kInversePi + frame.ambient.rgb);
  imageStore(shown, ivec3(pixel, kEye), vec4(srgb(color), 1.0));
}
