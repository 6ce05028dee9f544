/// Partial requests, with a renderer and a tracer but without a network: each mask is composed of what was
/// reprojected and what was asked for, and is the base of the next one.
#include "stereo/partial_request/partial_request.h"

#include "stereo/answers/frame_packer.h"
#include "stereo/base/check.h"
#include "tests/golden/test_rig.h"

namespace farshade {
namespace {

constexpr Duration kApart = std::chrono::milliseconds(28);

class PartialRequestsInARow : public OnLavapipe {
 protected:
  /// Makes the request number `number` for `views` and takes its whole answer. `spoil` changes the traced
  /// masks.
  void ask(std::uint32_t number, const StereoView& views,
           const std::function<void(ShadowFrame&)>& spoil = {}) {
    FrameRequest request{{.frame = {number},
                          .display_time = Time(kApart * number),
                          .scene_time = {},
                          .views = views,
                          .lights = lights_}};
    partial_request_.begin(request, assembler_.next_slot(),
                           number > apart_ ? assembler_.find({number - apart_}) : nullptr, hidden_);
    partial_request_.complete(request);
    requested_ = request.requested;
    assembler_.expect(request, layout_, lights_.revision, {}, partial_request_.parts().reprojected);
    if (!partial_request_.has_begun())
      renderer_->keep_depth(request, assembler_.find(request.frame)->slot, distances_);
    tracer_.trace(request, traced_);
    if (spoil) spoil(traced_);
    packer_.begin();
    packer_.add(traced_, request.requested);
    for (const std::vector<std::byte>& message : packer_.finish({.frame = request.frame}))
      if (const auto decoded = decode_server(message);
          const auto* const slice = std::get_if<Slice>(&*decoded))
        assembler_.accept(*slice);
    base_ = assembler_.find(request.frame);
    ASSERT_TRUE(base_->complete());
  }

  /// The share of wrong bits in the newest mask, percent.
  double wrong_percent() {
    ShadowFrame truth;
    FrameRequest whole = base_->request;
    whole.requested = {};
    tracer_.trace(whole, truth);
    std::size_t wrong = 0, all = 0;
    for (std::size_t eye = 0; eye < kEyes; ++eye)
      for_pixels(truth.masks[eye].size(), [&](std::uint32_t x, std::uint32_t y) {
        wrong += truth.masks[eye].word(x, y) != base_->masks[eye].word(x, y);
        ++all;
      });
    return 100 * static_cast<double>(wrong) / static_cast<double>(all);
  }

  Scene scene_ = bundled("box_over_plane.gltf");
  MaskLayout layout_{narrow<std::uint32_t>(scene_.lights.size())};
  Tracer tracer_ = Tracer::create(scene_).value();
  std::unique_ptr<Renderer> renderer_ = make_renderer(device_, scene_, {{256, 256}, {256, 256}, 8});
  PartialRequest partial_request_{*renderer_};
  Assembler assembler_;
  FramePacker packer_;
  ShadowFrame traced_;
  PerEye<Image<float>> distances_;
  const RequestRecord* base_ = nullptr;  ///< the newest
  LightChanges lights_;
  std::uint32_t apart_ = 1;  ///< requests from a base to the one that is reprojected from it
  PerEye<HiddenArea> hidden_;
  RequestedBlocks requested_;
};

TEST_F(PartialRequestsInARow, AsksForWholeViewsFirstAndForAPartThen) {
  const Rigid<Stage, Head> head = head_at_camera(scene_);
  ask(1, eyes_of(head, 256));
  EXPECT_TRUE(requested_.whole());
  EXPECT_TRUE(partial_request_.parts().messages.empty());
  for (std::uint32_t number = 2; number < 20; ++number) {
    ask(number, eyes_of(moved(head, 0.01 * number, {0.002 * number, 0, 0}), 256));
    EXPECT_GT(part_of(requested_), 0.01) << number;
    EXPECT_LT(part_of(requested_), 0.4) << number;
    EXPECT_FALSE(partial_request_.parts().messages.empty());
    EXPECT_LT(wrong_percent(), 0.05) << number;
  }
  // After a jump to another place.
  ask(20, eyes_of(head_looking({0.2, 2.5, -0.2}, {0, 0, 0}), 256));
  EXPECT_GT(part_of(requested_), 0.05);
  EXPECT_LT(wrong_percent(), 0.05);
}

/// As many chains of masks as requests are on their way: each must be refreshed.
TEST_F(PartialRequestsInARow, WrongBitsLiveForASecondAtMostHoweverLateTheAnswers) {
  const StereoView views = eyes_of(head_at_camera(scene_), 256);
  for (const std::uint32_t apart : {1u, 2u, 3u}) {
    apart_ = apart;
    assembler_ = Assembler();
    for (std::uint32_t number = 1; number <= apart; ++number)
      ask(number, views, [](ShadowFrame& frame) {
        // All lit: no edge to ask for.
        for (EyeMask& mask : frame.masks) std::ranges::fill(mask.bytes(), std::byte{1});
      });
    EXPECT_GT(wrong_percent(), 5);
    const auto second = static_cast<std::uint32_t>(std::chrono::seconds(1) / kApart) + 2;
    for (std::uint32_t number = apart + 1; number <= second + apart; ++number) ask(number, views);
    for (std::uint32_t number = second + apart + 1; number <= second + 2 * apart; ++number) {
      ask(number, views);
      EXPECT_LT(wrong_percent(), 0.05) << apart << " apart, request " << number;
    }
  }
}

/// A light that changes all the time leaves nothing to reproject. Then few requests try to.
TEST_F(PartialRequestsInARow, TriesSeldomIfEveryRequestWouldAskForTooMuch) {
  const StereoView views = eyes_of(head_at_camera(scene_), 256);
  std::uint32_t tried = 0, number = 1;
  for (; number <= 100; ++number) {
    for (std::uint32_t light = 0; light < scene_.lights.size(); ++light)
      change(lights_, light, number % 2 == 0, std::nullopt);
    ask(number, views);
    tried += partial_request_.has_begun();
    EXPECT_TRUE(requested_.whole()) << number;
  }
  EXPECT_EQ(tried, 6u);  // after 0, 1, 3, 7, 15 and 31 that do not
  for (; requested_.whole() && number < 200; ++number) ask(number, views);
  EXPECT_LE(number, 100 + PartialRequest::kMostSkipped + 2);
  for (std::uint32_t i = 0; i < 4; ++i, ++number) {
    ask(number, views);
    EXPECT_FALSE(requested_.whole()) << "an exception is followed by a single try";
  }
}

TEST_F(PartialRequestsInARow, OneLightOfThreeThatChangesLeavesTheOthersReprojected) {
  const StereoView views = eyes_of(head_at_camera(scene_), 256);
  ask(1, views);
  for (std::uint32_t number = 2; number <= 10; ++number) {
    change(lights_, 0, number % 2 == 0, std::nullopt);
    ask(number, views);
    EXPECT_FALSE(requested_.whole()) << number;
    EXPECT_GT(part_of(requested_), 0.3) << number;
  }
}

/// Lenses that hide the left of each view, or of one: at first, while all lights change all the time, and
/// after a jump, no ray is traced there, and the rest is as right as without lenses.
TEST_F(PartialRequestsInARow, WhatLensesHideIsNotAskedForEvenIfNothingIsKnown) {
  constexpr float kInner = -0.4f;
  for (HiddenArea& area : hidden_)
    area.corners = {{-50, -50}, {kInner, -50}, {-50, 50}, {-50, 50}, {kInner, -50}, {kInner, 50}};
  const StereoView ahead = eyes_of(head_at_camera(scene_), 256),
                   above = eyes_of(head_looking({0.2, 2.5, -0.2}, {0, 0, 0}), 256);
  for (std::uint32_t number = 1; number <= 12; ++number) {
    SCOPED_TRACE(number);
    if (number == 11) hidden_[1].corners.clear();
    if (number > 1 && number < 8)
      for (std::uint32_t light = 0; light < scene_.lights.size(); ++light)
        change(lights_, light, number % 2 == 1, std::nullopt);
    const StereoView& views = number < 10 ? ahead : above;
    ask(number, views);
    ASSERT_FALSE(requested_.whole());
    if (number < 8) {
      EXPECT_GT(part_of(requested_), PartialRequest::kMostRequested) << "all that is seen is asked for";
    }
    EXPECT_FALSE(partial_request_.parts().messages.empty());
    ShadowFrame truth;
    FrameRequest whole = base_->request;
    whole.requested = {};
    tracer_.trace(whole, truth);
    std::array<std::size_t, 2> requested{}, wrong{};
    for (std::size_t eye = 0; eye < kEyes; ++eye) {
      const auto [left, right, up, down] = tangents_of(views[eye].fov);
      const double inner_px =
          hidden_[eye].corners.empty() ? -10 : (kInner - left) / (right - left) * views[eye].size.width;
      for_pixels(views[eye].size, [&](std::uint32_t x, std::uint32_t y) {
        if (std::abs(x + 0.5 - inner_px) < kBlockSide_px) return;  // a block has one answer
        const bool shown = x > inner_px;
        requested[shown] += requested_bits(requested_, eye, views[eye].size, {x, y}) != 0;
        wrong[shown] += truth.masks[eye].word(x, y) != base_->masks[eye].word(x, y);
      });
    }
    EXPECT_EQ(requested[0], 0u);
    EXPECT_GT(requested[1], 0u);
    EXPECT_LT(wrong[1], 70u) << "0.1 % of what is shown";
    if (number % 2 == 1) {
      EXPECT_GT(wrong[0], 1000u) << "what is hidden is known";
    }
  }
}

}  // namespace
}  // namespace farshade
