#include "vr_client/report/picture_sheet.h"
#include "vr_client/report/run_report.h"

#include <gtest/gtest.h>

#include "tests/support/image_reader.h"
#include "tests/unit/scratch_folder.h"

namespace farshade {
namespace {

using namespace std::chrono_literals;

/// One pixel per source, one light, nothing stale.
ShownReport report_of_one_light(const std::vector<std::uint8_t>& sources) {
  const Extent size{static_cast<std::uint32_t>(sources.size()), 1};
  return {.mask = EyeMask(size, 1),
          .sources = sources,
          .positions = {},
          .visibility = std::vector<std::uint8_t>(sources.size()),
          .unknown = std::vector<std::uint32_t>(sources.size()),
          .stale = std::vector<std::uint32_t>(sources.size())};
}

TEST(WriteMeasured, WritesEveryPictureItPromises) {
  const ScratchFolder folder;
  const Extent size{5, 4};
  const ShownReport report = report_of_one_light(std::vector<std::uint8_t>(size.pixels(), 0));
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
  const std::uint32_t line = (sheet.size.height - 2 * 4 - 2) / 2;  // of a label
  EXPECT_EQ(sheet.size, (Extent{4 * 5 + 3 * 2, 2 * 4 + 2 + 2 * line}));
  EXPECT_EQ(sheet.at(0, line), Rgb8(10));
  EXPECT_EQ(sheet.at(7, line), Rgb8(11));
  EXPECT_EQ(sheet.at(0, 2 * line + 6), Rgb8(20)) << "the right eye is below";
}

TEST(WriteMeasured, HasNoSourcePictureWithoutAReport) {
  const ScratchFolder folder;
  const Extent size{5, 4};
  const PerEye<Image<Rgb8>> shown{Image<Rgb8>(size, Rgb8(10)), Image<Rgb8>(size, Rgb8(20))};
  const MeasuredFrame frame{.frame = {12}, .shown = shown, .reference = shown, .report = {}, .ages = {}};
  ASSERT_TRUE(write_measured(folder.path(), frame).has_value());
  EXPECT_FALSE(read_png(folder.path() / "worst_0012_left_source.png").has_value());
  EXPECT_EQ(read_png(folder.path() / "worst.png")->size.width, 3 * 5 + 2 * 2u);
}

/// The ink of a label, as text of '#' and ' '.
std::string ink(const std::string& label, std::uint32_t width) {
  const Extent size{width, 1};
  const Image<Rgb8> sheet = picture_sheet({{{label, Image<Rgb8>(size, Rgb8(9))}}});
  std::string text;
  for (std::uint32_t y = 0; y + 1 < sheet.size.height; ++y) {
    for (std::uint32_t x = 0; x < width; ++x) text += sheet.at(x, y).r < 128 ? '#' : ' ';
    text += '\n';
  }
  return text;
}

TEST(PictureSheet, WritesALabelAboveEachPictureAndCutsItOff) {
  EXPECT_EQ(ink("", 40).find('#'), std::string::npos);
  const std::string letter = ink("I", 11);
  // A serif above and below a stem of one pixel.
  EXPECT_NE(letter.find("###"), std::string::npos) << letter;
  EXPECT_GT(std::ranges::count(letter, '#'), 8) << letter;
  EXPECT_EQ(ink("II", 11), letter) << "the second letter has no room";
  EXPECT_EQ(std::ranges::count(ink("II", 30), '#'), 2 * std::ranges::count(letter, '#'));
  EXPECT_NE(ink("left", 60), ink("lift", 60));
}

TEST(WriteShown, RefusesAFolderThatIsNotThere) {
  const ScratchFolder folder;
  const PerEye<Image<Rgb8>> shown{Image<Rgb8>({2, 2}), Image<Rgb8>({2, 2})};
  EXPECT_FALSE(write_shown(folder.path() / "none", {1}, shown).has_value());
}

}  // namespace
}  // namespace farshade
