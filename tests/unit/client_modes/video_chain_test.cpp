#include "vr_client/modes/video.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "stereo/answers/video_parts.h"

namespace farshade {
namespace {

constexpr Extent kSize{128, 64};

class VideoChainTest : public testing::Test {
 protected:
  void SetUp() override {
    if (!has_video()) GTEST_SKIP() << video_version();
    encoder_ =
        VideoEncoder::create({.size = kSize, .bits_per_second = 10'000'000, .frames_per_second = 72}).value();
    chain_.emplace();
  }

  std::vector<std::byte> unit(std::uint8_t level, KeyFrame key = KeyFrame::IfNeeded) {
    Image<Rgb8> picture(kSize);
    std::ranges::fill(picture.pixels, Rgb8(level));
    const std::span<const std::byte> bytes = encoder_->encode(picture, key);
    return {bytes.begin(), bytes.end()};
  }
  /// The grey level of the picture; -1 if there is none.
  int taken(FrameId frame, FrameId after, const std::vector<std::byte>& unit, Extent size = kSize) {
    const Image<Rgb8>* const picture = chain_->take(frame, after, unit, size);
    return picture == nullptr ? -1 : picture->at(9, 9).g;
  }

  std::unique_ptr<VideoEncoder> encoder_;
  std::optional<VideoChain> chain_;
};

TEST_F(VideoChainTest, DecodesUnitsThatDependOnEachOther) {
  EXPECT_EQ(chain_->next(), Coding::Alone);
  EXPECT_NEAR(taken({3}, {3}, unit(40)), 40, 2);
  EXPECT_EQ(chain_->next(), Coding::AfterLast);
  EXPECT_NEAR(taken({4}, {3}, unit(90)), 90, 2);
  EXPECT_NEAR(taken({9}, {4}, unit(140)), 140, 2) << "frames without a picture are no gap";
}

TEST_F(VideoChainTest, GoesOnAfterAGapWithoutAKeyFrame) {
  taken({1}, {1}, unit(40));
  unit(60);  // frame 2 is lost
  EXPECT_NE(taken({3}, {2}, unit(90)), -1);
  EXPECT_EQ(chain_->next(), Coding::AfterLast);
  int level = -1;
  std::uint32_t frame = 4;
  for (; frame < 4 + 2 * kRefresh_pictures; ++frame) level = taken({frame}, {frame - 1}, unit(140));
  EXPECT_NEAR(level, 140, 2) << "the intra refresh has healed it";
}

TEST_F(VideoChainTest, TakesAUnitThatLacksParts) {
  taken({1}, {1}, unit(40));
  Image<Rgb8> noise(kSize);
  std::mt19937 random(5);
  for (Rgb8& pixel : noise.pixels) pixel = Rgb8(static_cast<std::uint8_t>(random()));
  const std::span<const std::byte> whole = encoder_->encode(noise, KeyFrame::IfNeeded);
  const VideoUnitParts parts = video_parts(whole);
  ASSERT_GT(parts.size(), 3u);
  std::vector<std::byte> unit(whole.begin(), whole.end());
  std::ranges::fill(std::span(unit).subspan(parts[0].size(), parts[1].size()), std::byte{0});
  EXPECT_NE(taken({2}, {1}, unit), -1);
  EXPECT_EQ(chain_->next(), Coding::AfterLast);
}

TEST_F(VideoChainTest, NeedsAKeyFrameFirst) {
  unit(40);  // frame 1 is lost
  EXPECT_EQ(taken({2}, {1}, unit(90)), -1);
  EXPECT_EQ(chain_->next(), Coding::Alone);
  EXPECT_NEAR(taken({3}, {3}, unit(140, KeyFrame::Now)), 140, 2);
  EXPECT_EQ(chain_->next(), Coding::AfterLast);
}

/// A view of another size starts another encoder. If its key frame is lost, units of that size would be
/// decoded with the parameter sets of the old size.
TEST_F(VideoChainTest, AfterALostKeyFrameOfANewSizeDecodesNothingUpToAnotherOne) {
  taken({1}, {1}, unit(40));
  constexpr Extent other{160, 64};
  encoder_ =
      VideoEncoder::create({.size = other, .bits_per_second = 10'000'000, .frames_per_second = 72}).value();
  const auto unit_of = [&](std::uint8_t level, KeyFrame key = KeyFrame::IfNeeded) {
    const std::span<const std::byte> bytes = encoder_->encode(Image<Rgb8>(other, Rgb8(level)), key);
    return std::vector(bytes.begin(), bytes.end());
  };
  unit_of(60);  // frame 2 is lost
  EXPECT_EQ(taken({3}, {2}, unit_of(90), other), -1);
  EXPECT_EQ(chain_->next(), Coding::Alone);
  EXPECT_NEAR(taken({4}, {4}, unit_of(140, KeyFrame::Now), other), 140, 2);
}

TEST_F(VideoChainTest, RefusesAUnitThatOnlyClaimsToBeAKeyFrame) {
  taken({1}, {1}, unit(40));
  EXPECT_EQ(taken({2}, {2}, unit(90)), -1);
  EXPECT_EQ(chain_->next(), Coding::Alone);
}

TEST_F(VideoChainTest, RefusesOtherSizesAndUnitsWithoutAPicture) {
  taken({1}, {1}, unit(40));
  EXPECT_EQ(taken({2}, {1}, unit(90), {64, 64}), -1);
  EXPECT_EQ(chain_->next(), Coding::Alone);
  EXPECT_EQ(taken({3}, {3}, unit(140, KeyFrame::Now), {64, 64}), -1)
      << "a key frame of a size nobody asked for";
  taken({4}, {4}, unit(140, KeyFrame::Now));
  EXPECT_EQ(taken({5}, {4}, std::vector(3000, std::byte{0})), -1) << "all parts with slices are lost";
  EXPECT_EQ(chain_->next(), Coding::Alone);
  EXPECT_NEAR(taken({6}, {6}, unit(140, KeyFrame::Now)), 140, 2);
}

}  // namespace
}  // namespace farshade
