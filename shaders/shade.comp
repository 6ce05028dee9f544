// Shades both eyes' pixels. For each light, the visibility k_i of a pixel's surface point comes from the masks in
// use (reproject.glsl). A visibility that no mask knows is shown by a stated rule (guess). The formula is
//   I = (I_d / pi) * sum_i k_i * saturate(N . L_i) * I_i
// Almost all pixels are easy: the newest mask knows the point, and no shadow edge is near. The first pass shades
// these and lists the others. The second pass shades the listed pixels with all sources and filters. A third pass
// does the same for listed pixels on instances that can move.
// Variants: DIRECT reads the newest mask at the shown pixel, in one pass. With SHADOW_MAPS (and DIRECT) visibilities
// come from shadow maps (shadow_lookup.glsl). REPORT writes what each pixel was shaded with. MOTION: some instances
// can move.
// (lavapipe executes both sides of every branch, so work is saved by separate passes, not by branches.)
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#include "shaders/shade_data.h"
#include "shaders/shared.h"

layout(local_size_x = FARSHADE_SHADE_GROUP) in;

layout(constant_id = FARSHADE_CONSTANT_LIGHTS) const uint kLights = 1;
layout(constant_id = FARSHADE_CONSTANT_WORD_BYTES) const uint kWordBytes = 1;
#ifdef DIRECT
const uint kPass = FARSHADE_PASS_DIRECT;
#else
layout(constant_id = FARSHADE_CONSTANT_PASS) const uint kPass = FARSHADE_PASS_EASY;
#endif
layout(constant_id = FARSHADE_CONSTANT_OTHER_EYE) const bool kOtherEye = false;
layout(constant_id = FARSHADE_CONSTANT_RANGES_AND_CONES) const bool kRangesAndCones = false;
layout(constant_id = FARSHADE_CONSTANT_NEAR) const float kNear = 1e-4;
layout(constant_id = FARSHADE_CONSTANT_UNKNOWN_VISIBILITY) const float kUnknownVisibility = 1.0;
layout(constant_id = FARSHADE_CONSTANT_EYE) const uint kEye = 0;
layout(constant_id = FARSHADE_CONSTANT_WHOLE) const bool kWhole = false;
layout(constant_id = FARSHADE_CONSTANT_MOVED) const bool kMoved = false;
layout(constant_id = FARSHADE_CONSTANT_NEIGHBOURS) const bool kNeighbours = true;
layout(constant_id = FARSHADE_CONSTANT_EDGES) const bool kEdges = true;
layout(constant_id = FARSHADE_CONSTANT_SHARPNESS) const float kSharpness = 1.0;
layout(constant_id = FARSHADE_CONSTANT_EDGE_BIT) const uint kEdgeBit = 1;
layout(constant_id = FARSHADE_CONSTANT_MAP_SIDE) const uint kMapSide = 1;
layout(constant_id = FARSHADE_CONSTANT_PCF_RADIUS) const uint kPcfRadius = 0;
layout(constant_id = FARSHADE_CONSTANT_DETAIL) const float kDetail_px = 0.0;

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
  // For each eye two lists: hard pixels, and those on instances that can move. xyz = dispatch size, w = length.
  uvec4 hard_lists[4];
  // For each eye: x and y in 16 bits each. The second list is stored backwards from the end.
  uint hard_pixels[];
};
#endif
#ifdef SHADOW_MAPS
const bool kShadowMaps = true;
#define REPORT_SET 2
#else
const bool kShadowMaps = false;
#define REPORT_SET 1
#endif

const bool kSecondLook = kPass >= FARSHADE_PASS_HARD;  // a pass over listed pixels
const uint kPlanes = FARSHADE_PLANES(kLights), kGroups = (kLights + 7) / 8, kQuads = FARSHADE_QUADS(kLights);

#include "shaders/motion.glsl"
#include "shaders/reproject.glsl"
#include "shaders/report.glsl"

// The direction of an octahedral normal. Its length is not 1.
vec3 unfolded(vec2 p) {
  vec3 n = vec3(p, 1.0 - abs(p.x) - abs(p.y));
  float fold = max(-n.z, 0.0);
  n.xy -= vec2(n.x < 0.0 ? -fold : fold, n.y < 0.0 ? -fold : fold);
  return n;
}

#include "shaders/shadow_lookup.glsl"

// These limits prevent 0/0 where a light lies on the surface, and infinity, which becomes NaN in shadow.
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

// The newest mask's pixel in the direction of the shown pixel, as if both views had one pose.
ivec2 direct_pixel(ivec2 pixel) { return ivec2(floor((vec2(pixel) + 0.5) * frame.direct.xy + frame.direct.zw)); }

Sample direct_sample(ivec2 pixel) {
  const uint source = kNewest;
  Sample result = Sample(FARSHADE_SOURCE_UNKNOWN, false, direct_pixel(pixel), vec2(0.0));
  result.at = vec2(result.pixel) + 0.5;
  if (frame.counts.x > 0 && all(greaterThanEqual(result.pixel, ivec2(0))) &&
      all(lessThan(result.pixel, ivec2(frame.sources[source].per_step.zw))) && tile_known(source, result.pixel))
    result.source = source;
  return result;
}

// The rule for unknown visibility: what the newest mask has in the direction of the shown pixel; `otherwise` if the head
// has turned too far or the mask's tile is missing.
Visibility8 guess(ivec2 pixel, uint group, uint otherwise) {
  ivec2 last = ivec2(frame.sources[kNewest].per_step.zw) - 1;
  ivec2 there = clamp(direct_pixel(pixel), ivec2(0), last);
  bool usable = frame.counts.z != 0u && tile_known(kNewest, there);
  return eight_of(usable ? mask_bits(kNewest, there, group / 4) >> (group % 4 * 8) : otherwise);
}

#ifndef DIRECT
uint list_place(uint i, bool can_move) {
  uvec2 size = uvec2(frame.eye[kEye].size_px.xy);
  return size.x * size.y * kEye + (can_move ? size.x * size.y - 1 - i : i);
}

void list_as_hard(ivec2 pixel, bool can_move) {
  uint list = kEye * 2 + uint(can_move), i = atomicAdd(hard_lists[list].w, 1);
  if (i % gl_WorkGroupSize.x == 0) atomicAdd(hard_lists[list].x, 1);
  hard_pixels[list_place(i, can_move)] = pixel.x | pixel.y << 16;
}
#else
void list_as_hard(ivec2 pixel, bool can_move) {}
#endif

Surface surface_at(ivec2 pixel, float depth, uint stored) {
  vec4 window = frame.eye[kEye].window.origin_step;
  Surface surface;
  surface.position = vec3(window.xy + (vec2(pixel) + 0.5) * window.zw, -1.0) * (kNear / depth);
  surface.normal = unfolded(unpackSnorm4x8(stored).xy);
  surface.slot = kMoved ? slot_of(stored >> 16) : 0u;
  return surface;
}

// What the masks know of a surface point.
struct Lookup {
  Sample taken;       // whose bits the point takes
  Sample neighbour;   // on the same plane, for points that no view saw and for stale bits of older masks
  bool known;         // `taken` has a source
  uint source;        // of `taken`; the newest if it has none
  ivec2 pixel;        // of `taken`; 0 if it has no source
  bool on_edge;       // a shadow edge is near
};

Lookup look_up(ivec2 pixel, Surface surface) {
  Lookup result;
  if (kShadowMaps)
    result.taken = Sample(kNewest, false, pixel, vec2(pixel) + 0.5);
  else if (kPass == FARSHADE_PASS_DIRECT)
    result.taken = direct_sample(pixel);
  else if (kPass == FARSHADE_PASS_EASY)
    result.taken = sample_source(kNewest, surface);
  else
    result.taken = first_sample(surface);
  result.neighbour = Sample(FARSHADE_SOURCE_UNKNOWN, true, ivec2(0), vec2(0.0));
  if (kSecondLook && kNeighbours) {
    bool unseen = result.taken.source == FARSHADE_SOURCE_UNKNOWN;
    bool old = kMoved && mask_of(result.taken.source) > 0;
    result.neighbour = nearest_on_plane(surface, frame.counts.x > 0 && (unseen || old));
    if (unseen) result.taken = result.neighbour;
  }
  result.known = result.taken.source != FARSHADE_SOURCE_UNKNOWN;
  result.source = kSecondLook && result.known ? result.taken.source : kNewest;
  result.pixel = result.known ? result.taken.pixel : ivec2(0);
  result.on_edge = kEdges && kPass != FARSHADE_PASS_DIRECT && result.known &&
                   near_shadow_edge(result.source, result.pixel, result.taken.at);
  return result;
}

// The bits of one plane of 32 lights at a surface point.
struct PlaneBits {
  uint visible;
  uint stale;           // of older masks: something has moved since
  uint from_neighbour;  // stale bits that the neighbour replaces
  uint unknown;
};

PlaneBits plane_bits(Lookup found, uint slot, vec3 p_stage, uint plane) {
  PlaneBits bits = PlaneBits(0u, 0u, 0u, 0u);
  const uint mask = mask_of(found.source);
  if (found.known && !kShadowMaps) bits.visible = mask_bits(found.source, found.pixel, plane);
  if (kSecondLook && kMoved) bits.stale = stale_bits(1, slot, p_stage, plane);
  // The stale bits of an older mask are not used, since a newer mask exists.
  if (kSecondLook && kMoved && mask > 0 && found.known && found.neighbour.source != FARSHADE_SOURCE_UNKNOWN) {
    bits.from_neighbour = bits.stale;
    bits.visible =
        (bits.visible & ~bits.stale) | (mask_bits(kNewest, found.neighbour.pixel, plane) & bits.stale);
  }
  bits.unknown = !found.known ? ~0u : mask > 0 ? bits.stale & ~bits.from_neighbour : 0u;
  return bits;
}

// The visibility of eight lights, unknown ones by the rule.
Visibility8 visibility_of(uint group, ivec2 pixel, Surface surface, Lookup found, PlaneBits bits, Visibility8 from_maps) {
  uint plane = group / 4;
  Visibility8 k = eight_of(bits.visible >> (group % 4 * 8));
  if (kShadowMaps) k = from_maps;
  if (kSecondLook && found.on_edge) k = edge_visibility(surface, bits.stale, group, k);
  Visibility8 unknown = eight_of(bits.unknown >> (group % 4 * 8)), guessed = Visibility8(vec4(1.0), vec4(1.0));
  // A stale bit is a better guess than none, unless the viewer has changed the light. Otherwise the guess is lit.
  uint otherwise = found.known ? bits.visible | frame.changed_lights[plane / 4][plane % 4] : ~0u;
  if (kSecondLook) guessed = guess(pixel, group, otherwise >> (group % 4 * 8));
  k.low = mix(k.low, kUnknownVisibility * guessed.low, unknown.low);
  k.high = mix(k.high, kUnknownVisibility * guessed.high, unknown.high);
  return k;
}

void shade_uncovered(ivec2 pixel, uint record) {
  imageStore(shown, ivec3(pixel, kEye), vec4(srgb(frame.background.rgb), 1.0));
  report_uncovered(record);
}

void shade(ivec2 pixel) {
  const uint record = report_record(pixel);
  float depth = texelFetch(depth_ring, ivec3(pixel, frame.counts.y + kEye), 0).r;
  if (depth == 0.0) {
    shade_uncovered(pixel, record);
    return;
  }
  uvec2 stored = texelFetch(surfaces, ivec3(pixel, kEye), 0).xy;
  Surface surface = surface_at(pixel, depth, stored.y);
  Lookup found = look_up(pixel, surface);
  if (kPass == FARSHADE_PASS_EASY)
    if (!found.known || found.on_edge || (kMoved && has_moved(0, surface.slot)))
      list_as_hard(pixel, surface.slot != 0u);

  mat3 turn = mat3(frame.eye[kEye].stage_from_eye);
  vec3 p_stage = turn * surface.position;
  vec3 n_stage = normalize(unfolded(unpackSnorm2x16(stored.x)));
  vec3 plane_stage = turn * plane_normal(pixel, depth, n_stage * turn);
  vec3 irradiance = vec3(0.0);
  PlaneBits bits;
  uint shining = 0u;  // lights that would shine here without shadows
  for (uint group = 0; group < kGroups; ++group) {
    if (group % 4 == 0) {
      bits = plane_bits(found, surface.slot, p_stage, group / 4);
      uint newest_stale = 0u;
      if (kReport && kMoved && mask_of(found.source) == 0 && found.known)
        newest_stale = stale_bits(0, surface.slot, p_stage, group / 4);
      report_plane(record, group / 4, bits.unknown, newest_stale, bits.from_neighbour);
    }
    Visibility8 from_maps = visibility_from_maps(group, p_stage, plane_stage, n_stage);
    Visibility8 k = visibility_of(group, pixel, surface, found, bits, from_maps);
    for (uint i = 0; i < 8 && group * 8 + i < kLights; ++i) {
      vec3 unshadowed = radiance(group * 8 + i, p_stage, n_stage);
      irradiance += (i < 4 ? k.low[i] : k.high[i - 4]) * unshadowed;
      if (kReport) shining += uint(any(greaterThan(unshadowed, vec3(0.0))));
    }
    report_visibility(record, group, k);
  }
  report_source(record, found.known, found.source, found.taken, shining);

  const float kInversePi = 0.31830988618;
  vec3 color = texelFetch(base_colors, ivec3(pixel, kEye), 0).rgb * (irradiance * kInversePi + frame.ambient.rgb);
  imageStore(shown, ivec3(pixel, kEye), vec4(srgb(color), 1.0));
}

void main() {
  if (!kSecondLook) {
    if (gl_GlobalInvocationID.x < uint(frame.eye[kEye].size_px.x)) shade(ivec2(gl_GlobalInvocationID.xy));
    return;
  }
#ifndef DIRECT
  const bool can_move = kPass == FARSHADE_PASS_MOVING;
  if (gl_GlobalInvocationID.x < hard_lists[kEye * 2 + uint(can_move)].w) {
    uint pixel = hard_pixels[list_place(gl_GlobalInvocationID.x, can_move)];
    shade(ivec2(pixel & 0xFFFFu, pixel >> 16));
  }
#endif
}
