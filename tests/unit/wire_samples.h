/// Messages and masks that the wire's tests share.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <random>
#include <span>
#include <vector>

#include "stereo/frame/shadow_frame.h"
#include "stereo/frame/tiles.h"
#include "stereo/wire/envelope.h"
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

/// Byte i is first + i.
template <std::size_t N>
std::array<std::uint8_t, N> counting(unsigned first) {
  std::array<std::uint8_t, N> bytes;
  for (std::size_t i = 0; i < N; ++i) bytes[i] = static_cast<std::uint8_t>(first + i);
  return bytes;
}

inline ContentHash counting_hash() {
  return counting<32>(0);
}
inline SharedKey shared_key() {
  return {.name = "desk", .secret = counting<32>(0)};
}

inline Welcome welcome() {
  return {counting_hash(), 3};
}
inline Refusal refusal() {
  return {RefusalReason::SceneMismatch, counting_hash()};
}
inline Probe probe() {
  return {.token = 0x0102030405060708};
}

/// A quarter turn to the left, eyes 64 mm apart, asymmetric fov; one light off, one elsewhere; of three
/// datagrams the second has not come.
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
  RequestMessage message;
  message.request = {FrameId{258}, time_from_ns(11'111'111), time_from_ns(-1), {view, right}};
  message.request.lights = {
      .revision = 5,
      .lights = {
          {.light = 2, .revision = 3, .on = false, .pose = {}},
          {.light = 0,
           .revision = 5,
           .on = true,
           .pose = LightPose{Point<Stage>{{0.5, 2.0, -1.25}}, Vector<Stage>{{0, -1, 0}}}},
      }};
  message.newest_received = FrameId{255};
  message.probe_echo = probe().token;
  message.arrivals = {.first = 1000, .base = time_from_ns(11'000'000), .count = 3};
  message.arrivals.ticks[1] = ArrivalReport::kNotArrived;
  message.arrivals.ticks[2] = 47;
  return message;
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
          .superseded = 5,
          .bytes_per_second = 12'500'000,
          .scale_eighths = 7};
}

// ---- envelopes

template <class Envelope>
Bytes enveloped(const Envelope& envelope) {
  Bytes datagram;
  encode(envelope, datagram);
  return datagram;
}

/// Its proof is one of shared_key(): made by `python3` and hashlib.blake2b, not by the code under test.
inline Hello hello() {
  return {.client = counting<32>(0x20),
          .key = {0xd8, 0xd8, 0xc6, 0xac, 0x12, 0xd1, 0xb2, 0x8b},
          .scene_hash = counting_hash(),
          .cookie = counting<16>(0xc0),
          .proof = {0x26, 0xcd, 0xe7, 0x82, 0x40, 0x64, 0xec, 0xa0, 0x0a, 0x3c, 0x10,
                    0x39, 0xb8, 0x0b, 0xdc, 0x03, 0x09, 0xed, 0xf8, 0x8b, 0x47, 0xb2,
                    0xbf, 0xe0, 0x8e, 0x1c, 0x76, 0x69, 0x20, 0x80, 0x1b, 0x47}};
}
inline Retry retry() {
  return {counting<16>(0x20), counting<16>(0xc0)};
}
inline OpenRefusal open_refusal() {
  return {.reason = RefusalReason::UnknownKey, .echo = counting<16>(0x20)};
}
inline Accept accept_sample(std::span<const std::byte> sealed) {
  return {counting<16>(0x20), SessionId{0x0807060504030201}, counting<32>(0x60), sealed};
}
inline NoSession no_session() {
  return {SessionId{0x0807060504030201}};
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

/// The messages of one eye.
inline std::vector<Bytes> packed(const ShadowFrame& frame, Side eye, std::span<const std::uint8_t> sent = {},
                                 SameAllOver same = SameAllOver::OneValue) {
  SlicePacker packer(same);
  packer.start(frame, eye, sent);
  std::vector<Bytes> messages;
  while (const std::optional<Slice> slice = packer.next()) messages.push_back(encoded(ServerMessage(*slice)));
  return messages;
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
