#include "stereo/video/video.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "stereo/image/difference.h"

namespace farshade {
namespace {

using Unit = std::vector<std::byte>;

constexpr Extent kSize{320, 160};

/// A drawn scene that moves with `frame`: a shaded floor, bars and discs with sharp edges, fine stripes.
Image<Rgb8> drawn(Extent size, int frame) {
  Image<Rgb8> picture(size);
  const auto level = [](double value) { return static_cast<std::uint8_t>(std::clamp(value, 0.0, 255.0)); };
  for (std::uint32_t y = 0; y < size.height; ++y)
    for (std::uint32_t x = 0; x < size.width; ++x) {
      const double u = x + 2.5 * frame, v = y + 0.5 * frame;
      const double texture = 12 * std::sin(u * 0.9) * std::sin(v * 0.7) + 9 * std::sin(u * 0.31 + v * 0.17);
      const bool bar = std::fmod(u, 57) < 19,
                 disc = std::hypot(std::fmod(u, 83) - 41, std::fmod(v, 83) - 41) < 21;
      picture.at(x, y) = Rgb8(level((disc ? 200 : 90) + texture), level((bar ? 60 : 140) + texture + 0.2 * v),
                              level(disc && bar ? 30 : 120 + 0.5 * texture));
    }
  return picture;
}

VideoEncoder encoder(const VideoFormat& format) {
  Expected<VideoEncoder> made = VideoEncoder::create(format);
  if (!made) throw std::runtime_error(made.error().what);
  return std::move(*made);
}

VideoDecoder decoder() {
  Expected<VideoDecoder> made = VideoDecoder::create();
  if (!made) throw std::runtime_error(made.error().what);
  return std::move(*made);
}

Unit unit_of(VideoEncoder& by, const Image<Rgb8>& picture, KeyFrame key = KeyFrame::IfNeeded) {
  const std::span<const std::byte> bytes = by.encode(picture, key);
  return {bytes.begin(), bytes.end()};
}

/// The first `frames` units of the drawn scene.
std::vector<Unit> units_of(VideoEncoder& by, int frames) {
  std::vector<Unit> units;
  for (int frame = 0; frame < frames; ++frame) units.push_back(unit_of(by, drawn(by.format().size, frame)));
  return units;
}

Fault fault_of(const Expected<const Image<Rgb8>*>& decoded) {
  return decoded ? throw std::runtime_error("it was decoded") : decoded.error().fault;
}

TEST(Video, NamesItsLibraries) {
  EXPECT_TRUE(has_video());
  EXPECT_NE(video_version().find("libavcodec"), std::string::npos);
  EXPECT_NE(video_version().find("with libx264"), std::string::npos);
}

Image<Rgb8> grey(Image<Rgb8> picture) {
  for (Rgb8& pixel : picture.pixels) pixel = Rgb8(pixel.g);
  return picture;
}

/// Colour has half the resolution, and the drawn scene has coloured edges, so its PSNR cannot be high.
TEST(Video, EveryPictureComesBackAtOnceAndIsClose) {
  for (const bool coloured : {false, true}) {
    VideoEncoder coder = encoder({kSize, 50'000'000, 72});
    VideoDecoder back = decoder();
    testing::internal::CaptureStderr();
    for (int frame = 0; frame < 12; ++frame) {
      const Image<Rgb8> picture = coloured ? drawn(kSize, frame) : grey(drawn(kSize, frame));
      const auto decoded = back.decode(coder.encode(picture, KeyFrame::IfNeeded));
      ASSERT_TRUE(decoded.has_value()) << decoded.error().what;
      ASSERT_EQ((*decoded)->size, kSize);
      EXPECT_GT(psnr_db(picture, **decoded), coloured ? 31.0 : 50.0) << "frame " << frame;
    }
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "") << "libav prints nothing";
  }
}

/// Half a picture of one colour. 4:2:0 does not change it, so it shows whether encoder and decoder agree
/// about range and matrix.
TEST(Video, ColoursKeepTheirLevels) {
  for (const Rgb8 colour : {Rgb8(0, 0, 0), Rgb8(255, 255, 255), Rgb8(255, 0, 0), Rgb8(0, 0, 255),
                            Rgb8(128, 128, 128), Rgb8(10, 200, 90)}) {
    VideoEncoder coder = encoder({kSize, 50'000'000, 72});
    VideoDecoder back = decoder();
    const auto decoded = back.decode(coder.encode(Image<Rgb8>(kSize, colour), KeyFrame::IfNeeded));
    ASSERT_TRUE(decoded.has_value());
    for (const std::uint32_t x : {0u, kSize.width / 2, kSize.width - 1})
      for (int channel = 0; channel < 3; ++channel)
        EXPECT_NEAR((*decoded)->at(x, kSize.height - 1)[channel], colour[channel], 3);
  }
}

TEST(Video, KeepsToTheBitRate) {
  for (const std::uint32_t rate : {1'500'000u, 5'000'000u}) {
    constexpr int frames = 60;
    VideoEncoder coder = encoder({kSize, rate, 72});
    std::size_t bytes = 0, largest = 0;
    for (const Unit& unit : units_of(coder, frames)) {
      bytes += unit.size();
      largest = std::max(largest, unit.size());
    }
    const double share_bytes = rate / 72.0 / 8;
    EXPECT_NEAR(static_cast<double>(bytes), share_bytes * frames, 0.15 * share_bytes * frames);
    EXPECT_LT(static_cast<double>(largest), 4 * share_bytes);
  }
}

TEST(Video, KeyFrameIsDecodedWithoutEarlierPictures) {
  VideoEncoder coder = encoder({kSize, 20'000'000, 72});
  const std::vector<Unit> units = units_of(coder, 3);
  const Image<Rgb8> picture = drawn(kSize, 3);
  const Unit key = unit_of(coder, picture, KeyFrame::Now);
  VideoDecoder late = decoder();
  EXPECT_EQ(fault_of(late.decode(units[1])), Fault::Missing);
  EXPECT_EQ(fault_of(late.decode(units[2])), Fault::Missing);
  const auto decoded = late.decode(key);
  ASSERT_TRUE(decoded.has_value()) << decoded.error().what;
  EXPECT_GT(psnr_db(picture, **decoded), 30.0);
}

TEST(Video, RecoversFromALostUnitByAKeyFrame) {
  VideoEncoder coder = encoder({kSize, 20'000'000, 72});
  const std::vector<Unit> units = units_of(coder, 5);
  VideoDecoder back = decoder();
  ASSERT_TRUE(back.decode(units[0]).has_value());
  ASSERT_TRUE(back.decode(units[1]).has_value());
  back.reset();
  EXPECT_EQ(fault_of(back.decode(units[3])), Fault::Missing);
  ASSERT_TRUE(back.decode(unit_of(coder, drawn(kSize, 5), KeyFrame::Now)).has_value());
  const Image<Rgb8> next = drawn(kSize, 6);
  const auto decoded = back.decode(unit_of(coder, next));
  ASSERT_TRUE(decoded.has_value()) << decoded.error().what;
  EXPECT_GT(psnr_db(next, **decoded), 30.0);
}

TEST(Video, SamePicturesGiveTheSameBytes) {
  VideoEncoder a = encoder({kSize, 5'000'000, 72}), b = encoder({kSize, 5'000'000, 72});
  for (int frame = 0; frame < 20; ++frame) {
    const KeyFrame key = frame == 10 ? KeyFrame::Now : KeyFrame::IfNeeded;
    ASSERT_EQ(unit_of(a, drawn(kSize, frame), key), unit_of(b, drawn(kSize, frame), key)) << frame;
  }
}

TEST(Video, SizesThatAreNoMultipleOfABlockComeBack) {
  for (const Extent size : {Extent{32, 32}, Extent{34, 46}, Extent{70, 38}, Extent{1030, 34}}) {
    SCOPED_TRACE(size.width);
    VideoEncoder coder = encoder({size, 50'000'000, 72});
    VideoDecoder back = decoder();
    const Image<Rgb8> picture = drawn(size, 0);
    const auto decoded = back.decode(coder.encode(picture, KeyFrame::IfNeeded));
    ASSERT_TRUE(decoded.has_value()) << decoded.error().what;
    ASSERT_EQ((*decoded)->size, size);
    EXPECT_GT(psnr_db(picture, **decoded), 30.0);
  }
}

TEST(Video, TheDecoderFollowsANewSize) {
  VideoDecoder back = decoder();
  for (const Extent size : {Extent{64, 64}, Extent{128, 32}, Extent{64, 64}}) {
    VideoEncoder coder = encoder({size, 20'000'000, 72});
    const auto decoded = back.decode(coder.encode(drawn(size, 0), KeyFrame::IfNeeded));
    ASSERT_TRUE(decoded.has_value()) << decoded.error().what;
    EXPECT_EQ((*decoded)->size, size);
  }
}

TEST(Video, RefusesFormatsItCannotMake) {
  const auto fault = [](const VideoFormat& format) {
    const Expected<VideoEncoder> made = VideoEncoder::create(format);
    return made ? throw std::runtime_error("it was made") : made.error().fault;
  };
  for (const Extent size :
       {Extent{33, 64}, Extent{64, 33}, Extent{0, 0}, Extent{64, 30}, Extent{16386, 64}, Extent{64, 8194}})
    EXPECT_EQ(fault({size, 1'000'000, 72}), Fault::OutOfRange);
  EXPECT_EQ(fault({kSize, 0, 72}), Fault::OutOfRange);
  EXPECT_EQ(fault({kSize, 1'000'000, 0}), Fault::OutOfRange);
  EXPECT_EQ(fault({kSize, 1'000'000, std::nan("")}), Fault::OutOfRange);
}

// Damaged units: units come from the network.

/// A key frame and the frame after it, small enough to keep the tests below short.
struct TwoUnits {
  TwoUnits() {
    VideoEncoder coder = encoder({{64, 48}, 20'000'000, 72});
    key = unit_of(coder, drawn({64, 48}, 0));
    next = unit_of(coder, drawn({64, 48}, 1));
  }
  Unit key, next;
};

/// Arithmetic decoding reads on into the zeros after the end of a unit. So its last block may decode without
/// its bytes.
constexpr std::size_t kLastBlock_bytes = 32;

TEST(VideoDecoder, RefusesTruncations) {
  const TwoUnits units;
  VideoDecoder back = decoder();
  for (std::size_t length = 0; length < units.key.size(); ++length) {
    const auto decoded = back.decode(std::span(units.key).first(length));
    EXPECT_TRUE(!decoded || length + kLastBlock_bytes > units.key.size())
        << length << " of " << units.key.size();
  }
  for (std::size_t length = 0; length < units.next.size(); ++length) {
    ASSERT_TRUE(back.decode(units.key).has_value()) << "the decoder recovers";
    const auto decoded = back.decode(std::span(units.next).first(length));
    EXPECT_TRUE(!decoded || length + kLastBlock_bytes > units.next.size())
        << length << " of " << units.next.size();
  }
}

TEST(VideoDecoder, OutlivesDamageAndNoise) {
  constexpr std::uint64_t seed = 20'260;
  SCOPED_TRACE(seed);
  std::mt19937_64 random(seed);
  const TwoUnits units;
  VideoDecoder back = decoder();
  testing::internal::CaptureStderr();
  for (int round = 0; round < 2000; ++round) {
    Unit damaged = round % 2 == 0 ? units.key : units.next;
    const std::size_t hits = 1 + random() % 4;
    for (std::size_t hit = 0; hit < hits; ++hit) {
      // Parameter sets and slice headers are short and come first, so half of the damage goes there.
      const std::size_t reach =
          random() % 2 == 0 ? std::min<std::size_t>(64, damaged.size()) : damaged.size();
      damaged[random() % reach] = static_cast<std::byte>(random());
    }
    if (round % 16 == 0)
      for (std::byte& byte : damaged) byte = static_cast<std::byte>(random());
    const auto decoded = back.decode(damaged);
    ASSERT_TRUE(!decoded || (*decoded)->pixels.size() == (*decoded)->size.pixels());
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "") << "libav prints nothing for damaged units, either";
  back.reset();
  EXPECT_TRUE(back.decode(units.key).has_value());
  EXPECT_TRUE(back.decode(units.next).has_value());
}

// Both eyes are in one picture.

TEST(SideBySide, GivesBothEyesBack) {
  for (const Extent eye : {Extent{32, 32}, Extent{33, 17}, Extent{1, 1}, Extent{4, 5}}) {
    const PerEye<Image<Rgb8>> eyes{drawn(eye, 0), drawn(eye, 7)};
    const Image<Rgb8> picture = side_by_side(eyes);
    EXPECT_EQ(picture.size, side_by_side_size(eye));
    EXPECT_EQ(picture.size.width % 4 + picture.size.height % 2, 0u) << "no colour is shared between eyes";
    EXPECT_EQ(two_eyes(picture, eye), eyes);
  }
}

TEST(SideBySide, PadsAnOddSideWithItsLastPixelsAgain) {
  const PerEye<Image<Rgb8>> eyes{drawn({33, 17}, 0), drawn({33, 17}, 7)};
  const Image<Rgb8> picture = side_by_side(eyes);
  ASSERT_EQ(picture.size, (Extent{68, 18}));
  EXPECT_EQ(picture.at(33, 5), eyes[0].at(32, 5));
  EXPECT_EQ(picture.at(34, 5), eyes[1].at(0, 5));
  EXPECT_EQ(picture.at(67, 17), eyes[1].at(32, 16));
}

}  // namespace
}  // namespace farshade
