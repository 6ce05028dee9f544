#include "vr_client/report/pictures.h"

#include <gtest/gtest.h>

#include <set>

#include "stereo/image/codec.h"
#include "tests/unit/scratch_folder.h"

namespace farshade {
namespace {

using namespace std::chrono_literals;

int brightness(Rgb8 color) {
  return color.r + color.g + color.b;
}

/// One pixel a source, one light, nothing stale.
ShownReport report_of(const std::vector<std::uint8_t>& sources) {
  const Extent size{static_cast<std::uint32_t>(sources.size()), 1};
  return {.mask = EyeMask(size, 1),
          .sources = sources,
          .positions = {},
          .visibility = std::vector<std::uint8_t>(sources.size()),
          .unknown = std::vector<std::uint32_t>(sources.size()),
          .stale = std::vector<std::uint32_t>(sources.size()),
          .beside = std::vector<std::uint32_t>(sources.size())};
}

/// One pixel a source, all masks of `age`.
Image<Rgb8> sources_drawn(const std::vector<std::uint8_t>& sources, Duration age) {
  const Extent size{static_cast<std::uint32_t>(sources.size()), 1};
  return source_picture(report_of(sources), MaskAges(ShadingPass::kMaxMasks, age), size);
}

TEST(SourcePicture, TellsEverySourceApart) {
  const Image<Rgb8> picture =
      sources_drawn({0, 1, kOtherEye, kNeighbour, kOtherEye + 1, kSourceUnknown, kSourceUncovered}, 0ms);
  EXPECT_EQ(picture.at(0, 0), Rgb8(60, 220, 90)) << "this eye's newest";
  EXPECT_EQ(picture.at(1, 0).b, 255) << "an older one";
  EXPECT_EQ(picture.at(2, 0), Rgb8(60, 210, 230)) << "the other eye's newest";
  EXPECT_EQ(picture.at(3, 0), Rgb8(240, 230, 60)) << "the nearest pixel on the same surface";
  EXPECT_EQ(picture.at(4, 0), picture.at(1, 0)) << "older is older, whichever eye's";
  EXPECT_EQ(picture.at(5, 0), Rgb8(255, 140, 0));
  EXPECT_EQ(picture.at(6, 0), Rgb8(0));
}

TEST(SourcePicture, TintsWhatIsStaleInAnyPlane) {
  ShownReport report = report_of({0, 0, 0});
  report.stale = {0, 0, 1, 0, 0, 1u << 7};  // two planes a pixel
  const Image<Rgb8> picture = source_picture(report, {0ms}, {3, 1});
  EXPECT_EQ(picture.at(0, 0), Rgb8(60, 220, 90));
  EXPECT_EQ(picture.at(1, 0), Rgb8(255, 220, 90));
  EXPECT_EQ(picture.at(2, 0), Rgb8(255, 220, 90));
}

TEST(SourcePicture, EveryMaskInHandHasItsOwnColor) {
  std::vector<std::uint8_t> all;
  for (std::size_t i = 0; i < ShadingPass::kMaxMasks; ++i) all.push_back(static_cast<std::uint8_t>(i));
  const Image<Rgb8> picture = sources_drawn(all, 0ms);
  std::set<std::array<int, 3>> colors;
  for (const Rgb8 color : picture.pixels) colors.insert({color.r, color.g, color.b});
  EXPECT_EQ(colors.size(), all.size());
  for (std::uint32_t i = 2; i < all.size(); ++i) EXPECT_GT(picture.at(i, 0).r, picture.at(i - 1, 0).r);
}

TEST(SourcePicture, DarkensWithAgeToBlack) {
  for (const std::uint8_t source : std::array<std::uint8_t, 2>{0, 1}) {
    int last = 1000;
    for (const Duration age : {0ms, 100ms, 300ms, 490ms}) {
      const int now = brightness(sources_drawn({source}, age).at(0, 0));
      EXPECT_LT(now, last);
      last = now;
    }
    EXPECT_EQ(brightness(sources_drawn({source}, kOldestDrawn).at(0, 0)), 0);
    EXPECT_EQ(brightness(sources_drawn({source}, 10s).at(0, 0)), 0);
  }
}

TEST(WriteMeasured, WritesEveryPictureItPromises) {
  const ScratchFolder folder;
  const Extent size{5, 4};
  const ShownReport report = report_of(std::vector<std::uint8_t>(size.pixels(), 0));
  const MeasuredFrame frame{.frame = {12},
                            .shown = {Image<Rgb8>(size, Rgb8(10)), Image<Rgb8>(size, Rgb8(20))},
                            .reference = {Image<Rgb8>(size, Rgb8(11)), Image<Rgb8>(size, Rgb8(20))},
                            .report = {report, report},
                            .ages = {0ms}};
  ASSERT_TRUE(write_measured(folder.path(), frame).has_value());
  for (const std::string eye : {"left", "right"})
    for (const std::string what : {"shown", "reference", "difference_x8", "source"})
      EXPECT_EQ(read_png(folder.path() / ("worst_0012_" + eye + "_" + what + ".png"))->size, size);
  EXPECT_EQ(*read_png(folder.path() / "worst_0012_left_difference_x8.png"), Image<Rgb8>(size, Rgb8(8)));
  const Image<Rgb8> sheet = *read_png(folder.path() / "worst.png");
  EXPECT_EQ(sheet.size, (Extent{4 * 5 + 3 * 2, 2 * 4 + 2}));
  EXPECT_EQ(sheet.at(0, 0), Rgb8(10));
  EXPECT_EQ(sheet.at(7, 0), Rgb8(11));
  EXPECT_EQ(sheet.at(0, 6), Rgb8(20)) << "the right eye is below";
}

TEST(WriteShown, RefusesAFolderThatIsNotThere) {
  const ScratchFolder folder;
  const PerEye<Image<Rgb8>> shown{Image<Rgb8>({2, 2}), Image<Rgb8>({2, 2})};
  EXPECT_FALSE(write_shown(folder.path() / "none", {1}, shown).has_value());
}

}  // namespace
}  // namespace farshade
