/// A renderer with a device, images and command buffers of its own gets the visibilities that Renderer shades
/// with, and no message of the validation layer, which checks synchronisation, too.
#include <numbers>

#include "stereo/plan/plan_masks.h"
#include "tests/golden/foreign_renderer.h"
#include "tests/golden/test_rig.h"

namespace farshade {
namespace {

using namespace std::chrono_literals;

constexpr std::uint32_t kEmbeddedSide_px = 192;
constexpr Time kMaskTime = Time(700ms), kShownTime = Time(725ms);

/// The room, with leaves that have no holes.
Scene solid_room() {
  Scene scene = bundled("room.glb");
  for (Material& material : scene.materials) material.alpha_cutoff.reset();
  return scene;
}

struct EmbeddingCase {
  const char* name;
  ShadingPasses passes;
  std::uint32_t lights;  ///< more than four have two layers an eye
  std::uint32_t frames;  ///< in flight
};

class Embedding : public OnLavapipe, public testing::WithParamInterface<EmbeddingCase> {
 protected:
  [[nodiscard]] static DrawPlan plan_of(const Scene& scene) {
    DrawPlan plan = plan_for(scene, {.all_lights = true}).draw;
    plan.passes = GetParam().passes;
    return plan;
  }

  [[nodiscard]] static FrameMoment moment(FrameId frame, Time time, const StereoView& views,
                                          const LightChanges& lights = {}) {
    return {.frame = frame, .display_time = time, .scene_time = time, .views = views, .lights = lights};
  }

  /// Records with `record` into a command buffer, and waits until it has been executed.
  template <class Record>
  void run(const Record& record) {
    record(foreign_.begin());
    foreign_.end();
  }

  /// The bytes of the report's visibilities that differ from those of the foreign renderer, and all.
  struct Compared {
    std::size_t different = 0, all = 0, fractions = 0;
  };
  [[nodiscard]] Compared compare(const PerEye<ShownReport>& reports) const {
    const std::vector<std::uint8_t> bytes = foreign_.visibilities();
    const std::uint32_t lights = plan_.mask.lights, quads = FARSHADE_QUADS(lights);
    Compared compared;
    for (std::size_t eye = 0; eye < kEyes; ++eye)
      for (std::size_t pixel = 0; pixel < size_.pixels(); ++pixel)
        for (std::uint32_t i = 0; i < lights; ++i) {
          const std::size_t layer = eye * quads + i / 4;
          const std::uint8_t expected = reports[eye].visibility[pixel * lights + i];
          ++compared.all;
          compared.different += bytes[(layer * size_.pixels() + pixel) * 4 + i % 4] != expected;
          compared.fractions += expected != 0 && expected != 255;
        }
    return compared;
  }

  const Extent size_{kEmbeddedSide_px, kEmbeddedSide_px};
  const RendererLimits limits_{size_, {240, 240}, 4, GetParam().frames};
  Scene scene_ = with_lights(solid_room(), GetParam().lights);
  DrawPlan plan_ = plan_of(scene_);
  TestRig rig_{device_, scene_, kEmbeddedSide_px, 4, 0, GetParam().passes};
  ForeignRenderer foreign_{scene_, size_,
                           static_cast<std::uint32_t>(kEyes) * FARSHADE_QUADS(plan_.mask.lights)};
  VisibilityRecorder recorder_ =
      VisibilityRecorder::create(foreign_.device(), scene_, plan_, limits_, GetParam().passes).value();
};

TEST_P(Embedding, GivesTheVisibilitiesAndTheUnknownBlocksOfRenderer) {
  const StereoView then = rig_.eyes(rig_.head()),
                   next = rig_.eyes(moved(rig_.head(), 0.08, {0.03, 0, -0.02})),
                   shown = rig_.eyes(moved(rig_.head(), 0.05, {0.02, 0, 0}));
  rig_.set_time(kMaskTime);
  const Mask mask = rig_.ask(kTraced, then);
  const std::vector<Mask> faces = rig_.ask_cube_mask({rig_.head().translation});
  rig_.set_time(kShownTime);
  LightChanges changes;
  change(changes, 0, false, std::nullopt);
  rig_.set_lights(changes);
  const RequestReprojection expected = rig_.reproject_to_request(kNow, next, mask).value();
  const Shown picture = rig_.show(shown, {mask.traced_mask()}, {}, faces);

  const SceneState before = state_at(scene_, kMaskTime), now = state_at(scene_, kShownTime, changes);
  std::vector<FrameMoment> pairs;
  for (const Mask& pair : faces) pairs.push_back(moment(pair.frame, kMaskTime, pair.views));
  std::vector<FaceRequest> requested;
  for (const FrameMoment& pair : pairs) requested.push_back({pair, pair_of(pair.frame)});
  run([&](VkCommandBuffer commands) {
    EXPECT_TRUE(recorder_.record_request(commands, moment(kTraced, kMaskTime, then), 2, nullptr));
    recorder_.record_faces(commands, requested, before);
  });
  recorder_.begin_frame();
  const TracedMask traced = mask.traced_mask();
  std::vector<TracedMask> traced_faces;
  for (const Mask& pair : faces) traced_faces.push_back(pair.traced_mask());
  run([&](VkCommandBuffer commands) {
    EXPECT_TRUE(recorder_.record_request(commands, moment(kNow, kShownTime, next, changes), 3, &traced));
    foreign_.draw(shown, now);
    const std::array masks{traced};
    recorder_.record_visibility(commands,
                                {.views = shown, .state = now, .masks = masks, .cube_mask = traced_faces},
                                foreign_.images());
    foreign_.read_back();
  });
  RequestReprojection found;
  recorder_.read_unknown(found);
  for (std::size_t eye = 0; eye < kEyes; ++eye) {
    EXPECT_EQ(found.covered[eye], expected.covered[eye]);
    EXPECT_EQ(found.masks[eye], expected.masks[eye]);
  }
  const Compared compared = compare(picture.reports);
  EXPECT_GT(compared.fractions, 1000u) << "filtered edges";
  EXPECT_EQ(compared.different, 0u) << "of " << compared.all;
  EXPECT_EQ(foreign_.messages(), std::vector<std::string>{});
  foreign_.make_a_hazard();
  ASSERT_FALSE(foreign_.messages().empty()) << "synchronisation is checked";
  EXPECT_NE(foreign_.messages()[0].find("SYNC-HAZARD-WRITE-AFTER-WRITE"), std::string::npos);
}

TEST_P(Embedding, RefusesWhatDoesNotFit) {
  const StereoView large = eyes_of(rig_.head(), kEmbeddedSide_px * 2);
  run([&](VkCommandBuffer commands) {
    EXPECT_THROW((void)recorder_.record_request(commands, moment(kNow, kShownTime, large), 1, nullptr),
                 std::invalid_argument);
    const SceneState now = state_at(scene_, kShownTime);
    EXPECT_THROW(recorder_.record_visibility(commands, {.views = large, .state = now}, foreign_.images()),
                 std::invalid_argument);
  });
  const Scene other = with_lights(scene_, GetParam().lights + 1);
  const Expected<VisibilityRecorder> of_another =
      VisibilityRecorder::create(foreign_.device(), other, plan_, limits_);
  ASSERT_FALSE(of_another);
  EXPECT_EQ(of_another.error().fault, Fault::Unsupported);
}

/// The slot of a request is that of its base.
TEST_P(Embedding, ARequestInTheSlotOfItsBaseKeepsNoDepth) {
  const StereoView views = rig_.eyes(rig_.head());
  const Mask mask = rig_.trace(kTraced, views);
  const TracedMask base = mask.traced_mask();
  run([&](VkCommandBuffer commands) {
    EXPECT_TRUE(recorder_.record_request(commands, moment(kTraced, kMaskTime, views), 2, nullptr));
  });
  recorder_.begin_frame();
  run([&](VkCommandBuffer commands) {
    EXPECT_FALSE(recorder_.record_request(commands, moment(kNow, kShownTime, views), 2, &base));
    EXPECT_TRUE(recorder_.record_request(commands, moment(kNow, kShownTime, views), 2, nullptr));
  });
}

INSTANTIATE_TEST_SUITE_P(, Embedding,
                         testing::Values(EmbeddingCase{"sorted", ShadingPasses::Sorted, 3, 1},
                                         EmbeddingCase{"single", ShadingPasses::Single, 6, 2}),
                         [](const auto& tested) { return std::string(tested.param.name); });

}  // namespace
}  // namespace farshade
