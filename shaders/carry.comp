// Carries a mask over to requested views, and finds what must be asked for (docs/asking.md).
// A light of a pixel is carried over if the four pixels around its point in the mask are known and agree in this light,
// and the depth between them is the point's. A light of a block is unknown if it is unknown in any pixel.
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
// For each eye and block the shares of the lights (stereo/frame/asked_blocks.h) that are unknown.
layout(std430, binding = 6) writeonly buffer Unknown { uint unknown[]; };

const uint kPlanes = FARSHADE_PLANES(kLights), kSide = FARSHADE_BLOCK_PX;

#include "shaders/masks.glsl"
#include "shaders/swept.glsl"

// As in reproject.glsl. The depth between four pixels is exact on a plane, so surfaces that bend need no allowance.
const float kFootprint = 1.0, kRounding = 16.0 / 16777216.0;

// Where a pixel of a requested view lies in the mask.
struct Place {
  bool seen;      // the mask sees its surface
  ivec2 taps[4];  // the pixels around it: upper left and right, lower left and right
  uint nearest;   // of the taps
};

Place find(SourceData source, vec4 window, vec2 center, float depth) {
  // The point, times depth / near, so that it is finite where no surface is.
  vec3 ray = vec3(window.xy + center * window.zw, -1.0);
  vec3 p = mat3(source.traced_from_shown) * ray + source.traced_from_shown[3].xyz * (depth / kNear);
  float inverse_z = -1.0 / p.z, there = depth * inverse_z;
  vec2 at = (p.xy * inverse_z - source.origin_step.xy) * source.per_step.xy;
  ivec2 corner = ivec2(floor(at - 0.5));
  vec2 part = at - 0.5 - vec2(corner);
  vec4 depths = textureGather(depth_ring, vec3((vec2(corner) + 1.0) / vec2(textureSize(depth_ring, 0).xy), source.place.x));
  float between = mix(mix(depths.w, depths.z, part.x), mix(depths.x, depths.y, part.x), part.y);
  float step_px = max(abs(source.origin_step.z), abs(source.origin_step.w));
  float tolerance = ((kFootprint + 2.0 * kDetail_px) * step_px + kRounding) * there;
  ivec2 taps[4] = ivec2[](inside(source, corner), inside(source, corner + ivec2(1, 0)),
                          inside(source, corner + ivec2(0, 1)), inside(source, corner + 1));
  bool known = block_known(source, taps[0]) && block_known(source, taps[1]) && block_known(source, taps[2]) &&
               block_known(source, taps[3]);
  bool within = all(greaterThanEqual(corner, ivec2(0))) && all(lessThan(corner + 1, ivec2(source.per_step.zw)));
  bool covered = all(greaterThan(depths, vec4(0.0)));
  bool same = abs(between - there) <= tolerance;  // false behind the mask's eye, where both are negative
  return Place(within && known && covered && same, taps, uint(part.x >= 0.5) + 2u * uint(part.y >= 0.5));
}

// The lights of a plane that have moved, or that an instance that has moved may have changed at `position`
// (eye-relative, stage axes).
uint stale_bits(vec3 position, uint plane) {
  return frame.stale_lights[plane / 4][plane % 4] | (kMoved ? swept_bits(0, position, plane) : 0u);
}

// The shares of the lights `bits`: bit s of each byte is share s.
uint shares_of(uint bits) {
  bits |= bits >> 16;
  return (bits | bits >> 8) & 0xffu;
}

// Carries row `y` of a block. Returns the shares that are unknown.
uint carry_row(uvec2 block, uvec2 blocks, uvec2 size, uint y) {
  SourceData source = frame.sources[kEye * FARSHADE_MAX_SOURCES];
  vec4 window = frame.eye[kEye].window.origin_step;
  const uint per_word = 4 / kBitsBytes;  // pixels of a carried word
  const uint all_shares = (1u << min(kLights, 8u)) - 1u;
  uint missing = 0u;
  Place row[kSide];
  bool covered[kSide];
  vec3 position[kSide];
  [[unroll]] for (uint x = 0; x < kSide; ++x) {
    ivec2 pixel = ivec2(block * kSide + uvec2(x, y));
    vec2 center = vec2(pixel) + 0.5;
    float depth = texelFetch(depth_ring, ivec3(min(pixel, ivec2(size) - 1), frame.counts.y + kEye), 0).r;
    covered[x] = depth > 0.0 && all(lessThan(uvec2(pixel), size));
    row[x] = find(source, window, center, depth);
    position[x] = mat3(frame.eye[kEye].stage_from_eye) *
                  (vec3(window.xy + center * window.zw, -1.0) * (kNear / max(depth, 1e-30)));
    missing |= covered[x] && !row[x].seen ? all_shares : 0u;
  }
  [[unroll]] for (uint plane = 0; plane < kPlanes; ++plane) {
    uint used = kLights >= plane * 32 + 32 ? ~0u : (1u << (kLights % 32)) - 1u;
    uint first = (((kEye * kPlanes + plane) * blocks.y * kSide + block.y * kSide + y) * blocks.x + block.x) * kBitsBytes;
    uint words[4] = uint[](0u, 0u, 0u, 0u);
    [[unroll]] for (uint x = 0; x < kSide; ++x) {
      uint taps[4];
      [[unroll]] for (uint tap = 0; tap < 4; ++tap) taps[tap] = mask_bits(source, row[x].taps[tap], plane) & used;
      uint differ = (taps[0] ^ taps[1]) | (taps[0] ^ taps[2]) | (taps[0] ^ taps[3])
                    | (stale_bits(position[x], plane) & used);
      missing |= covered[x] ? shares_of(differ) : 0u;
      uint upper = row[x].nearest % 2 == 0 ? taps[0] : taps[1], lower = row[x].nearest % 2 == 0 ? taps[2] : taps[3];
      uint bits = covered[x] ? (row[x].nearest < 2 ? upper : lower) : 0u;
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
