// Carries a mask over to requested views, and finds the blocks that must be asked for (docs/asking.md).
// A pixel is carried over if the four pixels around its point in the mask are known, have the same bits, and the depth
// between them is the point's. A block with any other pixel is unknown.
// One invocation handles one block: lavapipe then reads and writes without atomics. Branches would cost more than they
// save (shade.comp).
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#include "shaders/carry_data.h"
#include "shaders/shade_data.h"
#include "shaders/shared.h"

layout(local_size_x = FARSHADE_CARRY_GROUP) in;

layout(constant_id = FARSHADE_CARRY_LIGHTS) const uint kLights = 1;
layout(constant_id = FARSHADE_CARRY_WORD_BYTES) const uint kWordBytes = 1;
layout(constant_id = FARSHADE_CARRY_BITS_BYTES) const uint kBitsBytes = 1;
layout(constant_id = FARSHADE_CARRY_EDGE_BIT) const uint kEdgeBit = 1;
layout(constant_id = FARSHADE_CARRY_NEAR) const float kNear = 1e-4;
layout(constant_id = FARSHADE_CARRY_DETAIL) const float kDetail_px = 0.0;
layout(constant_id = FARSHADE_CARRY_EYE) const uint kEye = 0;
layout(constant_id = FARSHADE_CARRY_WHOLE) const bool kWhole = false;
layout(constant_id = FARSHADE_CARRY_MOVED) const bool kMoved = false;

// Views are the requested ones; the first source of each eye is the mask. counts.y = layer of their depth.
layout(binding = 0) uniform Frame { FrameData frame; };
layout(binding = 1) uniform Lights { LightData lights[kLights + 1]; };
layout(std430, binding = 2) readonly buffer Masks { uint mask_words[]; };
layout(std430, binding = 3) readonly buffer KnownBlocks { uint known_words[]; };
layout(binding = 4) uniform sampler2DArray depth_ring;
// For each eye: planes of rows of whole blocks, words of kBitsBytes each.
layout(std430, binding = 5) writeonly buffer Carried { uint carried[]; };
// For each eye and block 1 if it is unknown.
layout(std430, binding = 6) writeonly buffer Unknown { uint unknown[]; };

const uint kPlanes = FARSHADE_PLANES(kLights), kSide = FARSHADE_BLOCK_PX;

#include "shaders/masks.glsl"
#include "shaders/swept.glsl"

// As in reproject.glsl. The depth between four pixels is exact on a plane, so surfaces that bend need no allowance.
const float kFootprint = 1.0, kRounding = 16.0 / 16777216.0;

// A pixel of a requested view.
struct Pixel {
  bool known;
  ivec2 at;  // the mask's pixel with its bits
};

Pixel carry(SourceData source, vec4 window, vec2 center, float depth) {
  // The point, times depth / near, so that it is finite where no surface is.
  vec3 ray = vec3(window.xy + center * window.zw, -1.0);
  vec3 p = mat3(source.traced_from_shown) * ray + source.traced_from_shown[3].xyz * (depth / kNear);
  float inverse_z = -1.0 / p.z, there = depth * inverse_z;
  vec2 at = (p.xy * inverse_z - source.origin_step.xy) * source.per_step.xy;
  ivec2 corner = ivec2(floor(at - 0.5)), pixel = inside(source, ivec2(floor(at)));
  vec2 part = at - 0.5 - vec2(corner);
  vec4 depths = textureGather(depth_ring, vec3((vec2(corner) + 1.0) / vec2(textureSize(depth_ring, 0).xy), source.place.x));
  float between = mix(mix(depths.w, depths.z, part.x), mix(depths.x, depths.y, part.x), part.y);
  float step_px = max(abs(source.origin_step.z), abs(source.origin_step.w));
  float tolerance = ((kFootprint + 2.0 * kDetail_px) * step_px + kRounding) * there;
  bool known = block_known(source, inside(source, corner)) && block_known(source, inside(source, corner + ivec2(1, 0))) &&
               block_known(source, inside(source, corner + ivec2(0, 1))) && block_known(source, inside(source, corner + 1));
  bool within = all(greaterThanEqual(corner, ivec2(0))) && all(lessThan(corner + 1, ivec2(source.per_step.zw)));
  bool covered = all(greaterThan(depths, vec4(0.0)));
  bool same = abs(between - there) <= tolerance;  // false behind the mask's eye, where both are negative
  bool agree = !near_shadow_edge(source, pixel, at);
  return Pixel(within && known && covered && same && agree, pixel);
}

// Whether an instance that has moved may have changed a bit at `position` (eye-relative, stage axes).
bool is_stale(vec3 position) {
  uint stale = 0u;
  for (uint plane = 0; kMoved && plane < kPlanes; ++plane) stale |= swept_bits(0, position, plane);
  return stale != 0u;
}

// Carries row `y` of a block. Returns 1 if it has an unknown pixel.
uint carry_row(uvec2 block, uvec2 blocks, uvec2 size, uint y) {
  SourceData source = frame.sources[kEye * FARSHADE_MAX_SOURCES];
  vec4 window = frame.eye[kEye].window.origin_step;
  const uint per_word = 4 / kBitsBytes;  // pixels of a carried word
  uint missing = 0u;
  Pixel row[kSide];
  bool covered[kSide];
  [[unroll]] for (uint x = 0; x < kSide; ++x) {
    ivec2 pixel = ivec2(block * kSide + uvec2(x, y));
    vec2 center = vec2(pixel) + 0.5;
    float depth = texelFetch(depth_ring, ivec3(min(pixel, ivec2(size) - 1), frame.counts.y + kEye), 0).r;
    bool within = all(lessThan(uvec2(pixel), size));
    covered[x] = depth > 0.0 && within;
    row[x] = carry(source, window, center, depth);
    bool stale = kMoved && is_stale(mat3(frame.eye[kEye].stage_from_eye) *
                                    (vec3(window.xy + center * window.zw, -1.0) * (kNear / max(depth, 1e-30))));
    missing |= uint(covered[x] && (!row[x].known || stale));
  }
  [[unroll]] for (uint plane = 0; plane < kPlanes; ++plane) {
    uint used = kLights >= plane * 32 + 32 ? ~0u : (1u << (kLights % 32)) - 1u;
    uint first = (((kEye * kPlanes + plane) * blocks.y * kSide + block.y * kSide + y) * blocks.x + block.x) * kBitsBytes;
    uint words[4] = uint[](0u, 0u, 0u, 0u);
    [[unroll]] for (uint x = 0; x < kSide; ++x) {
      uint bits = covered[x] ? mask_bits(source, row[x].at, plane) & used : 0u;
      words[x / per_word] |= bits << (x % per_word * kBitsBytes * 8u);
    }
    [[unroll]] for (uint i = 0; i < kBitsBytes; ++i) carried[first + i] = words[i];
  }
  return missing;
}

void main() {
  uvec2 size = uvec2(frame.eye[kEye].size_px.xy), blocks = (size + kSide - 1) / kSide;
  uvec2 block = min(gl_GlobalInvocationID.xy, blocks - 1);  // those beyond the last one do its work again
  uint missing = carry_row(block, blocks, size, 0);
  missing |= carry_row(block, blocks, size, 1);
  missing |= carry_row(block, blocks, size, 2);
  missing |= carry_row(block, blocks, size, 3);
  unknown[(kEye * blocks.y + block.y) * blocks.x + block.x] = missing;
}
