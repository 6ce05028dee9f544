/// Messages and masks that the tests of the wire format share.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <random>
#include <span>
#include <vector>

#include "stereo/codec/ask_coder.h"
#include "stereo/codec/slice.h"
#include "stereo/frame/shadow_frame.h"
#include "stereo/frame/tiles.h"
#include "stereo/messages/messages.h"
#include "stereo/sealing/envelope.h"

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

/// Byte i has the value first + i.
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
  return {counting_hash(), 3, Welcome{}.most_pixels, kTracedAnswers, {-6}};
}
inline Refusal refusal() {
  return {RefusalReason::SceneMismatch, counting_hash()};
}
inline Probe probe() {
  return {.token = 0x0102030405060708};
}

/// A quarter turn to the left, eyes 64 mm apart, an asymmetric fov, one light off and one at another place.
/// Of three datagrams, the second has not arrived.
inline RequestMessage request() {
  View view;
  view.stage_from_eye.rotation = {0.70710678118654757, 0.0, 0.70710678118654757, 0.0};
  view.stage_from_eye.translation = {1.0, 1.5, -0.032};
  view.fov = {-0.75, 0.5, 0.625, -0.875};
  view.size = {1024, 768};
  View right = view;
  right.stage_from_eye.translation.z = 0.032;
  right.fov.left_rad = -0.5;
  right.fov.right_rad = 0.75;
  RequestMessage message;
  message.request = {{FrameId{258}, time_from_ns(11'111'111), time_from_ns(-1), {view, right}}};
  message.request.lights = {
      .revision = {5},
      .lights = {
          {.light = 2, .revision = {3}, .on = false, .pose = {}},
          {.light = 0,
           .revision = {5},
           .on = true,
           .pose = LightPose{Point<Stage>{{0.5, 2.0, -1.25}}, Vector<Stage>{{0, -1, 0}}}},
      }};
  message.request.answer = {.kind = Answer::Video,
                            .bits_per_second = 2'000'000,
                            .interval = Duration(11'111'111),
                            .coding = Coding::Alone};
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
          .update = Duration(3'000'000),
          .primary = Duration(31'000'000),
          .shadow = Duration(37'000'000),
          .draw = Duration(19'000'000),
          .pack = Duration(450'000),
          .waited = Duration(20'000),
          .superseded = 5,
          .bytes_per_second = 12'500'000,
          .view_scale = {7}};
}

inline constexpr std::array kThreeBytes{std::byte{10}, std::byte{11}, std::byte{12}};
inline PlaneSlice plane_slice() {
  return {.frame = FrameId{258},
          .eye = Side::Right,
          .kind = PlaneKind::Depth,
          .size = {20, 18},
          .word_bytes = 4,
          .first_tile = 1,
          .tile_count = 2,
          .block = kThreeBytes};
}
inline PathProbe path_probe() {
  return {.padding = std::span(PathProbe::kZeros).first(3)};
}
inline VideoPart video_part() {
  return {.frame = FrameId{258}, .after = FrameId{257}, .part = 2, .parts = 3, .bytes = kThreeBytes};
}

template <class Envelope>
Bytes enveloped(const Envelope& envelope) {
  Bytes datagram;
  encode(envelope, datagram);
  return datagram;
}

/// Its proof was made with shared_key() by `python3` and hashlib.blake2b, not by the code under test.
inline Hello hello() {
  return {.client = counting<32>(0x20),
          .key = {0xd8, 0xd8, 0xc6, 0xac, 0x12, 0xd1, 0xb2, 0x8b},
          .scene_hash = counting_hash(),
          .cookie = counting<16>(0xc0),
          .proof = {0x83, 0x4b, 0x0d, 0x9b, 0x08, 0x08, 0x16, 0x80, 0xd7, 0x89, 0xcf,
                    0x14, 0x3c, 0x00, 0xa1, 0x30, 0x14, 0x85, 0x80, 0x8b, 0xb5, 0xe4,
                    0x7a, 0xbd, 0xef, 0x05, 0xa3, 0x9f, 0xf0, 0x57, 0xab, 0xed}};
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

/// 20 x 18 pixels and two lights. There are two columns and two rows of tiles, of which only the first is
/// complete. Light 0 reaches only the pixels from x = 5 on in rows 3 to 7. Light 1 reaches all rows but the
/// last two.
inline ShadowFrame small_frame() {
  ShadowFrame frame;
  frame.frame = FrameId{258};
  frame.light_set_revision = {7};
  for (EyeMask& mask : frame.masks) {
    mask = EyeMask({20, 18}, 2);
    for (std::uint32_t y = 0; y < 18; ++y)
      for (std::uint32_t x = 0; x < 20; ++x)
        mask.set_word(x, y, 0, (x >= 5 && x < 16 && y >= 3 && y < 8 ? 1u : 0u) | (y < 16 ? 2u : 0u));
  }
  return frame;
}

/// Every bit is random.
inline EyeMask noise_mask(Extent size, std::uint32_t lights, std::mt19937& random) {
  EyeMask mask(size, lights);
  for (std::uint32_t plane = 0; plane < mask.layout().planes(); ++plane)
    for (std::uint32_t y = 0; y < size.height; ++y)
      for (std::uint32_t x = 0; x < size.width; ++x)
        mask.set_word(x, y, plane, static_cast<std::uint32_t>(random()) & mask.layout().used_bits(plane));
  return mask;
}

/// Similar to shadows: each light has a straight and a round edge.
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
  frame.light_set_revision = {2};
  frame.masks = {left, right};
  return frame;
}

/// The messages of one eye.
inline std::vector<Bytes> packed(const ShadowFrame& frame, Side eye,
                                 std::span<const RequestedTile> requested = {},
                                 std::span<const std::uint8_t> sent = {}) {
  SlicePacker packer;
  packer.start(frame, eye, requested, sent);
  std::vector<Bytes> messages;
  while (const std::optional<Slice> slice = packer.next()) messages.push_back(encoded(ServerMessage(*slice)));
  return messages;
}

/// The messages that ask for blocks of one eye.
inline std::vector<Bytes> requested_messages(Extent size, Side eye, std::uint32_t lights,
                                             std::span<const RequestedTile> requested) {
  AskPacker packer;
  packer.start(FrameId{258}, eye, size, lights, requested);
  std::vector<Bytes> messages;
  while (const std::optional<AskSlice> slice = packer.next())
    messages.push_back(encoded(ClientMessage(*slice)));
  return messages;
}

/// Of a view of 20 x 18 pixels and two lights: a few blocks of tile 0 in light 1, one of them in light 0,
/// too; nothing of tile 1; all of tile 2; block 0 of tile 3 in light 0.
inline const std::vector<RequestedTile> kSampleRequested{
    {.shares = {0x0040, 0x0360}}, {}, all_lights_in(kAllBlocks, 2), {.shares = {0x0001}}};
inline Bytes ask_sample() {
  return requested_messages({20, 18}, Side::Right, 2, kSampleRequested).at(0);
}

/// Each share of about half of the tiles has random blocks, or all, or none.
inline std::vector<RequestedTile> noise_requested(Extent size, std::uint32_t lights, std::mt19937& random) {
  std::vector<RequestedTile> requested(TileGrid{size}.count());
  for (RequestedTile& tile : requested)
    if (random() % 2 == 0)
      for (std::uint32_t share = 0; share < shares_of(lights); ++share) {
        const std::uint32_t kind = random() % 4;
        tile.shares[share] = static_cast<BlockBits>(kind == 0 ? 0 : kind == 1 ? 0xffff : random());
      }
  return requested;
}

/// An LZ4 block that contains `bytes` uncompressed.
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
