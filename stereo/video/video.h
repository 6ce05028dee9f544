/// Video: pictures as H.264 and back, for answers that are pictures. libavcodec with libx264 does it; a build
/// without them (FARSHADE_VIDEO=OFF) has the same interface and says Unavailable.
/// Tuned for the next picture, not for the stream: no B frames, no lookahead, each picture goes in and comes
/// out as one access unit, and no unit is larger than four pictures' share of the bit rate.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "stereo/base/expected.h"
#include "stereo/frame/view.h"
#include "stereo/image/image.h"

namespace farshade {

/// Whether this build can encode and decode.
[[nodiscard]] bool has_video();
/// The libraries and their versions, or the words that say how to get them.
[[nodiscard]] std::string video_version();

struct VideoFormat {
  Extent size;  ///< pixels of the whole picture; both sides even, 32 at least
  std::uint32_t bits_per_second = 20'000'000;
  double frames_per_second = 72;
  friend bool operator==(const VideoFormat&, const VideoFormat&) = default;
};

/// A key frame is decoded without any unit before it. The first picture is one; others only where asked.
enum class KeyFrame : std::uint8_t { IfNeeded, Now };

/// H.264 High profile, YUV 4:2:0, BT.709 in full range. The same pictures give the same bytes.
class VideoEncoder {
 public:
  /// OutOfRange: sides that are odd, below 32 or beyond two views side by side; a bit rate beyond
  /// 10^5..10^9; frames a second beyond 1..1000. Unavailable: a build without video, or libx264 will not.
  [[nodiscard]] static Expected<VideoEncoder> create(const VideoFormat& format);
  VideoEncoder(VideoEncoder&&) noexcept;
  VideoEncoder& operator=(VideoEncoder&&) noexcept;
  ~VideoEncoder();

  [[nodiscard]] const VideoFormat& format() const;

  /// One whole access unit: Annex B, with parameter sets at key frames. Valid until the next call.
  /// `picture` is of the format's size.
  [[nodiscard]] std::span<const std::byte> encode(const Image<Rgb8>& picture, KeyFrame key);

 private:
  struct Codec;
  explicit VideoEncoder(std::unique_ptr<Codec> codec);
  std::unique_ptr<Codec> codec_;
};

/// The way back. Units are foreign bytes, and what can be told to be damaged is refused as a whole. Not all
/// can: the last block of a unit that lacks its last bytes, or a picture whose predecessor was never decoded,
/// looks whole and is wrong. So the caller decodes whole units only, and resets after a gap.
class VideoDecoder {
 public:
  [[nodiscard]] static Expected<VideoDecoder> create();
  VideoDecoder(VideoDecoder&&) noexcept;
  VideoDecoder& operator=(VideoDecoder&&) noexcept;
  ~VideoDecoder();

  /// The picture of one whole access unit, valid until the next call. Missing: it is no key frame, and none
  /// has been decoded since the start, a reset or a refusal. Malformed: no picture comes of it. Unsupported:
  /// not what VideoEncoder makes. OutOfRange: larger than two views of kMaxViewSide_px side by side.
  [[nodiscard]] Expected<const Image<Rgb8>*> decode(std::span<const std::byte> access_unit);

  /// After a gap: only a key frame is decodable.
  void reset();

 private:
  struct Codec;
  explicit VideoDecoder(std::unique_ptr<Codec> codec);
  std::unique_ptr<Codec> codec_;
};

/// Size of both eyes of `eye` pixels side by side. 4:2:0 halves the colour of two columns and two rows, so
/// an eye's odd side gets one more: its last column or row again.
[[nodiscard]] Extent side_by_side_size(Extent eye);

/// Both eyes, of one size, left eye first, padded as side_by_side_size says.
[[nodiscard]] Image<Rgb8> side_by_side(const PerEye<Image<Rgb8>>& eyes);

/// The eyes of a picture of side_by_side_size(eye), without the padding.
[[nodiscard]] PerEye<Image<Rgb8>> two_eyes(const Image<Rgb8>& picture, Extent eye);

}  // namespace farshade
