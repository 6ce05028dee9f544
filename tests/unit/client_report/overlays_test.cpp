#include "vr_client/report/overlays.h"

#include <gtest/gtest.h>

#include <numbers>
#include <set>

#include "stereo/frame/tiles.h"
#include "stereo/image/difference.h"
#include "stereo/math/rotation.h"

namespace farshade {
namespace {

using namespace std::chrono_literals;

constexpr Rgb8 kBlack(0), kOrange(255, 140, 0);

int brightness(Rgb8 color) {
  return color.r + color.g + color.b;
}

/// One pixel per source. Only pixels without a source are unknown; nothing is stale.
ShownReport report_of(const std::vector<std::uint8_t>& sources, std::uint32_t lights = 1) {
  const Extent size{static_cast<std::uint32_t>(sources.size()), 1};
  const MaskLayout layout{lights};
  ShownReport report{.mask = EyeMask(size, lights),
                     .sources = sources,
                     .positions = {},
                     .visibility = std::vector<std::uint8_t>(sources.size() * lights),
                     .unknown = std::vector<std::uint32_t>(sources.size() * layout.planes()),
                     .stale = std::vector<std::uint32_t>(sources.size() * layout.planes()),
                     .rays = std::vector<std::uint16_t>(sources.size())};
  for (std::size_t i = 0; i < sources.size(); ++i)
    for (std::uint32_t plane = 0; plane < layout.planes(); ++plane)
      if (sources[i] == kSourceUnknown) report.unknown[i * layout.planes() + plane] = layout.used_bits(plane);
  return report;
}

/// One pixel per source; all masks have this age.
Image<Rgb8> sources_drawn(const std::vector<std::uint8_t>& sources, Duration age) {
  const Extent size{static_cast<std::uint32_t>(sources.size()), 1};
  return source_picture(report_of(sources), MaskAges(kMaxMasks, age), size);
}

/// Owns the inputs of an overlay. The shown picture has one colour.
struct Frame {
  explicit Frame(ShownReport of, Rgb8 color = Rgb8(200, 100, 50))
      : report(std::move(of)),
        view{{}, {-0.5, 0.5, 0.5, -0.5}, report.mask.size()},
        shown(view.size, color) {}

  [[nodiscard]] Image<Rgb8> drawn(Overlay overlay) const {
    return overlay_picture(overlay, {.side = Side::Left,
                                     .view = view,
                                     .shown = shown,
                                     .reference = reference ? &*reference : nullptr,
                                     .report = report,
                                     .ages = ages,
                                     .newest = newest ? &*newest : nullptr,
                                     .light = light});
  }
  [[nodiscard]] std::vector<LegendEntry> explained(Overlay overlay) const {
    return legend(overlay, report.mask.lights(), light);
  }

  ShownReport report;
  View view;
  Image<Rgb8> shown;
  std::optional<Image<Rgb8>> reference;
  MaskAges ages = MaskAges(kMaxMasks, Duration{});
  std::optional<TracedMask> newest;
  std::uint32_t light = 0;
};

TEST(SourcePicture, TellsEverySourceApart) {
  const Image<Rgb8> picture =
      sources_drawn({0, 1, kOtherEye, kNeighbour, kOtherEye + 1, kSourceUnknown, kSourceUncovered}, 0ms);
  EXPECT_EQ(picture.at(0, 0), Rgb8(60, 220, 90)) << "this eye's newest";
  EXPECT_EQ(picture.at(1, 0).b, 255) << "an older one";
  EXPECT_EQ(picture.at(2, 0), Rgb8(60, 210, 230)) << "the other eye's newest";
  EXPECT_EQ(picture.at(3, 0), Rgb8(240, 230, 60)) << "the nearest pixel on the same surface";
  EXPECT_EQ(picture.at(4, 0), picture.at(1, 0)) << "older masks of both eyes have one colour";
  EXPECT_EQ(picture.at(5, 0), kOrange);
  EXPECT_EQ(picture.at(6, 0), kBlack);
}

TEST(SourceOverlay, MakesWhatWasReprojectedPaler) {
  const Extent traced{32, 16};
  const View view{{}, {-0.5, 0.5, 0.5, -0.5}, traced};
  const StereoView views{view, view};
  const PerEye<EyeMask> bits{EyeMask(traced, 1), EyeMask(traced, 1)};
  const PerEye<ReceivedTiles> known{ReceivedTiles{1, 0}, ReceivedTiles{1, 0}};
  const RequestedBlocks requested{{std::vector<RequestedTile>{{{1}}, {}}, std::vector<RequestedTile>(2)}};
  Frame frame(report_of({0, 0, 0}));
  frame.report.positions = {{3.5f, 3.5f}, {4.5f, 3.5f}, {20.5f, 3.5f}};
  frame.newest.emplace(TracedMask{{1}, {}, {}, views, bits, known, 0, kFirstLightSet, &requested});
  const Image<Rgb8> picture = frame.drawn(Overlay::Source);
  EXPECT_EQ(picture.at(0, 0), Rgb8(60, 220, 90)) << "asked for";
  EXPECT_EQ(picture.at(1, 0), frame.explained(Overlay::Source)[1].color) << "the next block was reprojected";
  EXPECT_EQ(picture.at(2, 0), picture.at(1, 0)) << "and so was the whole next tile";
  EXPECT_NE(picture.at(1, 0), picture.at(0, 0));
}

TEST(SourcePicture, DrawsRedLinesOverWhatIsStaleInAnyPlane) {
  ShownReport report = report_of(std::vector<std::uint8_t>(12, 0), 40);
  for (std::size_t pixel = 4; pixel < 8; ++pixel) report.stale[pixel * 2] = 1;
  for (std::size_t pixel = 8; pixel < 12; ++pixel) report.stale[pixel * 2 + 1] = 1u << 7;
  const Image<Rgb8> picture = source_picture(report, {0ms}, {4, 3});
  const Rgb8 lines = legend(Overlay::Source, 40, 0).back().color;
  for (std::uint32_t y = 0; y < 3; ++y)
    for (std::uint32_t x = 0; x < 4; ++x)
      EXPECT_EQ(picture.at(x, y), y > 0 && (x + y) % 4 == 0 ? lines : Rgb8(60, 220, 90)) << x << ", " << y;
}

TEST(SourcePicture, EveryUsedMaskHasItsOwnColor) {
  std::vector<std::uint8_t> all;
  for (std::size_t i = 0; i < kMaxMasks; ++i) all.push_back(static_cast<std::uint8_t>(i));
  const Image<Rgb8> picture = sources_drawn(all, 0ms);
  std::set<std::array<int, 3>> colors;
  for (const Rgb8 color : picture.pixels) colors.insert({color.r, color.g, color.b});
  EXPECT_EQ(colors.size(), all.size());
  for (std::uint32_t i = 2; i < all.size(); ++i) EXPECT_GT(picture.at(i, 0).r, picture.at(i - 1, 0).r);
}

TEST(SourcePicture, DarkensWithAgeYetTellsSourcesApart) {
  for (const std::uint8_t source : std::array<std::uint8_t, 2>{0, 1}) {
    int last = 1000;
    for (const Duration age : {0ms, 100ms, 300ms, 490ms}) {
      const int now = brightness(sources_drawn({source}, age).at(0, 0));
      EXPECT_LT(now, last);
      last = now;
    }
    EXPECT_LE(brightness(sources_drawn({source}, kOldestDrawn).at(0, 0)), last);
    EXPECT_EQ(sources_drawn({source}, 10s).pixels, sources_drawn({source}, kOldestDrawn).pixels);
  }
  const Image<Rgb8> old = sources_drawn({0, kOtherEye, 1, kNeighbour}, 10s);
  for (std::uint32_t a = 0; a < 4; ++a)
    for (std::uint32_t b = 0; b < a; ++b) EXPECT_NE(old.at(a, 0), old.at(b, 0));
}

TEST(Overlay, NamesDiffer) {
  std::set<std::string> names;
  for (const Overlay overlay : kOverlays) names.insert(name_of(overlay));
  EXPECT_EQ(names.size(), kOverlays.size());
  EXPECT_STREQ(name_of(Overlay::Rays), "rays");
  EXPECT_STREQ(name_of(Overlay::None), "none");
}

TEST(Overlay, LegendsTellTheirColorsApart) {
  EXPECT_TRUE(legend(Overlay::None, 3, 0).empty());
  for (const Overlay overlay : kOverlays)
    for (const std::uint32_t lights : {0u, 1u, 3u, 8u, 40u, 256u}) {
      if (overlay == Overlay::None || (overlay == Overlay::Unknown && lights <= 1)) continue;
      std::set<std::array<int, 3>> colors;
      std::set<std::string> texts;
      const std::vector<LegendEntry> entries = legend(overlay, lights, 0);
      for (const LegendEntry& entry : entries) {
        colors.insert({entry.color.r, entry.color.g, entry.color.b});
        texts.insert(entry.text);
      }
      EXPECT_EQ(colors.size(), entries.size()) << name_of(overlay) << " of " << lights;
      EXPECT_EQ(texts.size(), entries.size()) << name_of(overlay) << " of " << lights;
      EXPECT_LE(entries.size(), 9u);
      EXPECT_GE(entries.size(), 1u);
    }
}

TEST(Overlay, NeedsNoMasks) {
  Frame frame(report_of({0, 0}));  // as shadow maps report it
  frame.ages.clear();
  for (const Overlay overlay : kOverlays)
    if (overlay != Overlay::None && overlay != Overlay::Error) {
      EXPECT_EQ(frame.drawn(overlay).size, frame.view.size) << name_of(overlay);
    }
}

TEST(Overlay, IsBlackWhereNothingIsCovered) {
  Frame frame(report_of({kSourceUncovered, 0}));
  frame.report.visibility = {255, 255};
  for (const Overlay overlay :
       {Overlay::Source, Overlay::Age, Overlay::Unknown, Overlay::Light, Overlay::Rays}) {
    const Image<Rgb8> picture = frame.drawn(overlay);
    EXPECT_EQ(picture.at(0, 0), kBlack) << name_of(overlay);
    EXPECT_NE(picture.at(1, 0), kBlack) << name_of(overlay);
  }
}

TEST(Overlay, IsBlackWhereWhatItNeedsIsNotThere) {
  Frame frame(report_of({0, 0}));
  frame.report.sources.clear();
  for (const Overlay overlay : kOverlays) {
    const Image<Rgb8> nothing(frame.view.size);
    EXPECT_EQ(frame.drawn(overlay), overlay == Overlay::None ? frame.shown : nothing) << name_of(overlay);
  }
  Frame of_another_light(report_of({0, 0}, 3));
  of_another_light.light = 3;
  EXPECT_EQ(of_another_light.drawn(Overlay::Light), Image<Rgb8>(of_another_light.view.size));
}

TEST(Overlay, ErrorIsTheDifferenceEightTimes) {
  Frame frame(report_of({0, 0}), Rgb8(20));
  frame.reference = Image<Rgb8>(frame.view.size, Rgb8(20));
  frame.reference->at(1, 0) = Rgb8(36);
  const Image<Rgb8> picture = frame.drawn(Overlay::Error);
  const std::vector<LegendEntry> read = frame.explained(Overlay::Error);
  EXPECT_EQ(picture.at(0, 0), read.at(0).color) << read.at(0).text;
  EXPECT_EQ(picture.at(1, 0), read.at(1).color) << read.at(1).text;
}

TEST(Overlay, AgeIsThatOfTheMaskAndItsColorIsInTheLegend) {
  Frame frame(report_of({0, 1, 2, 3, kOtherEye + 2, kNeighbour, kNeighbour + kOtherEye + 1, kSourceUnknown}));
  frame.ages = {0ms, 100ms, 400ms, 5s};
  const Image<Rgb8> picture = frame.drawn(Overlay::Age);
  const std::vector<LegendEntry> read = frame.explained(Overlay::Age);
  ASSERT_EQ(read.size(), 7u);
  constexpr std::array<std::size_t, 8> entry_of{0, 1, 4, 5, 4, 0, 1, 6};
  for (std::uint32_t x = 0; x < entry_of.size(); ++x)
    EXPECT_EQ(picture.at(x, 0), read[entry_of[x]].color) << x << ": " << read[entry_of[x]].text;
  EXPECT_EQ(read[4].text, "400 ms");
}

TEST(Overlay, AgeGrowsLighterAllAlong) {
  double last = -1;
  for (int ms = 0; ms <= 500; ms += 10) {
    Frame frame(report_of({0}));
    frame.ages = {ms * 1ms};
    const Rgb8 color = frame.drawn(Overlay::Age).at(0, 0);
    const double luma = 0.2126 * color.r + 0.7152 * color.g + 0.0722 * color.b;
    EXPECT_GT(luma, last) << ms;
    last = luma;
  }
}

TEST(Overlay, UnknownIsBrighterTheMoreIsUnknown) {
  Frame frame(report_of({0, 0, 0, kSourceUnknown, 0}, 40), Rgb8(255));
  const auto set = [](std::vector<std::uint32_t>& words, std::size_t pixel, std::uint32_t first,
                      std::uint32_t second) {
    words[pixel * 2] = first;
    words[pixel * 2 + 1] = second;
  };
  set(frame.report.unknown, 1, 0, 1u << 7);
  set(frame.report.unknown, 2, 0b11, 1u << 7);
  set(frame.report.stale, 2, 0b100, 0);
  set(frame.report.stale, 4, 0, 1);
  const Image<Rgb8> picture = frame.drawn(Overlay::Unknown);
  const std::vector<LegendEntry> read = frame.explained(Overlay::Unknown);
  EXPECT_EQ(picture.at(0, 0), read.at(3).color) << read.at(3).text;
  EXPECT_EQ(picture.at(1, 0), read.at(1).color) << read.at(1).text;
  EXPECT_GT(brightness(picture.at(2, 0)), brightness(picture.at(1, 0)))
      << "unknown takes precedence over stale";
  EXPECT_LT(brightness(picture.at(2, 0)), brightness(picture.at(3, 0)));
  EXPECT_EQ(picture.at(3, 0), read.at(0).color) << read.at(0).text;
  EXPECT_EQ(picture.at(4, 0), read.at(2).color) << read.at(2).text;
}

TEST(Overlay, UnknownLeavesOfThePictureItsGreys) {
  Frame frame(report_of({0, 0}));
  frame.shown.at(1, 0) = Rgb8(20);
  const Image<Rgb8> picture = frame.drawn(Overlay::Unknown);
  for (const Rgb8 color : picture.pixels) EXPECT_TRUE(color.r == color.g && color.g == color.b);
  EXPECT_GT(picture.at(0, 0).r, picture.at(1, 0).r);
}

TEST(Overlay, LightIsThatLightAlone) {
  Frame frame(report_of({0, 0, 0, 0}, 40));
  frame.light = 37;
  for (std::size_t pixel = 0; pixel < 4; ++pixel)
    frame.report.visibility[pixel * 40 + 36] = frame.report.visibility[pixel * 40 + 38] = 255;
  frame.report.visibility[37] = 255;
  frame.report.visibility[2 * 40 + 37] = 255;
  frame.report.stale[2 * 2 + 1] = 1u << 5;    // light 37 of pixel 2
  frame.report.unknown[3 * 2 + 1] = 1u << 5;  // and of pixel 3
  frame.report.stale[0] = frame.report.unknown[0] = ~0u;
  frame.report.stale[1] = frame.report.unknown[1] = static_cast<std::uint8_t>(~(1u << 5));
  const Image<Rgb8> picture = frame.drawn(Overlay::Light);
  const std::vector<LegendEntry> read = frame.explained(Overlay::Light);
  EXPECT_EQ(read.at(0).text, "light 37 is visible");
  constexpr std::array<std::size_t, 4> entry_of{0, 2, 3, 4};
  for (std::uint32_t x = 0; x < entry_of.size(); ++x)
    EXPECT_EQ(picture.at(x, 0), read[entry_of[x]].color) << x << ": " << read[entry_of[x]].text;
}

TEST(Overlay, RaysAreCountedOnTheLegendsScale) {
  for (const std::uint32_t lights : {1u, 3u, 8u, 40u}) {
    Frame frame(report_of({0, 0, kSourceUnknown}, lights));
    frame.report.rays = {0, static_cast<std::uint16_t>(lights), static_cast<std::uint16_t>(lights)};
    const Image<Rgb8> picture = frame.drawn(Overlay::Rays);
    const std::vector<LegendEntry> read = frame.explained(Overlay::Rays);
    EXPECT_EQ(picture.at(0, 0), read.front().color);
    EXPECT_EQ(picture.at(1, 0), read.back().color);
    EXPECT_EQ(picture.at(2, 0), read.back().color) << "regardless of the known bits";
    EXPECT_EQ(read.front().text, "0 rays");
    EXPECT_EQ(read.back().text, std::to_string(lights) + (lights == 1 ? " ray" : " rays"));
  }
}

/// A shown view of 90 x 90 degrees in 100 x 100 pixels, and a mask for a window `grown` times as large.
class GuardBandOverlay : public testing::Test {
 protected:
  Image<Rgb8> drawn(double grown, double yaw_rad, glm::uvec2 traced_px = {120, 120}) {
    Frame frame(report_of(std::vector<std::uint8_t>(10'000)));
    const double quarter = std::numbers::pi / 4, wide = std::atan(grown);
    frame.view = {{}, {-quarter, quarter, quarter, -quarter}, {100, 100}};
    frame.shown = Image<Rgb8>(frame.view.size);
    const View traced{
        {rotation_exp({0, yaw_rad, 0}), {}}, {-wide, wide, wide, -wide}, {traced_px.x, traced_px.y}};
    views_ = {traced, traced};
    for (const Side side : kSides) {
      EyeMask& mask = masks_[index_of(side)] = EyeMask(traced.size, 2);
      for (std::uint32_t y = 0; y < traced.size.height; ++y)
        for (std::uint32_t x = 0; x < traced.size.width / 2; ++x) mask.set_word(x, y, 0, 0b11);
      known_[index_of(side)] = ReceivedTiles(TileGrid{traced.size}.count(), 1);
    }
    known_[0][0] = 0;
    frame.newest.emplace(TracedMask{{1}, {}, {}, views_, masks_, known_});
    return frame.drawn(Overlay::GuardBand);
  }

  StereoView views_;
  PerEye<EyeMask> masks_;
  PerEye<ReceivedTiles> known_;
  std::vector<LegendEntry> read_ = legend(Overlay::GuardBand, 2, 0);
  Rgb8 outline_ = read_[0].color, all_ = read_[1].color, none_ = read_[2].color, guard_ = read_[3].color,
       lacking_ = read_[4].color;
};

TEST_F(GuardBandOverlay, SurroundsTheShownView) {
  // Traced: 80 of 100 pixels, from 10 on. Shown: 1 / 1.25 of these, 64 of 100, from 18 on.
  const Image<Rgb8> picture = drawn(1.25, 0);
  for (const auto& [x, expected] : std::vector<std::pair<std::uint32_t, Rgb8>>{{9, kBlack},
                                                                               {10, guard_},
                                                                               {16, guard_},
                                                                               {17, outline_},
                                                                               {18, outline_},
                                                                               {19, all_},
                                                                               {49, all_},
                                                                               {50, none_},
                                                                               {80, none_},
                                                                               {81, outline_},
                                                                               {82, outline_},
                                                                               {90, kBlack}})
    EXPECT_EQ(picture.at(x, 50), expected) << x;
  for (const auto& [y, expected] : std::vector<std::pair<std::uint32_t, Rgb8>>{
           {9, kBlack}, {10, guard_}, {17, outline_}, {19, all_}, {82, outline_}, {89, guard_}, {90, kBlack}})
    EXPECT_EQ(picture.at(40, y), expected) << y;
  // Tile 0 of the left eye has not arrived.
  EXPECT_EQ(picture.at(19, 19), read_[5].color);
}

TEST_F(GuardBandOverlay, ShowsWhatATurnedHeadSeesBeyondIt) {
  // The traced head is turned to the left of the shown head.
  const Image<Rgb8> picture = drawn(1.25, 0.3);
  EXPECT_EQ(picture.at(12, 50), guard_);
  EXPECT_EQ(picture.at(94, 50), lacking_);
  const Image<Rgb8> other_way = drawn(1.25, -0.3);
  EXPECT_EQ(other_way.at(5, 50), lacking_);
  EXPECT_NE(other_way.at(88, 50), lacking_);
  const Image<Rgb8> behind = drawn(1.25, std::numbers::pi);
  for (const Rgb8 color : behind.pixels) EXPECT_TRUE(color != outline_ && color != lacking_);
}

TEST_F(GuardBandOverlay, IsTheSameAtAnyResolutionOfTheMask) {
  EXPECT_EQ(drawn(1.25, 0.1).at(60, 60), drawn(1.25, 0.1, {48, 240}).at(60, 60));
  EXPECT_EQ(drawn(1.25, 0.1, {48, 240}).at(45, 50), all_);
}

}  // namespace
}  // namespace farshade
