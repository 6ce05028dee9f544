#include <algorithm>
#include <limits>

#include "stereo/base/check.h"
#include "stereo/frame/answer_spec.h"
#include "stereo/video/colours.h"
#include "stereo/video/libav.h"
#include "stereo/video/video.h"

namespace farshade {
namespace {

/// Size of the encoder's VBV buffer, in pictures. No unit is larger, and none takes longer on a link with the
/// configured bit rate. With two or three pictures libx264 leaves a fifth or a seventh of the bit rate
/// unused.
constexpr double kBuffer_frames = 4;

/// libx264 does not end slices that may not have a block.
constexpr std::uint32_t kLeastSlice_bytes = 200;

std::string refusal(const VideoFormat& format) {
  const auto side_ok = [](std::uint32_t side, std::uint32_t most) {
    return side >= 32 && side <= most && side % 2 == 0;
  };
  const auto [width, height] = format.size;
  if (!side_ok(width, 2 * kMaxViewSide_px) || !side_ok(height, kMaxViewSide_px))
    return "video of " + std::to_string(width) + " x " + std::to_string(height) +
           ": sides must be even, 32 to " + std::to_string(2 * kMaxViewSide_px) + " x " +
           std::to_string(kMaxViewSide_px);
  if (format.bits_per_second < kLeastVideo_bits || format.bits_per_second > kMostVideo_bits)
    return "video of " + std::to_string(format.bits_per_second) + " bit/s: must be 10^5 to 10^9";
  if (format.slice_bytes < kLeastSlice_bytes)
    return "video in slices of " + std::to_string(format.slice_bytes) + " bytes: must be 200 or more";
  if (!(format.frames_per_second >= 1 && format.frames_per_second <= 1000))
    return "video of " + std::to_string(format.frames_per_second) + " frames/s: must be 1 to 1000";
  return "";
}

/// One thread, so that the bytes do not depend on the number of cores.
void describe(const VideoFormat& format, AVCodecContext& context) {
  const AVRational rate = av_d2q(format.frames_per_second, 1'000'000);
  context.width = narrow<int>(format.size.width);
  context.height = narrow<int>(format.size.height);
  context.pix_fmt = AV_PIX_FMT_YUV420P;
  context.color_range = AVCOL_RANGE_JPEG;
  context.colorspace = AVCOL_SPC_BT709;
  context.color_primaries = AVCOL_PRI_BT709;
  context.color_trc = AVCOL_TRC_IEC61966_2_1;
  context.time_base = av_inv_q(rate);
  context.framerate = rate;
  context.thread_count = 1;
  context.max_b_frames = 0;
  context.bit_rate = format.bits_per_second;
  context.rc_max_rate = format.bits_per_second;
  context.rc_buffer_size =
      static_cast<int>(std::min(kBuffer_frames * format.bits_per_second / format.frames_per_second,
                                double{std::numeric_limits<int>::max()}));
}

bool open(const VideoFormat& format, AVCodecContext& context, const AVCodec& codec) {
  AVDictionary* options = nullptr;
  av_dict_set(&options, "preset", "superfast", 0);
  av_dict_set(&options, "tune", "zerolatency", 0);
  av_dict_set(&options, "profile", "high", 0);
  av_dict_set(&options, "forced-idr", "1", 0);
  const std::string params = "intra-refresh=1:keyint=" + std::to_string(kRefresh_pictures) +
                             ":scenecut=0:slice-max-size=" + std::to_string(format.slice_bytes);
  av_dict_set(&options, "x264-params", params.c_str(), 0);
  const bool opened = avcodec_open2(&context, &codec, &options) >= 0;
  const bool understood = av_dict_count(options) == 0;
  av_dict_free(&options);
  return opened && understood;
}

class LibavEncoder final : public VideoEncoder {
 public:
  LibavEncoder(const VideoFormat& format, Libav<AVCodecContext> context, Libav<AVFrame> frame,
               Libav<AVPacket> packet, ColourConverter colours)
      : format_(format),
        context_(std::move(context)),
        frame_(std::move(frame)),
        packet_(std::move(packet)),
        colours_(std::move(colours)) {}

  [[nodiscard]] const VideoFormat& format() const override { return format_; }
  [[nodiscard]] std::span<const std::byte> encode(const Image<Rgb8>& picture, KeyFrame key) override;

 private:
  VideoFormat format_;
  Libav<AVCodecContext> context_;
  Libav<AVFrame> frame_;
  Libav<AVPacket> packet_;
  ColourConverter colours_;
};

std::span<const std::byte> LibavEncoder::encode(const Image<Rgb8>& picture, KeyFrame key) {
  AVFrame& frame = *frame_;
  AVPacket& packet = *packet_;
  check(av_frame_make_writable(&frame) >= 0, "there is memory for a video frame");
  colours_.to_yuv(picture, {{frame.data[0], frame.data[1], frame.data[2]},
                            {frame.linesize[0], frame.linesize[1], frame.linesize[2]}});
  frame.pict_type = key == KeyFrame::Now ? AV_PICTURE_TYPE_I : AV_PICTURE_TYPE_NONE;
  check(avcodec_send_frame(context_.get(), &frame) >= 0, "libx264 takes each picture");
  ++frame.pts;
  av_packet_unref(&packet);
  check(avcodec_receive_packet(context_.get(), &packet) >= 0, "one picture in is one unit out");
  return std::as_bytes(std::span(packet.data, narrow<std::size_t>(packet.size)));
}

}  // namespace

bool has_video() {
  return true;
}

std::string video_version() {
  const AVCodec* encoder = avcodec_find_encoder_by_name("libx264");
  const unsigned version = avcodec_version();
  return "libavcodec " + std::to_string(AV_VERSION_MAJOR(version)) + "." +
         std::to_string(AV_VERSION_MINOR(version)) + "." + std::to_string(AV_VERSION_MICRO(version)) +
         (encoder != nullptr ? " with libx264" : " without libx264");
}

Expected<std::unique_ptr<VideoEncoder>> VideoEncoder::create(const VideoFormat& format) {
  if (const std::string why = refusal(format); !why.empty()) return fail(Fault::OutOfRange, why);
  av_log_set_level(AV_LOG_QUIET);  // its return codes report errors
  const AVCodec* codec = avcodec_find_encoder_by_name("libx264");
  if (codec == nullptr)
    return fail(Fault::Unavailable, "this libavcodec has no libx264: install one that has, as Debian's");
  Libav<AVCodecContext> context(avcodec_alloc_context3(codec));
  Libav<AVFrame> frame(av_frame_alloc());
  Libav<AVPacket> packet(av_packet_alloc());
  Expected<ColourConverter> colours = ColourConverter::create(format.size, ColourConverter::To::Yuv);
  if (!colours) return tl::unexpected(colours.error());
  if (!context || !frame || !packet) return fail(Fault::Unavailable, "no memory for a video encoder");
  describe(format, *context);
  if (!open(format, *context, *codec))
    return fail(Fault::Unavailable, "libx264 does not start with this format");
  frame->width = context->width;
  frame->height = context->height;
  frame->format = context->pix_fmt;
  frame->color_range = context->color_range;
  frame->colorspace = context->colorspace;
  frame->pts = 0;
  if (av_frame_get_buffer(frame.get(), 0) < 0) return fail(Fault::Unavailable, "no memory for a video frame");
  return std::make_unique<LibavEncoder>(format, std::move(context), std::move(frame), std::move(packet),
                                        std::move(*colours));
}

}  // namespace farshade
