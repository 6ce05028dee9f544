/// Messages: what client and server say to each other once they share keys, one message a sealed datagram.
/// PROTOCOL.md has the bytes. They are encoded to and decoded from a span of bytes and know nothing of
/// addresses, sockets or sealing. Decoders check length, then ranges, then trailing bytes; they refuse, never
/// clamp.
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
#include "stereo/frame/pixel_plane.h"
#include "stereo/frame/shadow_frame.h"
#include "stereo/frame/view_scale.h"
#include "stereo/wire/arrival_report.h"
#include "stereo/wire/refusal.h"

namespace farshade {

inline constexpr std::uint16_t kProtocolVersion = 3;
inline constexpr std::size_t kMaxDatagram_bytes = 1200;  ///< UDP payload, sealing included
inline constexpr std::size_t kSealing_bytes = 39;        ///< of these: what sealing adds (envelope.h)
inline constexpr std::size_t kMaxMessage_bytes = kMaxDatagram_bytes - kSealing_bytes;

/// As Scene::hash; the wire knows no scenes.
using ContentHash = std::array<std::uint8_t, 32>;

// ---- client -> server

/// What to trace, and what the server should know by then. Each request says all that the server has not yet
/// acknowledged, so that none needs another.
struct RequestMessage {
  /// Changed lights that one request can carry; the others follow in the next.
  static constexpr std::size_t kMostLightChanges = 6;

  FrameRequest
      request;  ///< of its lights those that the server is not known to have, at most kMostLightChanges
  std::optional<FrameId> newest_received{};  ///< newest frame of which a slice came; older than request.frame
  std::uint64_t probe_echo = 0;              ///< the newest Probe's token
  ArrivalReport arrivals{};
};

// ---- either way

/// A run of tiles of one plane of one eye: of the positions that a request brings, of the G-buffer that
/// answers one. Decodes without any other (plane_codec.h packs and opens it).
struct PlaneSlice {
  FrameId frame{};
  Side eye = Side::Left;
  PlaneKind kind = PlaneKind::BaseColor;
  Extent size{};                       ///< of the whole plane
  std::uint32_t word_bytes = 4;        ///< 1 to 4
  std::uint32_t first_tile = 0;        ///< in TileGrid{size}
  std::uint32_t tile_count = 0;        ///< 1 or more, first_tile + tile_count within the grid
  std::span<const std::byte> block{};  ///< LZ4; a view into the message or the packer, owned by neither
};

using ClientMessage = std::variant<RequestMessage, PlaneSlice>;

// ---- server -> client

/// The answer to a hello whose sender has the key and the scene.
struct Welcome {
  ContentHash scene_hash{};
  std::uint32_t light_count = 0;
  /// Of an eye's view that a request may ask for: nobody's trace keeps the others waiting for long.
  std::uint32_t most_pixels = std::uint32_t{1} << 23;
  AnswerSet answers = set_of(Answer::Masks);  ///< that requests may want
  friend bool operator==(const Welcome&, const Welcome&) = default;
};

enum class RefusalReason : std::uint8_t {
  VersionMismatch = 1,
  UnknownKey = 2,  ///< no key of this id, or a hello that was not made with it
  SceneMismatch = 3,
  Busy = 4,  ///< no room for another client; ask again later
};

/// The answer to a hello whose sender has the key, and yet gets no session: SceneMismatch or Busy.
struct Refusal {
  RefusalReason reason = RefusalReason::Busy;
  ContentHash scene_hash{};  ///< the server's
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
  std::span<const std::byte> block{};  ///< LZ4; a view into the message or the packer, owned by neither
};

/// A part of the coded picture of both eyes. All parts but the last have kVideoPart_bytes.
struct VideoPart {
  FrameId frame{};
  FrameId after{};                     ///< it decodes after this frame's picture; `frame` itself: alone
  std::uint32_t part = 0, parts = 1;   ///< this one, of so many: at most kMostVideoParts
  std::span<const std::byte> bytes{};  ///< a view, owned by neither; 1 or more
};
inline constexpr std::size_t kVideoPartHeader_bytes = 13;
inline constexpr std::size_t kVideoPart_bytes = kMaxMessage_bytes - kVideoPartHeader_bytes;
inline constexpr std::uint32_t kMostVideoParts = 4096;

/// Sent after a frame's last slice: what the frame was and cost. Lost like any other datagram.
struct FrameReport {
  FrameId frame{};
  std::uint32_t slices = 0;         ///< messages of this frame, this report not among them
  std::uint32_t payload_bytes = 0;  ///< of those messages, before they are sealed
  std::uint64_t primary_rays = 0, shadow_rays = 0;
  std::uint64_t full_shadow_rays = 0;            ///< of a trace that leaves nothing out
  Duration primary{}, shadow{}, draw{}, pack{};  ///< stages of this frame; coding is part of pack
  Duration waited{};                             ///< from arrival of the request to its trace
  std::uint32_t superseded = 0;                  ///< requests dropped so far because a newer one came
  std::uint32_t bytes_per_second = 0;            ///< that the server takes the path to this client to carry
  ViewScale view_scale{};                        ///< the size of views that the client should request
  friend bool operator==(const FrameReport&, const FrameReport&) = default;
};

/// Sent to an address from which the client's datagrams come of late: whoever is there says the token in its
/// next request, and slices go there from then on. Also sent, with a token that means nothing, to a client
/// that asks and has been sent nothing for 100 ms: a sign of life of a busy server.
struct Probe {
  std::uint64_t token = 0;  ///< not 0
  friend bool operator==(const Probe&, const Probe&) = default;
};

/// Bytes of a slice's message before its block.
inline constexpr std::size_t kSliceHeader_bytes = 23;
inline constexpr std::size_t kMaxBlock_bytes = kMaxMessage_bytes - kSliceHeader_bytes;
/// The same of a plane's slice.
inline constexpr std::size_t kPlaneSliceHeader_bytes = 18;
inline constexpr std::size_t kMaxPlaneBlock_bytes = kMaxMessage_bytes - kPlaneSliceHeader_bytes;

using ServerMessage = std::variant<Welcome, Refusal, Slice, FrameReport, Probe, PlaneSlice, VideoPart>;

// ---- bytes

/// Replaces `bytes` by the message's, at most kMaxMessage_bytes. A message out of its ranges is a bug here.
void encode(const ClientMessage& message, std::vector<std::byte>& bytes);
void encode(const ServerMessage& message, std::vector<std::byte>& bytes);

/// Blocks and parts point into `bytes`.
[[nodiscard]] Decoded<ClientMessage> decode_client(std::span<const std::byte> bytes);
[[nodiscard]] Decoded<ServerMessage> decode_server(std::span<const std::byte> bytes);

}  // namespace farshade
