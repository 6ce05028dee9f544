// The video decoder of a client that asked for pictures of 64 x 48. The first byte says whether it has
// decoded a genuine key frame before; the other bytes are a unit. It must end with a picture of that size or
// a refusal, and decode a genuine key frame afterwards. Limits of time and of single allocations are
// libFuzzer's.
#include "stereo/video/video.h"
#include "stereo/base/check.h"
#include "tests/fuzz/target.h"

using namespace farshade;

namespace {

constexpr Extent kAsked{64, 48};

const std::vector<std::byte>& genuine_key_frame() {
  static const std::vector<std::byte> unit = [] {
    const auto encoder = VideoEncoder::create({kAsked, 2'000'000, 72, 300});
    check(encoder.has_value(), "this build has video");
    Image<Rgb8> picture(kAsked);
    for (std::uint32_t y = 0; y < kAsked.height; ++y)
      for (std::uint32_t x = 0; x < kAsked.width; ++x)
        picture.at(x, y) = Rgb8(static_cast<std::uint8_t>(3 * x), static_cast<std::uint8_t>(5 * y), 90);
    const std::span<const std::byte> bytes = (*encoder)->encode(picture, KeyFrame::Now);
    return std::vector<std::byte>(bytes.begin(), bytes.end());
  }();
  return unit;
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Choices choices(data, size);
  const auto decoder = VideoDecoder::create().value();
  if (choices.up_to(1) == 1)
    check(decoder->decode(genuine_key_frame(), kAsked).has_value(), "a genuine key frame is decoded");
  const auto picture = decoder->decode(choices.rest(), kAsked);
  check(!picture || (*picture)->size == kAsked, "a picture has the size that was asked for");
  check(!picture || (*picture)->pixels.size() == kAsked.pixels(), "and all of its pixels");
  decoder->reset();
  check(decoder->decode(genuine_key_frame(), kAsked).has_value(), "the decoder recovers");
  return 0;
}
