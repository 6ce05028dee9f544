// Of ForeignRenderer: one eye of one instance.
#version 460

layout(push_constant) uniform Drawn {
  mat4 clip_from_object;
  vec4 stage_from_object_normal[3];  // columns; w: origin.x, origin.y and step.x of the eye's window
  float step_y;
  uint instance;
};
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 0) out vec3 stage_normal;

invariant gl_Position;

void main() {
  gl_Position = clip_from_object * vec4(position, 1.0);
  stage_normal = mat3(stage_from_object_normal[0].xyz, stage_from_object_normal[1].xyz, stage_from_object_normal[2].xyz) * normal;
}
