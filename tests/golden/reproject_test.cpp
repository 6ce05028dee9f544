/// Reprojection on the device: which bits each pixel gets from masks that were traced for other views.
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "stereo/frame/tiles.h"
#include "tests/golden/test_rig.h"
#include "tests/oracle/scene_builder.h"

namespace farshade {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

/// Shares over both eyes: `unknown` of covered pixels, `wrong` of the pixel-lights of known pixels.
struct Outcome {
  std::size_t covered = 0, known = 0;
  double unknown = 0, wrong = 0;
};

Outcome outcome_of(const Shown& shown, const Mask& truth) {
  Outcome outcome;
  std::size_t wrong = 0;
  const std::uint32_t lights = truth.bits[0].lights();
  for_covered(shown, [&](Side side, std::uint32_t x, std::uint32_t y, std::uint8_t source) {
    ++outcome.covered;
    if (source == kSourceUnknown) return;
    ++outcome.known;
    for (std::uint32_t i = 0; i < lights; ++i)
      wrong += shown.reports[index_of(side)].mask.lit(x, y, i) != truth.bits[index_of(side)].lit(x, y, i);
  });
  const auto known = static_cast<double>(outcome.known);
  outcome.unknown = 1 - known / static_cast<double>(outcome.covered);
  outcome.wrong = outcome.known == 0 ? 0 : static_cast<double>(wrong) / (known * lights);
  return outcome;
}

class Reproject : public OnLavapipe {};

/// Expects that every covered pixel has the bits of the same pixel of the mask.
void expect_same_mask(TestRig& rig, const StereoView& views, const Mask& mask) {
  const Shown shown = rig.show(views, {mask.traced_mask()}, kPlainReprojection);
  std::size_t covered = 0, elsewhere = 0, changed = 0;
  for_covered(shown, [&](Side side, std::uint32_t x, std::uint32_t y, std::uint8_t source) {
    ++covered;
    elsewhere += source != 0;
    changed += !same_bits(shown.reports[index_of(side)].mask, {x, y}, mask.bits[index_of(side)], {x, y});
  });
  EXPECT_GT(covered, 1000u);
  EXPECT_EQ(elsewhere, 0u) << "of " << covered << " covered pixels";
  EXPECT_EQ(changed, 0u) << "of " << covered << " covered pixels";
}

struct LitScene {
  const char* file;
  std::uint32_t lights;
};

class ReprojectSamePose : public OnLavapipe, public testing::WithParamInterface<LitScene> {};

TEST_P(ReprojectSamePose, ReturnsSameMask) {
  TestRig rig(device_, with_lights(bundled(GetParam().file), GetParam().lights), 192);
  const StereoView views = rig.eyes(rig.head());
  const Mask traced = rig.ask(kTraced, views);
  expect_same_mask(rig, views, traced);
  expect_same_mask(rig, views, with_noise(traced, 20261));
}

INSTANTIATE_TEST_SUITE_P(
    , ReprojectSamePose,
    testing::Values(LitScene{"box_over_plane.gltf", 1}, LitScene{"box_over_plane.gltf", 2},
                    LitScene{"box_over_plane.gltf", 40}, LitScene{"room.glb", 3}, LitScene{"room.glb", 9},
                    LitScene{"room.glb", 17}, LitScene{"room.glb", 40}),
    [](const auto& tested) {
      const std::string file = tested.param.file;
      return file.substr(0, file.find('.')) + "_" + std::to_string(tested.param.lights) + "_lights";
    });

struct Move {
  const char* name;
  const char* file;
  double yaw_degrees;
  glm::dvec3 step_m;
  double most_wrong, most_unknown;  ///< shares; measured values are about two thirds
};

class ReprojectMove : public OnLavapipe, public testing::WithParamInterface<Move> {};

TEST_P(ReprojectMove, IsWrongAndIgnorantWithinBounds) {
  const Move& move = GetParam();
  TestRig rig(device_, bundled(move.file), 256);
  const Mask stale = rig.ask(kTraced, rig.eyes(rig.head()));
  const StereoView now = rig.eyes(moved(rig.head(), move.yaw_degrees * kDegree, move.step_m));
  const Outcome outcome =
      outcome_of(rig.show(now, {stale.traced_mask()}, kPlainReprojection), rig.trace(kNow, now));
  RecordProperty("wrong", std::to_string(outcome.wrong));
  RecordProperty("unknown", std::to_string(outcome.unknown));
  EXPECT_LE(outcome.wrong, move.most_wrong);
  EXPECT_LE(outcome.unknown, move.most_unknown);
  EXPECT_GT(outcome.unknown, 0) << "a moved head sees new surfaces";
}

INSTANTIATE_TEST_SUITE_P(
    , ReprojectMove,
    testing::Values(Move{"BoxTurn1", "box_over_plane.gltf", 1, {0, 0, 0}, 0.0007, 0.031},
                    Move{"BoxTurn20", "box_over_plane.gltf", 20, {0, 0, 0}, 0.0033, 0.41},
                    Move{"BoxStep10cm", "box_over_plane.gltf", 0, {0.1, 0, 0}, 0.0006, 0.031},
                    Move{"RoomTurn1", "room.glb", 1, {0, 0, 0}, 0.03, 0.078},
                    Move{"RoomTurn5", "room.glb", 5, {0, 0, 0}, 0.031, 0.21},
                    Move{"RoomTurn20", "room.glb", 20, {0, 0, 0}, 0.033, 0.56},
                    Move{"RoomStep1cm", "room.glb", 0, {0.01, 0, 0}, 0.021, 0.034},
                    Move{"RoomStep10cm", "room.glb", 0, {0.1, 0, 0}, 0.0135, 0.088},
                    Move{"RoomAhead10cm", "room.glb", 0, {0, 0, -0.1}, 0.031, 0.062}),
    [](const auto& tested) { return std::string(tested.param.name); });

/// Eyes of 200 pixels have 12.5 columns of tiles.
class ReprojectTiles : public OnLavapipe, public testing::WithParamInterface<std::uint32_t> {};

TEST_P(ReprojectTiles, ThatNeverArrivedStayUnknown) {
  const std::uint32_t side_px = GetParam();
  TestRig rig(device_, bundled("room.glb"), side_px);
  const StereoView views = rig.eyes(rig.head());
  const TileGrid grid{views[0].size};
  Mask holed = with_noise(rig.ask(kTraced, views), 1);
  for (std::uint32_t tile = 0; tile < grid.count(); ++tile) {
    holed.received_tiles[0][tile] = tile % 3 != 0;
    holed.received_tiles[1][tile] = tile % 2 == 0;
  }
  const auto known = [&](Side side, std::uint32_t x, std::uint32_t y) {
    return holed.received_tiles[index_of(side)][y / kTileSide_px * grid.columns() + x / kTileSide_px] != 0;
  };
  std::size_t unknown = 0, disagreeing = 0;
  for_covered(rig.show(views, {holed.traced_mask()}, kPlainReprojection),
              [&](Side side, std::uint32_t x, std::uint32_t y, std::uint8_t source) {
                unknown += source == kSourceUnknown;
                disagreeing += source != (known(side, x, y) ? 0 : kSourceUnknown);
              });
  EXPECT_GT(unknown, 1000u);
  EXPECT_EQ(disagreeing, 0u);

  const Mask older = with_noise(rig.ask(kOlder, views), 2);
  const Shown shown = rig.show(views, {holed.traced_mask(), older.traced_mask()}, kPlainReprojection);
  std::size_t misread = 0;
  for_covered(shown, [&](Side side, std::uint32_t x, std::uint32_t y, std::uint8_t source) {
    const std::size_t eye = index_of(side);
    const Mask& expected = known(side, x, y) ? holed : older;
    misread += source != (known(side, x, y) ? 0 : 1) ||
               !same_bits(shown.reports[eye].mask, {x, y}, expected.bits[eye], {x, y});
  });
  EXPECT_EQ(misread, 0u);
}

INSTANTIATE_TEST_SUITE_P(OfEyes_px, ReprojectTiles, testing::Values(192, 200),
                         testing::PrintToStringParamName());

TEST_F(Reproject, TakesTheNewestOfSeveralMasksThatKnowATile) {
  TestRig rig(device_, bundled("room.glb"), 128);
  const StereoView views = rig.eyes(rig.head());
  std::vector<Mask> masks;  // oldest first
  for (std::uint32_t i = 0; i < 4; ++i) masks.push_back(with_noise(rig.ask(FrameId{i + 1}, views), i));
  std::ranges::reverse(masks);
  // Bit `m` of the tile's number says whether mask `m` knows it: all 16 combinations occur.
  for (std::size_t m = 0; m < masks.size(); ++m)
    for (ReceivedTiles& tiles : masks[m].received_tiles)
      for (std::size_t tile = 0; tile < tiles.size(); ++tile) tiles[tile] = (tile >> m & 1u) != 0;
  std::vector<TracedMask> traced_masks;
  for (const Mask& mask : masks) traced_masks.push_back(mask.traced_mask());
  const Shown shown = rig.show(views, traced_masks, kPlainReprojection);
  std::array<std::size_t, 4> used{};
  std::size_t wrong_source = 0, wrong_bits = 0;
  for_covered(shown, [&](Side side, std::uint32_t x, std::uint32_t y, std::uint8_t source) {
    const std::uint32_t tile = y / kTileSide_px * TileGrid{views[0].size}.columns() + x / kTileSide_px;
    std::uint8_t newest = 0;
    while (newest < 4 && (tile >> newest & 1u) == 0) ++newest;
    wrong_source += source != (newest < 4 ? newest : kSourceUnknown);
    if (newest == 4) return;
    ++used[newest];
    wrong_bits +=
        !same_bits(shown.reports[index_of(side)].mask, {x, y}, masks[newest].bits[index_of(side)], {x, y});
  });
  EXPECT_EQ(wrong_source, 0u);
  EXPECT_EQ(wrong_bits, 0u);
  for (const std::size_t count : used) EXPECT_GT(count, 500u);
}

TEST_F(Reproject, TakesTheOlderMaskOnlyWhereTheNewestFails) {
  TestRig rig(device_, bundled("room.glb"), 192);
  const auto turned = [&](double degrees) { return rig.eyes(moved(rig.head(), degrees * kDegree, {})); };
  const Mask older = with_noise(rig.ask(kOlder, turned(12)), 3),
             newest = with_noise(rig.ask(kTraced, turned(-8)), 4);
  const Shown both = rig.show(turned(0), {newest.traced_mask(), older.traced_mask()}, kPlainReprojection),
              first = rig.show(turned(0), {newest.traced_mask()}, kPlainReprojection),
              second = rig.show(turned(0), {older.traced_mask()}, kPlainReprojection);
  std::array<std::size_t, 2> used{};
  std::size_t wrong_source = 0, wrong_bits = 0;
  for_covered(both, [&](Side side, std::uint32_t x, std::uint32_t y, std::uint8_t source) {
    const auto source_in = [&](const Shown& shown) {
      return shown.reports[index_of(side)].sources[std::size_t{y} * both.pictures[0].size.width + x];
    };
    const std::uint8_t expected = source_in(first) == 0 ? 0 : source_in(second) == 0 ? 1 : kSourceUnknown;
    wrong_source += source != expected;
    if (source == kSourceUnknown) return;
    ++used.at(source);
    const Shown& alone = source == 0 ? first : second;
    wrong_bits +=
        !same_bits(both.reports[index_of(side)].mask, {x, y}, alone.reports[index_of(side)].mask, {x, y});
  });
  EXPECT_EQ(wrong_source, 0u);
  EXPECT_EQ(wrong_bits, 0u);
  EXPECT_GT(used[0], 10'000u);
  EXPECT_GT(used[1], 1'000u);
}

TEST_F(Reproject, TakesNothingFromAViewThatLooksElsewhere) {
  TestRig rig(device_, bundled("room.glb"), 128);
  for (const double degrees : {90.0, 180.0}) {
    const Mask elsewhere =
        with_noise(rig.ask(kTraced, rig.eyes(moved(rig.head(), degrees * kDegree, {}))), 5);
    const Shown shown = rig.show(rig.eyes(rig.head()), {elsewhere.traced_mask()}, kPlainReprojection);
    std::size_t known = 0;
    for_covered(shown, [&](Side, std::uint32_t, std::uint32_t, std::uint8_t source) {
      known += source != kSourceUnknown;
    });
    EXPECT_EQ(known, 0u) << "pixels, after a turn of " << degrees << " degrees";
  }
}

TEST_F(Reproject, ShowsUnknownByTheStatedRule) {
  TestRig rig(device_, bundled("room.glb"), 128);
  const StereoView views = rig.eyes(rig.head());
  Mask all_lit = rig.ask(kTraced, views);
  for (EyeMask& bits : all_lit.bits)
    for (std::uint32_t y = 0; y < 128; ++y)
      for (std::uint32_t x = 0; x < 128; ++x) bits.set_word(x, y, 0, bits.layout().used_bits(0));
  const Shown lit = rig.show(views, {all_lit.traced_mask()}, {.lookup = Lookup::Direct}),
              unknown = rig.show(views, {});
  ASSERT_EQ(kUnknownVisibility, 1.0f);
  EXPECT_EQ(unknown.pictures[0], lit.pictures[0]);
  EXPECT_EQ(unknown.pictures[1], lit.pictures[1]);
}

/// A sheet of no thickness at z = 0, and a wall on either side.
Scene sheet_between_walls() {
  SceneBuilder builder;
  builder.add(quad({0, 0, 0}, {0.5, 0, 0}, {0, 0.5, 0}));
  builder.add(quad({0, 0, -4}, {9, 0, 0}, {0, 9, 0}));
  builder.add(quad({0, 0, 4}, {9, 0, 0}, {0, 9, 0}));
  builder.point_light({0.3, 0.8, 1.5});
  return builder.build();
}

TEST_F(Reproject, TellsBackFromFrontOfASheet) {
  TestRig rig(device_, sheet_between_walls(), 128);
  const Rigid<Stage, Head> front{{1, 0, 0, 0}, {0, 0, 1.2}}, back{{0, 0, 1, 0}, {0, 0, -1.2}};
  const Mask of_front = rig.ask(kTraced, rig.eyes(front));
  const Shown from_back = rig.show(rig.eyes(back), {of_front.traced_mask()}, kPlainReprojection);
  const ShownReport& report = from_back.reports[0];
  EXPECT_EQ(report.sources[64 * 128 + 64], kSourceUnknown) << "the middle of the sheet's back";
  std::size_t known = 0;
  for_covered(from_back, [&](Side, std::uint32_t, std::uint32_t, std::uint8_t source) {
    known += source != kSourceUnknown;
  });
  EXPECT_EQ(known, 0u) << "the view of the front saw neither the sheet's back nor the wall behind the eye";
}

struct WallCase {
  double slope, footprints;
  float detail_px;
  bool is_one_surface;
};

/// In each row, one point right of the step takes its bits from a pixel that saw the wall left of the step.
/// The pixel's centre is 0.4 pixels away from the point. The slanted walls change by 3.2 footprints in 0.4
/// pixels, and 8 bits represent their normal exactly.
TEST_F(Reproject, TakesSurfacesWithinTheToleranceForOne) {
  constexpr std::uint32_t kWide_px = 192, kBeforeStep = kWide_px / 2 - 1;
  constexpr double kSlanted = 113.0 / 14;
  for (const WallCase& tested : {WallCase{0, 0.7, 0, true},
                                 {0, 1.4, 0, false},
                                 {kSlanted, 2.2, 0, true},
                                 {kSlanted, 3.4, 0, false},
                                 {0, 2.4, 1, true},
                                 {0, 4, 1, false}}) {
    const SteppedWall wall{.side_px = kWide_px, .slope = tested.slope, .step = tested.footprints};
    TestRig rig(device_, wall.scene(), kWide_px, 4, tested.detail_px);
    const Mask traced = rig.ask(kTraced, wall.views(0.3));
    std::size_t checked = 0, wrong = 0;
    for_covered(rig.show(wall.views(0.7), {traced.traced_mask()}, kPlainReprojection),
                [&](Side, std::uint32_t x, std::uint32_t, std::uint8_t source) {
                  if (x < kBeforeStep - 8 || x > kBeforeStep + 8) return;
                  ++checked;
                  wrong += (source == kSourceUnknown) != (x == kBeforeStep && !tested.is_one_surface);
                });
    EXPECT_EQ(checked, kEyes * 17 * kWide_px);
    EXPECT_EQ(wrong, 0u) << "pixels at a step of " << tested.footprints << " footprints, slope "
                         << tested.slope << ", with a detail of " << tested.detail_px << " px";
  }
}

TEST_F(Reproject, PassesOverMasksWhoseDepthLeftTheRing) {
  TestRig rig(device_, bundled("box_over_plane.gltf"), 128, 2);
  const StereoView before = rig.eyes(moved(rig.head(), 3 * kDegree, {0.05, 0, 0})),
                   now = rig.eyes(rig.head());
  const auto known = [&](const std::vector<TracedMask>& masks) {
    std::size_t count = 0;
    for_covered(rig.show(now, masks, kPlainReprojection),
                [&](Side, std::uint32_t, std::uint32_t, std::uint8_t source) {
                  EXPECT_TRUE(source == 0 || source == kSourceUnknown) << "source " << int{source};
                  count += source == 0;
                });
    return count;
  };
  const Mask first = rig.ask(FrameId{10}, before), second = rig.ask(FrameId{11}, before);
  EXPECT_GT(known({first.traced_mask()}), 1000u) << "the ring has two slots";
  EXPECT_GT(known({first.traced_mask()}), 1000u) << "frames without a request use no slot";
  const Mask third = rig.ask(FrameId{12}, before);
  EXPECT_EQ(known({first.traced_mask()}), 0u) << "the third request uses its slot";
  EXPECT_GT(known({first.traced_mask(), second.traced_mask()}), 1000u)
      << "the second request still counts, as the newest";
  EXPECT_GT(known({third.traced_mask()}), 1000u);
}

TEST_F(Reproject, HoldsFarFromTheOrigin) {
  const auto scene_at = [](const glm::dvec3& shift) {
    SceneBuilder builder(shift);
    builder.add(quad({0, 0, 0}, {0, 0, 4}, {4, 0, 0}));
    builder.add(box({0, 0.6, 0}, {0.3, 0.3, 0.3}));
    builder.point_light({0.8, 2, 0.5});
    builder.directional_light({-1, -1, -0.3});
    return builder.build();
  };
  const auto show_at = [&](const glm::dvec3& shift) {
    TestRig rig(device_, scene_at(shift), 128);
    const Rigid<Stage, Head> head =
        head_looking(shift + glm::dvec3(0.5, 1.6, 2.5), shift + glm::dvec3(0, 0.4, 0));
    const Mask stale = rig.ask(kTraced, rig.eyes(moved(head, 2 * kDegree, {0.03, 0, 0})));
    const StereoView now = rig.eyes(head);
    const Shown shown = rig.show(now, {stale.traced_mask()}, kPlainReprojection);
    return outcome_of(shown, rig.trace(kNow, now));
  };
  const Outcome near = show_at({0, 0, 0}), far = show_at({1e6, 0, -1e6});
  EXPECT_NEAR(far.wrong, near.wrong, 0.001);
  EXPECT_NEAR(far.unknown, near.unknown, 0.002);
  EXPECT_EQ(far.covered, near.covered);
}

}  // namespace
}  // namespace farshade
