/// Capture file: all inputs of a run, frame by frame, and hashes of the pictures that the run showed, so that
/// replay.h can repeat the run bit for bit. docs/capture-file.md specifies the bytes. A record is a kind, a
/// length, fields and a checksum. Each kind has one field list for both writing and reading.
#pragma once

#include <string>
#include <vector>

#include "stereo/messages/messages.h"
#include "vr_client/frame/frame_loop.h"

namespace farshade {

inline constexpr std::uint32_t kCaptureMagic = 0x53534446;  // "FDSS" in byte order
inline constexpr std::uint16_t kCaptureVersion = 5;
inline constexpr std::size_t kCapturePreamble_bytes =
    8;  ///< magic, format version, protocol version of the messages
inline constexpr std::size_t kRecordHead_bytes = 5;      ///< kind and length
inline constexpr std::size_t kRecordChecksum_bytes = 4;  ///< after the fields
inline constexpr std::size_t kMaxRecord_bytes = 16384;   ///< without kind and length
inline constexpr std::size_t kMaxCaptureText_bytes = 255;

enum class RecordKind : std::uint8_t {
  Header = 1,
  Frame = 2,
  Received = 3,
  Request = 4,
  Pictures = 5,
  End = 6
};

/// Who traced the masks.
enum class MaskOrigin : std::uint8_t { Nobody, Server, OwnTracer };

/// Configuration of the captured run.
struct CaptureHeader {
  std::string scene;  ///< name of the scene file, for messages only
  ContentHash scene_hash{};
  std::uint32_t lights = 0;
  MaskOrigin origin = MaskOrigin::Nobody;
  RendererLimits limits;       ///< traced_size is size or largest_traced(size)
  double detail_px = 0;        ///< limit of the geometric error of the drawn levels of detail
  std::uint32_t requests = 0;  ///< number of requests that the FrameReceiver remembers
  double refresh_hz = 0;
  Exposure exposure{};  ///< until a Welcome says another
  MaskPolicy policy;
  std::string device;  ///< name of the GPU; another GPU may draw other pictures
};

struct CapturedMessage {
  Time arrived;
  std::vector<std::byte> bytes;  ///< input of decode_server
};

struct CapturedRequest {
  Time sent;
  FrameRequest request;  ///< as sent, with only the light changes that the server had not confirmed
};

/// BLAKE2b-128 of the size and the pixels of a picture.
using PictureHash = std::array<std::uint8_t, 16>;
[[nodiscard]] PictureHash hash_of(const Image<Rgb8>& picture);

/// Inputs of a frame except server messages.
struct CapturedFrameInput {
  FrameTiming timing;
  StereoView views;        ///< their size is the header's limits.size
  FrameSettings settings;  ///< without `report`, which changes no picture
};

struct CapturedFrame {
  CapturedFrameInput input;
  std::vector<CapturedMessage> before;  ///< received before `request` was sent; all, if there is no request
  std::optional<CapturedRequest> request;  ///< empty if the frame sent no request or no session was open
  std::vector<CapturedMessage> after;  ///< received after `request` was sent and before the frame was drawn
  PerEye<PictureHash> pictures{};
};

/// Append the beginning of a file (preamble and header) and one frame. Texts are cut to
/// kMaxCaptureText_bytes, and '?' replaces control characters. Any other value out of its range is a bug in
/// the caller.
void append(const CaptureHeader& header, std::vector<std::byte>& file);
void append(const CapturedFrame& frame, std::vector<std::byte>& file);

/// Ends a file. A file without this record lacks its end.
struct CaptureEnd {
  std::uint32_t frames = 0;  ///< in the file
};
void append(const CaptureEnd& end, std::vector<std::byte>& file);

/// CRC-32 of a record's kind, length and fields.
[[nodiscard]] std::uint32_t checksum_of(std::span<const std::byte> record);

// Decoders of the record bodies: `bytes` excludes kind, length and checksum. They refuse bytes as message
// decoders do.

[[nodiscard]] Decoded<CaptureHeader> decode_header(std::span<const std::byte> bytes);
/// `eye_size` is the size of both views; the file holds it once, in its header.
[[nodiscard]] Decoded<CapturedFrameInput> decode_frame(std::span<const std::byte> bytes, Extent eye_size);
/// Refuses bytes that are not a server message.
[[nodiscard]] Decoded<CapturedMessage> decode_received(std::span<const std::byte> bytes);
/// Refuses client messages that are not a request (Type).
[[nodiscard]] Decoded<CapturedRequest> decode_request(std::span<const std::byte> bytes);
[[nodiscard]] Decoded<PerEye<PictureHash>> decode_pictures(std::span<const std::byte> bytes);
[[nodiscard]] Decoded<CaptureEnd> decode_end(std::span<const std::byte> bytes);

}  // namespace farshade
