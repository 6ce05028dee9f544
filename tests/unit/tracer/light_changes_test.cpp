// Lights that a viewer has switched off or moved.
#include <gtest/gtest.h>

#include "stereo/gltf/gltf.h"
#include "tests/oracle/agreement.h"
#include "tests/oracle/scene_builder.h"

namespace farshade {
namespace {

using namespace std::chrono_literals;

constexpr double kMostInCoarseBand = 0.25;  // pixels are coarse here, and the room is full of edges

class BundledScene : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    Expected<Scene> scene = load_scene(std::string(FARSHADE_ASSETS "/") + GetParam());
    ASSERT_TRUE(scene) << scene.error().what;
    scene_ = std::move(*scene);
    ASSERT_GE(lights(), 2u);
    const Rigid<Stage, Eye> camera =
        scene_.camera.value_or(look({3, 3.5, 3}, {0, 0.3, 0}, 48).stage_from_eye);
    views_[0] = {camera, {-0.6, 0.5, 0.5, -0.5}, {48, 40}};
    views_[1] = views_[0];
    views_[1].stage_from_eye.translation += glm::dvec3(0.06, 0, 0);
  }
  [[nodiscard]] std::uint32_t lights() const { return static_cast<std::uint32_t>(scene_.lights.size()); }
  [[nodiscard]] LightPose nudged(std::uint32_t light, const glm::dvec3& step) const {
    const Light now = state_at(scene_, kTime).light_set.lights[light];
    return {Point<Stage>{now.position.v + step}, {glm::normalize(now.direction.v + 0.2 * step)}};
  }
  void expect_agrees(const ShadowFrame& frame, const LightChanges& changes) const {
    EXPECT_EQ(frame.light_set_revision, changes.revision);
    const SceneState state = state_at(scene_, kTime, changes);
    for (const Side side : kSides) {
      const oracle::Agreement a =
          oracle::compare(frame.masks[index_of(side)], oracle::trace(scene_, state, views_[index_of(side)]));
      EXPECT_EQ(a.wrong, 0u) << name_of(side) << " eye at pixel " << a.wrong_x << ", " << a.wrong_y
                             << ", light " << a.wrong_light;
      EXPECT_LE(a.band_share(), kMostInCoarseBand);
      EXPECT_LE(a.wrong_in_band * 10, a.in_band);
    }
  }
  TraceStats trace(Tracer& tracer, const LightChanges& changes, ShadowFrame& frame) const {
    FrameRequest request = request_for(views_, kTime);
    request.lights = changes;
    return tracer.trace(request, frame);
  }

  static constexpr Time kTime{300ms};
  Scene scene_;
  StereoView views_;
};

TEST_P(BundledScene, ChangedLightsAreTracedAsTheyAre) {
  Tracer tracer = Tracer::create(scene_).value();
  ShadowFrame frame, as_loaded;
  trace(tracer, {}, as_loaded);
  LightChanges changes;
  change(changes, 0, true, nudged(0, {0.4, 0.1, -0.3}));
  change(changes, lights() - 1, false, std::nullopt);
  trace(tracer, changes, frame);
  expect_agrees(frame, changes);
  EXPECT_NE(frame.masks[0], as_loaded.masks[0]);
  change(changes, 0, true, std::nullopt);
  change(changes, lights() - 1, true, std::nullopt);
  trace(tracer, changes, frame);
  EXPECT_EQ(frame.masks, as_loaded.masks);
  EXPECT_EQ(frame.light_set_revision, LightSetRevision{5});
}

TEST_P(BundledScene, TwoViewersOfOneRevisionGetTheirOwnLights) {
  Tracer tracer = Tracer::create(scene_).value();
  LightChanges mine, yours;
  change(mine, 0, false, std::nullopt);
  change(yours, 1, false, std::nullopt);
  ShadowFrame frame;
  for (const LightChanges& changes : {mine, yours, mine}) {
    trace(tracer, changes, frame);
    expect_agrees(frame, changes);
  }
}

TEST_P(BundledScene, NoRayGoesToALightThatIsOff) {
  Tracer tracer = Tracer::create(scene_).value();
  ShadowFrame frame;
  const TraceStats all = trace(tracer, {}, frame);
  std::uint64_t alone_rays = 0;
  for (std::uint32_t on = 0; on < lights(); ++on) {
    LightChanges changes;
    for (std::uint32_t light = 0; light < lights(); ++light)
      if (light != on) change(changes, light, false, std::nullopt);
    const TraceStats alone = trace(tracer, changes, frame);
    EXPECT_EQ(alone.full_shadow_rays * lights(), all.full_shadow_rays);
    alone_rays += alone.shadow_rays;
  }
  EXPECT_EQ(alone_rays, all.shadow_rays);

  LightChanges dark;
  for (std::uint32_t light = 0; light < lights(); ++light) change(dark, light, false, std::nullopt);
  const TraceStats none = trace(tracer, dark, frame);
  EXPECT_EQ(none.shadow_rays + none.full_shadow_rays + none.primary_rays, 0u);
  for (const Side side : kSides)
    EXPECT_EQ(frame.masks[index_of(side)], EyeMask(views_[index_of(side)].size, lights()));
}

INSTANTIATE_TEST_SUITE_P(Named, BundledScene, testing::Values("box_over_plane.gltf", "room.glb"),
                         [](const auto& tested) { return std::string(tested.param).substr(0, 3); });

}  // namespace
}  // namespace farshade
