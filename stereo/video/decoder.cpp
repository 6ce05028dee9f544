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

}  // namespace

struct VideoDecoder::Codec {
  Libav<AVCodecContext> context;  ///< null after a reset, until a key frame comes
  Libav<AVFrame> frame;
  Libav<AVPacket> packet;
  std::optional<ColourConverter> colours;  ///< for the size of the last picture
  bool has_reference = false;              ///< a key frame was decoded
  bool is_concealed = false;
  Image<Rgb8> picture;

  Expected<void> open();
  Expected<void> decode_frame(std::span<const std::byte> unit);
  Expected<void> convert_frame(Extent size);
};

VideoDecoder::VideoDecoder(std::unique_ptr<Codec> codec) : codec_(std::move(codec)) {}
VideoDecoder::VideoDecoder(VideoDecoder&&) noexcept = default;
VideoDecoder& VideoDecoder::operator=(VideoDecoder&&) noexcept = default;
VideoDecoder::~VideoDecoder() = default;

Expected<VideoDecoder> VideoDecoder::create() {
  av_log_set_level(AV_LOG_QUIET);  // it logs every damaged unit
  auto codec = std::make_unique<Codec>();
  codec->frame.reset(av_frame_alloc());
  codec->packet.reset(av_packet_alloc());
  if (!codec->frame || !codec->packet) return fail(Fault::Unavailable, "no memory for a video decoder");
  return codec->open().map([&] { return VideoDecoder(std::move(codec)); });
}

Expected<void> VideoDecoder::Codec::open() {
  const AVCodec* codec = avcodec_find_decoder(AV_CODEC_ID_H264);
  if (codec == nullptr) return fail(Fault::Unavailable, "this libavcodec does not decode H.264");
  context.reset(avcodec_alloc_context3(codec));
  if (!context) return fail(Fault::Unavailable, "no memory for a video decoder");
  context->thread_count = 1;  // frame threads would delay pictures
  context->flags |= AV_CODEC_FLAG_LOW_DELAY | AV_CODEC_FLAG_OUTPUT_CORRUPT;
  context->error_concealment = FF_EC_GUESS_MVS | FF_EC_DEBLOCK;
  if (avcodec_open2(context.get(), codec, nullptr) < 0)
    return fail(Fault::Unavailable, "libavcodec's H.264 decoder does not start");
  return {};
}

/// Decodes the unit's only picture into `frame`.
Expected<void> VideoDecoder::Codec::decode_frame(std::span<const std::byte> unit) {
  // libavcodec copies data that it does not own, and does not change it.
  packet->data = const_cast<std::uint8_t*>(reinterpret_cast<const std::uint8_t*>(unit.data()));
  packet->size = narrow<int>(unit.size());
  if (avcodec_send_packet(context.get(), packet.get()) < 0)
    return fail(Fault::Malformed, "a video unit is damaged");
  if (avcodec_receive_frame(context.get(), frame.get()) < 0)
    return fail(Fault::Malformed, "a video unit holds no whole picture");
  is_concealed = frame->decode_error_flags != 0 || (frame->flags & AV_FRAME_FLAG_CORRUPT) != 0;
  return {};
}

Expected<void> VideoDecoder::Codec::convert_frame(Extent size) {
  if (!is_ours(*frame))
    return fail(Fault::Unsupported, "video is not 4:2:0, BT.709 in full range and of even sides");
  if (Extent{narrow<std::uint32_t>(frame->width), narrow<std::uint32_t>(frame->height)} != size)
    return fail(Fault::OutOfRange, "a video picture of another size than was asked for");
  if (!colours || colours->size() != size) {
    Expected<ColourConverter> made = ColourConverter::create(size, ColourConverter::To::Rgb);
    if (!made) return tl::unexpected(made.error());
    colours.emplace(std::move(*made));
  }
  colours->to_rgb({{frame->data[0], frame->data[1], frame->data[2]},
                   {frame->linesize[0], frame->linesize[1], frame->linesize[2]}},
                  picture);
  return {};
}

Expected<const Image<Rgb8>*> VideoDecoder::decode(std::span<const std::byte> unit, Extent size) {
  if (unit.empty() || unit.size() > kMaxUnit_bytes)
    return fail(Fault::Malformed, "a video unit of " + std::to_string(unit.size()) + " bytes");
  const Expected<VideoUnit> content = examine_unit(unit, size);
  if (!content) {
    reset();
    return tl::unexpected(content.error());
  }
  if (!codec_->has_reference && !content->holds_key_frame)
    return fail(Fault::Missing,
                "a video unit depends on pictures that have not arrived: a key frame is needed");
  const Expected<void> shown = (codec_->context ? Expected<void>{} : codec_->open())
                                   .and_then([&] { return codec_->decode_frame(unit); })
                                   .and_then([&] { return codec_->convert_frame(size); });
  if (!shown) {
    reset();
    return tl::unexpected(shown.error());
  }
  codec_->has_reference = true;
  return &codec_->picture;
}

bool VideoDecoder::concealed() const {
  return codec_->is_concealed;
}

/// Drops the whole decoder: the contents of a damaged parameter set would survive a flush.
void VideoDecoder::reset() {
  codec_->has_reference = false;
  codec_->context.reset();
}

}  // namespace farshade
