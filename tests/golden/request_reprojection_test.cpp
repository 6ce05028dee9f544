/// Reprojecting a mask to requested views, and what a request must ask for (docs/partial-requests.md): every
/// bit of the composed mask is either traced at these views or equal to what a trace gives, except a stated
/// share.
#include <cmath>
#include <numbers>

#include "tests/golden/test_rig.h"
#include "tests/oracle/scene_builder.h"

namespace farshade {
namespace {

using namespace std::chrono_literals;

constexpr double kOneDegree = std::numbers::pi / 180;
constexpr std::uint32_t kSide_px = 256;
constexpr std::uint32_t kThreeLights = 7;  // bits of the lights of room.glb

/// Shares of the bits of both eyes, percent: those that are asked for, and those of the others that differ
/// from a trace.
struct Shares {
  double requested = 0, wrong = 0;
};

/// Of a mask that was composed: `truth` has the traced bits.
Shares shares_of(const Mask& composed, const Mask& truth) {
  std::size_t bits = 0, requested = 0, wrong = 0;
  const std::uint32_t lights = truth.bits[0].lights();
  for (std::size_t eye = 0; eye < kEyes; ++eye)
    for_pixels(truth.views[eye].size, [&](std::uint32_t x, std::uint32_t y) {
      const std::uint32_t here = requested_bits(composed.requested, eye, truth.views[eye].size, {x, y});
      for (std::uint32_t i = 0; i < lights; ++i) {
        const bool is_requested = (here >> (i % 32) & 1) != 0;
        requested += is_requested;
        wrong += !is_requested && composed.bits[eye].lit(x, y, i) != truth.bits[eye].lit(x, y, i);
      }
      bits += lights;
    });
  const auto percent = [](std::size_t part, std::size_t all) {
    return 100 * static_cast<double>(part) / static_cast<double>(all);
  };
  return {percent(requested, bits), percent(wrong, bits)};
}

class ReprojectionToRequest : public OnLavapipe {};

/// A floor and a box that do not move, a box that moves, and lights that do not.
Scene moving_box() {
  SceneBuilder builder;
  builder.add(quad({0, 0, 0}, {0, 0, 4}, {4, 0, 0}));
  builder.add(box({0, 0.6, 0}, {0.3, 0.3, 0.3}));
  builder.point_light({0.8, 2, 0.5});
  builder.directional_light({-1, -1, -0.3});
  builder.move(builder.add(box({-1, 0.6, 0.5}, {0.15, 0.15, 0.15})), {0.5, 0, 0});
  return builder.build();
}

const Rigid<Stage, Head> kAbove = head_looking({0.5, 1.6, 2.5}, {0, 0.4, 0});

struct ReprojectionMove {
  const char* name;
  double yaw_rad;
  glm::dvec3 step_m;
  double most_wrong;  ///< percent
};

class ReprojectionAfter : public OnLavapipe, public testing::WithParamInterface<ReprojectionMove> {};

TEST_P(ReprojectionAfter, LeavesOnlyBitsThatATraceGives) {
  // More lights have more shadow edges. Lights of 1, 2 and 4 bytes, and of two planes.
  for (const auto& [lights, most_requested] : {std::pair{3u, 60.0}, {9u, 70.0}, {17u, 85.0}, {40u, 95.0}}) {
    TestRig rig(device_, with_lights(bundled("room.glb"), lights), 2 * kSide_px);
    const Mask base = rig.ask(kTraced, rig.eyes(rig.head()));
    const StereoView views = rig.eyes(moved(rig.head(), GetParam().yaw_rad, GetParam().step_m));
    const Mask composed = rig.ask_for_unknown(kNow, views, base);
    const Shares shares = shares_of(composed, rig.trace(kNow, views));
    RecordProperty("asked_percent", std::to_string(shares.requested));
    RecordProperty("wrong_percent", std::to_string(shares.wrong));
    EXPECT_GT(shares.requested, 1) << lights << " lights";
    EXPECT_LT(shares.requested, most_requested) << lights << " lights";
    EXPECT_LT(shares.wrong, GetParam().most_wrong) << lights << " lights";
  }
}

INSTANTIATE_TEST_SUITE_P(, ReprojectionAfter,
                         testing::Values(ReprojectionMove{"nothing", 0, {0, 0, 0}, 0.01},
                                         ReprojectionMove{"a_turn", 3 * kOneDegree, {0, 0, 0}, 0.03},
                                         ReprojectionMove{"a_step", 0, {0.03, 0.01, -0.02}, 0.03},
                                         ReprojectionMove{"both", -2 * kOneDegree, {-0.02, 0, 0.03}, 0.03}),
                         [](const auto& tested) { return std::string(tested.param.name); });

TEST_F(ReprojectionToRequest, AsksForWhatTheBaseDidNotSee) {
  TestRig rig(device_, bundled("room.glb"), kSide_px);
  const Mask base = rig.ask(kTraced, rig.eyes(rig.head()));
  const StereoView views = rig.eyes(moved(rig.head(), 20 * kOneDegree, {0, 0, 0}));
  const Mask composed = rig.ask_for_unknown(kNow, views, base);
  // A turn to the left uncovers the left border: 20 of about 63 degrees.
  for (std::size_t eye = 0; eye < kEyes; ++eye)
    for_pixels({kSide_px / 5, kSide_px}, [&](std::uint32_t x, std::uint32_t y) {
      ASSERT_EQ(requested_bits(composed.requested, eye, views[eye].size, {x, y}) & kThreeLights, kThreeLights)
          << x << ", " << y;
    });
  const StereoView behind = rig.eyes(moved(rig.head(), 180 * kOneDegree, {0, 0, 0}));
  EXPECT_EQ(shares_of(rig.ask_for_unknown({4}, behind, base), rig.trace({4}, behind)).requested, 100);
}

TEST_F(ReprojectionToRequest, WithoutABaseAsksForAllLightsWhereASurfaceIs) {
  TestRig rig(device_, bundled("box_over_plane.gltf"), kSide_px);
  const StereoView views = rig.eyes(rig.head());
  static_cast<void>(rig.ask(kTraced, views));
  RequestReprojection reprojected;
  const FrameMoment request{.frame = kNow, .display_time = {}, .scene_time = {}, .views = views};
  const Scene scene = bundled("box_over_plane.gltf");
  const std::unique_ptr<Renderer> renderer_owner =
      make_renderer(device_, scene, RendererLimits{{kSide_px, kSide_px}, {kSide_px, kSide_px}, 2});
  Renderer& renderer = *renderer_owner;
  ASSERT_TRUE(renderer.reproject_to_request(request, 0, nullptr));
  renderer.read_reprojected(reprojected);
  std::size_t surfaces = 0, blocks = 0;
  for (std::size_t eye = 0; eye < kEyes; ++eye) {
    const RequestedTile all = all_lights_in(kAllBlocks, reprojected.requested.lights);
    for_pixels(views[eye].size, [&](std::uint32_t x, std::uint32_t y) {
      if (rig.requested_distance()[eye].pixels[std::size_t{y} * kSide_px + x] == 0) return;
      ++surfaces;
      const std::uint32_t tile = y / kTileSide_px * TileGrid{views[eye].size}.columns() + x / kTileSide_px;
      const auto bit =
          static_cast<std::uint32_t>(std::countr_zero(block_bit(x % kTileSide_px, y % kTileSide_px)));
      ASSERT_EQ(reprojected.requested.tiles[eye][tile].at(bit), all.at(bit)) << x << ", " << y;
    });
    for (const RequestedTile& tile : reprojected.requested.tiles[eye])
      blocks += static_cast<std::size_t>(std::popcount(tile.any()));
  }
  EXPECT_GT(surfaces, 10'000u);
  EXPECT_LT(blocks * kBlockSide_px * kBlockSide_px, surfaces * 11 / 10) << "the sky is asked for";
}

/// The lights that differ between the pixels of a block and those around it.
std::uint32_t differing_bits(const EyeMask& mask, glm::uvec2 pixel) {
  const glm::uvec2 block = pixel / kBlockSide_px * kBlockSide_px;
  const std::uint32_t first = mask.word(block.x, block.y);
  std::uint32_t differ = 0;
  for (std::uint32_t y = std::max(block.y, 1u) - 1; y < std::min(block.y + 5, mask.size().height); ++y)
    for (std::uint32_t x = std::max(block.x, 1u) - 1; x < std::min(block.x + 5, mask.size().width); ++x)
      differ |= mask.word(x, y) ^ first;
  return differ;
}

TEST_F(ReprojectionToRequest, AsksOnlyForTheLightsThatHaveAnEdgeThere) {
  SceneBuilder builder;
  builder.add(quad({0, 0, 0}, {0, 0, 9}, {9, 0, 0}));
  builder.add(box({0.4, 2.2, 0.2}, {0.2, 0.2, 0.2}));  // above the views: they see one plane
  for (const double side : {-1.0, 0.0, 1.0}) builder.point_light({0.6 * side, 3, 0.3 * side});
  TestRig rig(device_, builder.build(), kSide_px);
  const StereoView views = rig.eyes(head_looking({0.3, 1.5, 0.8}, {0.3, 0, 0}));
  const Mask base = rig.ask(kTraced, views);
  const RequestReprojection reprojected = rig.reproject_to_request(kNow, views, base).value();
  std::array<std::size_t, 4> pixels{};  // by the number of lights that are asked for
  for (std::size_t eye = 0; eye < kEyes; ++eye)
    for_pixels(views[eye].size, [&](std::uint32_t x, std::uint32_t y) {
      if (std::min(x, y) < 8 || std::max(x, y) >= kSide_px - 8)
        return;  // the taps of a border may lie outside
      const std::uint32_t requested =
          requested_bits(reprojected.requested, eye, views[eye].size, {x, y}) & kThreeLights;
      ++pixels[static_cast<std::size_t>(std::popcount(requested))];
      ASSERT_EQ(requested & ~differing_bits(base.bits[eye], {x, y}), 0u) << x << ", " << y;
    });
  EXPECT_GT(pixels[0], 80'000u);
  EXPECT_GT(pixels[1], 1000u);
  EXPECT_LT(pixels[3], pixels[1] / 4) << "edges of different lights seldom lie in one block";
}

struct SurfaceStep {
  double footprints;
  float detail_px;
  bool is_one_surface;
};

/// The new views are half a pixel away from the mask's. In each row, one point lies in the middle between the
/// two pixels beside the step, and the depth between them differs from the point's by half of the step.
TEST_F(ReprojectionToRequest, TakesSurfacesWithinTheToleranceForOne) {
  for (const SurfaceStep& step : {SurfaceStep{1.4, 0, true}, {3, 0, false}, {5, 1, true}, {9, 1, false}}) {
    const SteppedWall wall{.side_px = kSide_px, .step = step.footprints};
    TestRig rig(device_, wall.scene(), kSide_px, 4, step.detail_px);
    const Mask base = rig.ask(kTraced, wall.views(0.25));
    const StereoView views = wall.views(0.75);
    const RequestReprojection reprojected = rig.reproject_to_request(kNow, views, base).value();
    std::size_t wrong = 0;
    for (std::size_t eye = 0; eye < kEyes; ++eye)
      for_pixels(views[eye].size, [&](std::uint32_t x, std::uint32_t y) {
        if (std::min(x, y) < 8 || std::max(x, y) >= kSide_px - 8) return;
        const bool is_beside_step = x / kBlockSide_px == (kSide_px / 2 - 1) / kBlockSide_px;
        const bool is_requested =
            (requested_bits(reprojected.requested, eye, views[eye].size, {x, y}) & 1) != 0;
        wrong += is_requested != (is_beside_step && !step.is_one_surface);
      });
    EXPECT_EQ(wrong, 0u) << "pixels at a step of " << step.footprints << " footprints, with a detail of "
                         << step.detail_px << " px";
  }
}

TEST_F(ReprojectionToRequest, AsksForTilesThatHaveNotCome) {
  TestRig rig(device_, bundled("room.glb"), kSide_px);
  const StereoView views = rig.eyes(rig.head());
  Mask base = rig.ask(kTraced, views);
  const std::uint32_t columns = TileGrid{views[0].size}.columns();
  const auto is_lost = [](std::uint32_t tile) { return tile % 7 == 3; };
  for (ReceivedTiles& tiles : base.received_tiles)
    for (std::uint32_t tile = 0; tile < tiles.size(); ++tile) tiles[tile] = !is_lost(tile);
  const RequestReprojection reprojected = rig.reproject_to_request(kNow, views, base).value();
  for (std::size_t eye = 0; eye < kEyes; ++eye)
    for_pixels(views[eye].size, [&](std::uint32_t x, std::uint32_t y) {
      const bool is_covered = rig.requested_distance()[eye].pixels[std::size_t{y} * kSide_px + x] > 0;
      if (!is_covered || !is_lost(y / kTileSide_px * columns + x / kTileSide_px)) return;
      ASSERT_EQ(requested_bits(reprojected.requested, eye, views[eye].size, {x, y}) & kThreeLights,
                kThreeLights)
          << x << ", " << y;
    });
}

TEST_F(ReprojectionToRequest, AsksForBlocksOfTheBaseThatHaveNotCome) {
  TestRig rig(device_, bundled("room.glb"), kSide_px);
  const StereoView views = rig.eyes(rig.head());
  const Mask first = rig.ask(kOlder, views);
  Mask base = rig.ask_for_unknown(kTraced, views, first);
  const Mask whole = base;
  for (ReceivedTiles& tiles : base.received_tiles) std::ranges::fill(tiles, std::uint8_t{0});
  const RequestReprojection reprojected = rig.reproject_to_request(kNow, views, base).value();
  std::size_t again = 0;
  for (std::size_t eye = 0; eye < kEyes; ++eye)
    for_pixels(views[eye].size, [&](std::uint32_t x, std::uint32_t y) {
      const bool is_covered = rig.requested_distance()[eye].pixels[std::size_t{y} * kSide_px + x] > 0;
      if (!is_covered || requested_bits(base.requested, eye, views[eye].size, {x, y}) == 0) return;
      ++again;
      ASSERT_EQ(requested_bits(reprojected.requested, eye, views[eye].size, {x, y}) & kThreeLights,
                kThreeLights)
          << x << ", " << y;
    });
  EXPECT_GT(again, 1000u);
  const Shares shares = shares_of(rig.ask_for_unknown(kNow, views, whole), rig.trace(kNow, views));
  EXPECT_LT(shares.requested, 70);
}

/// Of a composed mask whose answer is still on its way, only what was reprojected is shown.
TEST_F(ReprojectionToRequest, BlocksThatHaveNotComeAreNotShown) {
  TestRig rig(device_, bundled("room.glb"), kSide_px);
  const StereoView views = rig.eyes(rig.head());
  const Mask first = rig.ask(kOlder, views);
  Mask mask = rig.ask_for_unknown(kTraced, views, first);
  for (ReceivedTiles& tiles : mask.received_tiles) std::ranges::fill(tiles, std::uint8_t{0});
  const Shown shown = rig.show(views, {mask.traced_mask()}, kPlainReprojection);
  std::size_t missing = 0, there = 0;
  for_covered(shown, [&](Side side, std::uint32_t x, std::uint32_t y, std::uint8_t source) {
    const std::size_t eye = index_of(side);
    const bool is_requested = requested_bits(mask.requested, eye, views[eye].size, {x, y}) != 0;
    ++(is_requested ? missing : there);
    ASSERT_EQ(source == kSourceUnknown, is_requested) << x << ", " << y;
  });
  EXPECT_GT(missing, 1000u);
  EXPECT_GT(there, 10'000u);
}

TEST_F(ReprojectionToRequest, AsksForWhereAMovingBoxCastsItsShadow) {
  TestRig rig(device_, moving_box(), kSide_px);
  const StereoView views = rig.eyes(kAbove);
  const Mask base = rig.ask(kTraced, views);
  rig.set_time(Time(100ms));
  const Mask composed = rig.ask_for_unknown(kNow, views, base);
  const Mask truth = rig.trace(kNow, views);
  std::size_t changed = 0;
  for (std::size_t eye = 0; eye < kEyes; ++eye)
    for_pixels(views[eye].size, [&](std::uint32_t x, std::uint32_t y) {
      if (same_bits(base.bits[eye], {x, y}, truth.bits[eye], {x, y})) return;
      ++changed;
      EXPECT_TRUE(same_bits(composed.bits[eye], {x, y}, truth.bits[eye], {x, y})) << x << ", " << y;
    });
  EXPECT_GT(changed, 100u);
  EXPECT_LT(shares_of(composed, truth).requested, 50);
}

/// Light `light` is asked for in all covered pixels, and less than `most_others` of the two others.
void expect_all_of(std::uint32_t light, const RequestReprojection& reprojected, TestRig& rig,
                   double most_others) {
  std::size_t covered = 0, others = 0;
  for (std::size_t eye = 0; eye < kEyes; ++eye)
    for_pixels({kSide_px, kSide_px}, [&](std::uint32_t x, std::uint32_t y) {
      if (!(rig.requested_distance()[eye].pixels[std::size_t{y} * kSide_px + x] > 0)) return;
      const std::uint32_t requested =
          requested_bits(reprojected.requested, eye, {kSide_px, kSide_px}, {x, y}) & kThreeLights;
      ASSERT_TRUE((requested >> light & 1) != 0) << x << ", " << y;
      ++covered;
      others += static_cast<std::size_t>(std::popcount(requested & ~(1u << light)));
    });
  EXPECT_GT(covered, std::size_t{kSide_px} * kSide_px);
  EXPECT_GT(others, 0u);
  EXPECT_LT(static_cast<double>(others), most_others * 2 * static_cast<double>(covered));
}

constexpr std::uint32_t kPendant = 1;  // a light of room.glb

/// A horizontal plate with lights above and below it: one that is seen from both sides, or one for each side.
Scene plate(bool of_one) {
  SceneBuilder builder;
  builder.add(quad({0, 1.2, 0}, {0, 0, 1}, {1, 0, 0}), of_one ? 0 : builder.material({}));
  if (!of_one) builder.add(quad({0, 1.2, 0}, {1, 0, 0}, {0, 0, 1}), builder.material({}));
  builder.point_light({0.4, 2, 0.2});
  builder.point_light({-0.3, 0.4, 0.1});
  return builder.build();
}

TEST_F(ReprojectionToRequest, DoesNotCrossToTheOtherSideOfASurface) {
  const auto eye_at = [](double y_m) { return head_looking({0.1, y_m, 1.6}, {0, 1.2, 0}); };
  for (const bool of_one : {true, false}) {
    SCOPED_TRACE(of_one);
    TestRig rig(device_, plate(of_one), kSide_px);
    for (const auto& [before_m, after_m] : {std::pair{1.1, 1.3}, {1.3, 1.1}, {1.16, 1.21}, {1.7, 0.7}}) {
      const Mask base = rig.ask(kTraced, rig.eyes(eye_at(before_m)));
      const StereoView views = rig.eyes(eye_at(after_m));
      const Mask truth = rig.trace(kNow, views);
      std::size_t lit = 0;
      for_pixels(views[0].size,
                 [&](std::uint32_t x, std::uint32_t y) { lit += truth.bits[0].word(x, y) != 0 ? 1u : 0u; });
      EXPECT_GT(lit, 500u);
      EXPECT_LT(shares_of(rig.ask_for_unknown(kNow, views, base), truth).wrong, 0.01) << after_m;
    }
    const Mask base = rig.ask(kTraced, rig.eyes(eye_at(1.3)));
    const StereoView views = rig.eyes(eye_at(1.4));
    EXPECT_LT(shares_of(rig.ask_for_unknown(kNow, views, base), rig.trace(kNow, views)).requested, 10)
        << "from the same side it is reprojected";
  }
}

TEST_F(ReprojectionToRequest, AsksForAllOfALightThatHasMoved) {
  TestRig rig(device_, bundled("room.glb"), kSide_px);
  const StereoView views = rig.eyes(rig.head());
  const Mask base = rig.ask(kTraced, views);
  rig.set_time(Time(300ms));  // the pendant swings, and so does its shade
  const Mask composed = rig.ask_for_unknown(kNow, views, base);
  EXPECT_LT(shares_of(composed, rig.trace(kNow, views)).wrong, 0.03);
  expect_all_of(kPendant, rig.reproject_to_request({5}, views, base).value(), rig, 0.8);
}

TEST_F(ReprojectionToRequest, AsksForAllOfALightThatWasSwitched) {
  TestRig rig(device_, bundled("room.glb"), kSide_px);
  const StereoView views = rig.eyes(rig.head());
  const Mask base = rig.ask(kTraced, views);
  LightChanges changes;
  for (const bool on : {false, true}) {
    change(changes, kPendant, on, std::nullopt);
    rig.set_lights(changes);
    const Mask composed = rig.ask_for_unknown(kNow, views, base);
    EXPECT_LT(shares_of(composed, rig.trace(kNow, views)).wrong, 0.01);
    expect_all_of(kPendant, rig.reproject_to_request({5}, views, base).value(), rig, 0.5);
  }
}

TEST_F(ReprojectionToRequest, StaysRightWhenItIsDoneAgainAndAgain) {
  TestRig rig(device_, bundled("room.glb"), kSide_px);
  Mask base = rig.ask({1}, rig.eyes(rig.head()));
  double first = 0, last = 0;
  for (std::uint32_t hop = 1; hop <= 24; ++hop) {
    const double t = hop / 24.0;
    const auto head =
        moved(rig.head(), 25 * kOneDegree * std::sin(6 * t), {0.2 * t, 0.05 * std::sin(9 * t), -0.1 * t});
    const StereoView views = rig.eyes(head);
    base = rig.ask_for_unknown({hop + 1}, views, base);
    const double wrong = shares_of(base, rig.trace({hop + 1}, views)).wrong;
    if (hop <= 4) first = std::max(first, wrong);
    if (hop > 20) last = std::max(last, wrong);
  }
  // Lines of shadow that are thinner than a pixel lie between the pixels of one view and on those of another.
  // It does not become worse. Asking for all lights of a block at any light's edge halves it
  // (docs/partial-requests.md).
  EXPECT_LT(first, 0.06);
  EXPECT_LT(last, 0.06);
}

/// At first the shadow on the floor is thinner than a pixel and lies between two rows.
TEST_F(ReprojectionToRequest, FindsAShadowThatGrowsWhileTheHeadRisesFromTheFloor) {
  SceneBuilder builder;
  builder.add(quad({0, 0, -3}, {0, 0, 5}, {4, 0, 0}));
  builder.add(box({0.8, 0.55, -2.5}, {0.15, 0.15, 0.15}));
  builder.point_light({0, 1.4, -2});
  TestRig rig(device_, builder.build(), kSide_px);
  const auto eyes = [&](double y_m) { return rig.eyes(head_looking({0, y_m, 0}, {0, y_m, -1})); };
  Mask base = rig.ask({1}, eyes(1e-3));
  double wrong = 0, requested = 0;
  for (std::uint32_t hop = 1; hop <= 60; ++hop) {
    const StereoView views = eyes(1e-3 + 5e-4 * hop);
    base = rig.ask_for_unknown({hop + 1}, views, base);
    const Shares shares = shares_of(base, rig.trace({hop + 1}, views));
    wrong = std::max(wrong, shares.wrong);
    requested = std::max(requested, shares.requested);
  }
  EXPECT_EQ(wrong, 0) << "0.09 % if four pixels of any depth serve";
  EXPECT_LT(requested, 8) << "6.1 %, and 3.4 % if four pixels of any depth serve";
}

}  // namespace
}  // namespace farshade
