// Shadow maps: which lights see a shown surface point? A light's map keeps the depth of the surface nearest to it
// (Williams 1978). The (2r + 1)^2 texels about the point are compared with it, and what they say is weighed by how much
// of a box 2r texels wide about the point each of them covers: percentage-closer filtering (Reeves, Salesin, Cook,
// "Rendering antialiased shadows with depth maps", SIGGRAPH 1987), without steps between texels.
// Bias: a texel is compared with the depth that the receiver's own plane has there (J. Isidoro, "Shadow mapping: GPU-based
// tips and techniques", GDC 2006), so that a plane does not shadow itself at any slope, without an offset that would part
// shadows from what casts them. What is left is slack: half of what the plane's depth changes from the point to the
// texel, since surfaces bend; a texel's width, since they have corners; and float's rounding. (shadow_map_bench
// --size 192 --frames 3, room at 1024 texels: mask error 0.0138; with a quarter of texel and change 0.0170.)

#ifdef SHADOW_MAPS
layout(set = 1, binding = 0) uniform sampler2DArray shadow_maps;
layout(set = 1, binding = 1) uniform ShadowMaps { ShadowMapData maps[kLights + 1]; };

const float kMapBend = 0.5, kMapFootprint = 1.0, kMapRounding = 16.0 / 16777216.0;

// 0, as where nothing is covered, beyond the picture.
float shown_depth(ivec2 pixel) {
  ivec2 last = ivec2(frame.eye[kEye].size_px.xy) - 1, inside = clamp(pixel, ivec2(0), last);
  return inside == pixel ? texelFetch(depth_ring, ivec3(inside, frame.counts.y + kEye), 0).r : 0.0;
}

// Of the planes that a pixel's neighbours, one beside and one above or below, may span with it, the normal of the one
// that is most like the shading normal `n`: of any other a neighbour lies on another surface. Where none is much like
// it, the surface is too thin on the screen to tell. Both are the shown eye's, the plane's towards it. Depth is
// near / distance, which a plane makes linear on the screen (gbuffer.frag).
const float kMuchLike = 0.7;

vec3 plane_normal(ivec2 pixel, float depth, vec3 n) {
  vec4 window = frame.eye[kEye].window.origin_step;
  vec2 t = window.xy + (vec2(pixel) + 0.5) * window.zw;
  vec2 before = depth - vec2(shown_depth(pixel - ivec2(1, 0)), shown_depth(pixel - ivec2(0, 1)));
  vec2 after = vec2(shown_depth(pixel + ivec2(1, 0)), shown_depth(pixel + ivec2(0, 1))) - depth;
  vec4 best = vec4(n, kMuchLike);
  [[unroll]] for (int i = 0; i < 4; ++i) {
    vec2 gradient = vec2(i % 2 == 0 ? before.x : after.x, i < 2 ? before.y : after.y) / window.zw;
    vec3 plane = normalize(vec3(-gradient, depth - dot(gradient, t)));
    float like = dot(plane, n);
    if (like > best.w) best = vec4(plane, like);
  }
  return best.xyz;
}

// A point before a light, and the plane that it lies on: in texels of one layer of its map.
struct Receiver {
  vec2 at;         // texels
  float depth;     // as the map has it
  vec2 gradient;   // of the plane's depth, a texel
  float slack;     // of every comparison
  uint layer;
};

Receiver receiver_of(uint i, vec3 from_light, vec3 plane) {
  uint kind = maps[i].place.x;
  uint layer = maps[i].place.y;
  vec3 p, n;  // along the map's axes
  if (kind == FARSHADE_MAP_CUBE) {
    vec3 size = abs(from_light);
    bool x = size.x >= size.y && size.x >= size.z, y = !x && size.y >= size.z;
    p = x ? from_light.zyx : y ? from_light.xzy : from_light;
    n = x ? plane.zyx : y ? plane.xzy : plane;
    layer += (x ? 0u : y ? 2u : 4u) + uint(p.z < 0.0);
    n.z = p.z < 0.0 ? -n.z : n.z;
    p.z = abs(p.z);
  } else {
    mat3 axes = mat3(maps[i].right.xyz, maps[i].up.xyz, maps[i].ahead.xyz);
    p = from_light * axes;
    n = plane * axes;
  }
  vec2 texels = vec2(maps[i].right.w, -maps[i].up.w);
  Receiver receiver;
  receiver.layer = layer;
  if (kind == FARSHADE_MAP_PARALLEL) {
    float per_m = maps[i].ahead.w;
    receiver.at = p.xy * texels;
    receiver.depth = -p.z * per_m;
    receiver.gradient = per_m * n.xy / (n.z * texels);
    receiver.slack = kMapFootprint * per_m / texels.x + kMapRounding;
  } else {
    receiver.at = p.xy / p.z * texels;
    receiver.depth = kNear / p.z;
    receiver.gradient = kNear * n.xy / (dot(n, p) * texels);
    receiver.slack = (kMapFootprint / texels.x + kMapRounding) * receiver.depth;
  }
  receiver.at += 0.5 * float(kMapSide);
  return receiver;
}

// Of the box about the point, the share that a texel `d` texels from the point's own covers along one axis; `f` is
// the point's place in its own.
float covers(int d, float f) {
  int r = int(kPcfRadius);
  return r == 0 ? 1.0 : (1.0 - (d == -r ? f : 0.0) - (d == r ? 1.0 - f : 0.0)) / float(2 * r);
}

float unblocked(Receiver receiver) {
  int r = int(kPcfRadius);
  ivec2 own = clamp(ivec2(floor(receiver.at)), ivec2(r), ivec2(int(kMapSide) - 1 - r));
  vec2 f = clamp(receiver.at - vec2(own), 0.0, 1.0);
  float lit = 0.0;
  for (int y = -r; y <= r; ++y)
    for (int x = -r; x <= r; ++x) {
      float change = dot(receiver.gradient, vec2(own + ivec2(x, y)) + 0.5 - receiver.at);
      float blocker = texelFetch(shadow_maps, ivec3(own + ivec2(x, y), receiver.layer), 0).r;
      bool blocked = blocker > receiver.depth + change + kMapBend * abs(change) + receiver.slack;
      lit += blocked ? 0.0 : covers(x, f.x) * covers(y, f.y);
    }
  return lit;
}

// As a mask's bit is defined (tracer.h): 0 where the light is off, behind one of the normals, or does not reach.
float sight_of_light(uint i, vec3 p, vec3 plane, vec3 n) {
  vec4 place = lights[i].position[kEye];
  vec3 to_light = place.xyz - p * place.w;
  bool reaches = maps[i].place.x != FARSHADE_MAP_NONE && dot(n, to_light) > 0.0 && dot(plane, to_light) > 0.0;
  if (kRangesAndCones) {
    float distance2 = dot(to_light, to_light);
    vec4 cone = lights[i].spot_cone;
    float falloff = -dot(lights[i].spot_direction.xyz, to_light) * inversesqrt(distance2) * cone.x + cone.y;
    reaches = reaches && distance2 * lights[i].intensity.w < 1.0 && falloff > 0.0;
  }
  return reaches ? unblocked(receiver_of(i, p - maps[i].origin[kEye].xyz, plane)) : 0.0;
}

Visibility8 sights_of_lights(uint group, vec3 p, vec3 plane, vec3 n) {
  Visibility8 k = Visibility8(vec4(0.0), vec4(0.0));
  for (uint i = 0; i < 8 && group * 8 + i < kLights; ++i) {
    float sight = sight_of_light(group * 8 + i, p, plane, n);
    if (i < 4) k.low[i] = sight;
    else k.high[i - 4] = sight;
  }
  return k;
}
#else
vec3 plane_normal(ivec2 pixel, float depth, vec3 n) { return n; }
Visibility8 sights_of_lights(uint group, vec3 p, vec3 plane, vec3 n) { return Visibility8(vec4(0.0), vec4(0.0)); }
#endif
