/// Messages: what client and server say to each other, one message a datagram. PROTOCOL.md has the bytes.
/// They are encoded to and decoded from a span of bytes and know nothing of addresses, sockets or sealing.
/// Decoders check length, then ranges, then trailing bytes; they refuse, never clamp, and allocate nothing.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <variant>
#include <vector>

#include "stereo/base/clock.h"
#include "stereo/base/expected.h"
#include "stereo/frame/eye_mask.h"
#include "stereo/frame/frame_id.h"
#include "stereo/frame/shadow_frame.h"
#include "stereo/wire/refusal.h"

namespace farshade {

inline constexpr std::uint16_t kProtocolVersion = 1;
inline constexpr std::size_t kMaxDatagram_bytes = 1200;  ///< UDP payload, sealing included

/// As Scene::hash; the wire knows no scenes.
using ContentHash = std::array<std::uint8_t, 32>;

// ---- client -> server

/// First words. Its layout is the same in every version, so that each server can say what it speaks.
/// No answer to it is longer than it is.
struct Hello {
  std::uint16_t version = kProtocolVersion;
  ContentHash scene_hash{};
  std::array<std::uint8_t, 16> reserved{};  ///< zeros
  friend bool operator==(const Hello&, const Hello&) = default;
};

struct RequestMessage {
  TraceRequest request;
  std::optional<FrameId> newest_received;  ///< newest frame of which a slice came; older than request.frame
};

using ClientMessage = std::variant<Hello, RequestMessage>;

// ---- server -> client

struct Welcome {
  ContentHash scene_hash{};
  std::uint32_t light_count = 0;
  std::uint32_t light_set_revision = 0;
  friend bool operator==(const Welcome&, const Welcome&) = default;
};

enum class RefusalReason : std::uint8_t {
  VersionMismatch = 1,
  SceneMismatch = 2,
  Busy = 3,         ///< no room for another client; ask again later
  NotWelcomed = 4,  ///< a request came before Hello, or after the server forgot this client
};

/// Its layout is the same in every version.
struct Refusal {
  RefusalReason reason = RefusalReason::Busy;
  std::uint16_t version = kProtocolVersion;  ///< the server's
  ContentHash scene_hash{};                  ///< the server's
  friend bool operator==(const Refusal&, const Refusal&) = default;
};

/// A run of tiles of one plane of one eye's mask; decodes without any other slice (slice.h packs and opens
/// it).
struct Slice {
  FrameId frame{};
  std::uint32_t light_set_revision = 0;
  Side eye = Side::Left;
  Extent size{};                       ///< of the whole mask
  std::uint32_t lights = 0;            ///< of the whole mask
  std::uint32_t plane = 0;             ///< it tells lights 32 * plane and up, as MaskLayout has them
  std::uint32_t first_tile = 0;        ///< in TileGrid{size}
  std::uint32_t tile_count = 0;        ///< 1 or more, first_tile + tile_count within the grid
  std::span<const std::byte> block{};  ///< LZ4; a view into the datagram or the packer, owned by neither
};

/// Sent after a frame's last slice: what the frame was and cost. Lost like any other datagram.
struct FrameReport {
  FrameId frame{};
  std::uint32_t slices = 0;         ///< datagrams of this frame, this report not among them
  std::uint32_t payload_bytes = 0;  ///< of those datagrams
  std::uint64_t primary_rays = 0, shadow_rays = 0;
  std::uint64_t full_shadow_rays = 0;    ///< of a trace that leaves nothing out
  Duration primary{}, shadow{}, pack{};  ///< stages of this frame
  Duration waited{};                     ///< from arrival of the request to its trace
  std::uint32_t superseded = 0;          ///< requests dropped so far because a newer one came
  friend bool operator==(const FrameReport&, const FrameReport&) = default;
};

/// Bytes of a slice's datagram before its block.
inline constexpr std::size_t kSliceHeader_bytes = 29;
inline constexpr std::size_t kMaxBlock_bytes = kMaxDatagram_bytes - kSliceHeader_bytes;

using ServerMessage = std::variant<Welcome, Refusal, Slice, FrameReport>;

// ---- bytes

/// Replaces `datagram` by the message's bytes, at most kMaxDatagram_bytes. A message out of its ranges is a
/// bug here.
void encode(const ClientMessage& message, std::vector<std::byte>& datagram);
void encode(const ServerMessage& message, std::vector<std::byte>& datagram);

/// A Slice's block points into `datagram`.
[[nodiscard]] Decoded<ClientMessage> decode_client(std::span<const std::byte> datagram);
[[nodiscard]] Decoded<ServerMessage> decode_server(std::span<const std::byte> datagram);

}  // namespace farshade
