// Reproject and shade. What the masks in hand know of each shown pixel's surface point (reproject.glsl) is the
// visibility k_i of each light; what none knows is shown by a stated rule (guessed). Then the formula:
//   I = (I_d / pi) * sum_i k_i * saturate(N . L_i) * I_i
// Nearly every pixel is easy: the newest mask knows it, and no shadow edge is near. The first pass shades those and
// lists the others; the second pass takes all the time it needs for what is listed, a third for what is listed of
// instances that can move. Compiled with DIRECT, one pass reads the newest mask at the shown pixel itself.
// With SHADOW_MAPS as well, no mask is read: visibilities come from maps (shadow_lookup.glsl).
// (REPORT: tells of each pixel what it was shown with. MOTION: some instances can move.)
// (lavapipe walks through both sides of every branch, and through every loop once: only passes spare work.)
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#include "shaders/shared.h"

layout(local_size_x = 64) in;

layout(constant_id = 0) const uint kLights = 1;
layout(constant_id = 1) const uint kWordBytes = 1;
#ifdef DIRECT
const uint kPass = FARSHADE_PASS_DIRECT;
#else
layout(constant_id = 2) const uint kPass = FARSHADE_PASS_EASY;
#endif
layout(constant_id = 3) const bool kOtherEye = false;  // its views are sources too
layout(constant_id = 4) const bool kRangesAndCones = false;
layout(constant_id = 5) const float kNear = 1e-4;
layout(constant_id = 6) const float kUnknownVisibility = 1.0;
layout(constant_id = 7) const uint kEye = 0;
layout(constant_id = 8) const bool kWhole = false;    // every tile of every mask in hand is known
layout(constant_id = 9) const bool kMoved = false;    // something has moved since some mask in hand
layout(constant_id = 10) const bool kNeighbours = true;  // else a point that no view saw stays unknown
layout(constant_id = 11) const bool kEdges = true;    // shadow edges between pixels; else the nearest pixel's bits
layout(constant_id = 12) const float kSharpness = 1.0;
layout(constant_id = 13) const bool kMovedSinceNewest = false;
layout(constant_id = 14) const uint kEdgeBit = 1;  // of a mask, and the three after it: mask_edges.h
layout(constant_id = 15) const uint kMapSide = 1;
layout(constant_id = 16) const uint kPcfRadius = 0;

layout(binding = 0) uniform Frame { FrameData frame; };
layout(binding = 1) uniform Lights { LightData lights[kLights + 1]; };
layout(std430, binding = 2) readonly buffer Masks { uint mask_words[]; };
layout(std430, binding = 3) readonly buffer KnownTiles { uint known_words[]; };
layout(binding = 4) uniform sampler2DArray depth_ring;
layout(binding = 5) uniform sampler2DArray base_colors;
layout(binding = 6) uniform usampler2DArray surfaces;
layout(binding = 7, rgba8) uniform writeonly image2DArray shown;
#ifndef DIRECT
layout(std430, binding = 8) buffer Hard {
  // An eye's hard pixels and those on instances that can move: x, y, z = the dispatch that takes them, w = how many.
  uvec4 hard_lists[4];
  uint hard_pixels[];  // an eye: x and y in 16 bits each; those on instances that can move from the end
};
#endif
#ifdef SHADOW_MAPS
const bool kShadowMaps = true;
#define REPORT_SET 2
#else
const bool kShadowMaps = false;
#define REPORT_SET 1
#endif
#ifdef REPORT
layout(std430, set = REPORT_SET, binding = 0) writeonly buffer Report { uint report[]; };
const bool kReport = true;
void tell(uint at, uint word) { report[at] = word; }
#else
const bool kReport = false;
void tell(uint at, uint word) {}
#endif

#include "shaders/motion.glsl"
#include "shaders/reproject.glsl"

const uint kPlanes = (kLights + 31) / 32, kGroups = (kLights + 7) / 8, kQuads = (kLights + 3) / 4;
// Source (and from bit 16 on how many lights can shine here), position, visibilities, unknown, stale, beside.
const uint kReportWords = 3 + kQuads + 3 * kPlanes;

// The direction of an octahedral normal, of any length.
vec3 unfolded(vec2 p) {
  vec3 n = vec3(p, 1.0 - abs(p.x) - abs(p.y));
  float fold = max(-n.z, 0.0);
  n.xy -= vec2(n.x < 0.0 ? -fold : fold, n.y < 0.0 ? -fold : fold);
  return n;
}

#include "shaders/shadow_lookup.glsl"

// Neither 0/0 where a light stands on the surface, nor infinity, of which a shadow would make NaN.
const float kLeastDistance2 = 1e-30, kMostRadiance = 1e30;

vec3 radiance(uint i, vec3 p, vec3 n) {
  vec4 place = lights[i].position[kEye];
  vec3 to_light = place.xyz - p * place.w;
  float distance2 = max(dot(to_light, to_light), kLeastDistance2);
  vec3 l = to_light * inversesqrt(distance2);
  float strength = max(dot(n, l), 0.0) * (place.w == 0.0 ? 1.0 : 1.0 / distance2);
  if (kRangesAndCones) {
    float reach = distance2 * lights[i].intensity.w;
    vec4 cone = lights[i].spot_cone;
    float falloff = clamp(-dot(lights[i].spot_direction.xyz, l) * cone.x + cone.y, 0.0, 1.0);
    strength *= clamp(1.0 - reach * reach, 0.0, 1.0) * falloff * falloff;
  }
  return min(lights[i].intensity.rgb * strength, vec3(kMostRadiance));
}

vec3 srgb(vec3 c) {
  return mix(1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, 12.92 * c, lessThanEqual(c, vec3(0.0031308)));
}

// The pixel of the newest mask that lies at the shown pixel, whatever both see.
ivec2 lies_at(ivec2 pixel) { return ivec2(floor((vec2(pixel) + 0.5) * frame.direct.xy + frame.direct.zw)); }

Found same_pixel(ivec2 pixel) {
  const uint source = kFirst;
  Found found = Found(FARSHADE_SOURCE_UNKNOWN, false, lies_at(pixel), vec2(0.0));
  found.at = vec2(found.pixel) + 0.5;
  if (frame.counts.x > 0 && all(greaterThanEqual(found.pixel, ivec2(0))) &&
      all(lessThan(found.pixel, ivec2(frame.sources[source].per_step.zw))) && tile_known(source, found.pixel))
    found.source = source;
  return found;
}

// The rule for what is unknown: as the newest mask has it at the shown pixel itself; `otherwise` where it cannot say,
// because the head has turned away or its tile has not come.
Visibility8 guessed(ivec2 pixel, uint group, uint otherwise) {
  ivec2 last = ivec2(frame.sources[kFirst].per_step.zw) - 1;
  ivec2 there = clamp(lies_at(pixel), ivec2(0), last);
  bool tells = frame.counts.z != 0u && tile_known(kFirst, there);
  return eight_of(tells ? mask_bits(kFirst, there, group / 4) >> (group % 4 * 8) : otherwise);
}

#ifndef DIRECT
uint hard_place(uint i, bool can_move) {
  uvec2 size = uvec2(frame.eye[kEye].size_px.xy);
  return size.x * size.y * kEye + (can_move ? size.x * size.y - 1 - i : i);
}

void list_as_hard(ivec2 pixel, bool can_move) {
  uint list = kEye * 2 + uint(can_move), i = atomicAdd(hard_lists[list].w, 1);
  if (i % gl_WorkGroupSize.x == 0) atomicAdd(hard_lists[list].x, 1);
  hard_pixels[hard_place(i, can_move)] = pixel.x | pixel.y << 16;
}
#endif

void shade(ivec2 pixel) {
  vec4 size = frame.eye[kEye].size_px;
  uint report_at = ((kEye * uint(size.y) + uint(pixel.y)) * uint(size.x) + uint(pixel.x)) * kReportWords;

  float depth = texelFetch(depth_ring, ivec3(pixel, frame.counts.y + kEye), 0).r;
  if (depth == 0.0) {
    imageStore(shown, ivec3(pixel, kEye), vec4(srgb(frame.background.rgb), 1.0));
    if (kReport) {
      tell(report_at, FARSHADE_SOURCE_UNCOVERED);
      for (uint word = 1; word < kReportWords; ++word) tell(report_at + word, 0u);
    }
    return;
  }

  vec4 window = frame.eye[kEye].window.origin_step;
  uvec2 stored = texelFetch(surfaces, ivec3(pixel, kEye), 0).xy;
  Surface surface;
  surface.position = vec3(window.xy + (vec2(pixel) + 0.5) * window.zw, -1.0) * (kNear / depth);
  surface.normal = unfolded(unpackSnorm4x8(stored.y).xy);
  surface.slot = kMoved ? slot_of(stored.y >> 16) : 0u;
  Found found;
  if (kShadowMaps)
    found = Found(kFirst, false, pixel, vec2(pixel) + 0.5);
  else if (kPass == FARSHADE_PASS_DIRECT)
    found = same_pixel(pixel);
  else if (kPass == FARSHADE_PASS_EASY)
    found = look_up(kFirst, surface);
  else
    found = find(surface);
  // What no view saw, and lights that only a mask knew which is not trusted any more, are taken from beside.
  Found beside = Found(FARSHADE_SOURCE_UNKNOWN, true, ivec2(0), vec2(0.0));
  if (kPass >= FARSHADE_PASS_HARD && kNeighbours) {
    bool unseen = found.source == FARSHADE_SOURCE_UNKNOWN;
    beside = nearest_on_plane(surface, frame.counts.x > 0 && (unseen || (kMoved && mask_of(found.source) > 0)));
    if (unseen) found = beside;
  }
  const bool known = found.source != FARSHADE_SOURCE_UNKNOWN, second_look = kPass >= FARSHADE_PASS_HARD;
  const uint source = second_look && known ? found.source : kFirst;
  const ivec2 traced_pixel = known ? found.pixel : ivec2(0);
  const uint mask = mask_of(source);
  const bool on_edge = kEdges && kPass != FARSHADE_PASS_DIRECT && known && near_shadow_edge(source, traced_pixel, found.at);
#ifndef DIRECT
  if (kPass == FARSHADE_PASS_EASY)
    if (!known || on_edge || (kMovedSinceNewest && has_moved(0, surface.slot))) list_as_hard(pixel, surface.slot != 0u);
#endif

  vec3 p_stage = mat3(frame.eye[kEye].stage_from_eye) * surface.position;
  vec3 n_stage = normalize(unfolded(unpackSnorm2x16(stored.x)));
  mat3 turn = mat3(frame.eye[kEye].stage_from_eye);
  vec3 plane_stage = turn * plane_normal(pixel, depth, n_stage * turn);
  vec3 irradiance = vec3(0.0);
  uint stale = 0u, unknown = 0u, bits = 0u;  // of the plane at hand; stale: in older masks
  uint rays = 0u;                            // lights whose visibility matters here
  for (uint group = 0; group < kGroups; ++group) {
    uint plane = group / 4;
    if (group % 4 == 0) {
      bits = known && !kShadowMaps ? mask_bits(source, traced_pixel, plane) : 0u;
      stale = second_look && kMoved ? stale_bits(1, surface.slot, p_stage, plane) : 0u;
      // A newer mask than this one has been traced since: what is stale is not trusted any more.
      uint from_beside = 0u;
      if (second_look && kMoved && mask > 0 && known && beside.source != FARSHADE_SOURCE_UNKNOWN) {
        from_beside = stale;
        bits = (bits & ~stale) | (mask_bits(kFirst, beside.pixel, plane) & stale);
      }
      unknown = !known ? ~0u : mask > 0 ? stale & ~from_beside : 0u;
      if (kReport) {
        uint used = kLights >= plane * 32 + 32 ? ~0u : (1u << (kLights % 32)) - 1u;
        tell(report_at + 3 + kQuads + plane, unknown & used);
        uint shown_stale = kMovedSinceNewest && mask == 0 && known ? stale_bits(0, surface.slot, p_stage, plane) : 0u;
        tell(report_at + 3 + kQuads + kPlanes + plane, shown_stale & used);
        tell(report_at + 3 + kQuads + 2 * kPlanes + plane, from_beside & used);
      }
    }
    Visibility8 k = eight_of(bits >> (group % 4 * 8));
    if (kShadowMaps) k = sights_of_lights(group, p_stage, plane_stage, n_stage);
    if (second_look && on_edge) k = edge_visibility(surface, stale, group, k);
    Visibility8 is_unknown = eight_of(unknown >> (group % 4 * 8)), guess = Visibility8(vec4(1.0), vec4(1.0));
    // An older mask's stale bit is a better guess than none, but of a light that the viewer has changed it says
    // nothing. That one, and what no mask saw, is lit.
    uint otherwise = known ? bits | frame.changed_lights[plane / 4][plane % 4] : ~0u;
    if (second_look) guess = guessed(pixel, group, otherwise >> (group % 4 * 8));
    k.low = mix(k.low, kUnknownVisibility * guess.low, is_unknown.low);
    k.high = mix(k.high, kUnknownVisibility * guess.high, is_unknown.high);
    for (uint i = 0; i < 8 && group * 8 + i < kLights; ++i) {
      vec3 unshadowed = radiance(group * 8 + i, p_stage, n_stage);
      irradiance += (i < 4 ? k.low[i] : k.high[i - 4]) * unshadowed;
      if (kReport) rays += uint(any(greaterThan(unshadowed, vec3(0.0))));
    }
    if (kReport) {
      tell(report_at + 3 + group * 2, packUnorm4x8(k.low));
      if (group * 2 + 1 < kQuads) tell(report_at + 4 + group * 2, packUnorm4x8(k.high));
    }
  }
  if (kReport) {
    uint shown_with = known ? source % FARSHADE_MAX_SOURCES + (found.beside ? FARSHADE_NEIGHBOUR : 0u)
                            : FARSHADE_SOURCE_UNKNOWN;
    tell(report_at, shown_with | rays << 16);
    tell(report_at + 1, floatBitsToUint(found.at.x));
    tell(report_at + 2, floatBitsToUint(found.at.y));
  }

  const float kInversePi = 0.31830988618;
  vec3 color = texelFetch(base_colors, ivec3(pixel, kEye), 0).rgb * (irradiance * kInversePi + frame.ambient.rgb);
  imageStore(shown, ivec3(pixel, kEye), vec4(srgb(color), 1.0));
}

void main() {
  if (kPass < FARSHADE_PASS_HARD) {
    if (gl_GlobalInvocationID.x < uint(frame.eye[kEye].size_px.x)) shade(ivec2(gl_GlobalInvocationID.xy));
    return;
  }
#ifndef DIRECT
  const bool can_move = kPass == FARSHADE_PASS_MOVING;
  if (gl_GlobalInvocationID.x < hard_lists[kEye * 2 + uint(can_move)].w) {
    uint pixel = hard_pixels[hard_place(gl_GlobalInvocationID.x, can_move)];
    shade(ivec2(pixel & 0xFFFFu, pixel >> 16));
  }
#endif
}
