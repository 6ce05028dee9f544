// The client loses its device while it shows frames: it opens the device again and goes on in its session.
#include <gtest/gtest.h>

#include <algorithm>

#include "stereo/gltf/gltf.h"
#include "stereo/gpu/device.h"
#include "stereo/gpu/device_losses.h"
#include "stereo/head/reader.h"
#include "tests/network/rehearsal.h"
#include "tests/support/test_place.h"
#include "vr_client/modes/run_frames.h"

namespace farshade {
namespace {

constexpr std::uint32_t kLostAt = 20, kFrames = 64;
constexpr Duration kPeriod = std::chrono::milliseconds(10);

/// The bundled room at its first instant: nothing moves, so requests are for a part of their views.
Scene still_room() {
  Scene scene = load_scene(asset("room.glb")).value();
  scene.animation_length_s = 0;
  for (Node& node : scene.nodes) node.moving = false;
  return scene;
}

class LostDevice : public testing::Test {
 protected:
  [[nodiscard]] Played played(std::optional<Play::Loss> loss) {
    Play play{.device = device_,
              .scene = scene_,
              .head = head_,
              .size = {192, 192},
              .frames = kFrames,
              .reference_every = 4,
              .loss = loss};
    play.watch = [&](const FrameView& view, const FrameRecord&, const MeasuredFrame*) {
      shown_.push_back(view.shown.frame.value);
    };
    return farshade::play(play, network_from("delay=25ms").value());
  }

  gpu::Device device_ = gpu::open_device({.name_contains = test_gpu()}).value();
  Scene scene_ = still_room();
  HeadRecording head_ = load_head_recording(asset("walk.csv"), {}).value();
  std::vector<std::uint32_t> shown_;
};

const FrameRecord* find(const Played& played, std::uint32_t frame) {
  const auto& records = played.log.records();
  const auto found =
      std::ranges::find_if(records, [&](const FrameRecord& one) { return one.frame.value == frame; });
  return found == records.end() ? nullptr : &*found;
}

/// Means over the compared frames from `first` on, worse eye.
struct Quality {
  double psnr_db = 0, error_percent = 0;
  double requested = 0;  ///< the share of the views that requests ask for
};

Quality quality(const Played& played, std::uint32_t first) {
  Quality sum;
  int compared = 0, requests = 0;
  for (const FrameRecord& record : played.log.records()) {
    if (record.frame.value < first) continue;
    if (record.requested) sum.requested += *record.requested, ++requests;
    if (!record.errors) continue;
    const auto& [left, right] = *record.errors;
    sum.psnr_db += std::min(left.psnr_db, right.psnr_db);
    sum.error_percent += 100 * std::max(left.mask_error, right.mask_error);
    ++compared;
  }
  return {sum.psnr_db / compared, sum.error_percent / compared, sum.requested / requests};
}

/// Without a depth the masks that have come cannot be used, so whole views are asked for until new ones come.
TEST_F(LostDevice, IsOpenedAgainAndTheRunGoesOnInItsSession) {
  const Played calm = played({});
  shown_.clear();
  const Played shaken = played(Play::Loss{device_, kLostAt});
  EXPECT_FALSE(device_.use->abandoned) << "another device is open";
  EXPECT_EQ(shaken.client.sessions, 1u);
  EXPECT_EQ(shaken.server.sessions.welcomed, 1u);
  ASSERT_EQ(shown_.size(), kFrames - 1);
  EXPECT_EQ(shown_[kLostAt - 2], kLostAt - 1);
  EXPECT_EQ(shown_[kLostAt - 1], kLostAt + 1) << "frames count on";

  ASSERT_TRUE(find(shaken, kLostAt + 1));
  EXPECT_TRUE(find(shaken, kLostAt + 1)->start_up);
  EXPECT_EQ(find(shaken, kLostAt + 1)->requested, 1.0) << "whole views";
  EXPECT_FALSE(find(shaken, kLostAt + 6)->start_up) << "the answers to these come after 50 ms";

  const Quality again = quality(shaken, kLostAt + 20), undisturbed = quality(calm, kLostAt + 20);
  std::printf(
      "from 20 frames after the loss on: %.2f dB, mask error %.3f %%; undisturbed: %.2f dB, %.3f %%\n",
      again.psnr_db, again.error_percent, undisturbed.psnr_db, undisturbed.error_percent);
  EXPECT_NEAR(again.psnr_db, undisturbed.psnr_db, 0.2);
  EXPECT_NEAR(again.error_percent, undisturbed.error_percent, 0.05);
  EXPECT_NEAR(again.requested, undisturbed.requested, 0.02);
  // The head's motion is known again as well as without the loss.
  EXPECT_NEAR(quality(shaken, kFrames - 8).psnr_db, quality(calm, kFrames - 8).psnr_db, 0.02);
}

/// Frames of no server, on a device that a test loses as it likes.
class LostFrames : public testing::Test, public Runtime {
 protected:
  [[nodiscard]] std::optional<FrameTiming> wait_frame() override {
    if (++begun_ > most_) return std::nullopt;
    return FrameTiming{Time(begun_ * kPeriod), kPeriod};
  }
  [[nodiscard]] StereoView locate_views(Time) override {
    StereoView views;
    views.fill({*scene_.camera, {-0.7, 0.7, 0.7, -0.7}, kEye});
    return views;
  }
  void add_output(const gpu::Recorder&) override {
    if (is_lost_in_(begun_)) throw vk::DeviceLostError("vkQueueSubmit");
  }

  [[nodiscard]] Expected<void> show(std::function<bool(std::uint32_t frame)> is_lost_in,
                                    std::uint32_t frames) {
    is_lost_in_ = std::move(is_lost_in);
    most_ = frames;
    make();
    FrameDevice device{.context =
                           [this] {
                             return RunContext{.scene = scene_,
                                               .runtime = *this,
                                               .renderer = *renderer_,
                                               .mode = {.mode = Mode::Full},
                                               .settings = settings_,
                                               .policy = {}};
                           },
                       .clear = [this] { renderer_.reset(); }};
    if (can_open_)
      device.reopen = [this]() -> Expected<void> {
        EXPECT_FALSE(renderer_) << "everything on the lost device is gone";
        if (++opened_ > most_opened_) return fail(Fault::Missing, "no driver");
        make();
        return {};
      };
    const auto watch = [this](const FrameView& view) { shown_.push_back(view.shown.frame.value); };
    return run_frames(device, watch, [] { return false; });
  }

  gpu::Device device_ = gpu::open_device({.name_contains = test_gpu()}).value();
  Scene scene_ = load_scene(asset("room.glb")).value();
  std::unique_ptr<Renderer> renderer_;
  bool can_open_ = true;
  int most_opened_ = 1000, opened_ = 0;
  std::uint32_t in_flight_ = 1;
  std::vector<std::uint32_t> shown_;

 private:
  static constexpr Extent kEye{16, 16};
  void make() { renderer_ = make_renderer(device_, scene_, {kEye, kEye, 1, in_flight_}); }

  FrameSettings settings_;
  std::function<bool(std::uint32_t)> is_lost_in_;
  std::uint32_t begun_ = 0, most_ = 0;
};

TEST_F(LostFrames, AreLeftOut) {
  const Expected<void> done = show([](std::uint32_t frame) { return frame == 1 || frame == 4; }, 6);
  EXPECT_TRUE(done);
  EXPECT_EQ(shown_, (std::vector<std::uint32_t>{2, 3, 5, 6}));
  EXPECT_EQ(opened_, 2);
}

/// The frame before the lost one is in flight.
TEST_F(LostFrames, AreLeftOutWithFramesInFlight) {
  in_flight_ = 2;
  EXPECT_TRUE(show([](std::uint32_t frame) { return frame == 1 || frame == 4; }, 6));
  EXPECT_EQ(shown_, (std::vector<std::uint32_t>{2, 3, 5, 6}));
}

TEST_F(LostFrames, InARowGiveTheDeviceUp) {
  const Expected<void> done = show([](std::uint32_t frame) { return frame % 20 == 0; }, 1000);
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().fault, Fault::Unavailable);
  EXPECT_NE(done.error().what.find(
                "the GPU was lost 3 times in a row (vkQueueSubmit: ErrorDeviceLost): start vr_client"),
            std::string::npos)
      << done.error().what;
  EXPECT_EQ(opened_, gpu::DeviceLosses::kMost - 1);
  EXPECT_EQ(shown_.size(), 3 * 19u);
  EXPECT_FALSE(renderer_);
}

TEST_F(LostFrames, ApartDoNot) {
  const auto is_lost = [](std::uint32_t frame) { return frame % (kEnoughFrames + 1) == 0; };
  EXPECT_TRUE(show(is_lost, gpu::DeviceLosses::kMost * (kEnoughFrames + 1)));
  EXPECT_EQ(opened_, gpu::DeviceLosses::kMost);
}

TEST_F(LostFrames, EndTheRunIfNoDeviceCanBeOpened) {
  most_opened_ = 0;
  const Expected<void> done = show([](std::uint32_t frame) { return frame == 3; }, 6);
  ASSERT_FALSE(done);
  EXPECT_NE(done.error().what.find("cannot be opened again (vkQueueSubmit: ErrorDeviceLost; no driver)"),
            std::string::npos)
      << done.error().what;
  EXPECT_EQ(shown_.size(), 2u);
}

/// As in a replay.
TEST_F(LostFrames, EndTheRunIfTheDeviceMustNotBeOpenedAgain) {
  can_open_ = false;
  const Expected<void> done = show([](std::uint32_t frame) { return frame == 3; }, 6);
  ASSERT_FALSE(done);
  EXPECT_TRUE(done.error().what.starts_with("the GPU was lost (vkQueueSubmit: ErrorDeviceLost): "))
      << done.error().what;
  EXPECT_FALSE(renderer_);
}

}  // namespace
}  // namespace farshade
