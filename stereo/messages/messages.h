/// Messages between client and server, one message in each sealed datagram. PROTOCOL.md has the bytes.
/// The encoders and decoders know nothing of addresses, sockets or sealing. Decoders check length, then
/// ranges, then trailing bytes. They refuse a bad message; they never clamp a value.
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
#include "stereo/frame/exposure.h"
#include "stereo/frame/eye_mask.h"
#include "stereo/frame/frame_id.h"
#include "stereo/frame/pixel_plane.h"
#include "stereo/frame/shadow_frame.h"
#include "stereo/frame/view_scale.h"
#include "stereo/messages/arrival_report.h"
#include "stereo/messages/refusal.h"
#include "stereo/messages/version.h"

namespace farshade {

/// UDP payload, sealing included: what every path must carry (as for QUIC, RFC 9000, 14), and the most that a
/// client sends.
inline constexpr std::size_t kBaseDatagram_bytes = 1200;
/// The most that a server sends, once a PathProbe of that size has arrived: a packet of 1,500 bytes with the
/// headers of IPv4 and UDP.
inline constexpr std::size_t kMaxDatagram_bytes = 1472;
inline constexpr std::size_t kSealing_bytes =
    39;  ///< the part of a datagram that sealing needs (stereo/sealing/envelope.h)
inline constexpr std::size_t kBaseMessage_bytes = kBaseDatagram_bytes - kSealing_bytes;
inline constexpr std::size_t kMaxMessage_bytes = kMaxDatagram_bytes - kSealing_bytes;

/// The same as Scene::hash, without a dependency on scenes.
using ContentHash = std::array<std::uint8_t, 32>;
/// In a Hello: the client has no scene, and asks which one is served.
inline constexpr ContentHash kNoScene{};

// ---- client -> server

/// A request for a frame. It contains everything that the server has not yet acknowledged, so that no request
/// depends on an earlier one.
struct RequestMessage {
  /// Most light changes in one request; the next requests contain the others.
  static constexpr std::size_t kMostLightChanges = 6;

  /// Its light changes are those that the server may not have yet, at most kMostLightChanges.
  FrameRequest request;
  std::optional<FrameId>
      newest_received{};         ///< newest frame with a slice that came; older than request.frame
  std::uint64_t probe_echo = 0;  ///< the newest Probe's token, or 0
  ArrivalReport arrivals{};
};

// ---- either way

/// Consecutive tiles of one plane of one eye: positions from the client, or a G-buffer from the server. It
/// decodes without any other slice (stereo/codec/plane_codec.h).
struct PlaneSlice {
  FrameId frame{};
  Side eye = Side::Left;
  PlaneKind kind = PlaneKind::BaseColor;
  Extent size{};                       ///< size of the whole plane
  std::uint32_t word_bytes = 4;        ///< 1 to kMaxPlaneWord_bytes
  std::uint32_t first_tile = 0;        ///< in TileGrid{size}
  std::uint32_t tile_count = 0;        ///< 1 or more, first_tile + tile_count within the grid
  std::span<const std::byte> block{};  ///< LZ4; points into the received message or the packer
};

/// The requested blocks of consecutive tiles of one eye's view. It decodes without any other slice
/// (stereo/codec/ask_coder.h).
struct AskSlice {
  FrameId frame{};
  Side eye = Side::Left;
  Extent size{};                       ///< of the requested view
  std::uint32_t lights = 0;            ///< in the requested mask
  std::uint32_t first_tile = 0;        ///< in TileGrid{size}
  std::uint32_t tile_count = 0;        ///< 1 or more, first_tile + tile_count within the grid
  std::span<const std::byte> block{};  ///< points into the received message or the packer
};
/// Bytes of an AskSlice message before its block.
inline constexpr std::size_t kAskSliceHeader_bytes = 18;
inline constexpr std::size_t kMaxAskBlock_bytes = kBaseMessage_bytes - kAskSliceHeader_bytes;

/// The client ends its session, which frees its place at once.
struct Leave {
  friend bool operator==(const Leave&, const Leave&) = default;
};

/// A client's Leave and a server's Goodbye are sent so often, since any datagram may be lost.
inline constexpr int kGoodbyes = 3;
inline constexpr Duration kBetweenGoodbyes = std::chrono::milliseconds(20);

using ClientMessage = std::variant<RequestMessage, AskSlice, PlaneSlice, Leave>;

// ---- server -> client

/// The answer to a Hello from a client that has the key and the scene.
struct Welcome {
  ContentHash scene_hash{};
  std::uint32_t light_count = 0;
  /// Most pixels of an eye's view. The limit keeps one client's trace from delaying the others for long.
  std::uint32_t most_pixels = std::uint32_t{1} << 23;
  AnswerSet answers = set_of(Answer::Masks);  ///< that clients may request
  Exposure exposure{};                        ///< of pictures, wherever they are drawn
  friend bool operator==(const Welcome&, const Welcome&) = default;
};

enum class RefusalReason : std::uint8_t {
  VersionMismatch = 1,
  UnknownKey = 2,  ///< the server has no key with this id, or the proof was made with another key
  SceneMismatch = 3,
  Busy = 4,  ///< the server has no room for another client now
};

/// The answer to a Hello from a client that has the key but gets no session: SceneMismatch or Busy.
struct Refusal {
  RefusalReason reason = RefusalReason::Busy;
  ContentHash scene_hash{};  ///< the server's
  friend bool operator==(const Refusal&, const Refusal&) = default;
};

/// Consecutive tiles of one plane of one eye's mask. It decodes without any other slice
/// (stereo/codec/slice.h).
struct Slice {
  FrameId frame{};
  LightSetRevision light_set_revision{};
  Side eye = Side::Left;
  Extent size{};                       ///< size of the whole mask
  std::uint32_t lights = 0;            ///< in the whole mask
  std::uint32_t plane = 0;             ///< it has the lights from 32 * plane on (MaskLayout)
  std::uint32_t first_tile = 0;        ///< in TileGrid{size}
  std::uint32_t tile_count = 0;        ///< 1 or more, first_tile + tile_count within the grid
  std::span<const std::byte> block{};  ///< coded tiles; points into the received message or the packer
};

/// A part of a coded picture of both eyes, or of a block of masks (stereo/codec/mask_block.h). All parts but
/// the last have kVideoPart_bytes; zeros at their end fill up those of a picture.
struct VideoPart {
  FrameId frame{};
  FrameId after{};                     ///< the frame whose picture it depends on; `frame` itself: none
  std::uint32_t part = 0, parts = 1;   ///< index and number of parts, at most kMostVideoParts
  std::span<const std::byte> bytes{};  ///< 1 to kVideoPart_bytes; points into the received message
                                       ///< or the packer
};
inline constexpr std::size_t kVideoPartHeader_bytes = 13;
inline constexpr std::size_t kVideoPart_bytes = kBaseMessage_bytes - kVideoPartHeader_bytes;
inline constexpr std::uint32_t kMostVideoParts = 4096;

/// The server sends it after the other messages of a frame. It may be lost like any other datagram.
struct FrameReport {
  FrameId frame{};
  std::uint32_t slices = 0;         ///< messages of this frame, without this report
  std::uint32_t payload_bytes = 0;  ///< bytes of those messages, before sealing
  std::uint64_t primary_rays = 0, shadow_rays = 0;
  std::uint64_t full_shadow_rays = 0;  ///< shadow rays that a trace without any saving would need
  /// Times of the stages. Update: of the scene, to the time of the request. Pack includes coding.
  Duration update{}, primary{}, shadow{}, draw{}, pack{};
  Duration waited{};                   ///< from the request's arrival to its trace
  std::uint32_t superseded = 0;        ///< requests that newer ones have replaced so far
  std::uint32_t bytes_per_second = 0;  ///< that the path carries, by the server's estimate
  ViewScale view_scale{};              ///< the size of views that the client should request
  friend bool operator==(const FrameReport&, const FrameReport&) = default;
};

/// The server's work on the frame, without waiting.
[[nodiscard]] inline Duration total_work(const FrameReport& report) {
  return report.update + report.primary + report.shadow + report.draw + report.pack;
}

/// The server sends it to a new address of a client. The client puts the token into its next requests, and
/// the server then sends slices to that address. It is also a keepalive (kKeepaliveInterval) from a busy
/// server to a client that sends requests; nothing depends on its token then.
struct Probe {
  std::uint64_t token = 0;  ///< not 0
  friend bool operator==(const Probe&, const Probe&) = default;
};

/// Why the server has ended a session.
enum class EndReason : std::uint8_t {
  ServerEnds = 1,  ///< the server's process ends
  Revoked = 2,     ///< the key was taken out of the ring
  Expired = 3,     ///< the key's time is over
  Displaced = 4,   ///< the server was full, and a key with fewer sessions needed one
  Withdrawn = 5,   ///< the answer that the session uses is no longer offered
};

/// The last message of a session.
struct Goodbye {
  EndReason reason = EndReason::ServerEnds;
  friend bool operator==(const Goodbye&, const Goodbye&) = default;
};

/// Fills a datagram up to the size whose arrival the server wants to know of (stereo/net/path_mtu.h). It says
/// nothing.
struct PathProbe {
  std::span<const std::byte> padding{};  ///< 1 or more zeros; points into the received message or kZeros
  static constexpr std::array<std::byte, kMaxMessage_bytes> kZeros{};
};

/// Bytes of a Slice message before its block.
inline constexpr std::size_t kSliceHeader_bytes = 23;
inline constexpr std::size_t kMaxBlock_bytes = kMaxMessage_bytes - kSliceHeader_bytes;
/// Bytes of a PlaneSlice message before its block.
inline constexpr std::size_t kPlaneSliceHeader_bytes = 18;
inline constexpr std::size_t kMaxPlaneBlock_bytes = kMaxMessage_bytes - kPlaneSliceHeader_bytes;

using ServerMessage =
    std::variant<Welcome, Refusal, Slice, FrameReport, Probe, PlaneSlice, VideoPart, Goodbye, PathProbe>;

// ---- bytes

/// Replaces `bytes` by the message's bytes: at most kBaseMessage_bytes of a client's, kMaxMessage_bytes of a
/// server's. Checks that its fields are in their ranges. `version` is that of the session.
void encode(const ClientMessage& message, std::vector<std::byte>& bytes,
            ProtocolVersion version = kProtocolVersion);
void encode(const ServerMessage& message, std::vector<std::byte>& bytes,
            ProtocolVersion version = kProtocolVersion);

/// Blocks and parts of the result point into `bytes`.
[[nodiscard]] Decoded<ClientMessage> decode_client(std::span<const std::byte> bytes,
                                                   ProtocolVersion version = kProtocolVersion);
[[nodiscard]] Decoded<ServerMessage> decode_server(std::span<const std::byte> bytes,
                                                   ProtocolVersion version = kProtocolVersion);

}  // namespace farshade
