// Shades both eyes' pixels. For each light, the visibility k_i of a pixel's surface point comes from the masks in
// use (reproject.glsl). A visibility that no mask knows is shown by a stated rule (guess). The formula is
//   I = (I_d / pi) * sum_i k_i * saturate(N . L_i) * I_i
// Almost all pixels are easy: the newest mask knows the point, and no shadow edge is near. The first pass shades
// these and lists the others. The second pass shades the listed pixels with all sources and filters. A third pass
// does the same for listed pixels on instances that can move. GPUs may prefer a single pass over all pixels, without
// lists (ShadingPasses); its pictures are the same.
// Variants: DIRECT reads the newest mask at the shown pixel, in one pass. With SHADOW_MAPS (and DIRECT) visibilities
// come from shadow maps (shadow_lookup.glsl). EASY is the first pass, FLIPPED shades pixels whose bits edge_rays.comp has
// changed, SINGLE is the one that needs no other; without these, the shader is the second or third. FEW_LIGHTS: at most
// FARSHADE_FEW_LIGHTS. REPORT writes what each pixel was shaded with. VISIBILITY writes visibilities instead of a picture.
// MOTION: some instances can move. Drivers remove what a
// constant leaves out only after they have inlined it: as a variant of the preprocessor, the first pass takes lavapipe
// 0.05 s to compile instead of 0.33 s, the second for few lights 0.26 s instead of 0.42 s.
// Lavapipe executes both sides of every branch, so work is saved by separate passes, not by branches. It reads a uniform
// once for all lanes; but inside of a branch, and of a loop that it cannot unroll, once for each lane. So branches contain
// little more than stores. && and || are branches, too. SINGLE has branches over work, for devices that skip it.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#include "shaders/shade_data.h"
#include "shaders/shared.h"

layout(local_size_x = FARSHADE_SHADE_GROUP) in;

#if defined(DIRECT)
const uint kPass = FARSHADE_PASS_DIRECT;
#elif defined(EASY)
const uint kPass = FARSHADE_PASS_EASY;
#define HAS_LISTS
#elif defined(FLIPPED)
const uint kPass = FARSHADE_PASS_FLIPPED;
#define HAS_LISTS
uint flipped_entry = 0u;
#elif defined(SINGLE)
const uint kPass = FARSHADE_PASS_SINGLE;
#define SECOND_LOOK  // looks in all sources
#else
#define SECOND_LOOK
#define HAS_LISTS
layout(constant_id = FARSHADE_CONSTANT_PASS) const uint kPass = FARSHADE_PASS_EASY;
#endif
#ifdef SHADOW_MAPS
const bool kShadowMaps = true;
#define REPORT_SET 2
#else
const bool kShadowMaps = false;
#define REPORT_SET 1
#endif

#ifdef SECOND_LOOK
const bool kSecondLook = true;
#else
const bool kSecondLook = false;
#endif
#include "shaders/shading.glsl"
#ifdef HAS_LISTS
#include "shaders/lists.glsl"
#endif
#include "shaders/report.glsl"
#include "shaders/output.glsl"

#include "shaders/shadow_lookup.glsl"

// These limits prevent 0/0 where a light lies on the surface, and infinity, which becomes NaN in shadow. Pictures are
// the same for kLeastDistance2 from 1e-37 to 1e-14 (0.1 um), and for kMostRadiance from far beyond white to 1e35: the
// sum over all lights is then finite.
const float kLeastDistance2 = 1e-30, kMostRadiance = 1e30;

vec3 radiance(uint i, vec3 p, vec3 n) {
  vec4 place = lights[i].position[shown_eye];
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
  SourceData source = source_of(kNewest);
  ivec2 there = direct_pixel(pixel), near = inside(source, there);
  bool known = block_known(source, near) && frame.counts.x > 0;
  return Sample(near == there && known ? kNewest : FARSHADE_SOURCE_UNKNOWN, false, there, vec2(there) + 0.5);
}

// The rule for unknown visibility: what the cube mask has in the direction of the point; without it, what the newest
// mask has in the direction of the shown pixel; lit if the head has turned too far or the mask's tile is missing.
Visibility8 guess(ivec2 pixel, Sample closest, uint group) {
  const uint plane = group / 4;
  SourceData newest = source_of(kNewest), face = newest;
  ivec2 there = inside(newest, direct_pixel(pixel)), nearby = there;
  bool known = block_known(newest, there) && frame.counts.z != 0u, around = closest.source != FARSHADE_SOURCE_UNKNOWN;
  if (around) face = source_of(closest.source);
  if (around) nearby = closest.pixel;
  uint bits = known ? mask_bits(newest, there, plane) : ~0u, of_face = mask_bits(face, nearby, plane);
  // Of lights that the viewer has changed since then, the cube mask knows nothing.
  uint old = frame.changed_lights[plane / 4][plane % 4] & frame.stale_lights[FARSHADE_SINCE_CUBE_MASK * 2 + plane / 4][plane % 4];
  if (around) bits = (of_face & ~old) | (bits & old);
  return eight_of(bits >> (group % 4 * 8));
}

// What the masks know of a surface point.
struct Lookup {
  Sample taken;       // whose bits the point takes
  Sample closest;     // of the cube mask, for points that no view saw: a guess
  bool known;         // `taken` has a source
  uint source;        // of `taken`; the newest if it has none
  SourceData traced;  // of `source`
  ivec2 pixel;        // of `taken`; 0 if it has no source
  bool on_edge;       // a shadow edge is near
  bool hard;          // the bits of the newest mask are not enough
};

// A point this close to the centre of a mask pixel, in pixels, has its bits.
const float kSampled_px = 1.0 / 256.0;

// Whether a pixel needs the work for hard ones. In a list all do.
bool is_hard(Lookup found) { return kPass != FARSHADE_PASS_SINGLE || found.hard; }

Lookup look_up(ivec2 pixel, Surface surface) {
  Lookup result;
  if (kShadowMaps)
    result.taken = Sample(kNewest, false, pixel, vec2(pixel) + 0.5);
  else if (kPass == FARSHADE_PASS_DIRECT)
    result.taken = direct_sample(pixel);
  else
    result.taken = first_sample(surface);
  result.closest = Sample(FARSHADE_SOURCE_UNKNOWN, false, ivec2(0), vec2(0.0));
#ifdef SECOND_LOOK
  if (kCubeMask) {
    bool unseen = result.taken.source == FARSHADE_SOURCE_UNKNOWN;
    FaceSamples around = cube_mask_samples(surface, unseen);
    if (unseen) result.taken = around.same;
    result.closest = around.closest;
  }
  if (kNeighbours) {
    bool unseen = result.taken.source == FARSHADE_SOURCE_UNKNOWN;
    Sample neighbour = nearest_on_plane(surface, frame.counts.x > 0 && unseen);
    if (unseen) result.taken = neighbour;
  }
#endif
  result.known = result.taken.source != FARSHADE_SOURCE_UNKNOWN;
  result.source = kSecondLook && result.known ? result.taken.source : kNewest;
  result.pixel = result.known ? result.taken.pixel : ivec2(0);
  result.traced = source_of(result.source);
  bool near_edge = near_shadow_edge(result.traced, result.pixel, result.taken.at);
  result.on_edge = kEdges && kPass != FARSHADE_PASS_DIRECT && result.known && near_edge;
  // The bit of a point that a ray of the server has met is exact.
  vec2 off = abs(result.taken.at - vec2(result.pixel) - 0.5);
  if (kEdgeRays && max(off.x, off.y) < kSampled_px) result.on_edge = false;
  result.hard = !result.known || result.on_edge || result.source != kNewest;
  return result;
}

// The bits of one plane of 32 lights at a surface point.
struct PlaneBits {
  uint visible;
  uint stale;  // of masks other than the first: something has moved since
  uint unknown;
};

PlaneBits plane_bits(Lookup found, uint slot, vec3 p_stage, uint plane) {
  PlaneBits bits = PlaneBits(0u, 0u, 0u);
#ifdef FLIPPED
  bits.visible = list_words[flipped_word(flipped_entry, 1 + plane)];
  return bits;
#endif
  const bool first = mask_of(found.source) == 0;
  const uint since = is_face(found.source) ? FARSHADE_SINCE_CUBE_MASK : FARSHADE_SINCE_OLDER;
  if (!kShadowMaps) bits.visible = mask_bits(found.traced, found.pixel, plane);
  bits.visible = found.known ? bits.visible : 0u;
  if (kSecondLook && kMoved && is_hard(found)) bits.stale = stale_bits(since, slot, p_stage, plane);
  // A stale bit of the point itself is the best that there is, unless the viewer has changed the light.
  uint changed = first ? 0u : bits.stale & frame.changed_lights[plane / 4][plane % 4];
  bits.unknown = found.known ? changed : ~0u;
  return bits;
}

// The visibility of eight lights, unknown ones by the rule.
Visibility8 visibility_of(uint group, ivec2 pixel, Surface surface, Lookup found, PlaneBits bits, Visibility8 from_maps) {
  uint plane = group / 4;
  Visibility8 k = eight_of(bits.visible >> (group % 4 * 8));
  if (kShadowMaps) k = from_maps;
  Visibility8 unknown = eight_of(bits.unknown >> (group % 4 * 8)), guessed = Visibility8(vec4(1.0), vec4(1.0));
#ifdef SECOND_LOOK
  if (is_hard(found)) {
    Visibility8 filtered = edge_visibility(found.source, surface, bits.stale, group, k);
    k.low = mix(k.low, filtered.low, bvec4(found.on_edge));
    k.high = mix(k.high, filtered.high, bvec4(found.on_edge));
    guessed = guess(pixel, found.closest, group);
  }
#endif
  k.low = mix(k.low, kUnknownVisibility * guessed.low, unknown.low);
  k.high = mix(k.high, kUnknownVisibility * guessed.high, unknown.high);
  return k;
}

// A pixel and what is known of it.
struct ShadedPixel {
  ivec2 pixel;
  uint record;  // of the report
  bool wanted;
  Surface surface;
  Lookup found;
  vec3 p, n, plane;  // eye-relative, stage axes; the plane's normal has any length
};

PlaneBits reported_bits(ShadedPixel at, uint plane) {
  PlaneBits bits = plane_bits(at.found, at.surface.slot, at.p, plane);
  const bool first = mask_of(at.found.source) == 0;
  uint stale = bits.stale & ~bits.unknown;
  if (kReport && kMoved && first) stale = stale_bits(FARSHADE_SINCE_NEWEST, at.surface.slot, at.p, plane);
  report_plane(at.record, plane, bits.unknown, at.found.known ? stale : 0u);
  return bits;
}

// The irradiance from the eight lights of a group. Adds to `shining` how many would shine here without shadows.
vec3 irradiance_from(uint group, ShadedPixel at, PlaneBits bits, inout uint shining) {
  Visibility8 from_maps = visibility_from_maps(group, at.p, at.plane, at.n);
  Visibility8 k = visibility_of(group, at.pixel, at.surface, at.found, bits, from_maps);
  vec3 irradiance = vec3(0.0);
  [[unroll]] for (uint i = 0; i < min(8, kLights - group * 8); ++i) {
    vec3 unshadowed = radiance(group * 8 + i, at.p, at.n);
    bool shines = any(greaterThan(unshadowed, vec3(0.0)));
    // Samples beside the point may face a light that the point does not face.
    if (kSecondLook && i < 4) k.low[i] = shines || !at.found.on_edge ? k.low[i] : 0.0;
    if (kSecondLook && i >= 4) k.high[i - 4] = shines || !at.found.on_edge ? k.high[i - 4] : 0.0;
    irradiance += (i < 4 ? k.low[i] : k.high[i - 4]) * unshadowed;
    if (kReport) shining += uint(shines);
  }
  report_visibility(at.record, group, k);
  write_visibility(at.pixel, at.wanted, group, k);
  return irradiance;
}

#ifdef EASY
void list(ivec2 pixel, bool edge, bool can_move) {
  if (edge) edge = list_as_edge(pixel);
  if (!edge) list_as_hard(pixel, can_move);
}
#else
void list(ivec2 pixel, bool edge, bool can_move) {}
#endif

// The light that the surface at a pixel reflects. `record` is that of the report. Writes nothing, and lists no pixel, that
// is not `wanted`.
vec3 reflected(ivec2 pixel, float depth, uint record, bool wanted) {
  ShadedPixel at;
  at.pixel = pixel;
  at.record = record;
  at.wanted = wanted;
  uvec2 stored = texelFetch(surfaces, ivec3(pixel, shown_eye), 0).xy;
  at.surface = surface_at(pixel, depth, stored.y);
  at.found = look_up(pixel, at.surface);
  if (kPass == FARSHADE_PASS_EASY) {
    bool moved = kMoved && has_moved(0, at.surface.slot), unseen = !at.found.known && frame.counts.y != 0u;
    bool edge = kEdgeRays && (at.found.on_edge || unseen) && !moved;
    if (wanted && (at.found.hard || moved)) list(pixel, edge, at.surface.slot != 0u);
  }
  mat3 turn = mat3(frame.eye[shown_eye].stage_from_eye);
  at.p = turn * at.surface.position;
  at.n = normalize(unfolded(unpackSnorm2x16(stored.x)));
  at.plane = turn * plane_normal(pixel, depth, at.n * turn);

  // The first group is apart, because in a loop every uniform would be read by each lane.
  uint shining = 0u;
  PlaneBits bits;
  vec3 irradiance = vec3(0.0);
  if (kGroups > 0) {
    bits = reported_bits(at, 0);
    irradiance = irradiance_from(0, at, bits, shining);
  }
#ifndef FEW_LIGHTS
  if (kGroups > 1)
    for (uint group = 1; group < kGroups; ++group) {
      if (group % 4 == 0) bits = reported_bits(at, group / 4);
      irradiance += irradiance_from(group, at, bits, shining);
    }
#endif
  report_source(at.record, at.found.known, kPass == FARSHADE_PASS_FLIPPED, at.found.source, at.found.taken, shining);

  const float kInversePi = 0.31830988618;
  return base_color(pixel) * (irradiance * kInversePi + frame.ambient.rgb);
}

// Writes nothing if the pixel is not `wanted`: because it lies outside of the picture, or is not listed.
void shade(ivec2 pixel, bool wanted) {
  float depth = texelFetch(shown_depths, ivec3(pixel, shown_eye), 0).r;
  bool covered = depth != 0.0;
  uint record = report_record(pixel, wanted);
  if (!covered) report_uncovered(record);
  if (!covered) write_uncovered(pixel, wanted);
  vec3 color = frame.background.rgb;
  if (kPass != FARSHADE_PASS_SINGLE || covered) {
    vec3 surface = reflected(pixel, covered ? depth : 1.0, covered ? record : kNoRecord, wanted && covered);
    color = mix(color, surface, bvec3(covered));
  }
  write_picture(pixel, wanted, srgb(color));
}

void main() {
#ifdef FLIPPED
  uint i = listed_entry(), pixel = 0u;
  bool listed = i < lists[list_of(FARSHADE_LIST_FLIPPED)].w;
  if (listed) flipped_entry = i;
  if (listed) pixel = list_words[flipped_word(i, 0)];
  shade(unpacked(pixel), listed);
#elif defined(HAS_LISTS) && !defined(EASY)
  const bool can_move = kPass == FARSHADE_PASS_MOVING;
  uint i = listed_entry(), word = hard_word(i, can_move), pixel = 0u;
  bool listed = i < lists[list_of(can_move ? FARSHADE_LIST_MOVING : FARSHADE_LIST_HARD)].w;
  if (listed) pixel = list_words[word];
  shade(unpacked(pixel), listed);
#else
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = ivec2(frame.eye[shown_eye].size_px.xy);
  shade(min(pixel, max(size - 1, ivec2(0))), all(lessThan(pixel, size)));
#endif
}
