/// Video: encodes pictures as H.264 and decodes them, with libavcodec and libx264. A build without these
/// libraries (FARSHADE_VIDEO=OFF) has the same interface, which returns Unavailable.
/// The settings give low latency: no B frames and no lookahead, so each picture becomes one access unit at
/// once. No unit is larger than four pictures' share of the bit rate.
///
/// Losses heal without a key frame. Each picture codes a few columns of blocks alone; after kRefresh_pictures
/// the columns have passed over the whole picture, and begin again (periodic intra refresh). Blocks behind
/// the columns depend only on blocks behind them. So a picture is whole again at the end of the first pass
/// that began after the loss.
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
/// The libraries and their versions, or how to get them.
[[nodiscard]] std::string video_version();

/// The pictures of one pass of the intra refresh.
inline constexpr std::uint32_t kRefresh_pictures = 24;

struct VideoFormat {
  Extent size;  ///< pixels of the whole picture; width and height are even and at least 32
  std::uint32_t bits_per_second = 20'000'000;
  double frames_per_second = 72;
  /// No slice is larger, except one that is a single block of 16 x 16 pixels. A slice decodes without the
  /// others.
  std::uint32_t slice_bytes = 1'100;
  friend bool operator==(const VideoFormat&, const VideoFormat&) = default;
};

/// A key frame decodes without an earlier unit. The first picture is one; later pictures only on request.
enum class KeyFrame : std::uint8_t { IfNeeded, Now };

/// H.264 High profile, YUV 4:2:0, BT.709, full range. The same pictures give the same bytes.
class VideoEncoder {
 public:
  /// OutOfRange: width or height is odd, below 32 or larger than two views side by side; the bit rate is
  /// outside of 10^5..10^9; frames a second are outside of 1..1000; slices have less than 200 bytes.
  /// Unavailable: this build has no video, or libx264 fails.
  [[nodiscard]] static Expected<std::unique_ptr<VideoEncoder>> create(const VideoFormat& format);
  virtual ~VideoEncoder() = default;

  [[nodiscard]] virtual const VideoFormat& format() const = 0;

  /// Returns one whole access unit: Annex B, with parameter sets at key frames. Valid until the next call.
  /// `picture` has the format's size.
  [[nodiscard]] virtual std::span<const std::byte> encode(const Image<Rgb8>& picture, KeyFrame key) = 0;
};

/// Decodes the encoder's units. Units are foreign bytes. A unit may lack slices, and units may be missing:
/// the decoder then takes the missing blocks from the picture before, and the intra refresh heals the
/// picture.
class VideoDecoder {
 public:
  [[nodiscard]] static Expected<std::unique_ptr<VideoDecoder>> create();
  virtual ~VideoDecoder() = default;

  /// Returns the picture of one access unit, valid until the next call. `size`: the pixels that were asked
  /// for. The memory that decoding takes depends on it and not on what the unit announces. Missing: the unit
  /// is not a key frame, and no key frame has been decoded since the start, a reset or an error. Malformed:
  /// the unit gives no picture. Unsupported: the format is not VideoEncoder's. OutOfRange: the picture has
  /// another size, or what examine_unit (video_unit.h) says.
  [[nodiscard]] virtual Expected<const Image<Rgb8>*> decode(std::span<const std::byte> access_unit,
                                                            Extent size) = 0;

  /// The decoder knows that blocks of the last picture were missing or wrong. False does not mean that the
  /// picture is whole: its reference picture may have been damaged.
  [[nodiscard]] virtual bool concealed() const = 0;

  /// Only a key frame decodes then.
  virtual void reset() = 0;
};

/// Size of a picture with two eyes of `eye` pixels side by side. 4:2:0 needs an even width and height, so an
/// eye with an odd width or height gets its last column or row twice.
[[nodiscard]] Extent side_by_side_size(Extent eye);

/// Both eyes side by side, left eye first, padded as side_by_side_size says. Both have the same size.
[[nodiscard]] Image<Rgb8> side_by_side(const PerEye<Image<Rgb8>>& eyes);

/// Splits a picture of side_by_side_size(eye) into the eyes, without the padding.
[[nodiscard]] PerEye<Image<Rgb8>> two_eyes(const Image<Rgb8>& picture, Extent eye);

}  // namespace farshade
