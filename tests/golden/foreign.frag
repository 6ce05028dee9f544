// Of ForeignRenderer: writes a pixel of `surfaces` as docs/embedding.md says.
#version 460

layout(push_constant) uniform Drawn {
  mat4 clip_from_object;
  vec4 stage_from_object_normal[3];
  float step_y;
  uint instance;
};
layout(location = 0) in vec3 stage_normal;
layout(location = 0) out uvec2 surface;

vec2 octahedral(vec3 n) {
  vec2 p = n.xy / (abs(n.x) + abs(n.y) + abs(n.z));
  vec2 folded = (1.0 - abs(p.yx)) * vec2(p.x < 0.0 ? -1.0 : 1.0, p.y < 0.0 ? -1.0 : 1.0);
  return n.z < 0.0 ? folded : p;
}

// Of the triangle, in the eye's space. gl_FragCoord.z is near / distance, which is linear on the screen.
vec3 geometric_normal() {
  vec2 origin = vec2(stage_from_object_normal[0].w, stage_from_object_normal[1].w);
  vec2 step = vec2(stage_from_object_normal[2].w, step_y), at = origin + gl_FragCoord.xy * step;
  vec2 gradient = vec2(dFdx(gl_FragCoord.z), dFdy(gl_FragCoord.z)) / step;
  return normalize(vec3(gradient, -(gl_FragCoord.z - dot(gradient, at))));
}

void main() {
  vec3 n = normalize(gl_FrontFacing ? stage_normal : -stage_normal);
  surface = uvec2(packSnorm2x16(octahedral(n)),
                  (packSnorm4x8(vec4(octahedral(geometric_normal()), 0.0, 0.0)) & 0xFFFFu) | instance << 16);
}
