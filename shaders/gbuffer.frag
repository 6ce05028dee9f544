// Writes the G-buffer: the base colour, and in two words the shading normal, the geometric normal and the instance.
// TEXTURED and COLORED add the inputs that a mesh has, because every declared input must be bound. With DEPTH_ONLY it
// only does the alpha test. Alpha is read at LOD 0, as the tracer reads it.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shaders/shared.h"

layout(constant_id = 0) const bool kMasked = false;
layout(constant_id = 1) const bool kGeometricNormals = true;  // needed to reproject masks
layout(constant_id = 2) const bool kInstances = true;         // needed if some instances can move

#ifdef TEXTURED
layout(set = 1, binding = 0) uniform sampler2DArray base_color_texture;
layout(location = 1) in vec2 texture_uv;
#endif
#ifdef COLORED
layout(location = 2) in vec4 vertex_color;
#endif
layout(set = 0, binding = 0) uniform Instance { InstanceData instance; };

#ifndef DEPTH_ONLY
layout(set = 0, binding = 1) uniform Frame { FrameData frame; };

layout(location = 0) in vec3 stage_normal;
layout(location = 3) flat in uint eye;

layout(location = 0) out vec4 base_color;
layout(location = 1) out uvec2 surface;

// The octahedral map of unit vectors to [-1, 1]^2 (Cigolle et al., "A Survey of Efficient Representations for
// Independent Unit Vectors", JCGT 2014).
vec2 octahedral(vec3 n) {
  vec2 p = n.xy / (abs(n.x) + abs(n.y) + abs(n.z));
  vec2 folded = (1.0 - abs(p.yx)) * vec2(p.x < 0.0 ? -1.0 : 1.0, p.y < 0.0 ? -1.0 : 1.0);
  return n.z < 0.0 ? folded : p;
}

// Depth is near / distance, which is linear on the screen for a plane: 1/z = A tx + B ty + C with eye-space normal
// (A, B, -C). Its screen derivatives are exact within a triangle.
vec3 geometric_normal() {
  vec4 window = mix(frame.eye[0].window.origin_step, frame.eye[1].window.origin_step, bvec4(eye == 1));
  vec2 t = window.xy + gl_FragCoord.xy * window.zw;
  vec2 gradient = vec2(dFdx(gl_FragCoord.z), dFdy(gl_FragCoord.z)) / window.zw;
  return normalize(vec3(gradient, -(gl_FragCoord.z - dot(gradient, t))));
}
#endif

void main() {
  vec4 color = instance.base_color;
#ifdef COLORED
  color *= vertex_color;
#endif
  if (kMasked) {
    float alpha = color.a;
#ifdef TEXTURED
    alpha *= textureLod(base_color_texture, vec3(texture_uv, 0.0), 0.0).a;
#endif
    if (alpha < instance.alpha_cutoff) discard;
  }
#ifndef DEPTH_ONLY
#ifdef TEXTURED
  color.rgb *= texture(base_color_texture, vec3(texture_uv, 0.0)).rgb;
#endif
  base_color = vec4(color.rgb, 1.0);

  vec3 n = normalize(stage_normal);
  if (!gl_FrontFacing) n = -n;
  surface = uvec2(packSnorm2x16(octahedral(n)), kInstances ? instance.index << 16 : 0u);
  if (kGeometricNormals) surface.y |= packSnorm4x8(vec4(octahedral(geometric_normal()), 0.0, 0.0)) & 0xFFFFu;
#endif
}
