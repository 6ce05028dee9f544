/// A frame is drawn for the views that are located just before its picture is recorded.
#include "tests/golden/test_rig.h"
#include "tests/unit/client_modes/scripted_link.h"
#include "vr_client/modes/make_pipeline.h"

namespace farshade {
namespace {

using modes_test::ScriptedLink;

constexpr std::uint32_t kSide_px = 64;
constexpr int kFrames = 3;

/// A head that turns a little before each look at it.
class RestlessHead final : public Runtime {
 public:
  explicit RestlessHead(Rigid<Stage, Head> head) : head_(head) {}
  [[nodiscard]] std::optional<FrameTiming> wait_frame() override {
    if (++frame_ > kFrames) return std::nullopt;
    return FrameTiming{Time(frame_ * std::chrono::milliseconds(11)), std::chrono::milliseconds(11)};
  }
  [[nodiscard]] StereoView locate_views(Time) override {
    return located.emplace_back(
        eyes_of(moved(head_, 0.01 * static_cast<double>(located.size()), {}), kSide_px));
  }
  std::vector<StereoView> located;

 private:
  Rigid<Stage, Head> head_;
  int frame_ = 0;
};

struct ShownFrames {
  std::vector<StereoView> views, requested;
  std::vector<PerEye<Image<Rgb8>>> pictures;
};

class NewestPose : public OnLavapipe {
 protected:
  ShownFrames show(Locate locate, const ModeSettings& mode, ServerConnection* link = nullptr,
                   const RequestSettings& request = {}) {
    FrameSettings settings;
    settings.request = request;
    const RunContext context{.scene = scene_,
                             .runtime = head_,
                             .renderer = *renderer_,
                             .mode = mode,
                             .link = link,
                             .settings = settings,
                             .policy = {.pace = Pace::Real, .round_trip = std::chrono::milliseconds(20)},
                             .locate = locate};
    ShownFrames shown;
    const auto watch = [&](const FrameView& view) {
      shown.views.push_back(view.shown.views);
      if (view.request) shown.requested.push_back(view.request->views);
      shown.pictures.push_back(renderer_->read_shown());
    };
    EXPECT_TRUE(run(context, *make_pipeline(context), watch, [] { return false; }));
    return shown;
  }
  [[nodiscard]] PerEye<Image<Rgb8>> drawn_for(const StereoView& views) {
    const SceneState state = state_at(scene_, {});
    const ModeSettings local{.mode = Mode::Local};
    renderer_->draw(
        {.views = views, .state = state, .masks = {}, .reprojection = {}, .shadow_maps = &local.shadow_maps});
    return renderer_->read_shown();
  }

  Scene scene_ = bundled("box_over_plane.gltf");
  std::unique_ptr<Renderer> renderer_ =
      make_renderer(device_, scene_, RendererLimits{{kSide_px, kSide_px}, {kSide_px, kSide_px}, 4});
  RestlessHead head_{head_at_camera(scene_)};
};

TEST_F(NewestPose, IsDrawnAndIsWhatTheFrameSaysThatItShows) {
  const ShownFrames shown = show(Locate::ForDrawing, {.mode = Mode::Local});
  ASSERT_EQ(head_.located.size(), 2u * kFrames);
  ASSERT_EQ(shown.views.size(), std::size_t{kFrames});
  for (std::size_t frame = 0; frame < kFrames; ++frame) {
    EXPECT_EQ(shown.views[frame], head_.located[2 * frame + 1]) << frame;
    EXPECT_TRUE(shown.pictures[frame] == drawn_for(head_.located[2 * frame + 1])) << frame;
    EXPECT_FALSE(shown.pictures[frame] == drawn_for(head_.located[2 * frame])) << frame;
  }
}

TEST_F(NewestPose, IsNotAskedForInRunsThatLocateOnce) {
  const ShownFrames shown = show(Locate::Once, {.mode = Mode::Local});
  EXPECT_EQ(head_.located.size(), std::size_t{kFrames});
  EXPECT_EQ(shown.views, head_.located);
}

TEST_F(NewestPose, IsNotAskedForInModeFullWhichHasTracedItsViews) {
  const ShownFrames shown = show(Locate::ForDrawing, {.mode = Mode::Full});
  EXPECT_EQ(head_.located.size(), std::size_t{kFrames});
  EXPECT_EQ(shown.views, head_.located);
}

/// Its depth is the depth of the shown views.
TEST_F(NewestPose, IsNotAskedForIfTheRequestIsForTheShownViews) {
  ScriptedLink link;
  const ShownFrames shown = show(Locate::ForDrawing, {}, &link, {PredictorKind::Hold, GuardBandUse::Off, 1});
  ASSERT_EQ(shown.requested.size(), std::size_t{kFrames});
  EXPECT_EQ(head_.located.size(), std::size_t{kFrames});
  EXPECT_EQ(shown.views, shown.requested);
}

TEST_F(NewestPose, IsShownBesideARequestForPredictedViews) {
  ScriptedLink link;
  const ShownFrames shown = show(Locate::ForDrawing, {}, &link, {kDefaultPredictor, GuardBandUse::Off, 1});
  ASSERT_EQ(shown.requested.size(), std::size_t{kFrames});
  // Without a velocity, the first request is for the first views.
  ASSERT_EQ(head_.located.size(), 2u * kFrames - 1);
  for (std::size_t frame = 1; frame < kFrames; ++frame)
    EXPECT_EQ(shown.views[frame], head_.located[2 * frame]) << frame;
}

}  // namespace
}  // namespace farshade
