/// libavcodec, and owning pointers for its objects. Only encoder.cpp and decoder.cpp include it.
#pragma once

#include <memory>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavutil/opt.h>
}

namespace farshade {

struct LibavEnd {
  void operator()(AVCodecContext* context) const { avcodec_free_context(&context); }
  void operator()(AVFrame* frame) const { av_frame_free(&frame); }
  void operator()(AVPacket* packet) const { av_packet_free(&packet); }
};
template <class T>
using Libav = std::unique_ptr<T, LibavEnd>;

}  // namespace farshade
