// Edge rays: the client's own shadow rays. Where the newest mask has an edge of a light (mask_edges.h), and where it does
// not know the point, a ray from the point to the light decides. The triangles that it can meet are in the light's list
// for its direction (stereo/edge_rays/light_buffer.h). This pass works on the listed edges. It lists those where a bit of
// the mask is wrong or unknown, with the right bits, and lists those that it cannot decide as hard. Buffers of texels,
// because lavapipe reads a storage buffer once for each lane.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#include "shaders/edge_rays_data.h"
#include "shaders/shade_data.h"
#include "shaders/shared.h"

layout(local_size_x = FARSHADE_SHADE_GROUP) in;

const uint kPass = FARSHADE_PASS_RAYS;  // points are looked up as in the first pass
const bool kSecondLook = false;
#include "shaders/shading.glsl"
#include "shaders/lists.glsl"

layout(set = 1, binding = 0) uniform samplerBuffer ray_lights;  // ShadowMapData; the last: the triangles' origin
layout(set = 1, binding = 1) uniform usamplerBuffer light_buffers;
layout(set = 1, binding = 2) uniform samplerBuffer triangles;  // stereo/edge_rays/caster_texels.h
layout(set = 1, binding = 3) uniform samplerBuffer alphas;     // of textures

vec4 ray_light(uint light, uint row) { return texelFetch(ray_lights, int(light * FARSHADE_RAY_LIGHT_ROWS + row)); }

ShadowMapData projection_of(uint light) {
  ShadowMapData map;
  map.right = ray_light(light, 0);
  map.up = ray_light(light, 1);
  map.ahead = ray_light(light, 2);
  map.origin[shown_eye] = ray_light(light, 3 + shown_eye);
  map.place = floatBitsToUint(ray_light(light, 5));
  return map;
}

// A plane counts from this distance on. The drawn surface may lie kDetail_px off the true one, mostly much less; the
// rounding of depth grows with the distance from the eye, that of corners with the distance from their origin
// (docs/edge-rays.md has the measurements).
const float kSlackOfDetail = 0.5, kSlackOfDistance = 4e-6, kSlackOfScene = 2.5e-7;

// A ray between a point and a light.
struct Ray {
  vec3 point;   // relative to the triangles' origin
  vec3 along;   // from the light to the point; of a parallel light, unit
  bool parallel;
  float slack;  // metres
};

// The texel of a light's buffer that contains the direction of a ray, and its words' start.
uint texel_of(ShadowMapData map, vec3 from_light, out vec2 inside) {
  uint layer = 0;
  vec2 at;
  if (map.place.x == FARSHADE_MAP_CUBE) {
    vec3 size = abs(from_light);
    bool x = size.x >= size.y && size.x >= size.z, y = !x && size.y >= size.z;
    vec3 p = x ? from_light.zyx : y ? from_light.xzy : from_light;
    layer = (x ? 0u : y ? 2u : 4u) + uint(p.z < 0.0);
    at = p.xy / abs(p.z);
  } else {
    vec3 p = from_light * mat3(map.right.xyz, map.up.xyz, map.ahead.xyz);
    at = map.place.x == FARSHADE_MAP_PARALLEL ? p.xy : p.xy / max(p.z, 1e-30);  // nothing behind the light is lit
  }
  const float side = float(FARSHADE_LIGHT_BUFFER_SIDE);
  at = clamp(at * vec2(map.right.w, -map.up.w) + 0.5 * side, vec2(0.0), vec2(side - 1e-3));
  inside = fract(at);
  return (layer * FARSHADE_LIGHT_BUFFER_SIDE + uint(at.y)) * FARSHADE_LIGHT_BUFFER_SIDE + uint(at.x);
}

// The distance of a point from the light along the axis of its layer.
float depth_of(ShadowMapData map, vec3 from_light) {
  vec3 size = abs(from_light);
  return map.place.x == FARSHADE_MAP_CUBE ? max(size.x, max(size.y, size.z)) : dot(from_light, map.ahead.xyz);
}

// The place of the list of triangles that a ray may meet; 0 if it is empty.
uint list_at(ShadowMapData map, vec3 from_light) {
  vec2 inside;
  uint word = texelFetch(light_buffers, int(map.place.y + texel_of(map, from_light, inside))).x;
  [[unroll]] for (uint division = 0; division < FARSHADE_LIGHT_BUFFER_DIVISIONS; ++division) {
    inside *= float(FARSHADE_LIGHT_BUFFER_PARTS);
    uvec2 part = uvec2(inside);  // less than FARSHADE_LIGHT_BUFFER_PARTS
    inside -= vec2(part);
    bool divided = (word & FARSHADE_DIVIDED) != 0u;
    uint at = divided ? (word & ~FARSHADE_DIVIDED) + part.y * FARSHADE_LIGHT_BUFFER_PARTS + part.x : 0u;
    uint of_part = texelFetch(light_buffers, int(map.place.y + at)).x;
    word = divided ? of_part : word;
  }
  return word;
}

// Whether a triangle lies between point and light. Triangles that share an edge share its sign, so rays do not pass between
// them. A triangle whose plane is within `slack` of the point does not count: the point may lie on it.
bool is_between(vec3 a, vec3 b, vec3 c, Ray ray) {
  a -= ray.point;
  b -= ray.point;
  c -= ray.point;
  vec3 n = cross(b - a, c - a);
  vec3 side = vec3(dot(ray.along, cross(a, b)), dot(ray.along, cross(b, c)), dot(ray.along, cross(c, a)));
  bool inside = all(greaterThanEqual(side, vec3(0.0))) || all(lessThanEqual(side, vec3(0.0)));
  float distance = dot(n, a), whole = -dot(n, ray.along);  // the ray meets the plane at distance / whole of it
  bool beyond = distance * distance > ray.slack * ray.slack * dot(n, n) && distance * whole > 0.0;
  return inside && beyond && (ray.parallel || abs(distance) < abs(whole));
}

// Where a ray meets the plane of a triangle: the weights of its corners.
vec3 weights_at(vec3 a, vec3 b, vec3 c, Ray ray) {
  a -= ray.point;
  b -= ray.point;
  c -= ray.point;
  vec3 volumes = vec3(dot(ray.along, cross(b, c)), dot(ray.along, cross(c, a)), dot(ray.along, cross(a, b)));
  return volumes / (volumes.x + volumes.y + volumes.z);
}

// The two texels on both sides of a coordinate, and the weight of the second. x and y: along u and v.
struct Taps {
  vec2 first, second, weight;
};

// Beyond the edge of a texture that is mirrored, as beyond that of a clamped one, its last texel follows.
Taps taps_of(vec2 uv, vec2 size, uvec2 wrap) {
  bvec2 mirrored = equal(wrap, uvec2(FARSHADE_WRAP_MIRRORED)), clamped = equal(wrap, uvec2(FARSHADE_WRAP_CLAMPED));
  bvec2 repeats = equal(wrap, uvec2(FARSHADE_WRAP_REPEATED));
  vec2 folded = 1.0 - abs(1.0 - 2.0 * fract(0.5 * uv));
  vec2 place = mix(mix(fract(uv), folded, mirrored), clamp(uv, 0.0, 1.0), clamped) * size - 0.5;
  place = mix(clamp(place, vec2(0.0), size - 1.0), place, repeats);
  vec2 below = floor(place), next = below + 1.0;
  Taps taps;
  taps.weight = place - below;
  taps.first = mix(below, size - 1.0, lessThan(below, vec2(0.0)));
  taps.second = mix(next, mix(size - 1.0, vec2(0.0), repeats), greaterThanEqual(next, size));
  return taps;
}

float texture_alpha(vec4 texture, vec2 uv) {
  uint wraps = uint(texture.w);
  Taps taps = taps_of(uv, texture.yz, uvec2(wraps & 3u, wraps >> 2));
  int first = int(texture.x), width = int(texture.y);
  int top = first + int(taps.first.y) * width, bottom = first + int(taps.second.y) * width;
  ivec2 x = ivec2(taps.first.x, taps.second.x);
  vec2 left = vec2(texelFetch(alphas, top + x.x).r, texelFetch(alphas, bottom + x.x).r);
  vec2 right = vec2(texelFetch(alphas, top + x.y).r, texelFetch(alphas, bottom + x.y).r);
  vec2 rows = mix(left, right, taps.weight.x);
  return mix(rows.x, rows.y, taps.weight.y);
}

// Whether a ray that meets a triangle meets no hole there (stereo/tracer/hole_test.h). `at`: where the triangle's alpha is.
bool is_solid(int corner, int at, Ray ray) {
  vec3 weights = weights_at(texelFetch(triangles, corner).xyz, texelFetch(triangles, corner + 1).xyz,
                            texelFetch(triangles, corner + 2).xyz, ray);
  vec4 of_corners = texelFetch(triangles, at), uv_ab = texelFetch(triangles, at + 1), uv_c = texelFetch(triangles, at + 2);
  vec2 uv = mat3x2(uv_ab.xy, uv_ab.zw, uv_c.xy) * weights;
  return dot(of_corners.xyz, weights) * texture_alpha(texelFetch(triangles, int(uv_c.z)), uv) >= of_corners.w;
}

// What lies between a point and a light. `undecided`: only what may have a hole there.
struct Met {
  bool dark, undecided;
};

// Whether the light does not shine at the point, whatever lies between: it is behind the surface, out of reach, or the
// point is outside of its cone. `n` is the shading normal, `plane` the geometric one, both of any length. That one has
// eight bits a component, so only the rays decide near the horizon.
const float kHorizon = 1.0 / 64.0;

bool is_out_of_reach(uint light, vec3 along, vec3 n, vec3 plane) {
  float distance2 = dot(along, along);
  bool behind = dot(n, along) >= 0.0, below = dot(plane, along) > kHorizon * sqrt(dot(plane, plane) * distance2);
  bool outside = false;
  if (kRangesAndCones) {
    LightData data = lights[light];
    float falloff = dot(data.spot_direction.xyz, along) * inversesqrt(distance2) * data.spot_cone.x + data.spot_cone.y;
    bool far = data.position[shown_eye].w != 0.0 && distance2 * data.intensity.w >= 1.0;
    outside = far || falloff <= 0.0;
  }
  return behind || below || outside;
}

Met trace(uint light, vec3 p, vec3 n, vec3 plane, float slack) {
  ShadowMapData map = projection_of(light);
  vec3 from_light = p - map.origin[shown_eye].xyz;
  Ray ray;
  ray.point = p - ray_light(kLights, 3 + shown_eye).xyz;
  ray.parallel = map.place.x == FARSHADE_MAP_PARALLEL;
  ray.along = ray.parallel ? map.ahead.xyz : from_light;
  vec3 reach = abs(ray.point);
  ray.slack = slack + kSlackOfScene * max(reach.x, max(reach.y, reach.z));
  uint list = list_at(map, from_light), numbers = (1u << map.place.z) - 1u;
  // Triangles that begin beyond the point hide nothing from it, nor do the next ones of a list.
  float step = uintBitsToFloat(map.place.w), beyond = step > 0.0 ? (depth_of(map, from_light) - map.ahead.w) / step + 1.0 : 1e30;
  Met met = Met(is_out_of_reach(light, ray.along, n, plane), false);
  bool more = list != 0u && !met.dark;
  int i = int(map.place.y + list);
  while (more) {  // one round if no triangle has holes
    bool hit = false;
    int corner = 0;
    float alpha = 0.0;
    while (more && !hit) {
      uint word = texelFetch(light_buffers, i++).x;
      corner = int(word & numbers) * 3;
      vec4 first = texelFetch(triangles, corner);
      alpha = first.w;
      hit = is_between(first.xyz, texelFetch(triangles, corner + 1).xyz, texelFetch(triangles, corner + 2).xyz, ray);
      more = (word & FARSHADE_LAST) == 0u && float(word >> map.place.z) <= beyond;
    }
    bool unknown = hit && alpha == FARSHADE_UNKNOWN_HOLES, solid = hit && alpha == 0.0;
    if (kHoles && hit && alpha > 0.0) solid = is_solid(corner, int(alpha), ray);
    met.dark = met.dark || solid;
    met.undecided = met.undecided || unknown;
    more = more && !met.dark;
  }
  return met;
}

// Whether something that can move may lie between the point and the light.
bool passes_movable(vec3 p, uint light) {
#ifdef MOTION
  vec4 place = lights[light].position[shown_eye];
  vec3 to_light = place.xyz - p * place.w;
  float distance = length(to_light);
  to_light /= distance;
  bool passed = false;
  [[unroll]] for (uint i = 0; i < FARSHADE_MAX_MOVED; ++i)
    passed = passed || passes(frame.movable[shown_eye * FARSHADE_MAX_MOVED + i], p, to_light, place.w == 0.0 ? 1e30 : distance);
  return passed;
#else
  return false;
#endif
}

float slack_at(Surface surface) {
  vec4 window = frame.eye[shown_eye].window.origin_step;
  float pixel = max(abs(window.z), abs(window.w));
  return -surface.position.z * (kSlackOfDetail * kDetail_px * pixel + kSlackOfDistance);
}

void main() {
  uint i = listed_entry(), packed_pixel = 0u, edges = lists[list_of(FARSHADE_LIST_EDGES)].w;
  bool listed = i < min(edges, edge_capacity());
  bool traced = listed && edges <= edge_capacity();  // otherwise the order of invocations would choose
  if (listed) packed_pixel = list_words[edge_word(i)];
  ivec2 pixel = unpacked(packed_pixel);
  float depth = texelFetch(shown_depths, ivec3(pixel, shown_eye), 0).r;
  uvec2 stored = texelFetch(surfaces, ivec3(pixel, shown_eye), 0).xy;
  Surface surface = surface_at(pixel, depth, stored.y);
  mat3 turn = mat3(frame.eye[shown_eye].stage_from_eye);
  vec3 p = turn * surface.position, n = unfolded(unpackSnorm2x16(stored.x));
  vec3 plane_normal = -(turn * surface.normal);  // towards the eye
  float slack = slack_at(surface);
  Sample taken = first_sample(surface);
  bool known = taken.source != FARSHADE_SOURCE_UNKNOWN;
  SourceData newest = source_of(kNewest);
  uint visible[kPlanes];
  bool wrong = !known, hard = listed && !traced;
  [[unroll]] for (uint plane = 0; plane < kPlanes; ++plane) {
    uint all = kLights >= plane * 32 + 32 ? ~0u : (1u << (kLights % 32)) - 1u;
    uint cell = cell_bits(newest, taken.at, plane), has_buffer = frame.ray_lights[plane / 4][plane % 4];
    uint rays = !traced ? 0u : known ? cell : all;
    hard = hard || (rays & ~has_buffer) != 0u;
    rays &= has_buffer;
    uint of_mask = known ? mask_bits(newest, inside(newest, taken.pixel), plane) & all : 0u;
    visible[plane] = of_mask;
    while (rays != 0u) {
      uint bit = findLSB(rays), light = plane * 32 + bit;
      rays &= rays - 1;
      Met met = trace(light, p, n, plane_normal, slack);
      hard = hard || (!met.dark && (met.undecided || passes_movable(p, light)));
      visible[plane] = bitfieldInsert(visible[plane], uint(!met.dark), int(bit), 1);
    }
    wrong = wrong || visible[plane] != of_mask;
  }
  if (hard) list_as_hard(pixel, surface.slot != 0u);
  if (traced && wrong && !hard) {
    uint word = flipped_word(append(FARSHADE_LIST_FLIPPED), 0);
    list_words[word] = packed_pixel;
    [[unroll]] for (uint plane = 0; plane < kPlanes; ++plane) list_words[word + 1 + plane] = visible[plane];
  }
}
