#include "vr_client/modes/video.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace farshade {
namespace {

constexpr Extent kSize{128, 64};

class VideoChainTest : public testing::Test {
 protected:
  void SetUp() override {
    if (!has_video()) GTEST_SKIP() << video_version();
    encoder_.emplace(
        VideoEncoder::create({.size = kSize, .bits_per_second = 10'000'000, .frames_per_second = 72})
            .value());
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

  std::optional<VideoEncoder> encoder_;
  std::optional<VideoChain> chain_;
};

TEST_F(VideoChainTest, DecodesUnitsThatDependOnEachOther) {
  EXPECT_EQ(chain_->next(), Coding::Alone);
  EXPECT_NEAR(taken({3}, {3}, unit(40)), 40, 2);
  EXPECT_EQ(chain_->next(), Coding::AfterLast);
  EXPECT_NEAR(taken({4}, {3}, unit(90)), 90, 2);
  EXPECT_NEAR(taken({9}, {4}, unit(140)), 140, 2) << "frames without a picture are no gap";
}

TEST_F(VideoChainTest, AfterAGapDecodesNothingUpToAKeyFrame) {
  taken({1}, {1}, unit(40));
  unit(60);  // frame 2 is lost
  EXPECT_EQ(taken({3}, {2}, unit(90)), -1);
  EXPECT_EQ(chain_->next(), Coding::Alone);
  EXPECT_EQ(taken({4}, {3}, unit(100)), -1) << "it depends on a picture that was not decoded";
  EXPECT_NEAR(taken({5}, {5}, unit(140, KeyFrame::Now)), 140, 2);
  EXPECT_EQ(chain_->next(), Coding::AfterLast);
}

TEST_F(VideoChainTest, RefusesAUnitThatOnlyClaimsToBeAKeyFrame) {
  taken({1}, {1}, unit(40));
  EXPECT_EQ(taken({2}, {2}, unit(90)), -1);
  EXPECT_EQ(chain_->next(), Coding::Alone);
}

TEST_F(VideoChainTest, RefusesDamageAndOtherSizes) {
  taken({1}, {1}, unit(40));
  EXPECT_EQ(taken({2}, {1}, unit(90), {64, 64}), -1);
  EXPECT_EQ(chain_->next(), Coding::Alone);
  std::vector<std::byte> cut = unit(140, KeyFrame::Now);
  cut.resize(cut.size() / 4);
  EXPECT_EQ(taken({3}, {3}, cut), -1);
  EXPECT_EQ(chain_->next(), Coding::Alone);
}

}  // namespace
}  // namespace farshade
