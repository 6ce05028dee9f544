// Reproject: what do the masks in hand know of a shown surface point?
// The point is carried into each traced view in order of trust. The first view that saw the same surface there,
// in a tile that arrived, gives its bits; else the nearest pixel of the newest view on the point's own plane does.
// Where shadow edges pass (bits that came with the mask say so), the pixels around the point in all of this eye's
// views are weighed by their distance in pixels: views of other moments sample the edge elsewhere.
// What a mask may no longer know, because a light, a caster or the surface itself has moved since, is stale.

struct Surface {
  vec3 position, normal;  // of the shown eye's space; the normal is geometric, of any length
  uint slot;              // of an instance that can move
};

// A surface as one traced view sees it. On its tangent plane inverse depth is linear on the traced screen.
struct Sight {
  bool ahead;   // before the traced eye and facing it
  vec2 at;      // traced pixel position
  vec3 plane;   // depth that the plane has at a pixel's centre: dot(plane, (x, y, 1))
  float depth;  // of the point
  float slack;  // by which the depth of a point on the plane may be off
};

// A traced depth may differ from the plane's by half of what the plane changes between the point and the pixel's
// centre (surfaces bend, normals are rounded), by a pixel's footprint, and by float rounding.
const float kBend = 0.5, kFootprint = 1.0, kRounding = 16.0 / 16777216.0;

Sight sight_of(uint source, Surface surface) {
  mat4 traced_from_shown = frame.sources[source].traced_from_shown;
  vec4 window = frame.sources[source].origin_step;
  vec3 p = surface.position, n = surface.normal;
  if (kPass == FARSHADE_PASS_MOVING) carry_back(source % FARSHADE_MAX_MASKS, surface.slot, p, n);
  p = (traced_from_shown * vec4(p, 1.0)).xyz;
  n = mat3(traced_from_shown) * n;
  float facing = dot(n, p), inverse_z = -1.0 / p.z;
  Sight sight;
  sight.ahead = p.z < 0.0 && facing > 0.0;
  sight.at = (p.xy * inverse_z - window.xy) * frame.sources[source].per_step.xy;
  vec2 slope = n.xy * window.zw;
  sight.plane = kNear / facing * vec3(slope, dot(n.xy, window.xy) + 0.5 * (slope.x + slope.y) - n.z);
  sight.depth = kNear * inverse_z;
  sight.slack = (kFootprint * max(abs(window.z), abs(window.w)) + kRounding) * sight.depth;
  return sight;
}

bool tile_known(uint source, ivec2 pixel) {
  if (kWhole) return true;
  uint columns = (uint(frame.sources[source].per_step.z) + FARSHADE_TILE_PX - 1) / FARSHADE_TILE_PX;
  uint tile = uint(pixel.y) / FARSHADE_TILE_PX * columns + uint(pixel.x) / FARSHADE_TILE_PX;
  return (known_words[frame.sources[source].place.z + tile / 32] >> (tile % 32) & 1u) != 0u;
}

bool on_plane(Sight sight, ivec2 pixel, float traced, float bend) {
  float expected = dot(sight.plane, vec3(pixel, 1.0));
  return abs(traced - expected) <= bend * abs(expected - sight.depth) + sight.slack;
}

bool same_surface(uint source, Sight sight, ivec2 pixel, float bend) {
  if (any(lessThan(pixel, ivec2(0))) || any(greaterThanEqual(pixel, ivec2(frame.sources[source].per_step.zw))) ||
      !tile_known(source, pixel))
    return false;
  float traced = texelFetch(depth_ring, ivec3(pixel, frame.sources[source].place.x), 0).r;
  return on_plane(sight, pixel, traced, bend);
}

uint mask_bits(uint source, ivec2 pixel, uint plane) {
  uvec2 size = uvec2(frame.sources[source].per_step.zw);
  uint element = (plane * size.y + uint(pixel.y)) * size.x + uint(pixel.x);
  uint first = frame.sources[source].place.y;
  if (kWordBytes == 1) return mask_words[first + element / 4] >> (element % 4 * 8) & 0xFFu;
  if (kWordBytes == 2) return mask_words[first + element / 2] >> (element % 2 * 16) & 0xFFFFu;
  return mask_words[first + element];
}

// Does the mask say that the four pixels around the point `at` differ in some light?
bool near_shadow_edge(uint source, ivec2 pixel, vec2 at) {
  bvec2 second = greaterThanEqual(at - vec2(pixel), vec2(0.5));
  uint quarter = uint(second.x) + 2 * uint(second.y);
  return (mask_bits(source, pixel, kEdgeBit / 32) >> (kEdgeBit % 32 + quarter) & 1u) != 0u;
}

const uint kFirst = kEye * FARSHADE_MAX_SOURCES;  // this eye's newest

uint mask_of(uint source) { return source % FARSHADE_MAX_MASKS; }

struct Found {
  uint source;  // or FARSHADE_SOURCE_UNKNOWN
  bool beside;  // the pixel is not the point's, but the nearest on its plane
  ivec2 pixel;
  vec2 at;  // the point's traced pixel position
};

// Rings about a pixel, each twice as far: how far a shadow's bits may be carried along one plane.
const ivec2 kAround[8] = ivec2[](ivec2(-1, 0), ivec2(1, 0), ivec2(0, -1), ivec2(0, 1), ivec2(-1, -1), ivec2(1, 1),
                                 ivec2(-1, 1), ivec2(1, -1));
const uint kRings = 5;
const float kFarthest_px = 32.0, kNeighbourBend = 0.05;

Found nearest_on_plane(Surface surface, bool wanted) {
  const uint source = kFirst;
  Found found = Found(FARSHADE_SOURCE_UNKNOWN, true, ivec2(0), vec2(0.0));
  Sight sight = sight_of(source, surface);
  found.at = sight.at;
  vec2 inside = clamp(sight.at, vec2(0.0), frame.sources[source].per_step.zw - 1.0);
  wanted = wanted && sight.ahead && all(lessThanEqual(abs(inside - sight.at), vec2(kFarthest_px)));
  ivec2 start = ivec2(inside);
  [[dont_unroll]] for (uint tap = 0; wanted && tap <= 8 * kRings && found.source == FARSHADE_SOURCE_UNKNOWN; ++tap) {
    ivec2 pixel = tap == 0 ? start : start + (kAround[(tap - 1) % 8] << ((tap - 1) / 8));
    if (same_surface(source, sight, pixel, kNeighbourBend)) {
      found.source = source;
      found.pixel = pixel;
    }
  }
  return found;
}

Found look_up(uint source, Surface surface) {
  Sight sight = sight_of(source, surface);
  Found found = Found(FARSHADE_SOURCE_UNKNOWN, false, ivec2(floor(sight.at)), sight.at);
  if (sight.ahead && same_surface(source, sight, found.pixel, kBend)) found.source = source;
  return found;
}

// In order of trust: each mask, newest first, as traced for this eye and then for the other.
Found find(Surface surface) {
  Found found = look_up(kFirst, surface);
  const uint eyes = kOtherEye ? 2 : 1;
  for (uint i = 1; i < frame.counts.x * eyes && found.source == FARSHADE_SOURCE_UNKNOWN; ++i)
    found = look_up(kFirst + i / eyes + i % eyes * FARSHADE_MAX_MASKS, surface);
  return found;
}

// Visibility of eight lights from one word of eight bits.
struct Visibility8 {
  vec4 low, high;
};

Visibility8 eight_of(uint bits) {
  return Visibility8(vec4(uvec4(bits) >> uvec4(0, 1, 2, 3) & 1u), vec4(uvec4(bits) >> uvec4(4, 5, 6, 7) & 1u));
}

// Gaussian of a sample's distance in pixels; measured, see docs/reprojection.md.
const float kSigma_px = 0.5, kExponent = -0.72134752 / (kSigma_px * kSigma_px);  // -log2(e) / (2 sigma^2)

// Eight lights' visibility at a point near a shadow edge, from the four pixels about it in this eye's views.
// `stale` lights count in older masks for nothing.
Visibility8 edge_visibility(Surface surface, uint stale, uint group, Visibility8 nearest) {
  vec4 low = 1e-4 * nearest.low, high = 1e-4 * nearest.high, low_weight = vec4(1e-4), high_weight = vec4(1e-4);
  Visibility8 fresh = eight_of(~stale >> (group % 4 * 8));
  [[unroll]] for (uint mask = 0; mask < FARSHADE_MAX_MASKS; ++mask) {
    Sight sight = sight_of(kFirst + mask, surface);
    ivec2 corner = ivec2(floor(sight.at - 0.5));
    float trust = sight.ahead && mask < frame.counts.x ? 1.0 : 0.0;
    ivec2 size = ivec2(frame.sources[kFirst + mask].per_step.zw);
    vec3 gathered = vec3((vec2(corner) + 1.0) / vec2(textureSize(depth_ring, 0).xy), frame.sources[kFirst + mask].place.x);
    vec4 depths = textureGather(depth_ring, gathered);
    [[dont_unroll]] for (uint tap = 0; tap < 4; ++tap) {
      ivec2 pixel = corner + ivec2(tap & 1, tap >> 1);
      float traced = tap == 0 ? depths.w : tap == 1 ? depths.z : tap == 2 ? depths.x : depths.y;
      bool inside = all(greaterThanEqual(pixel, ivec2(0))) && all(lessThan(pixel, size));
      bool same = inside && tile_known(kFirst + mask, pixel) && on_plane(sight, pixel, traced, kBend);
      vec2 off = vec2(pixel) + 0.5 - sight.at;
      float weight = same ? trust * exp2(kExponent * dot(off, off)) : 0.0;
      Visibility8 lit = eight_of(mask_bits(kFirst + mask, inside ? pixel : ivec2(0), group / 4) >> (group % 4 * 8));
      vec4 low_now = mask > 0 ? weight * fresh.low : vec4(weight), high_now = mask > 0 ? weight * fresh.high : vec4(weight);
      low += low_now * lit.low;
      low_weight += low_now;
      if (kLights > 4) {
        high += high_now * lit.high;
        high_weight += high_now;
      }
    }
  }
  low = clamp((low / low_weight - 0.5) * kSharpness + 0.5, 0.0, 1.0);
  high = clamp((high / high_weight - 0.5) * kSharpness + 0.5, 0.0, 1.0);
  return Visibility8(low, high);
}
