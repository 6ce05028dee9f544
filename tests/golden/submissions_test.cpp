/// What a frame asks of the device's queue: one submission, and no wait before it was submitted.
#include "stereo/base/check.h"
#include "stereo/gpu/frame_commands.h"
#include "tests/golden/test_rig.h"
#include "vr_client/modes/make_pipeline.h"

namespace farshade {
namespace {

constexpr std::uint32_t kSubmissionSide_px = 64;
constexpr int kFrames = 4;

/// Calls to the queue until now.
struct Calls {
  explicit Calls(const gpu::Device& device)
      : submissions(device.use->submissions), waits(device.use->waits) {}
  std::uint64_t submissions, waits;
};

/// Shows frames of a head that turns, and counts what each asks of the queue.
class CountedFrames final : public Runtime {
 public:
  CountedFrames(const gpu::Device& device, Rigid<Stage, Head> head) : device_(device), head_(head) {}

  [[nodiscard]] std::optional<FrameTiming> wait_frame() override {
    if (++number_ > kFrames) return std::nullopt;
    before_.emplace(device_);
    return FrameTiming{Time(number_ * std::chrono::milliseconds(11)), std::chrono::milliseconds(11)};
  }
  [[nodiscard]] StereoView locate_views(Time) override {
    return eyes_of(moved(head_, 0.02 * number_, {}), kSubmissionSide_px);
  }
  void add_output(const gpu::Recorder& append) override {
    append([&](const vk::raii::CommandBuffer&) { ++outputs_; });
    const Calls now(device_);
    EXPECT_EQ(now.submissions, before_->submissions) << "frame " << number_ << " is recorded";
    EXPECT_EQ(now.waits, before_->waits);
  }
  void end_frame(Time) override {
    const Calls now(device_);
    EXPECT_EQ(now.submissions, before_->submissions + 1) << "frame " << number_ << " is one submission";
    EXPECT_EQ(now.waits, before_->waits) << "nothing waits inside of it";
  }
  /// At the end of a frame it waits for the oldest of `frames` in flight.
  void expect_one_wait(int frames) const {
    const Calls now(device_);
    EXPECT_EQ(now.submissions, before_->submissions + 1);
    EXPECT_EQ(now.waits, before_->waits + (number_ < frames ? 0 : 1));
  }
  [[nodiscard]] int outputs() const { return outputs_; }

 private:
  const gpu::Device& device_;
  Rigid<Stage, Head> head_;
  std::optional<Calls> before_;
  int number_ = 0, outputs_ = 0;
};

class SubmissionsOfModes : public OnLavapipe,
                           public testing::WithParamInterface<std::tuple<Mode, std::uint32_t>> {};

TEST_P(SubmissionsOfModes, AFrameWithoutAServerIsOneAndEndsWithOneWait) {
  const Scene scene = bundled("room.glb");
  const Extent size{kSubmissionSide_px, kSubmissionSide_px};
  const auto [mode, frames] = GetParam();
  const std::unique_ptr<Renderer> renderer =
      make_renderer(device_, scene, RendererLimits{size, size, 2, frames});
  CountedFrames runtime(device_, head_at_camera(scene));
  const FrameSettings settings;
  const RunContext context{.scene = scene,
                           .runtime = runtime,
                           .renderer = *renderer,
                           .mode = {.mode = mode},
                           .settings = settings,
                           .policy = {.pace = Pace::Real}};
  draw_ahead(context, {});  // makes what is made at first use
  ASSERT_TRUE(run(
      context, *make_pipeline(context),
      [&, ago = frames - 1](const FrameView& view) {
        runtime.expect_one_wait(static_cast<int>(ago) + 1);
        ASSERT_EQ(view.finished.has_value(), view.shown.frame.value > ago);
        if (!view.finished) return;
        EXPECT_EQ(view.finished->frame.value + ago, view.shown.frame.value);
        EXPECT_GT(view.finished->ready, view.finished->begun);
        EXPECT_LE(view.finished->ready, view.starts.end);
        EXPECT_EQ(view.times.ready, view.finished->ready - view.finished->begun);
      },
      [] { return false; }));
  EXPECT_EQ(runtime.outputs(), kFrames);
}

INSTANTIATE_TEST_SUITE_P(ThatDraw, SubmissionsOfModes,
                         testing::Combine(testing::Values(Mode::Hybrid, Mode::Local, Mode::Full),
                                          testing::Values(1u, 2u, 3u)),
                         [](const auto& each) {
                           return std::string(name_of(std::get<0>(each.param))) +
                                  std::to_string(std::get<1>(each.param));
                         });

class Submissions : public OnLavapipe {
 protected:
  TestRig rig_{device_, bundled("box_over_plane.gltf"), kSubmissionSide_px};
  /// A mask, and the views of the request after it.
  Mask mask_ = rig_.ask(kTraced, rig_.eyes(rig_.head()));
  StereoView requested_ = rig_.eyes(moved(rig_.head(), 0.03, {0.01, 0, 0}));
  [[nodiscard]] bool reproject() {
    const TracedMask base = mask_.traced_mask();
    return rig_.renderer().reproject_to_request(
        {.frame = kNow, .display_time = {}, .scene_time = {}, .views = requested_}, 1, &base);
  }
  /// Draws a frame and reads what its request leaves unknown before or after the picture.
  [[nodiscard]] std::pair<RequestReprojection, PerEye<Image<Rgb8>>> frame(bool reads_first) {
    RequestReprojection found;
    EXPECT_TRUE(reproject());
    if (reads_first) rig_.renderer().read_reprojected(found);
    const std::vector<TracedMask> masks{mask_.traced_mask()};
    const SceneState state = state_at(rig_.scene(), {});
    rig_.renderer().draw({.views = rig_.eyes(moved(rig_.head(), 0.02, {})),
                          .state = state,
                          .masks = masks,
                          .reprojection = {}});
    rig_.renderer().submit();
    if (!reads_first) rig_.renderer().read_reprojected(found);
    const DrawTimes times = rig_.renderer().finish();
    EXPECT_GT(times.request_reprojection, Duration{});
    EXPECT_GT(times.depth, Duration{});
    EXPECT_GT(times.gbuffer, Duration{});
    EXPECT_GT(times.shade, Duration{});
    EXPECT_GT(times.triangles.gbuffer, 0u);
    EXPECT_GT(times.triangles.depth, 0u);
    return {std::move(found), rig_.renderer().read_shown()};
  }
};

/// A frame that asks for what its mask leaves unknown has both in one submission, and sends its request
/// before its picture is done.
TEST_F(Submissions, ARequestAndItsPictureAreOne) {
  static_cast<void>(frame(false));  // compiles
  const Calls before(device_);
  EXPECT_TRUE(reproject());
  const SceneState state = state_at(rig_.scene(), {});
  rig_.renderer().draw({.views = requested_, .state = state, .masks = {}, .reprojection = {}});
  rig_.renderer().submit();
  const Calls submitted(device_);
  EXPECT_EQ(submitted.submissions, before.submissions + 1);
  EXPECT_EQ(submitted.waits, before.waits);
  RequestReprojection found;
  rig_.renderer().read_reprojected(found);
  EXPECT_GT(part_of(found.requested), 0);
  rig_.renderer().finish();
  const Calls after(device_);
  EXPECT_EQ(after.submissions, before.submissions + 1);
  EXPECT_EQ(after.waits, before.waits + 2);
}

/// In virtual time a request is sent before its picture is recorded; both orders give the same bits.
TEST_F(Submissions, TheOrderOfReadingChangesNothing) {
  const auto [found_first, shown_first] = frame(true);
  const auto [found_last, shown_last] = frame(false);
  for (std::size_t eye = 0; eye < kEyes; ++eye) {
    EXPECT_TRUE(found_first.masks[eye] == found_last.masks[eye]);
    EXPECT_TRUE(found_first.requested.tiles[eye] == found_last.requested.tiles[eye]);
    EXPECT_TRUE(found_first.covered[eye] == found_last.covered[eye]);
  }
  EXPECT_TRUE(shown_first == shown_last);
}

/// Two pictures in a row without a call between them: the second waits until the first is done, because they
/// share their memory.
TEST_F(Submissions, PicturesInARowDoNotDisturbEachOther) {
  const SceneState state = state_at(rig_.scene(), {});
  const auto draw = [&](double turn_rad) {
    rig_.renderer().draw({.views = rig_.eyes(moved(rig_.head(), turn_rad, {})),
                          .state = state,
                          .masks = {},
                          .reprojection = {}});
  };
  draw(0.3);
  const auto alone = rig_.renderer().read_shown();
  draw(0.1);
  EXPECT_FALSE(rig_.renderer().read_shown() == alone);
  draw(0.1);
  draw(0.3);
  EXPECT_TRUE(rig_.renderer().read_shown() == alone);
  rig_.renderer().finish();
  const auto triangles = [&](double turn_rad) {
    draw(turn_rad);
    return rig_.renderer().finish().triangles.gbuffer;
  };
  const std::uint64_t first = triangles(0.1), second = triangles(0.3);
  draw(0.1);
  EXPECT_EQ(triangles(0.3), first + second) << "a frame has the times and triangles of all its parts";
}

}  // namespace
}  // namespace farshade
