// Draws both eyes in one layered pass: the instances of a draw are the eyes, and an eye's layer is its index.
// DEPTH_ONLY omits what only colours need. TEXTURED and COLORED add texture coordinates and vertex colours; a mesh
// without such a stream has no buffer for it.
// (Not multiview: lavapipe of Mesa 22.3.6 loses every draw that needs clipping in all views but the first.)
#version 460
#extension GL_ARB_shader_viewport_layer_array : require
#extension GL_GOOGLE_include_directive : require
#include "shaders/shared.h"

layout(set = 0, binding = 0) uniform Instance { InstanceData instance; };

layout(location = 0) in vec3 position;
#ifndef DEPTH_ONLY
layout(location = 1) in vec2 octahedral_normal;
layout(location = 0) out vec3 stage_normal;
layout(location = 3) flat out uint eye;
#endif
#ifdef TEXTURED
layout(location = 2) in vec2 uv;
layout(location = 1) out vec2 texture_uv;
#endif
#ifdef COLORED
layout(location = 3) in vec4 color;
layout(location = 2) out vec4 vertex_color;
#endif

invariant gl_Position;

#ifndef DEPTH_ONLY
// The direction of an octahedral normal. Its length is not 1.
vec3 unfolded(vec2 p) {
  vec3 n = vec3(p, 1.0 - abs(p.x) - abs(p.y));
  float fold = max(-n.z, 0.0);
  n.xy -= vec2(n.x < 0.0 ? -fold : fold, n.y < 0.0 ? -fold : fold);
  return n;
}
#endif

void main() {
  gl_Layer = gl_InstanceIndex;
  // Both products, because an index would make lavapipe read each matrix once for every vertex.
  vec4 left = instance.clip_from_object[0] * vec4(position, 1.0);
  vec4 right = instance.clip_from_object[1] * vec4(position, 1.0);
  gl_Position = mix(left, right, bvec4(gl_InstanceIndex == 1));
#ifndef DEPTH_ONLY
  eye = gl_InstanceIndex;
  stage_normal = mat3(instance.stage_from_object_normal) * normalize(unfolded(octahedral_normal));
#endif
#ifdef TEXTURED
  texture_uv = uv;
#endif
#ifdef COLORED
  vertex_color = color;
#endif
}
