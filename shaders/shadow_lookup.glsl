// Shadow maps: the visibility of lights at a shown surface point. A light's map stores the depth of the surface nearest
// to the light (Williams 1978). The (2r + 1)^2 texels around the point are compared with the point, and each result is
// weighted by the share of a box, 2r texels wide around the point, that the texel covers: percentage-closer filtering
// (Reeves, Salesin, Cook, "Rendering antialiased shadows with depth maps", SIGGRAPH 1987), continuous between texels.
// Bias: a texel is compared with the depth of the receiver's plane at the texel (J. Isidoro, "Shadow mapping: GPU-based
// tips and techniques", GDC 2006). So a plane of any slope does not shadow itself, and no constant offset detaches shadows
// from their casters. The remaining tolerance is half of the plane's change of depth from the point to the texel, because
// surfaces bend; one texel's width, because they have corners; and float rounding. (shadow_map_bench --size 192
// --frames 3 --sharpness 1, room at 1024 texels: mask error 0.0138; with a quarter of both terms 0.0170.)

#ifdef SHADOW_MAPS
layout(set = 1, binding = 0) uniform sampler2DArray shadow_maps;
layout(set = 1, binding = 1) uniform ShadowMaps { ShadowMapData maps[kLights + 1]; };

const float kMapBend = 0.5, kMapFootprint = 1.0, kMapRounding = 16.0 / 16777216.0;

// 0 outside of the picture, as for uncovered pixels.
float shown_depth(ivec2 pixel) {
  ivec2 last = ivec2(frame.eye[shown_eye].size_px.xy) - 1, inside = clamp(pixel, ivec2(0), last);
  return inside == pixel ? texelFetch(shown_depths, ivec3(inside, shown_eye), 0).r : 0.0;
}

// The normal of the plane through the pixel and two of its neighbours, one beside it and one above or below. Of the four
// such planes, it takes the one closest to the shading normal `n`, because any other contains a neighbour on another
// surface. It returns `n` if none is close: then the surface is only a pixel wide. Both normals are in the shown eye's
// space; the plane's faces the eye. Depth is near / distance, which is linear on the screen for a plane (gbuffer.frag).
const float kClose = 0.7;

vec3 plane_normal(ivec2 pixel, float depth, vec3 n) {
  vec4 window = frame.eye[shown_eye].window.origin_step;
  vec2 t = window.xy + (vec2(pixel) + 0.5) * window.zw;
  vec2 before = depth - vec2(shown_depth(pixel - ivec2(1, 0)), shown_depth(pixel - ivec2(0, 1)));
  vec2 after = vec2(shown_depth(pixel + ivec2(1, 0)), shown_depth(pixel + ivec2(0, 1))) - depth;
  vec4 best = vec4(n, kClose);
  [[unroll]] for (int i = 0; i < 4; ++i) {
    vec2 gradient = vec2(i % 2 == 0 ? before.x : after.x, i < 2 ? before.y : after.y) / window.zw;
    vec3 plane = normalize(vec3(-gradient, depth - dot(gradient, t)));
    float like = dot(plane, n);
    if (like > best.w) best = vec4(plane, like);
  }
  return best.xyz;
}

// A point that receives light, and its plane, in texels of one layer of the light's map.
struct Receiver {
  vec2 at;         // texels
  float depth;     // in the units of the map
  vec2 gradient;   // of the plane's depth, per texel
  float tolerance;  // of every comparison
  uint layer;
};

// `error_m`: how far the shown surface may lie from the true one.
Receiver receiver_of(ShadowMapData map, vec3 from_light, vec3 plane, float error_m) {
  uint kind = map.place.x;
  uint layer = map.place.y;
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
    mat3 axes = mat3(map.right.xyz, map.up.xyz, map.ahead.xyz);
    p = from_light * axes;
    n = plane * axes;
  }
  vec2 texels = vec2(map.right.w, -map.up.w);
  Receiver receiver;
  receiver.layer = layer;
  if (kind == FARSHADE_MAP_PARALLEL) {
    float per_m = map.ahead.w;
    receiver.at = p.xy * texels;
    receiver.depth = -p.z * per_m;
    receiver.gradient = per_m * n.xy / (n.z * texels);
    receiver.tolerance = ((kMapFootprint + kDetail_px) / texels.x + error_m) * per_m + kMapRounding;
  } else {
    receiver.at = p.xy / p.z * texels;
    receiver.depth = kNear / p.z;
    receiver.gradient = kNear * n.xy / (dot(n, p) * texels);
    receiver.tolerance = ((kMapFootprint + kDetail_px) / texels.x + error_m / p.z + kMapRounding) * receiver.depth;
  }
  receiver.at += 0.5 * float(kMapSide);
  return receiver;
}

// The share of the filter box that a texel covers along one axis. `d` is its distance in texels from the texel of the
// point; `f` is the position of the point in its texel.
float covers(int d, float f) {
  int r = int(kPcfRadius);
  return r == 0 ? 1.0 : (1.0 - (d == -r ? f : 0.0) - (d == r ? 1.0 - f : 0.0)) / float(2 * r);
}

// The filtered edge gets the contrast of the filtered edges of masks (reproject.glsl). docs/modes.md has the measurement.
// Everything that casts shadows lies in the map, so nothing blocks points beside it or behind it: a sky may lie there.
float unblocked(Receiver receiver) {
  int r = int(kPcfRadius);
  vec2 from_middle = abs(receiver.at - 0.5 * float(kMapSide));
  if (max(from_middle.x, from_middle.y) > 0.5 * float(kMapSide)) return 1.0;
  ivec2 own = clamp(ivec2(floor(receiver.at)), ivec2(r), ivec2(int(kMapSide) - 1 - r));
  vec2 f = clamp(receiver.at - vec2(own), 0.0, 1.0);
  float lit = 0.0;
  for (int y = -r; y <= r; ++y)
    for (int x = -r; x <= r; ++x) {
      float change = dot(receiver.gradient, vec2(own + ivec2(x, y)) + 0.5 - receiver.at);
      float blocker = texelFetch(shadow_maps, ivec3(own + ivec2(x, y), receiver.layer), 0).r;
      bool blocked = blocker > 0.0 && blocker > receiver.depth + change + kMapBend * abs(change) + receiver.tolerance;
      lit += blocked ? 0.0 : covers(x, f.x) * covers(y, f.y);
    }
  return clamp((lit - 0.5) * kSharpness + 0.5, 0.0, 1.0);
}

// Defined as a mask's bit is (tracer.h): 0 if the light is off, behind one of the normals, or out of reach.
float visibility_from_map(uint i, vec3 p, vec3 plane, vec3 n) {
  ShadowMapData map = maps[i];
  vec4 place = lights[i].position[shown_eye];
  vec3 to_light = place.xyz - p * place.w;
  bool reaches = map.place.x != FARSHADE_MAP_NONE && dot(n, to_light) > 0.0 && dot(plane, to_light) > 0.0;
  if (kRangesAndCones) {
    float distance2 = dot(to_light, to_light);
    vec4 cone = lights[i].spot_cone;
    float falloff = -dot(lights[i].spot_direction.xyz, to_light) * inversesqrt(distance2) * cone.x + cone.y;
    reaches = reaches && distance2 * lights[i].intensity.w < 1.0 && falloff > 0.0;
  }
  vec2 window_step = abs(frame.eye[shown_eye].window.origin_step.zw);
  float error_m = kDetail_px * max(window_step.x, window_step.y) * length(p);
  float lit = unblocked(receiver_of(map, p - map.origin[shown_eye].xyz, plane, error_m));
  return reaches ? lit : 0.0;
}

Visibility8 visibility_from_maps(uint group, vec3 p, vec3 plane, vec3 n) {
  Visibility8 k = Visibility8(vec4(0.0), vec4(0.0));
  [[unroll]] for (uint i = 0; i < min(8, kLights - group * 8); ++i) {
    float visibility = visibility_from_map(group * 8 + i, p, plane, n);
    if (i < 4) k.low[i] = visibility;
    else k.high[i - 4] = visibility;
  }
  return k;
}
#else
vec3 plane_normal(ivec2 pixel, float depth, vec3 n) { return n; }
Visibility8 visibility_from_maps(uint group, vec3 p, vec3 plane, vec3 n) { return Visibility8(vec4(0.0), vec4(0.0)); }
#endif
