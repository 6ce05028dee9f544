#include "vr_client/preview/inspection.h"

#include <gtest/gtest.h>

namespace farshade {
namespace {

constexpr Extent kOne{1, 1};

Rgb8 through(Rgb8 overlay, Rgb8 picture, double share) {
  return seen_through(Image<Rgb8>(kOne, overlay), Image<Rgb8>(kOne, picture), share).pixels[0];
}

TEST(SeenThrough, MixesTheOverlayWithTheBrightnessOfThePicture) {
  const Rgb8 green(0, 158, 115);
  EXPECT_EQ(through(green, Rgb8(10, 200, 90), 0), green);
  EXPECT_EQ(through(green, Rgb8(255), 0.5), Rgb8(128, 207, 185));
  EXPECT_EQ(through(green, Rgb8(0), 0.5), Rgb8(0, 79, 58));
  EXPECT_EQ(through(Rgb8(0), Rgb8(0, 255, 0), 0.5), Rgb8(91)) << "no colour of the picture";
}

TEST(ShowsThrough, IsOnlyForOverlaysOfTheShownPixels) {
  for (const Overlay overlay : {Overlay::Source, Overlay::Age, Overlay::Light, Overlay::Rays})
    EXPECT_TRUE(shows_through(overlay)) << name_of(overlay);
  for (const Overlay overlay : {Overlay::None, Overlay::Unknown, Overlay::Error, Overlay::GuardBand})
    EXPECT_FALSE(shows_through(overlay)) << name_of(overlay);
}

}  // namespace
}  // namespace farshade
