// The triangles that the lens hides (stereo/frame/hidden_area.h), at one depth. An eye's layer is its index, as in
// gbuffer.vert.
#version 460
#extension GL_ARB_shader_viewport_layer_array : require

// From the plane z = -1 of the eye to clip space; depth.
layout(push_constant) uniform Drawn {
  vec2 scale, offset;
  float depth;
};

layout(location = 0) in vec2 corner;

invariant gl_Position;

void main() {
  gl_Layer = gl_InstanceIndex;
  gl_Position = vec4(corner * scale + offset, depth, 1.0);
}
