/// Messages and masks that the wire's tests share.
#pragma once

#include <algorithm>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <random>
#include <span>
#include <vector>

#include "stereo/frame/shadow_frame.h"
#include "stereo/frame/tiles.h"
#include "stereo/wire/messages.h"
#include "stereo/wire/slice.h"

namespace farshade::wire_samples {

using Bytes = std::vector<std::byte>;

inline Bytes bytes_of(std::initializer_list<unsigned> values) {
  Bytes bytes;
  for (const unsigned value : values) bytes.push_back(static_cast<std::byte>(value));
  return bytes;
}

inline Bytes encoded(const ClientMessage& message) {
  Bytes bytes;
  encode(message, bytes);
  return bytes;
}
inline Bytes encoded(const ServerMessage& message) {
  Bytes bytes;
  encode(message, bytes);
  return bytes;
}

inline ContentHash counting_hash() {
  ContentHash hash;
  for (std::size_t i = 0; i < hash.size(); ++i) hash[i] = static_cast<std::uint8_t>(i);
  return hash;
}

inline Hello hello() {
  return {.scene_hash = counting_hash()};
}
inline Welcome welcome() {
  return {counting_hash(), 3, 7};
}
inline Refusal refusal() {
  return {RefusalReason::SceneMismatch, kProtocolVersion, counting_hash()};
}

/// A quarter turn to the left, eyes 64 mm apart, asymmetric fov.
inline RequestMessage request() {
  View view;
  view.stage_from_eye.rotation = {0.70710678118654757, 0.0, 0.70710678118654757, 0.0};
  view.stage_from_eye.translation = {1.0, 1.5, -0.032};
  view.fov = {-0.75, 0.5, 0.625, -0.875};
  view.size = {1024, 768};
  View right = view;
  right.stage_from_eye.translation.z = 0.032;
  right.fov.left = -0.5;
  right.fov.right = 0.75;
  return {{FrameId{258}, time_from_ns(11'111'111), time_from_ns(-1), {view, right}}, FrameId{255}};
}

inline FrameReport report() {
  return {.frame = FrameId{258},
          .slices = 14,
          .payload_bytes = 14'600,
          .primary_rays = 2'097'152,
          .shadow_rays = 3'100'000,
          .full_shadow_rays = 6'291'456,
          .primary = Duration(31'000'000),
          .shadow = Duration(37'000'000),
          .pack = Duration(450'000),
          .waited = Duration(20'000),
          .superseded = 5};
}

/// 20 x 18 pixels, two lights: two columns and rows of tiles, of which only the first is whole. Light 0
/// reaches the pixels from x = 5 on in rows 3 to 7 and nothing else; light 1 reaches all but the last two
/// rows.
inline ShadowFrame small_frame() {
  ShadowFrame frame;
  frame.frame = FrameId{258};
  frame.light_set_revision = 7;
  for (EyeMask& mask : frame.masks) {
    mask = EyeMask({20, 18}, 2);
    for (std::uint32_t y = 0; y < 18; ++y)
      for (std::uint32_t x = 0; x < 20; ++x)
        mask.set_word(x, y, 0, (x >= 5 && x < 16 && y >= 3 && y < 8 ? 1u : 0u) | (y < 16 ? 2u : 0u));
  }
  return frame;
}

/// Every bit by a coin.
inline EyeMask noise_mask(Extent size, std::uint32_t lights, std::mt19937& random) {
  EyeMask mask(size, lights);
  for (std::uint32_t plane = 0; plane < mask.layout().planes(); ++plane)
    for (std::uint32_t y = 0; y < size.height; ++y)
      for (std::uint32_t x = 0; x < size.width; ++x)
        mask.set_word(x, y, plane, static_cast<std::uint32_t>(random()) & mask.layout().used_bits(plane));
  return mask;
}

/// Like shadows: each light has a straight and a round edge.
inline EyeMask edge_mask(Extent size, std::uint32_t lights, std::mt19937& random) {
  EyeMask mask(size, lights);
  std::uniform_real_distribution<double> anywhere(0.0, 1.0), slope(-2.0, 2.0);
  const double w = size.width, h = size.height;
  for (std::uint32_t light = 0; light < lights; ++light) {
    const double a = slope(random), b = slope(random), cx = anywhere(random) * w, cy = anywhere(random) * h;
    const double r = anywhere(random) * std::max(w, h) / 2;
    for (std::uint32_t y = 0; y < size.height; ++y)
      for (std::uint32_t x = 0; x < size.width; ++x) {
        const double dx = x - cx, dy = y - cy;
        const bool lit = a * dx + b * dy > 0 && dx * dx + dy * dy > r * r;
        mask.set_word(x, y, light / 32, mask.word(x, y, light / 32) | (lit ? 1u << light % 32 : 0u));
      }
  }
  return mask;
}

inline ShadowFrame frame_of(const EyeMask& left, const EyeMask& right) {
  ShadowFrame frame;
  frame.frame = FrameId{41};
  frame.light_set_revision = 2;
  frame.masks = {left, right};
  return frame;
}

/// The datagrams of one eye.
inline std::vector<Bytes> packed(const ShadowFrame& frame, Side eye,
                                 std::span<const std::uint8_t> sent = {}) {
  SlicePacker packer;
  packer.start(frame, eye, sent);
  std::vector<Bytes> datagrams;
  while (const std::optional<Slice> slice = packer.next())
    datagrams.push_back(encoded(ServerMessage(*slice)));
  return datagrams;
}

/// An LZ4 block that holds `bytes` as they are.
inline Bytes literal_block(const Bytes& bytes) {
  Bytes block;
  std::size_t n = bytes.size();
  block.push_back(static_cast<std::byte>(std::min<std::size_t>(n, 15) << 4));
  if (n >= 15) {
    for (n -= 15; n >= 255; n -= 255) block.push_back(std::byte{255});
    block.push_back(static_cast<std::byte>(n));
  }
  block.insert(block.end(), bytes.begin(), bytes.end());
  return block;
}

}  // namespace farshade::wire_samples
