#include "stereo/image/codec.h"

#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <limits>
#include <random>

#include "stereo/base/files.h"
#include "tests/support/image_reader.h"
#include "tests/unit/image/image_files.h"
#include "tests/unit/image/webp_files.h"
#include "tests/unit/scratch_folder.h"

namespace farshade {
namespace {

constexpr std::uint64_t kLimit = 1 << 20;

std::vector<std::byte> bytes_of(const std::filesystem::path& path) {
  return read_file(path, kLimit).value();
}

Image<Rgb8> random_picture(Extent size, std::uint32_t seed) {
  std::mt19937 random(seed);
  Image<Rgb8> image(size);
  for (Rgb8& p : image.pixels) p = Rgb8(random() & 255, random() & 255, random() & 255);
  return image;
}

TEST(PngCodec, ReturnsWhatWasWritten) {
  const ScratchFolder folder;
  const auto image = random_picture({37, 11}, 1);
  ASSERT_TRUE(write_png(folder.path() / "a.png", image));
  EXPECT_EQ(read_png(folder.path() / "a.png").value(), image);
  const auto rgba = decode_image(bytes_of(folder.path() / "a.png"), kLimit).value();
  EXPECT_EQ(rgba.at(36, 10), Rgba8(image.at(36, 10), 255));
}

TEST(PngCodec, Returns16BitWhatWasWritten) {
  const ScratchFolder folder;
  Image<std::uint16_t> image({3, 2});
  image.pixels = {0, 1, 0x0102, 0xff00, 0x00ff, 0xffff};
  ASSERT_TRUE(write_png16(folder.path() / "a.png", image));
  EXPECT_EQ(read_png16(folder.path() / "a.png").value(), image);
  const auto eight_bits = decode_image(bytes_of(folder.path() / "a.png"), kLimit).value();
  EXPECT_EQ(eight_bits.at(0, 1), Rgba8(254, 254, 254, 255));  // 0xff00: the file's high byte comes first
}

TEST(PngCodec, Refuses8BitWhere16AreExpected) {
  const ScratchFolder folder;
  ASSERT_TRUE(write_png(folder.path() / "a.png", random_picture({4, 4}, 2)));
  EXPECT_EQ(read_png16(folder.path() / "a.png").error().fault, Fault::Unsupported);
}

TEST(PngCodec, RefusesRowTooMany) {
  const auto image = decode_image(make_png_with_extra_row(), kLimit);
  ASSERT_FALSE(image);
  EXPECT_EQ(image.error().fault, Fault::Malformed);
}

TEST(PngCodec, DoesNotUnpackTexts) {
  const auto image = decode_image(make_png_with_faulty_text(), kLimit);
  ASSERT_TRUE(image) << image.error().what;
  EXPECT_EQ(image->at(0, 0), Rgba8(77, 77, 77, 255));
}

struct PngKind {
  const char* name;
  int bits, color;
  std::vector<std::uint8_t> rows;  // two rows of two pixels, as the file has them
  std::vector<Rgba8> pixels;       // the expected pixels
};

class PngKinds : public testing::TestWithParam<PngKind> {};

TEST_P(PngKinds, BecomeRgba8) {
  const PngKind& kind = GetParam();
  const auto image = decode_image(make_png({2, 2}, kind.bits, kind.color, kind.rows), kLimit);
  ASSERT_TRUE(image) << image.error().what;
  EXPECT_EQ(image->pixels, kind.pixels);
}

// Palette of make_png: red, green (alpha 128), blue, white.
INSTANTIATE_TEST_SUITE_P(
    PngCodec, PngKinds,
    testing::Values(PngKind{"grey8",
                            8,
                            0,
                            {0, 255, 7, 8},
                            {{0, 0, 0, 255}, {255, 255, 255, 255}, {7, 7, 7, 255}, {8, 8, 8, 255}}},
                    PngKind{"grey1",
                            1,
                            0,
                            {0b01000000, 0b10000000},
                            {{0, 0, 0, 255}, {255, 255, 255, 255}, {255, 255, 255, 255}, {0, 0, 0, 255}}},
                    PngKind{"grey16",
                            16,
                            0,
                            {0, 0, 255, 255, 128, 128, 0, 255},
                            {{0, 0, 0, 255}, {255, 255, 255, 255}, {128, 128, 128, 255}, {1, 1, 1, 255}}},
                    PngKind{"grey_alpha",
                            8,
                            4,
                            {1, 2, 3, 4, 5, 6, 7, 0},
                            {{1, 1, 1, 2}, {3, 3, 3, 4}, {5, 5, 5, 6}, {7, 7, 7, 0}}},
                    PngKind{"palette",
                            8,
                            3,
                            {0, 1, 2, 3},
                            {{255, 0, 0, 255}, {0, 255, 0, 128}, {0, 0, 255, 255}, {255, 255, 255, 255}}},
                    PngKind{"palette2",
                            2,
                            3,
                            {0b00010000, 0b10110000},
                            {{255, 0, 0, 255}, {0, 255, 0, 128}, {0, 0, 255, 255}, {255, 255, 255, 255}}},
                    PngKind{"rgba",
                            8,
                            6,
                            {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16},
                            {{1, 2, 3, 4}, {5, 6, 7, 8}, {9, 10, 11, 12}, {13, 14, 15, 16}}}),
    [](const auto& kind) { return std::string(kind.param.name); });

TEST(JpegCodec, DecodesColourAndGrey) {
  const auto colour = decode_image(make_jpeg({40, 24}, JpegKind::Colour), kLimit);
  ASSERT_TRUE(colour) << colour.error().what;
  EXPECT_EQ(colour->size, (Extent{40, 24}));
  const Rgba8 p = colour->at(20, 12);  // drawn as (200, 100, 50), quality 95
  EXPECT_NEAR(p.r, 200, 4);
  EXPECT_NEAR(p.g, 100, 4);
  EXPECT_NEAR(p.b, 50, 4);
  EXPECT_EQ(p.a, 255);
  const auto grey = decode_image(make_jpeg({40, 24}, JpegKind::Grey), kLimit);
  ASSERT_TRUE(grey) << grey.error().what;
  EXPECT_EQ(grey->at(3, 3), Rgba8(200, 200, 200, 255));
}

TEST(JpegCodec, RefusesCmyk) {
  EXPECT_EQ(decode_image(make_jpeg({16, 16}, JpegKind::Cmyk), kLimit).error().fault, Fault::Unsupported);
}

TEST(JpegCodec, RefusesManyScans) {
  const auto file = make_jpeg({16, 16}, JpegKind::ManyScans);
  const auto image = decode_image(file, kLimit);
  ASSERT_FALSE(image);
  EXPECT_NE(image.error().what.find("scans"), std::string::npos) << image.error().what;
}

TEST(WebpCodec, ReturnsWhatWasWritten) {
  Image<Rgba8> image({37, 11});
  std::mt19937 random(4);
  for (Rgba8& p : image.pixels)
    p = Rgba8(random() & 255, random() & 255, random() & 255, 1 + (random() & 127));
  const auto back = decode_image(make_webp(image), kLimit);
  ASSERT_TRUE(back) << back.error().what;
  EXPECT_EQ(*back, image);
}

TEST(WebpCodec, ReadsLossyPictures) {
  Image<Rgba8> image({40, 24});
  image.pixels.assign(image.pixels.size(), Rgba8(200, 100, 50, 255));
  const Rgba8 p = decode_image(make_webp(image, WebpKind::Lossy), kLimit).value().at(20, 12);
  EXPECT_NEAR(p.r, 200, 4);
  EXPECT_NEAR(p.g, 100, 4);
  EXPECT_NEAR(p.b, 50, 4);
  EXPECT_EQ(p.a, 255);
}

TEST(WebpCodec, ChecksTheSizeInTheHeaderFirst) {
  auto file = make_noise_webp({8, 8});
  ASSERT_EQ(std::memcmp(file.data() + 12, "VP8L", 4), 0);
  file[21] = file[22] = file[23] = std::byte{0xff};  // 16384 x 16384
  file[24] = std::byte{0x0f};
  const auto image = decode_image(file, kLimit);
  EXPECT_EQ(image.error().fault, Fault::OutOfRange) << image.error().what;
}

TEST(WebpCodec, RefusesAnimations) {
  const std::string head("RIFF\x16\x01\0\0WEBPVP8X\x0a\0\0\0\x02\0\0\0\x07\0\0\x07\0\0", 30);
  std::vector<std::byte> file(300);
  std::memcpy(file.data(), head.data(), head.size());
  const auto image = decode_image(file, kLimit);
  EXPECT_EQ(image.error().fault, Fault::Unsupported) << image.error().what;
}

TEST(DecodeImage, RefusesOtherFiles) {
  EXPECT_EQ(decode_image({}, kLimit).error().fault, Fault::Unsupported);
  const std::vector<std::byte> gif(100, std::byte{'G'});
  EXPECT_EQ(decode_image(gif, kLimit).error().fault, Fault::Unsupported);
}

TEST(DecodeImage, RefusesMorePixelsThanAllowed) {
  for (const auto& file :
       {make_noise_png({32, 32}), make_jpeg({32, 32}, JpegKind::Colour), make_noise_webp({32, 32})}) {
    EXPECT_TRUE(decode_image(file, 1024));
    EXPECT_EQ(decode_image(file, 1023).error().fault, Fault::OutOfRange);
  }
}

TEST(DecodeImage, RefusesSizeThatItsFileCannotFill) {
  auto file = make_png({2'000, 500}, 8, 6, {});
  file.resize(200);
  const auto image = decode_image(file, kLimit);
  ASSERT_FALSE(image);
  EXPECT_NE(image.error().what.find("too short"), std::string::npos) << image.error().what;
}

/// One file of each kind; the tests damage them.
std::vector<std::vector<std::byte>> sample_files() {
  return {make_noise_png({9, 7}), make_png({2, 2}, 8, 3, {0, 1, 2, 3}), make_jpeg({40, 24}, JpegKind::Colour),
          make_jpeg({40, 24}, JpegKind::Progressive), make_noise_webp({9, 7})};
}

TEST(DecodeImage, RefusesEveryTruncation) {
  for (const auto& file : sample_files()) {
    ASSERT_TRUE(decode_image(file, kLimit));
    for (std::size_t length = 0; length < file.size(); ++length) {
      const std::vector<std::byte> cut(file.begin(), file.begin() + static_cast<std::ptrdiff_t>(length));
      EXPECT_FALSE(decode_image(cut, kLimit)) << "cut to " << length << " of " << file.size();
    }
  }
}

TEST(DecodeImage, SurvivesEveryFlippedBit) {
  for (const auto& file : sample_files())
    for (std::size_t bit = 0; bit < 8 * file.size(); ++bit) {
      auto harmed = file;
      harmed[bit / 8] ^= std::byte{1} << (bit % 8);
      const auto image = decode_image(harmed, kLimit);
      if (image) {
        EXPECT_EQ(image->pixels.size(), image->size.pixels());
      }
    }
}

TEST(Pfm, IsLittleEndianBottomRowFirst) {
  const ScratchFolder folder;
  Image<float> image({2, 2});
  image.pixels = {1.5f, -2.0f, std::numeric_limits<float>::infinity(), 0.25f};
  ASSERT_TRUE(write_pfm(folder.path() / "a.pfm", image));
  const auto file = bytes_of(folder.path() / "a.pfm");
  const std::string header = "Pf\n2 2\n-1.0\n";
  ASSERT_EQ(file.size(), header.size() + 16);
  EXPECT_EQ(std::memcmp(file.data(), header.data(), header.size()), 0);
  std::array<float, 4> in_file;
  std::memcpy(in_file.data(), file.data() + header.size(), 16);
  EXPECT_EQ(in_file, (std::array{image.pixels[2], image.pixels[3], image.pixels[0], image.pixels[1]}));
  EXPECT_EQ(read_pfm(folder.path() / "a.pfm").value(), image);
}

TEST(Pfm, RefusesFaultyFiles) {
  const ScratchFolder folder;
  const auto read_back = [&](std::string_view text) {
    EXPECT_TRUE(write_file_atomically(folder.path() / "a.pfm", text));
    return read_pfm(folder.path() / "a.pfm");
  };
  using namespace std::string_view_literals;
  EXPECT_TRUE(read_back("Pf\n1 1\n-1.0\n\0\0\0\0"sv));
  for (const auto text :
       {""sv, "Pf"sv, "PF\n1 1\n-1.0\n"sv, "Pf\n1 1\n1.0\n\0\0\0\0"sv, "Pf\n1 1\n-1.0\n\0\0\0"sv,
        "Pf\n1 1\n-1.0\n\0\0\0\0\0"sv, "Pf\n0 1\n-1.0\n"sv, "Pf\n-1 1\n-1.0\n\0\0\0\0"sv,
        "Pf\n4000000000 4000000000\n-1.0\n"sv, "Pf\n1 1\nnan\n\0\0\0\0"sv})
    EXPECT_FALSE(read_back(text)) << text;
}

TEST(ImageFiles, NamePathAndReasonOnFailure) {
  const ScratchFolder folder;
  const auto nowhere = folder.path() / "none" / "a.png";
  const auto written = write_png(nowhere, random_picture({2, 2}, 3));
  ASSERT_FALSE(written);
  EXPECT_NE(written.error().what.find(nowhere.string()), std::string::npos);
  EXPECT_NE(written.error().what.find("No such file"), std::string::npos);
  EXPECT_EQ(read_png(nowhere).error().fault, Fault::Missing);
  ASSERT_TRUE(write_file_atomically(folder.path() / "b.png", "text"));
  EXPECT_NE(read_png(folder.path() / "b.png").error().what.find("b.png"), std::string::npos);
  EXPECT_FALSE(write_png(folder.path() / "empty.png", Image<Rgb8>{}));
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "empty.png"));
}

}  // namespace
}  // namespace farshade
