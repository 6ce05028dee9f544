// Reprojection: what the masks in use know of a shown surface point.
// The point is projected into each traced view, in order of trust. The first view that saw the same surface there, in a
// tile that arrived, gives its bits. If there is none, a face of the cube mask gives them (masks of all directions,
// with fewer pixels), else the nearest pixel of the newest view on the point's own plane.
// Near shadow edges (a mask's edge bits mark them), a line between the lit and the dark pixels around the point, in all of
// this eye's views, places the edge. Views of different times sample the edge at different places.
// Bits are stale if a light, a caster or the surface itself has moved since the mask was traced (motion.glsl).

struct Surface {
  vec3 position, normal;  // in the shown eye's space; the normal is geometric, of any length
  uint slot;              // of an instance that can move; 0 for others
};

// A surface point projected into a traced view. On its tangent plane, depth (near / distance) is linear on the screen.
struct Projection {
  bool visible;     // in front of the traced eye, and the surface faces it
  vec2 at;          // traced pixel position
  vec3 plane;       // depth of the plane at the centre of pixel (x, y): dot(plane, (x, y, 1))
  float depth;      // of the point
  float tolerance;  // of the depth of any point on the plane
};

// The depth stored at a traced pixel may differ from the plane's depth there by half of the plane's change between the
// point and the pixel's centre (surfaces bend, normals are rounded), by a pixel's footprint, by the geometric error of the
// levels of detail in both views, and by float rounding. The rounding only matters for pixels smaller than 1e-6 rad:
// kRounding may be 0 or ten times as large.
const float kBend = 0.5, kFootprint = 1.0, kRounding = 16.0 / 16777216.0;

const uint kNewest = 0;  // the source: this eye's newest mask

// A source of the shown eye.
SourceData source_of(uint index) { return frame.sources[shown_eye * FARSHADE_MAX_SOURCES + index]; }

bool is_face(uint source) { return source >= FARSHADE_FIRST_FACE; }

// The index of a source's mask: its place in the motions.
uint mask_of(uint source) {
  return is_face(source) ? FARSHADE_MAX_MASKS + (source - FARSHADE_FIRST_FACE) / 2 : source % FARSHADE_MAX_MASKS;
}

Projection project(uint mask, SourceData source, Surface surface) {
  vec4 window = source.origin_step;
  vec3 p = surface.position, n = surface.normal;
  if (is_carried(surface.slot)) carry_back(mask, surface.slot, p, n);
  p = (source.traced_from_shown * vec4(p, 1.0)).xyz;
  n = mat3(source.traced_from_shown) * n;
  float facing = dot(n, p), inverse_z = -1.0 / p.z;
  Projection projection;
  projection.visible = p.z < 0.0 && facing > 0.0;
  projection.at = (p.xy * inverse_z - window.xy) * source.per_step.xy;
  vec2 slope = n.xy * window.zw;
  projection.plane = kNear / facing * vec3(slope, dot(n.xy, window.xy) + 0.5 * (slope.x + slope.y) - n.z);
  projection.depth = kNear * inverse_z;
  projection.tolerance = ((kFootprint + 2.0 * kDetail_px) * max(abs(window.z), abs(window.w)) + kRounding) * projection.depth;
  return projection;
}

bool on_plane(Projection projection, ivec2 pixel, float traced, float bend) {
  float expected = dot(projection.plane, vec3(pixel, 1.0));
  return abs(traced - expected) <= bend * abs(expected - projection.depth) + projection.tolerance;
}

bool same_surface(sampler2DArray depths, SourceData source, Projection projection, ivec2 pixel, float bend) {
  ivec2 there = inside(source, pixel);
  bool known = block_known(source, there);
  bool near = on_plane(projection, there, texelFetch(depths, ivec3(there, source.place.x), 0).r, bend);
  return pixel == there && known && near;
}

// The pixel of a traced view that a surface point takes its bits from.
struct Sample {
  uint source;  // or FARSHADE_SOURCE_UNKNOWN
  bool beside;  // the pixel does not contain the point; it is the nearest one on the point's plane
  ivec2 pixel;
  vec2 at;  // the point's traced pixel position
};

// A search around a pixel in rings, each twice as far out as the one before. It limits how far bits are carried along a
// plane.
const ivec2 kAround[8] = ivec2[](ivec2(-1, 0), ivec2(1, 0), ivec2(0, -1), ivec2(0, 1), ivec2(-1, -1), ivec2(1, 1),
                                 ivec2(-1, 1), ivec2(1, -1));
const uint kRings = 5;
const float kFarthest_px = 32.0, kNeighbourBend = 0.05;

Sample nearest_on_plane(Surface surface, bool needed) {
  SourceData source = source_of(kNewest);
  Projection projection = project(0, source, surface);
  Sample found = Sample(FARSHADE_SOURCE_UNKNOWN, true, ivec2(0), projection.at);
  vec2 start = clamp(projection.at, vec2(0.0), source.per_step.zw - 1.0);
  needed = needed && projection.visible && all(lessThanEqual(abs(start - projection.at), vec2(kFarthest_px)));
  [[dont_unroll]] for (uint tap = 0; needed && tap <= 8 * kRings && found.source == FARSHADE_SOURCE_UNKNOWN; ++tap) {
    ivec2 pixel = ivec2(start) + (tap == 0 ? ivec2(0) : kAround[(tap - 1) % 8] << ((tap - 1) / 8));
    if (same_surface(mask_depths_0, source, projection, pixel, kNeighbourBend)) {
      found.source = kNewest;
      found.pixel = pixel;
    }
  }
  return found;
}

Sample sample_source(sampler2DArray depths, uint index, SourceData source, Surface surface) {
  Projection projection = project(mask_of(index), source, surface);
  Sample found = Sample(FARSHADE_SOURCE_UNKNOWN, false, ivec2(floor(projection.at)), projection.at);
  bool same = same_surface(depths, source, projection, found.pixel, kBend);
  if (projection.visible && same) found.source = index;
  return found;
}

// Looks for the point in a mask, as traced for this eye and then for the other, from the view `first` on.
void look_in(sampler2DArray depths, uint mask, uint first, Surface surface, inout Sample found) {
  const uint views = kOtherEye ? 2 : 1;
  [[dont_unroll]] for (uint view = first;
                       mask < frame.counts.x && view < views && found.source == FARSHADE_SOURCE_UNKNOWN; ++view) {
    uint index = kNewest + mask + view * FARSHADE_MAX_MASKS;
    found = sample_source(depths, index, source_of(index), surface);
  }
}

// The first source that knows the point: each mask, newest first, as traced for this eye and then for the other. The
// first pass looks only at the newest for this eye.
Sample first_sample(Surface surface) {
  Sample found = sample_source(mask_depths_0, kNewest, source_of(kNewest), surface);
#ifdef SECOND_LOOK
  look_in(mask_depths_0, 0, 1, surface, found);
  look_in(mask_depths_1, 1, 0, surface, found);
  look_in(mask_depths_2, 2, 0, surface, found);
  look_in(mask_depths_3, 3, 0, surface, found);
#endif
  return found;
}

// The four pixels around a position, from left to right and from top to bottom.
ivec2 tap_at(ivec2 corner, uint tap) { return corner + ivec2(tap & 1, tap >> 1); }
float of_tap(vec4 gathered, uint tap) {
  return tap == 0 ? gathered.w : tap == 1 ? gathered.z : tap == 2 ? gathered.x : gathered.y;
}
vec4 gather(sampler2DArray depths, ivec2 corner, uint layer) {
  return textureGather(depths, vec3((vec2(corner) + 1.0) / vec2(textureSize(depths, 0).xy), layer));
}

// What the cube mask knows of a point.
struct FaceSamples {
  Sample same;       // the nearest of the four pixels around the point that saw the same surface
  Sample closest;    // of all four, the one whose depth is closest to that of the point's plane
  float difference;  // of `closest`, relative to the depth
};

void add_face(uint index, SourceData source, Surface surface, inout FaceSamples samples) {
  Projection projection = project(mask_of(index), source, surface);
  ivec2 corner = corner_at(projection.at);
  vec4 depths = gather(cube_mask_depths, corner, source.place.x);
  float nearest = 1e30;
  [[unroll]] for (uint tap = 0; tap < 4; ++tap) {
    ivec2 pixel = tap_at(corner, tap), there = inside(source, pixel);
    float traced = of_tap(depths, tap);
    bool known = block_known(source, there) && pixel == there && projection.at == projection.at;
    bool same = projection.visible && known && on_plane(projection, pixel, traced, kBend);
    vec2 off = vec2(pixel) + 0.5 - projection.at;
    float distance = same ? dot(off, off) : 1e30;
    bool nearer = distance < nearest;
    samples.same.source = nearer ? index : samples.same.source;
    samples.same.pixel = nearer ? pixel : samples.same.pixel;
    samples.same.at = nearer ? projection.at : samples.same.at;
    nearest = min(nearest, distance);
    float difference = abs(traced - projection.depth) / projection.depth;
    bool closer = known && traced > 0.0 && projection.depth > 0.0 && difference < samples.difference;
    samples.closest.source = closer ? index : samples.closest.source;
    samples.closest.pixel = closer ? pixel : samples.closest.pixel;
    samples.difference = closer ? difference : samples.difference;
  }
}

// The first face of the cube mask that knows the point.
FaceSamples cube_mask_samples(Surface surface, bool needed) {
  Sample none = Sample(FARSHADE_SOURCE_UNKNOWN, false, ivec2(0), vec2(0.0));
  FaceSamples samples = FaceSamples(none, none, 1e30);
  const uint first = kNewest + FARSHADE_FIRST_FACE, faces = frame.counts.w;
  for (uint i = 0; needed && i < faces && samples.same.source == FARSHADE_SOURCE_UNKNOWN; ++i)
    add_face(first + i, source_of(first + i), surface, samples);
  return samples;
}

// The visibility of eight lights.
struct Visibility8 {
  vec4 low, high;
};

// From the lowest eight bits.
Visibility8 eight_of(uint bits) {
  return Visibility8(vec4(uvec4(bits) >> uvec4(0, 1, 2, 3) & 1u), vec4(uvec4(bits) >> uvec4(4, 5, 6, 7) & 1u));
}

// The samples around a point near a shadow edge: in each of this eye's masks the four pixels around the point, if they saw
// its surface. Masks of different times sample the edge at different places.
const uint kSamples = 4 * FARSHADE_MAX_MASKS;
struct EdgeSamples {
  vec2 off[kSamples];              // from the point, in pixels of the mask
  float weight[kSamples];          // by distance (D. Shepard, "A two-dimensional interpolation function", 1968)
  uint lit[kSamples];              // bits of a group of eight lights
  uint on_surface[kSamples];       // all bits or none
  uint fresh[FARSHADE_MAX_MASKS];  // the lights for which a mask's samples count; if nothing has moved, all bits or none
};

// `depths` are those of the pixels.
void add_samples(uint mask, SourceData source, Projection projection, vec4 depths, bool in_use, uint group,
                 inout EdgeSamples samples) {
  ivec2 corner = corner_at(projection.at);
  [[unroll]] for (uint tap = 0; tap < 4; ++tap) {
    ivec2 pixel = tap_at(corner, tap), there = inside(source, pixel);
    bool known = block_known(source, there), near = on_plane(projection, pixel, of_tap(depths, tap), kBend);
    bool on_surface = projection.visible && in_use && pixel == there && known && near;
    const uint i = 4 * mask + tap;
    samples.off[i] = on_surface ? vec2(pixel) + 0.5 - projection.at : vec2(0.0);
    float distance2 = dot(samples.off[i], samples.off[i]);
    samples.weight[i] = 1.0 / (distance2 * distance2 + 1e-6);
    samples.on_surface[i] = on_surface ? ~0u : 0u;
    samples.lit[i] = mask_bits(source, there, group / 4) >> (group % 4 * 8);
  }
}

void add_mask(sampler2DArray depths, uint mask, Surface surface, uint group, uint fresh, inout EdgeSamples samples) {
  SourceData source = source_of(kNewest + mask);
  Projection projection = project(mask, source, surface);
  vec4 around = gather(depths, corner_at(projection.at), source.place.x);
  samples.fresh[mask] = fresh;
  add_samples(mask, source, projection, around, mask < frame.counts.x, group, samples);
}

// This eye's oldest mask; if the point takes its bits from a face, that face instead, with all lights.
void add_oldest_or_face(uint taken, Surface surface, uint group, uint fresh, inout EdgeSamples samples) {
  const uint oldest = FARSHADE_MAX_MASKS - 1;
  bool face = is_face(taken);
  SourceData source = source_of(kNewest + oldest);
  if (face) source = source_of(taken);
  Projection projection = project(face ? mask_of(taken) : oldest, source, surface);
  ivec2 corner = corner_at(projection.at);
  vec4 depths = gather(mask_depths_3, corner, source.place.x);
  if (kCubeMask) depths = mix(depths, gather(cube_mask_depths, corner, source.place.x), bvec4(face));
  samples.fresh[oldest] = face ? ~0u : fresh;
  add_samples(oldest, source, projection, depths, face || oldest < frame.counts.x, group, samples);
}

// The nearest point to `other` on the line from `from` to `to`.
vec2 nearest_between(vec2 from, vec2 to, vec2 other) {
  vec2 along = to - from;
  return from + along * clamp(dot(other - from, along) / max(dot(along, along), 1e-12), 0.0, 1.0);
}

// `v` where `mask` has all bits, 0 where it has none.
float only(uint mask, float v) { return uintBitsToFloat(mask & floatBitsToUint(v)); }
vec2 only(uint mask, vec2 v) { return uintBitsToFloat(uvec2(mask) & floatBitsToUint(v)); }
uint all_if(uint bits, uint light) { return uint(int(bits << (31 - light)) >> 31); }

// The samples that count for one light: masks of all bits or none.
struct SidesOfEdge {
  uint lit[kSamples], dark[kSamples];
  vec2 lit_middle, dark_middle;  // their means
  float lit_weight, all_weight;  // sums, by distance
};

SidesOfEdge sides_of(EdgeSamples samples, uint light) {
  SidesOfEdge sides;
  vec2 lit = vec2(0.0), all = vec2(0.0);
  uint lits = 0, count = 0;
  sides.lit_weight = sides.all_weight = 0.0;
  [[unroll]] for (uint i = 0; i < kSamples; ++i) {
    uint used = samples.fresh[i / 4] & samples.on_surface[i];
    if (kMoved) used = all_if(used, light);
    sides.lit[i] = all_if(samples.lit[i], light) & used;
    sides.dark[i] = used ^ sides.lit[i];
    lit += only(sides.lit[i], samples.off[i]);
    all += only(used, samples.off[i]);
    lits -= sides.lit[i];
    count -= used;
    sides.lit_weight += only(sides.lit[i], samples.weight[i]);
    sides.all_weight += only(used, samples.weight[i]);
  }
  sides.lit_middle = lit / max(float(lits), 1.0);
  sides.dark_middle = (all - lit) / max(float(count - lits), 1.0);
  return sides;
}

// The outermost samples of both sides along a direction: all lit ones lie beyond `lit`, all dark ones before `dark`. The
// point is at 0.
const float kBeyond = 1e30;
struct Gap {
  float lit, dark;
  vec2 lit_at, dark_at;
};

Gap gap_along(vec2 across, EdgeSamples samples, SidesOfEdge sides) {
  Gap gap = Gap(kBeyond, -kBeyond, vec2(0.0), vec2(0.0));
  [[unroll]] for (uint i = 0; i < kSamples; ++i) {
    float at = dot(across, samples.off[i]);
    float lit = at + only(~sides.lit[i], kBeyond), dark = at - only(~sides.dark[i], kBeyond);
    gap.lit_at = lit < gap.lit ? samples.off[i] : gap.lit_at;
    gap.dark_at = dark > gap.dark ? samples.off[i] : gap.dark_at;
    gap.lit = min(lit, gap.lit);
    gap.dark = max(dark, gap.dark);
  }
  return gap;
}

// The visibility of a light at the point. A shadow's edge is straight within a pixel or two, so a line separates the lit from
// the dark samples. The widest gap between both is between the closest points of their convex hulls; Kozinec's algorithm
// (M. I. Schlesinger, V. Hlavac, "Ten lectures on statistical and structural pattern recognition", 2002, chapter 5) moves from
// the two means towards these points. The point is lit if it lies beyond the middle of the gap. If no line separates the
// samples, their mean decides, weighted by distance. `nearest` is used if no sample counts.
const int kSteps = 1;

float between_samples(EdgeSamples samples, uint light, float nearest) {
  SidesOfEdge sides = sides_of(samples, light);
  bool any = sides.all_weight > 0.0;
  float part = any ? sides.lit_weight / sides.all_weight : nearest, widest = 0.0;
  vec2 lit = sides.lit_middle, dark = sides.dark_middle;
  // Unrolled: lavapipe takes longer for a loop that it can leave early.
  [[unroll]] for (int i = 0; i <= kSteps; ++i) {
    vec2 across = lit - dark;
    Gap gap = gap_along(across, samples, sides);
    float width = (gap.lit - gap.dark) * inversesqrt(max(dot(across, across), 1e-12));
    bool wider = width > widest && max(gap.lit, -gap.dark) < kBeyond;
    part = wider ? -gap.dark / (gap.lit - gap.dark) : part;
    widest = wider ? width : widest;
    vec2 lit_next = nearest_between(lit, gap.lit_at, dark), dark_next = nearest_between(dark, gap.dark_at, lit);
    bool of_lit = dot(lit_next - dark, lit_next - dark) < dot(lit - dark_next, lit - dark_next);
    lit = of_lit ? lit_next : lit;
    dark = of_lit ? dark : dark_next;
  }
  // In pixels, the part of a gap is the distance from the edge, and so the coverage of a pixel.
  float slope = kSharpness > 0.0 ? kSharpness : max(widest, 1.0);
  return clamp((part - 0.5) * slope + 0.5, 0.0, 1.0);
}

// The visibility of eight lights at a point near a shadow edge, whose bits are those of the source `taken`. Samples of lights
// that are stale in masks other than the first do not count there; if `taken` is a face, older masks do not count at all.
Visibility8 edge_visibility(uint taken, Surface surface, uint stale, uint group, Visibility8 nearest) {
  EdgeSamples samples;
  uint fresh = is_face(taken) ? 0u : ~0u;
  if (kMoved) fresh &= ~stale >> (group % 4 * 8);
  add_mask(mask_depths_0, 0, surface, group, ~0u, samples);
  add_mask(mask_depths_1, 1, surface, group, fresh, samples);
  add_mask(mask_depths_2, 2, surface, group, fresh, samples);
  add_oldest_or_face(taken, surface, group, fresh, samples);
  Visibility8 k = nearest;
#ifdef FEW_LIGHTS
  [[unroll]] for (uint i = 0; i < kLights; ++i) k.low[i] = between_samples(samples, i, nearest.low[i]);
#else
  // Compilers take long for eight copies.
  [[dont_unroll]] for (uint i = 0; i < 8; ++i) {
    bvec4 low = equal(uvec4(0, 1, 2, 3), uvec4(i)), high = equal(uvec4(4, 5, 6, 7), uvec4(i));
    float visibility = between_samples(samples, i, dot(nearest.low, vec4(low)) + dot(nearest.high, vec4(high)));
    k.low = mix(k.low, vec4(visibility), low);
    k.high = mix(k.high, vec4(visibility), high);
  }
#endif
  return k;
}
