#include "stereo/video/video.h"

#include <gtest/gtest.h>
#include <malloc.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <iostream>
#include <optional>
#include <random>

#include "stereo/image/difference.h"
#include "stereo/video/video_unit.h"

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

std::unique_ptr<VideoEncoder> encoder(const VideoFormat& format) {
  auto made = VideoEncoder::create(format);
  if (!made) throw std::runtime_error(made.error().what);
  return std::move(*made);
}

std::unique_ptr<VideoDecoder> decoder() {
  auto made = VideoDecoder::create();
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
    const auto coder = encoder({kSize, 50'000'000, 72});
    const auto back = decoder();
    testing::internal::CaptureStderr();
    for (int frame = 0; frame < 12; ++frame) {
      const Image<Rgb8> picture = coloured ? drawn(kSize, frame) : grey(drawn(kSize, frame));
      const auto decoded = back->decode(coder->encode(picture, KeyFrame::IfNeeded), kSize);
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
    const auto coder = encoder({kSize, 50'000'000, 72});
    const auto back = decoder();
    const auto decoded = back->decode(coder->encode(Image<Rgb8>(kSize, colour), KeyFrame::IfNeeded), kSize);
    ASSERT_TRUE(decoded.has_value());
    for (const std::uint32_t x : {0u, kSize.width / 2, kSize.width - 1})
      for (int channel = 0; channel < 3; ++channel)
        EXPECT_NEAR((*decoded)->at(x, kSize.height - 1)[channel], colour[channel], 3);
  }
}

TEST(Video, KeepsToTheBitRate) {
  for (const std::uint32_t rate : {1'500'000u, 5'000'000u}) {
    constexpr int frames = 60;
    const auto coder = encoder({kSize, rate, 72});
    std::size_t bytes = 0, largest = 0;
    for (const Unit& unit : units_of(*coder, frames)) {
      bytes += unit.size();
      largest = std::max(largest, unit.size());
    }
    const double share_bytes = rate / 72.0 / 8;
    EXPECT_NEAR(static_cast<double>(bytes), share_bytes * frames, 0.15 * share_bytes * frames);
    EXPECT_LT(static_cast<double>(largest), 4 * share_bytes);
  }
}

TEST(Video, KeyFrameIsDecodedWithoutEarlierPictures) {
  const auto coder = encoder({kSize, 20'000'000, 72});
  const std::vector<Unit> units = units_of(*coder, 3);
  const Image<Rgb8> picture = drawn(kSize, 3);
  const Unit key = unit_of(*coder, picture, KeyFrame::Now);
  const auto late = decoder();
  EXPECT_EQ(fault_of(late->decode(units[1], kSize)), Fault::Missing);
  EXPECT_EQ(fault_of(late->decode(units[2], kSize)), Fault::Missing);
  const auto decoded = late->decode(key, kSize);
  ASSERT_TRUE(decoded.has_value()) << decoded.error().what;
  EXPECT_GT(psnr_db(picture, **decoded), 30.0);
}

TEST(Video, AfterAResetOnlyAKeyFrameIsDecoded) {
  const auto coder = encoder({kSize, 20'000'000, 72});
  const std::vector<Unit> units = units_of(*coder, 5);
  const auto back = decoder();
  ASSERT_TRUE(back->decode(units[0], kSize).has_value());
  ASSERT_TRUE(back->decode(units[1], kSize).has_value());
  back->reset();
  EXPECT_EQ(fault_of(back->decode(units[3], kSize)), Fault::Missing);
  ASSERT_TRUE(back->decode(unit_of(*coder, drawn(kSize, 5), KeyFrame::Now), kSize).has_value());
  const Image<Rgb8> next = drawn(kSize, 6);
  const auto decoded = back->decode(unit_of(*coder, next), kSize);
  ASSERT_TRUE(decoded.has_value()) << decoded.error().what;
  EXPECT_GT(psnr_db(next, **decoded), 30.0);
}

// Losses: the intra refresh heals them without a key frame.

/// The places at which NAL units begin.
std::vector<std::size_t> nal_units(const Unit& unit) {
  constexpr std::array start{std::byte{0}, std::byte{0}, std::byte{1}};
  std::vector<std::size_t> places;
  for (auto at = unit.begin(); (at = std::search(at, unit.end(), start.begin(), start.end())) != unit.end();
       at += start.size())
    places.push_back(static_cast<std::size_t>(at - unit.begin()));
  return places;
}

/// The unit with zeros in place of one of its NAL units.
Unit without(Unit unit, std::size_t nal_unit) {
  const std::vector<std::size_t> places = nal_units(unit);
  const std::size_t end = nal_unit + 1 < places.size() ? places[nal_unit + 1] : unit.size();
  std::fill(unit.begin() + static_cast<std::ptrdiff_t>(places.at(nal_unit)),
            unit.begin() + static_cast<std::ptrdiff_t>(end), std::byte{0});
  return unit;
}

/// Codes the drawn scene. One decoder gets all units, another one what `received` makes of unit kLost.
/// Returns the PSNR between both decoders' pictures, for each unit from the lost one on.
constexpr int kLost = 30;
std::vector<double> damage_dB(const std::function<std::optional<Unit>(const Unit&)>& received) {
  const auto coder = encoder({kSize, 8'000'000, 72, 400});
  const auto whole = decoder(), lossy = decoder();
  std::vector<double> psnr;
  for (int frame = 0; frame < kLost + 3 * static_cast<int>(kRefresh_pictures); ++frame) {
    const Unit sent = unit_of(*coder, drawn(kSize, frame));
    const Image<Rgb8> truth = **whole->decode(sent, kSize);
    const std::optional<Unit> unit = frame == kLost ? received(sent) : sent;
    if (!unit) continue;
    const auto decoded = lossy->decode(*unit, kSize);
    if (!decoded) throw std::runtime_error(decoded.error().what);
    if (frame >= kLost) psnr.push_back(psnr_db(truth, **decoded));
  }
  return psnr;
}

/// The number of pictures after which all are whole.
std::size_t healed_after(const std::vector<double>& psnr) {
  const auto last = std::find_if(psnr.rbegin(), psnr.rend(), [](double dB) { return dB < 60; });
  return static_cast<std::size_t>(psnr.rend() - last);
}

void print(const char* lost, const std::vector<double>& psnr) {
  std::cout << "a lost " << lost << " is healed after " << healed_after(psnr) << " pictures; PSNR in dB:";
  for (std::size_t i = 0; i < healed_after(psnr); i += 4) std::cout << ' ' << std::lround(psnr[i]);
  std::cout << '\n';
}

TEST(VideoRefresh, HealsALostUnitWithinTwoPasses) {
  const std::vector<double> psnr = damage_dB([](const Unit&) { return std::nullopt; });
  print("picture", psnr);
  EXPECT_LT(psnr[0], 40) << "it is damaged first";
  EXPECT_GT(*std::ranges::min_element(psnr), 15) << "but shows the scene";
  EXPECT_LE(healed_after(psnr), 2 * kRefresh_pictures);
}

TEST(VideoRefresh, HealsALostSliceWithinTwoPasses) {
  for (const std::size_t slice : {1u, 4u}) {
    const std::vector<double> psnr = damage_dB([&](const Unit& unit) {
      EXPECT_GT(nal_units(unit).size(), 6u);
      return without(unit, slice);
    });
    print("slice", psnr);
    EXPECT_LT(psnr[0], 60) << "it is damaged first";
    EXPECT_GT(*std::ranges::min_element(psnr), 20) << "a small part of the picture";
    EXPECT_LE(healed_after(psnr), 2 * kRefresh_pictures);
  }
}

TEST(VideoRefresh, NeedsNoKeyFrames) {
  const auto coder = encoder({kSize, 5'000'000, 72});
  const auto late = decoder();
  const std::vector<Unit> units = units_of(*coder, 3 * kRefresh_pictures);
  for (std::size_t i = 1; i < units.size(); ++i)
    ASSERT_EQ(fault_of(late->decode(units[i], kSize)), Fault::Missing) << i << " is a key frame";
}

TEST(VideoRefresh, SaysWhatWasConcealed) {
  const auto coder = encoder({kSize, 8'000'000, 72, 400});
  const auto back = decoder();
  const std::vector<Unit> units = units_of(*coder, 3);
  ASSERT_TRUE(back->decode(units[0], kSize).has_value());
  EXPECT_FALSE(back->concealed());
  ASSERT_TRUE(back->decode(without(units[1], 2), kSize).has_value());
  EXPECT_TRUE(back->concealed());
  ASSERT_TRUE(back->decode(units[2], kSize).has_value());
  EXPECT_FALSE(back->concealed());
}

TEST(Video, SlicesAreNoLargerThanAsked) {
  for (const std::uint32_t most : {300u, 1'084u}) {
    const auto coder = encoder({kSize, 20'000'000, 72, most});
    for (const Unit& unit : units_of(*coder, 8)) {
      std::vector<std::size_t> places = nal_units(unit);
      EXPECT_GT(places.size(), 3u);
      places.push_back(unit.size());
      // The first key frame begins with parameter sets and the encoder's settings.
      for (std::size_t i = 0; i + 1 < places.size(); ++i) {
        const bool is_settings = (unit[places[i] + 3] & std::byte{0x1f}) == std::byte{6};
        EXPECT_TRUE(is_settings || places[i + 1] - places[i] <= most) << i;
      }
    }
  }
}

TEST(Video, SamePicturesGiveTheSameBytes) {
  const auto a = encoder({kSize, 5'000'000, 72}), b = encoder({kSize, 5'000'000, 72});
  for (int frame = 0; frame < 20; ++frame) {
    const KeyFrame key = frame == 10 ? KeyFrame::Now : KeyFrame::IfNeeded;
    ASSERT_EQ(unit_of(*a, drawn(kSize, frame), key), unit_of(*b, drawn(kSize, frame), key)) << frame;
  }
}

TEST(Video, SizesThatAreNoMultipleOfABlockComeBack) {
  for (const Extent size : {Extent{32, 32}, Extent{34, 46}, Extent{70, 38}, Extent{1030, 34}}) {
    SCOPED_TRACE(size.width);
    const auto coder = encoder({size, 50'000'000, 72});
    const auto back = decoder();
    const Image<Rgb8> picture = drawn(size, 0);
    const auto decoded = back->decode(coder->encode(picture, KeyFrame::IfNeeded), size);
    ASSERT_TRUE(decoded.has_value()) << decoded.error().what;
    ASSERT_EQ((*decoded)->size, size);
    EXPECT_GT(psnr_db(picture, **decoded), 30.0);
  }
}

TEST(Video, TheDecoderFollowsANewSize) {
  const auto back = decoder();
  for (const Extent size : {Extent{64, 64}, Extent{128, 32}, Extent{64, 64}}) {
    const auto coder = encoder({size, 20'000'000, 72});
    const auto decoded = back->decode(coder->encode(drawn(size, 0), KeyFrame::IfNeeded), size);
    ASSERT_TRUE(decoded.has_value()) << decoded.error().what;
    EXPECT_EQ((*decoded)->size, size);
  }
}

TEST(Video, RefusesFormatsItCannotMake) {
  const auto fault = [](const VideoFormat& format) {
    const auto made = VideoEncoder::create(format);
    return made ? throw std::runtime_error("it was made") : made.error().fault;
  };
  for (const Extent size :
       {Extent{33, 64}, Extent{64, 33}, Extent{0, 0}, Extent{64, 30}, Extent{16386, 64}, Extent{64, 8194}})
    EXPECT_EQ(fault({size, 1'000'000, 72}), Fault::OutOfRange);
  EXPECT_EQ(fault({kSize, 0, 72}), Fault::OutOfRange);
  EXPECT_EQ(fault({kSize, 1'000'000, 0}), Fault::OutOfRange);
  EXPECT_EQ(fault({kSize, 1'000'000, std::nan("")}), Fault::OutOfRange);
  EXPECT_EQ(fault({kSize, 1'000'000, 72, 199}), Fault::OutOfRange);
}

// Damaged units: units come from the network.

/// A key frame and the frame after it, small enough to keep the tests below short.
struct TwoUnits {
  TwoUnits() {
    const auto coder = encoder({{64, 48}, 20'000'000, 72, 300});
    key = unit_of(*coder, drawn({64, 48}, 0));
    next = unit_of(*coder, drawn({64, 48}, 1));
  }
  Unit key, next;
};

/// What comes of a unit whose end is lost. Arithmetic decoding reads on into the zeros after the end, so it
/// may not notice that a slice is cut. It notices that slices are missing.
TEST(VideoDecoder, RefusesOrConcealsTruncations) {
  const TwoUnits units;
  const auto back = decoder();
  const auto is_fine = [&](const Unit& unit, std::size_t length) {
    const auto decoded = back->decode(std::span(unit).first(length), Extent{64, 48});
    if (!decoded) return true;
    return (*decoded)->size == Extent{64, 48} &&
           (back->concealed() || std::ranges::count(nal_units(unit), length) == 0);
  };
  ASSERT_GT(nal_units(units.next).size(), 3u);
  for (std::size_t length = 0; length < units.key.size(); ++length)
    EXPECT_TRUE(is_fine(units.key, length)) << length << " of " << units.key.size();
  for (std::size_t length = 0; length < units.next.size(); ++length) {
    ASSERT_TRUE(back->decode(units.key, Extent{64, 48}).has_value()) << "the decoder recovers";
    EXPECT_FALSE(back->concealed());
    EXPECT_TRUE(is_fine(units.next, length)) << length << " of " << units.next.size();
  }
}

/// The first key frame announces its size in about 30 bytes.
TEST(VideoDecoder, RefusesAPictureThatWasNotAskedForBeforeItIsDecoded) {
  const auto huge = encoder({{4096, 2048}, 20'000'000, 72});
  const Unit unit = unit_of(*huge, Image<Rgb8>({4096, 2048}));
  const auto back = decoder();
  const std::size_t before = mallinfo2().uordblks + mallinfo2().hblkhd;
  EXPECT_EQ(fault_of(back->decode(unit, kSize)), Fault::OutOfRange);
  EXPECT_LT(mallinfo2().uordblks + mallinfo2().hblkhd, before + (std::size_t{1} << 20)) << "bytes";
  const auto coder = encoder({kSize, 20'000'000, 72});
  EXPECT_TRUE(back->decode(unit_of(*coder, drawn(kSize, 0)), kSize).has_value());
}

TEST(VideoDecoder, RefusesAUnitWhoseSlicesComeAgainAndAgain) {
  const auto coder = encoder({kSize, 20'000'000, 72});
  Unit unit = unit_of(*coder, drawn(kSize, 0));
  EXPECT_TRUE(examine_unit(unit, kSize)->holds_key_frame);
  EXPECT_FALSE(examine_unit(unit_of(*coder, drawn(kSize, 1)), kSize)->holds_key_frame);
  const std::size_t last = nal_units(unit).back();
  unit.insert(unit.end(), unit.begin() + static_cast<std::ptrdiff_t>(last), unit.end());
  const auto back = decoder();
  EXPECT_EQ(fault_of(back->decode(unit, kSize)), Fault::Malformed);
}

TEST(VideoDecoder, OutlivesDamageAndNoise) {
  constexpr std::uint64_t seed = 20'260;
  SCOPED_TRACE(seed);
  std::mt19937_64 random(seed);
  const TwoUnits units;
  const auto back = decoder();
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
    const auto decoded = back->decode(damaged, Extent{64, 48});
    ASSERT_TRUE(!decoded || (*decoded)->pixels.size() == (*decoded)->size.pixels());
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "") << "libav prints nothing for damaged units, either";
  back->reset();
  EXPECT_TRUE(back->decode(units.key, Extent{64, 48}).has_value());
  EXPECT_TRUE(back->decode(units.next, Extent{64, 48}).has_value());
}

/// Losses as a network makes them, among them slices of the first key frame and whole key frames of new
/// sizes.
TEST(VideoDecoder, OutlivesLossesOfSlicesAndSizes) {
  constexpr std::uint64_t seed = 7'201;
  SCOPED_TRACE(seed);
  std::mt19937_64 random(seed);
  const auto back = decoder();
  int pictures = 0;
  for (const Extent size : {Extent{128, 64}, Extent{160, 96}, Extent{96, 96}, Extent{128, 64}}) {
    const auto coder = encoder({size, 20'000'000, 72, 300});
    for (int frame = 0; frame < 40; ++frame) {
      Unit unit = unit_of(*coder, drawn(size, frame), frame % 16 == 15 ? KeyFrame::Now : KeyFrame::IfNeeded);
      if (random() % 8 == 0) continue;
      const std::uint64_t most = random() % 3 == 0 ? nal_units(unit).size() - 1 : 2;
      for (std::uint64_t lost = random() % (most + 1); lost > 0; --lost)
        unit = without(unit, random() % nal_units(unit).size());
      const auto decoded = back->decode(unit, size);
      if (!decoded) continue;
      ++pictures;
      ASSERT_EQ((*decoded)->size, size);
      ASSERT_EQ((*decoded)->pixels.size(), size.pixels());
    }
  }
  EXPECT_GT(pictures, 60);  // while the key frame of a new size is missing, there is none
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
