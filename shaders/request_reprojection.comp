// Reprojects a mask to requested views, and finds what must be asked for (docs/partial-requests.md).
// A light of a pixel is reprojected if the four pixels around its point in the mask are known and agree in this light,
// the depth between them is the point's and differs little, and both eyes are on the same side of their plane. A light of
// a block is unknown if it is unknown in any pixel.
// One invocation handles one block: lavapipe then reads and writes without atomics. Branches would cost more than they
// save (shade.comp).
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#include "shaders/request_reprojection_data.h"
#include "shaders/shade_data.h"
#include "shaders/shared.h"

layout(local_size_x = FARSHADE_REQUEST_REPROJECTION_GROUP) in;

layout(constant_id = FARSHADE_REQUEST_REPROJECTION_LIGHTS) const uint kLights = 1;
layout(constant_id = FARSHADE_REQUEST_REPROJECTION_WORD_BYTES) const uint kWordBytes = 1;
layout(constant_id = FARSHADE_REQUEST_REPROJECTION_NEAR) const float kNear = 1e-4;
layout(constant_id = FARSHADE_REQUEST_REPROJECTION_DETAIL) const float kDetail_px = 0.0;
layout(constant_id = FARSHADE_REQUEST_REPROJECTION_MOVED) const bool kMoved = false;

layout(push_constant) uniform Dispatch { uint shown_eye; };  // 0 left, 1 right
// Views are the requested ones; the first source of each eye is the mask.
layout(binding = 0) uniform Frame { FrameData frame; };
layout(binding = 1) uniform Lights { LightData lights[kLights + 1]; };
// For each eye the quads of the mask (stereo/reproject/mask_quads.h), from word source.place.y on.
layout(std430, binding = 2) readonly buffer Quads { uint quad_words[]; };
layout(binding = 3) uniform sampler2DArray requested_depths;  // layers: eyes
// For each eye: planes of rows of whole blocks, words of kWordBytes each.
layout(std430, binding = 4) writeonly buffer Reprojected { uint reprojected[]; };
// For each eye and block the shares of the lights (stereo/frame/requested_blocks.h) that are unknown, and
// FARSHADE_REQUEST_REPROJECTION_COVERED.
layout(std430, binding = 5) writeonly buffer Unknown { uint unknown[]; };
layout(binding = 6) uniform sampler2DArray mask_depths;  // layers: eyes

const uint kPlanes = FARSHADE_PLANES(kLights), kSide = FARSHADE_BLOCK_PX;

#include "shaders/swept.glsl"

// As in reproject.glsl. The depth between four pixels is exact on a plane, so surfaces that bend need no allowance.
const float kFootprint = 1.0, kRounding = 16.0 / 16777216.0;
// The least ratio of the depths of four pixels. A flat view of a surface has less: a whole shadow fits between two pixels,
// and becomes visible when the eye rises, where all four pixels agree. FindsAShadowThatGrows... needs more than 1/2.
const float kLeastRatio = 0.8;

// Where a pixel of a requested view lies in the mask.
struct Place {
  bool seen;   // the mask sees its surface, from the same side
  ivec2 quad;  // the upper left of the four pixels around it
};

// Whether an eye is on that side of a surface from which the mask sees it: of the plane that four depths around the pixel
// position `part` between them span. On a plane, near / z is linear on the screen, so the plane is dot(n, p) = 1 with
// near * dot(n, ray) = depth. The mask's eye, at 0, is where dot(n, p) < 1.
bool on_seen_side(SourceData source, vec3 eye, vec4 depths, vec2 part, vec2 ray, float between) {
  vec2 slope = vec2(mix(depths.z - depths.w, depths.y - depths.x, part.y), mix(depths.x - depths.w, depths.y - depths.z, part.x));
  vec2 n = slope * source.per_step.xy;
  return dot(n, eye.xy + ray * eye.z) - between * eye.z < kNear;
}

Place find(SourceData source, vec4 window, vec2 center, float depth) {
  // The point, times depth / near, so that it is finite where no surface is.
  vec3 ray = vec3(window.xy + center * window.zw, -1.0);
  vec3 eye = source.traced_from_shown[3].xyz;
  vec3 p = mat3(source.traced_from_shown) * ray + eye * (depth / kNear);
  float inverse_z = -1.0 / p.z, there = depth * inverse_z;
  vec2 at = (p.xy * inverse_z - source.origin_step.xy) * source.per_step.xy;
  ivec2 quad = ivec2(floor(at - 0.5)), last = ivec2(source.per_step.zw) - 2;
  vec2 part = at - 0.5 - vec2(quad);
  vec4 depths = textureGather(mask_depths, vec3((vec2(quad) + 1.0) / vec2(textureSize(mask_depths, 0).xy), source.place.x));
  float between = mix(mix(depths.w, depths.z, part.x), mix(depths.x, depths.y, part.x), part.y);
  float step_px = max(abs(source.origin_step.z), abs(source.origin_step.w));
  float tolerance = ((kFootprint + 2.0 * kDetail_px) * step_px + kRounding) * there;
  bool within = all(greaterThanEqual(quad, ivec2(0))) && all(lessThanEqual(quad, last));
  vec2 least = min(depths.xy, depths.zw), most = max(depths.xy, depths.zw);
  bool even = min(least.x, least.y) > kLeastRatio * max(most.x, most.y);  // false where a depth is missing
  bool same = abs(between - there) <= tolerance;  // false behind the mask's eye, where both are negative
  bool facing = on_seen_side(source, eye, depths, part, p.xy * inverse_z, between);
  return Place(within && even && same && facing, clamp(quad, ivec2(0), max(last, ivec2(0))));
}

// The bits of a quad's upper left pixel, and the lights that differ in the quad.
uvec2 quad_bits(SourceData source, ivec2 quad, uint plane) {
  uvec2 size = uvec2(source.per_step.zw);
  uint element = (plane * size.y + uint(quad.y)) * size.x + uint(quad.x), first = source.place.y;
  if (kWordBytes == 4) return uvec2(quad_words[first + 2 * element], quad_words[first + 2 * element + 1]);
  const uint per_word = 2 / kWordBytes, bits = kWordBytes * 8;
  uint word = quad_words[first + element / per_word] >> (element % per_word * bits * 2u);
  return uvec2(bitfieldExtract(word, 0, int(bits)), bitfieldExtract(word, int(bits), int(bits)));
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

// Depth / near of the pixels of rows `y` and `y` + 1 of a block, from the left.
void read_depth(uvec2 block, uint y, out vec4 upper, out vec4 lower) {
  vec2 step = 1.0 / vec2(textureSize(requested_depths, 0).xy), at = (vec2(block * kSide + uvec2(0, y)) + 1.0) * step;
  float layer = float(shown_eye);
  vec4 left = textureGather(requested_depths, vec3(at, layer));
  vec4 right = textureGather(requested_depths, vec3(at.x + 2.0 * step.x, at.y, layer));
  upper = vec4(left.wz, right.wz);
  lower = vec4(left.xy, right.xy);
}

// Reprojects row `y` of a block. Returns the shares that are unknown, and FARSHADE_REQUEST_REPROJECTION_COVERED.
uint reproject_row(uvec2 block, uvec2 blocks, uvec2 size, uint y, vec4 depths) {
  SourceData source = frame.sources[shown_eye * FARSHADE_MAX_SOURCES];
  vec4 window = frame.eye[shown_eye].window.origin_step;
  const uint per_word = 4 / kWordBytes;  // pixels of a reprojected word
  const uint all_shares = (1u << min(kLights, 8u)) - 1u;
  uint missing = 0u;
  Place row[kSide];
  bool covered[kSide];
  vec3 position[kSide];
  [[unroll]] for (uint x = 0; x < kSide; ++x) {
    ivec2 pixel = ivec2(block * kSide + uvec2(x, y));
    vec2 center = vec2(pixel) + 0.5;
    float depth = depths[x];
    covered[x] = depth > 0.0 && all(lessThan(uvec2(pixel), size));
    row[x] = find(source, window, center, depth);
    position[x] = mat3(frame.eye[shown_eye].stage_from_eye) *
                  (vec3(window.xy + center * window.zw, -1.0) * (kNear / max(depth, 1e-30)));
    missing |= covered[x] ? FARSHADE_REQUEST_REPROJECTION_COVERED : 0u;
    missing |= covered[x] && !row[x].seen ? all_shares : 0u;
  }
  [[unroll]] for (uint plane = 0; plane < kPlanes; ++plane) {
    uint used = kLights >= plane * 32 + 32 ? ~0u : (1u << (kLights % 32)) - 1u;
    uint first = (((shown_eye * kPlanes + plane) * blocks.y * kSide + block.y * kSide + y) * blocks.x + block.x) * kWordBytes;
    uint words[4] = uint[](0u, 0u, 0u, 0u);
    [[unroll]] for (uint x = 0; x < kSide; ++x) {
      uvec2 quad = quad_bits(source, row[x].quad, plane);
      missing |= covered[x] ? shares_of((quad.y | stale_bits(position[x], plane)) & used) : 0u;
      uint bits = covered[x] ? quad.x & used : 0u;
      words[x / per_word] |= bits << (x % per_word * kWordBytes * 8u);
    }
    [[unroll]] for (uint i = 0; i < kWordBytes; ++i) reprojected[first + i] = words[i];
  }
  return missing;
}

void main() {
  uvec2 size = uvec2(frame.eye[shown_eye].size_px.xy), blocks = (size + kSide - 1) / kSide;
  uvec2 block = min(gl_GlobalInvocationID.xy, blocks - 1);  // those beyond the last one do its work again
  vec4 upper, lower;
  read_depth(block, 0, upper, lower);
  uint missing = reproject_row(block, blocks, size, 0, upper);
  missing |= reproject_row(block, blocks, size, 1, lower);
  read_depth(block, 2, upper, lower);
  missing |= reproject_row(block, blocks, size, 2, upper);
  missing |= reproject_row(block, blocks, size, 3, lower);
  unknown[(shown_eye * blocks.y + block.y) * blocks.x + block.x] = missing;
}
