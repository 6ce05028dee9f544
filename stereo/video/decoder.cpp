#include <optional>

#include "stereo/base/check.h"
#include "stereo/video/colours.h"
#include "stereo/video/libav.h"
#include "stereo/video/video.h"
#include "stereo/video/video_unit.h"

namespace farshade {
namespace {

/// Larger than every picture of the largest size.
constexpr std::size_t kMaxUnit_bytes = std::size_t{1} << 28;

bool is_ours(const AVFrame& frame) {
  const bool planes = frame.format == AV_PIX_FMT_YUV420P || frame.format == AV_PIX_FMT_YUVJ420P;
  return planes && frame.color_range == AVCOL_RANGE_JPEG && frame.colorspace == AVCOL_SPC_BT709 &&
         frame.width % 2 == 0 && frame.height % 2 == 0;
}

class LibavDecoder final : public VideoDecoder {
 public:
  Expected<void> open();
  [[nodiscard]] Expected<const Image<Rgb8>*> decode(std::span<const std::byte> unit, Extent size) override;
  [[nodiscard]] bool concealed() const override { return is_concealed_; }
  void reset() override;

 private:
  Expected<void> decode_frame(std::span<const std::byte> unit);
  Expected<void> convert_frame(Extent size);

  Libav<AVCodecContext> context_;  ///< null after a reset, until a key frame comes
  Libav<AVFrame> frame_{av_frame_alloc()};
  Libav<AVPacket> packet_{av_packet_alloc()};
  std::optional<ColourConverter> colours_;  ///< for the size of the last picture
  bool has_reference_ = false;              ///< a key frame was decoded
  bool is_concealed_ = false;
  Image<Rgb8> picture_;
};

Expected<void> LibavDecoder::open() {
  const AVCodec* codec = avcodec_find_decoder(AV_CODEC_ID_H264);
  if (codec == nullptr) return fail(Fault::Unavailable, "this libavcodec does not decode H.264");
  context_.reset(avcodec_alloc_context3(codec));
  if (!context_ || !frame_ || !packet_) return fail(Fault::Unavailable, "no memory for a video decoder");
  context_->thread_count = 1;  // frame threads would delay pictures
  context_->flags |= AV_CODEC_FLAG_LOW_DELAY | AV_CODEC_FLAG_OUTPUT_CORRUPT;
  context_->error_concealment = FF_EC_GUESS_MVS | FF_EC_DEBLOCK;
  if (avcodec_open2(context_.get(), codec, nullptr) < 0)
    return fail(Fault::Unavailable, "libavcodec's H.264 decoder does not start");
  return {};
}

/// Decodes the unit's only picture into `frame_`.
Expected<void> LibavDecoder::decode_frame(std::span<const std::byte> unit) {
  // libavcodec copies data that it does not own, and does not change it.
  packet_->data = const_cast<std::uint8_t*>(reinterpret_cast<const std::uint8_t*>(unit.data()));
  packet_->size = narrow<int>(unit.size());
  if (avcodec_send_packet(context_.get(), packet_.get()) < 0)
    return fail(Fault::Malformed, "a video unit is damaged");
  if (avcodec_receive_frame(context_.get(), frame_.get()) < 0)
    return fail(Fault::Malformed, "a video unit holds no whole picture");
  is_concealed_ = frame_->decode_error_flags != 0 || (frame_->flags & AV_FRAME_FLAG_CORRUPT) != 0;
  return {};
}

Expected<void> LibavDecoder::convert_frame(Extent size) {
  if (!is_ours(*frame_))
    return fail(Fault::Unsupported, "video is not 4:2:0, BT.709 in full range and of even sides");
  if (Extent{narrow<std::uint32_t>(frame_->width), narrow<std::uint32_t>(frame_->height)} != size)
    return fail(Fault::OutOfRange, "a video picture of another size than was asked for");
  if (!colours_ || colours_->size() != size) {
    Expected<ColourConverter> made = ColourConverter::create(size, ColourConverter::To::Rgb);
    if (!made) return tl::unexpected(made.error());
    colours_.emplace(std::move(*made));
  }
  colours_->to_rgb({{frame_->data[0], frame_->data[1], frame_->data[2]},
                    {frame_->linesize[0], frame_->linesize[1], frame_->linesize[2]}},
                   picture_);
  return {};
}

Expected<const Image<Rgb8>*> LibavDecoder::decode(std::span<const std::byte> unit, Extent size) {
  if (unit.empty() || unit.size() > kMaxUnit_bytes)
    return fail(Fault::Malformed, "a video unit of " + std::to_string(unit.size()) + " bytes");
  const Expected<VideoUnit> content = examine_unit(unit, size);
  if (!content) {
    reset();
    return tl::unexpected(content.error());
  }
  if (!has_reference_ && !content->holds_key_frame)
    return fail(Fault::Missing,
                "a video unit depends on pictures that have not arrived: a key frame is needed");
  const Expected<void> shown =
      (context_ ? Expected<void>{} : open()).and_then([&] { return decode_frame(unit); }).and_then([&] {
        return convert_frame(size);
      });
  if (!shown) {
    reset();
    return tl::unexpected(shown.error());
  }
  has_reference_ = true;
  return &picture_;
}

/// Drops the whole decoder: the contents of a damaged parameter set would survive a flush.
void LibavDecoder::reset() {
  has_reference_ = false;
  context_.reset();
}

}  // namespace

Expected<std::unique_ptr<VideoDecoder>> VideoDecoder::create() {
  av_log_set_level(AV_LOG_QUIET);  // it logs every damaged unit
  auto decoder = std::make_unique<LibavDecoder>();
  return decoder->open().map([&]() -> std::unique_ptr<VideoDecoder> { return std::move(decoder); });
}

}  // namespace farshade
