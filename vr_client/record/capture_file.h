/// Session file: what the outside world gave a client, frame by frame, and what the client made of it, so
/// that the session can be shown again bit for bit (replay.h). docs/session-file.md has the bytes; a record
/// is its kind, its length and its fields, and each kind has one field list for writing and reading.
#pragma once

#include <string>
#include <vector>

#include "stereo/wire/messages.h"
#include "vr_client/frame/frame_loop.h"

namespace farshade {

inline constexpr std::uint32_t kSessionMagic = 0x53534446;  // "FDSS" in byte order
inline constexpr std::uint16_t kSessionVersion = 1;
inline constexpr std::size_t kSessionPreamble_bytes = 8;  ///< magic, version, version of the messages inside
inline constexpr std::size_t kRecordHead_bytes = 5;       ///< kind, length
inline constexpr std::size_t kMaxRecord_bytes = 16384;    ///< without its head
inline constexpr std::size_t kMaxSessionText_bytes = 255;

enum class RecordKind : std::uint8_t { Header = 1, Frame = 2, Heard = 3, Asked = 4, Shown = 5 };

/// Who gave the masks.
enum class MaskOrigin : std::uint8_t { Nobody, Server, OwnTracer };

/// What a session stood on.
struct CaptureHeader {
  std::string scene;  ///< its file's name, for people
  ContentHash scene_hash{};
  std::uint32_t lights = 0;
  MaskOrigin origin = MaskOrigin::Nobody;
  RendererLimits limits;       ///< traced_size: size, or largest_traced(size)
  std::uint32_t requests = 0;  ///< that the AnswerInbox remembers
  double refresh_hz = 0;
  MaskPolicy policy;
  std::string device;  ///< that drew; another one may draw other pictures
};

struct CapturedMessage {
  Time arrived;
  std::vector<std::byte> bytes;  ///< as decode_server takes them
};

struct CapturedRequest {
  Time sent;
  FrameRequest request;  ///< as it went out: of its lights what the server was not known to have
};

/// BLAKE2b-128 of a picture's size and pixels.
using PictureHash = std::array<std::uint8_t, 16>;
[[nodiscard]] PictureHash hash_of(const Image<Rgb8>& picture);

/// All that the outside world decides about a frame but what the server says.
struct CapturedFrameInput {
  FrameTiming timing;
  StereoView views;        ///< of the session's eye size
  FrameSettings steering;  ///< but for `report`, which changes no picture
};

struct CapturedFrame {
  CapturedFrameInput input;
  std::vector<CapturedMessage> before;   ///< taken in before `asked` went out; all if nothing did
  std::optional<CapturedRequest> asked;  ///< nothing: it asked for nothing, or there was no session to ask in
  std::vector<CapturedMessage> after;    ///< taken in from then on, before it was drawn
  PerEye<PictureHash> shown{};
};

/// Appends what a file begins with, or what it goes on with. Texts are cut to kMaxSessionText_bytes and rid
/// of control characters; anything else out of its range is a bug here.
void append(const CaptureHeader& header, std::vector<std::byte>& file);
void append(const CapturedFrame& frame, std::vector<std::byte>& file);

// ---- what a record holds, from `bytes` without the record's head; refused as messages are

[[nodiscard]] Decoded<CaptureHeader> decode_header(std::span<const std::byte> bytes);
/// The views get `eye_size`, which the file says once.
[[nodiscard]] Decoded<CapturedFrameInput> decode_frame(std::span<const std::byte> bytes, Extent eye_size);
/// Its message decodes.
[[nodiscard]] Decoded<CapturedMessage> decode_heard(std::span<const std::byte> bytes);
[[nodiscard]] Decoded<CapturedRequest> decode_asked(std::span<const std::byte> bytes);
[[nodiscard]] Decoded<PerEye<PictureHash>> decode_shown(std::span<const std::byte> bytes);

}  // namespace farshade
