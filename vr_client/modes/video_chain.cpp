#include "vr_client/modes/video_chain.h"

#include <stdexcept>
#include <utility>

namespace farshade {
namespace {

VideoDecoder make_decoder() {
  Expected<VideoDecoder> decoder = VideoDecoder::create();
  if (!decoder) throw std::runtime_error(decoder.error().what);
  return std::move(*decoder);
}

}  // namespace

VideoChain::VideoChain() : decoder_(make_decoder()) {}

const Image<Rgb8>* VideoChain::take(FrameId frame, FrameId after, std::span<const std::byte> unit,
                                    Extent size) {
  const std::optional<FrameId> last = std::exchange(last_, std::nullopt);
  if (after == frame)
    decoder_.reset();  // a key frame depends on no other
  else if (after != last)
    return nullptr;
  const Expected<const Image<Rgb8>*> picture = decoder_.decode(unit);
  if (!picture || (*picture)->size != size) return nullptr;
  last_ = frame;
  return *picture;
}

}  // namespace farshade
