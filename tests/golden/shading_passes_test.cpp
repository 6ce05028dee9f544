/// The passes that a plan chooses for a device give the same pictures and reports, bit for bit.
#include <random>

#include "tests/golden/test_rig.h"
#include "tests/oracle/random_scenes.h"
#include "tests/oracle/scene_builder.h"

namespace farshade {
namespace {

using namespace std::chrono_literals;

struct PassesCase {
  const char* name;
  Scene (*scene)();
  Reprojection reprojection{};
  std::uint32_t masks = 3;
  enum class CubeMask : std::uint8_t { None, Kept } cube_mask = CubeMask::Kept;
  enum class Tiles : std::uint8_t { Whole, Lost } tiles = Tiles::Lost;
  Changes lights = Changes::Possible;  ///< by the viewer
};

std::ostream& operator<<(std::ostream& out, const PassesCase& tested) {
  return out << tested.name;
}

/// Moving lights and moving things.
Scene room() {
  return bundled("room.glb");
}

/// Nothing moves. Two groups of lights, which no variant for few lights serves.
Scene nine_lights() {
  return with_lights(bundled("box_over_plane.gltf"), 9);
}

Scene figures() {
  std::mt19937 random{11};  // the seed
  Scene scene = bending_figures(random);
  scene.camera = look({0.3, 1.5, 2.6}, {0, 0.8, 0}, 1).stage_from_eye;
  return scene;
}

class ShadingPassesOf : public OnLavapipe, public testing::WithParamInterface<PassesCase> {
 protected:
  static constexpr std::uint32_t kSide_px = 160;

  /// With masks of other poses and earlier times, after a change of the lights, and with masks of noise.
  std::vector<Shown> shown_with(ShadingPasses passes) {
    const PassesCase& tested = GetParam();
    TestRig rig(device_, tested.scene(), kSide_px, 4, 0, passes);
    std::vector<Mask> masks;  // newest first
    for (std::uint32_t i = 0; i < tested.masks; ++i) {
      rig.set_time(Time(650ms + 25ms * i));
      const double back = tested.masks - i;
      masks.insert(masks.begin(),
                   rig.ask({i + 1}, rig.eyes(moved(rig.head(), 0.04 * back, {0.02 * back, 0, 0.03}))));
    }
    if (tested.tiles == PassesCase::Tiles::Lost)
      for (std::size_t tile = 0; tile < masks[0].received_tiles[0].size(); ++tile)
        masks[0].received_tiles[tile % 2][tile] = tile % 5 != 0;
    std::vector<Mask> cube_mask;
    if (tested.cube_mask == PassesCase::CubeMask::Kept)
      cube_mask = rig.ask_cube_mask({rig.head().translation});
    rig.set_time(Time(750ms));
    const auto show = [&] {
      std::vector<TracedMask> traced;
      for (const Mask& mask : masks) traced.push_back(mask.traced_mask());
      return rig.show(rig.eyes(rig.head()), traced, tested.reprojection, cube_mask);
    };
    std::vector<Shown> result{show()};
    if (tested.lights == Changes::Possible) {
      LightChanges changes;
      change(changes, 0, true, LightPose{{{0.3, 2, 0.2}}});
      rig.set_lights(changes);
      result.push_back(show());
    }
    for (Mask& mask : masks) mask = with_noise(mask, mask.frame.value);  // all pixels are on an edge
    result.push_back(show());
    return result;
  }
};

void expect_same(const ShownReport& some, const ShownReport& others) {
  EXPECT_TRUE(some.mask == others.mask);
  EXPECT_EQ(some.sources, others.sources);
  EXPECT_EQ(some.positions, others.positions);
  EXPECT_EQ(some.visibility, others.visibility);
  EXPECT_EQ(some.unknown, others.unknown);
  EXPECT_EQ(some.stale, others.stale);
  EXPECT_EQ(some.rays, others.rays);
}

TEST_P(ShadingPassesOf, GiveTheSameBits) {
  const std::vector<Shown> sorted = shown_with(ShadingPasses::Sorted),
                           single = shown_with(ShadingPasses::Single);
  std::size_t hard = 0;
  for (std::size_t i = 0; i < sorted.size(); ++i)
    for (std::size_t eye = 0; eye < kEyes; ++eye) {
      SCOPED_TRACE(testing::Message() << "picture " << i << ", eye " << eye);
      EXPECT_TRUE(single[i].pictures[eye].pixels == sorted[i].pictures[eye].pixels);
      expect_same(single[i].reports[eye], sorted[i].reports[eye]);
      hard += static_cast<std::size_t>(std::ranges::count_if(
          sorted[i].reports[eye].sources, [](std::uint8_t s) { return s != 0 && s != kSourceUncovered; }));
    }
  EXPECT_GT(hard, 1000u) << "pixels that the newest mask does not know";
}

constexpr Reprojection kNoGuess{.eyes = Eyes::This, .gaps = Gaps::Unknown, .edges = Edges::Nearest};

INSTANTIATE_TEST_SUITE_P(, ShadingPassesOf,
                         testing::Values(PassesCase{"room", room},
                                         PassesCase{.name = "nine_lights_whole_masks_and_coverage",
                                                    .scene = nine_lights,
                                                    .reprojection = {.edges = Edges::Coverage},
                                                    .tiles = PassesCase::Tiles::Whole,
                                                    .lights = Changes::Never},
                                         PassesCase{.name = "figures_with_gaps_and_without_cube_mask",
                                                    .scene = figures,
                                                    .reprojection = kNoGuess,
                                                    .masks = 1,
                                                    .cube_mask = PassesCase::CubeMask::None}),
                         [](const auto& tested) { return std::string(tested.param.name); });

TEST(SuitedPasses, AreSortedOnTheProcessorAndSingleOnAGpu) {
  gpu::Device device;
  device.is_cpu = true;
  EXPECT_EQ(suited_passes(device), ShadingPasses::Sorted);
  device.is_cpu = false;
  EXPECT_EQ(suited_passes(device), ShadingPasses::Single);
}

class PassesWithoutAReport : public OnLavapipe {};

/// Other variants of the shader run.
TEST_F(PassesWithoutAReport, GiveTheSamePicture) {
  std::vector<PerEye<Image<Rgb8>>> pictures;
  for (const ShadingPasses passes : {ShadingPasses::Sorted, ShadingPasses::Single}) {
    TestRig rig(device_, bundled("box_over_plane.gltf"), 128, 4, 0, passes);
    const StereoView views = rig.eyes(rig.head());
    const Mask mask = with_noise(rig.ask(kTraced, rig.eyes(moved(rig.head(), 0.1, {0.02, 0, 0}))), 1);
    const std::vector<TracedMask> masks{mask.traced_mask()};
    const SceneState state = state_at(rig.scene(), Time(20ms));
    rig.renderer().draw({.views = views, .state = state, .masks = masks, .reprojection = {}});
    pictures.push_back(rig.renderer().read_shown());
  }
  EXPECT_TRUE(pictures[0] == pictures[1]);
}

}  // namespace
}  // namespace farshade
