/// Frames that the host prepares while the device works on earlier ones are the same, bit for bit, as frames
/// that wait for each other.
#include <algorithm>
#include <bit>
#include <random>

#include "stereo/gpu/memory.h"
#include "tests/golden/test_rig.h"
#include "tests/oracle/random_scenes.h"
#include "tests/oracle/scene_builder.h"

namespace farshade {
namespace {

using namespace std::chrono_literals;

constexpr std::uint32_t kFlightSide_px = 96, kFlightFrames = 15, kFlightSlots = 6;
constexpr Extent kFlightSize{kFlightSide_px, kFlightSide_px};

/// What the session has of each frame before it is drawn.
struct Moment {
  StereoView views;
  Time time;
  Mask mask;  ///< of the frame's request, which asks for the shown views
};

/// A head that moves; masks of noise, so that each differs from the others everywhere.
std::vector<Moment> moments_of(TestRig& rig) {
  std::vector<Moment> moments;
  for (std::uint32_t i = 0; i < kFlightFrames; ++i) {
    const Time now = Time(500ms) + i * 40ms;
    const StereoView views = rig.eyes(moved(rig.head(), 0.03 * i, {0.01 * i, 0, 0}));
    rig.set_time(now);
    moments.push_back({views, now, with_noise(rig.trace(FrameId{i + 1}, views), i)});
  }
  return moments;
}

/// Draws frames of all kinds and copies each picture, without waiting between them.
class Flight {
 public:
  Flight(const gpu::Device& device, const Scene& scene, const std::vector<Moment>& moments,
         std::uint32_t frames)
      : scene_(scene),
        moments_(moments),
        renderer_(make_renderer(device, scene,
                                RendererLimits{.size = kFlightSize,
                                               .traced_size = kFlightSize,
                                               .depth_frames = kFlightSlots,
                                               .frames = frames})),
        pictures_(gpu::make_readback_buffer(device, kFlightFrames * kPicture_bytes,
                                            vk::BufferUsageFlagBits::eTransferDst, "pictures")) {
    std::mt19937 random{5};  // the seed
    for (std::size_t eye = 0; eye < kEyes; ++eye) {
      planes_.base_color[eye] = PixelPlane(kFlightSize, 3);
      planes_.normal[eye] = PixelPlane(kFlightSize, 4);
      planes_.depth[eye] = PixelPlane(kFlightSize, 4);
      for (std::uint32_t& word : planes_.base_color[eye].words)
        word = narrow<std::uint32_t>(random() & 0xffffff);
      for (std::uint32_t& word : planes_.normal[eye].words) word = narrow<std::uint32_t>(random());
      std::ranges::fill(planes_.depth[eye].words, std::bit_cast<std::uint32_t>(0.06f));
      turned_[eye] = Image<Rgb8>(kFlightSize, Rgb8(10, 200, 90));
    }
  }

  /// The pixels of all frames, and what each request left unknown.
  struct Seen {
    std::vector<std::uint32_t> pixels;
    std::vector<RequestReprojection> unknown;
    std::vector<DrawTimes> times;
  };
  Seen fly() {
    Seen seen;
    for (std::uint32_t i = 0; i < kFlightFrames; ++i) {
      const bool reprojects = i % 5 == 1 && begin_request(i);
      draw(i);
      renderer_->append([&](const vk::raii::CommandBuffer& commands) { copy_picture(commands, i); });
      renderer_->submit();
      if (reprojects) renderer_->read_reprojected(seen.unknown.emplace_back());
      seen.times.push_back(renderer_->finish());
    }
    static_cast<void>(renderer_->read_shown());  // waits
    const auto words = pictures_.as<std::uint32_t>();
    seen.pixels.assign(words.begin(), words.end());
    return seen;
  }

 private:
  static constexpr std::size_t kPicture_bytes = kEyes * kFlightSide_px * kFlightSide_px * 4;

  [[nodiscard]] FrameMoment request(std::uint32_t i) const {
    const Moment& moment = moments_[i];
    return {.frame = moment.mask.frame,
            .display_time = moment.time,
            .scene_time = moment.time,
            .views = moment.views};
  }
  bool begin_request(std::uint32_t i) {
    const TracedMask base = moments_[i - 1].mask.traced_mask();
    return renderer_->reproject_to_request(request(i), i % kFlightSlots, &base);
  }

  void draw(std::uint32_t i) {
    const SceneState state = state_at(scene_, moments_[i].time);
    const FrameMoment asked = request(i);
    std::vector<TracedMask> masks;
    for (std::uint32_t back = 1; back <= std::min(i, 3u); ++back)
      masks.push_back(moments_[i - back].mask.traced_mask());
    ShownFrame frame{.views = moments_[i].views, .state = state, .masks = masks, .reprojection = {}};
    if (i % 5 != 1) frame.request = &asked, frame.request_slot = i % kFlightSlots;
    if (i % 5 == 2) frame.shadow_maps = &maps_;
    if (i % 5 == 3) return renderer_->draw_with_difference(frame, turned_, moments_[i - 1].views);
    if (i % 5 == 4 && i > 5) return renderer_->draw_received(planes_, frame);
    renderer_->draw(frame);
  }

  void copy_picture(const vk::raii::CommandBuffer& commands, std::uint32_t i) const {
    const gpu::Image& shown = renderer_->shown();
    constexpr auto rest = vk::ImageLayout::eGeneral, source = vk::ImageLayout::eTransferSrcOptimal;
    gpu::transition(commands, shown, rest, source);
    commands.copyImageToBuffer(
        *shown.image, source, *pictures_.buffer,
        vk::BufferImageCopy{.bufferOffset = i * kPicture_bytes,
                            .imageSubresource = {shown.aspect, 0, 0, narrow<std::uint32_t>(kEyes)},
                            .imageExtent = {kFlightSide_px, kFlightSide_px, 1}});
    gpu::transition(commands, shown, source, rest);
    gpu::show_copies_to_host(commands);
  }

  const Scene& scene_;
  const std::vector<Moment>& moments_;
  std::unique_ptr<Renderer> renderer_;
  gpu::ReadbackBuffer pictures_;
  GBufferPlanes planes_;
  PerEye<Image<Rgb8>> turned_;
  ShadowMapSettings maps_{.side_px = 128};
};

class FramesInFlight : public OnLavapipe, public testing::WithParamInterface<const char*> {
 protected:
  static Scene scene() {
    if (std::string_view(GetParam()) == "Room") return bundled("room.glb");
    std::mt19937 random{11};  // the seed
    Scene figures = bending_figures(random);
    figures.camera = look({0.3, 1.5, 2.6}, {0, 0.8, 0}, 1).stage_from_eye;
    return figures;
  }
};

TEST_P(FramesInFlight, AreTheSameAsFramesThatWaitForEachOther) {
  TestRig rig(device_, scene(), kFlightSide_px);
  const std::vector<Moment> moments = moments_of(rig);
  const Flight::Seen one_by_one = Flight(device_, rig.scene(), moments, 1).fly();
  ASSERT_EQ(one_by_one.unknown.size(), 3u);
  for (const std::uint32_t frames : {2u, 3u}) {
    const Flight::Seen seen = Flight(device_, rig.scene(), moments, frames).fly();
    EXPECT_TRUE(seen.pixels == one_by_one.pixels) << frames << " frames";
    for (std::size_t i = 0; i < seen.unknown.size(); ++i)
      for (std::size_t eye = 0; eye < kEyes; ++eye) {
        EXPECT_TRUE(seen.unknown[i].masks[eye] == one_by_one.unknown[i].masks[eye]) << i;
        EXPECT_TRUE(seen.unknown[i].covered[eye] == one_by_one.unknown[i].covered[eye]) << i;
      }
    for (std::uint32_t i = 0; i < kFlightFrames; ++i) {
      EXPECT_EQ(seen.times[i].gbuffer > Duration{}, i + 1 >= frames) << "those of the oldest frame: " << i;
      EXPECT_EQ(seen.times[i].triangles.gbuffer, one_by_one.times[i].triangles.gbuffer) << i;
      EXPECT_GT(seen.times[i].total, Duration{});
    }
  }
}

/// Comparisons after a run draw many pictures without a frame between them.
TEST_P(FramesInFlight, PicturesThatAreNoFramesUseTheirMemoryAgain) {
  TestRig rig(device_, scene(), kFlightSide_px);
  const std::vector<Moment> moments = moments_of(rig);
  const auto uploads_after = [&](int pictures) {
    device_.ledger = std::make_shared<gpu::Ledger>();
    const RendererLimits limits{.size = kFlightSize, .traced_size = kFlightSize, .frames = 2};
    const std::unique_ptr<Renderer> renderer = make_renderer(device_, rig.scene(), limits);
    for (int i = 0; i < pictures; ++i) {
      const Moment& moment = moments[static_cast<std::size_t>(i) % moments.size()];
      const SceneState state = state_at(rig.scene(), moment.time);
      const std::vector<TracedMask> masks{moment.mask.traced_mask()};
      renderer->draw({.views = moment.views,
                      .state = state,
                      .masks = masks,
                      .reprojection = {.lookup = Lookup::Direct}});
      renderer->discard_times();
    }
    return device_.ledger->read().peak[gpu::Use::Uploads];
  };
  EXPECT_EQ(uploads_after(60), uploads_after(15));
}

INSTANTIATE_TEST_SUITE_P(Of, FramesInFlight, testing::Values("Room", "BendingFigures"),
                         [](const auto& scene) { return std::string(scene.param); });

}  // namespace
}  // namespace farshade
