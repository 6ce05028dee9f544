/// Moving lights and instances: every bit that may have changed is marked as stale, and points on instances
/// that have moved are looked up at their old positions.
#include <cmath>

#include "tests/golden/test_rig.h"
#include "tests/oracle/random_scenes.h"
#include "tests/oracle/scene_builder.h"

namespace farshade {
namespace {

using namespace std::chrono_literals;

bool bit(const std::vector<std::uint32_t>& words, std::size_t pixel, std::uint32_t light) {
  return (words[pixel] >> light & 1u) != 0;  // of up to 32 lights
}

struct PixelLights {
  std::size_t all = 0, stale = 0, unknown = 0;
};

/// Counts of light `light` over covered pixels.
PixelLights count_of(const Shown& shown, std::uint32_t light) {
  PixelLights count;
  for_covered(shown, [&](Side side, std::uint32_t x, std::uint32_t y, std::uint8_t) {
    const ShownReport& report = shown.reports[index_of(side)];
    const std::size_t pixel = std::size_t{y} * report.mask.size().width + x;
    ++count.all;
    count.stale += bit(report.stale, pixel, light);
    count.unknown += bit(report.unknown, pixel, light);
  });
  return count;
}

/// A floor and a box that do not move, and three lights, of which the second moves.
Scene moving_light() {
  SceneBuilder builder;
  builder.add(quad({0, 0, 0}, {0, 0, 4}, {4, 0, 0}));
  builder.add(box({0, 0.6, 0}, {0.3, 0.3, 0.3}));
  builder.point_light({0.8, 2, 0.5});
  builder.move(builder.point_light({-0.8, 2, 0.5}), {0.5, 0, 0});
  builder.directional_light({-1, -1, -0.3});
  builder.move(builder.add(box({50, 0.6, 50}, {0.1, 0.1, 0.1})), {0.5, 0, 0});
  return builder.build();
}

const Rigid<Stage, Head> kBefore = head_looking({0.5, 1.6, 2.5}, {0, 0.4, 0});

class Stale : public OnLavapipe {};

/// The share of the pixel-lights that no mask knew.
double unknown_share(const Shown& shown) {
  double unknown = 0, all = 0;
  for (const std::uint32_t light : {0u, 1u, 2u}) {
    const PixelLights count = count_of(shown, light);
    unknown += static_cast<double>(count.unknown), all += static_cast<double>(count.all);
  }
  return unknown / all;
}

// If the G-buffer drew other vertices than the tracer met, or points were not carried back with the figures,
// the surfaces would not be those of the mask. Boxes of 12 triangles that bend are left out: one affine
// motion cannot follow them, so they count as unknown (part_motion.h).
TEST_F(Stale, DeformedFiguresAreWhereTheMaskSawThemAndAreCarriedBack) {
  std::mt19937 random{11};  // the seed
  TestRig rig(device_, bending_figures(random, 2000, {}, BendingBoxes::None), 128);
  const StereoView views = rig.eyes(head_looking({0.3, 1.5, 2.6}, {0, 0.8, 0}));
  rig.set_time(Time(620ms));
  const Mask traced = rig.ask(kTraced, views);
  const Shown at_once = rig.show(views, {traced.traced_mask()}, kPlainReprojection);
  EXPECT_LT(unknown_share(at_once), 0.001);
  rig.set_time(Time(650ms));
  const Shown later = rig.show(views, {traced.traced_mask()}, kPlainReprojection);
  std::size_t stale = 0;
  for (const std::uint32_t light : {0u, 1u}) stale += count_of(later, light).stale;
  EXPECT_GT(stale, 1000u) << "the figures are in view and move";
  EXPECT_LT(unknown_share(later), 0.006);
}

TEST_F(Stale, IsTheLightThatMovedAndNoOther) {
  TestRig rig(device_, moving_light(), 128);
  const StereoView views = rig.eyes(kBefore);
  const Mask traced = with_noise(rig.ask(kTraced, views), 1);
  const Shown still = rig.show(views, {traced.traced_mask()}, kPlainReprojection);
  rig.set_time(Time(200ms));
  const Shown moved = rig.show(views, {traced.traced_mask()}, kPlainReprojection);
  for (const std::uint32_t light : {0u, 1u, 2u}) {
    EXPECT_EQ(count_of(still, light).stale, 0u) << light;
    const PixelLights count = count_of(moved, light);
    EXPECT_EQ(count.stale, light == 1 ? count.all : 0u) << light;
    EXPECT_EQ(count.unknown, 0u) << "the newest mask is the best available: used, and flagged";
  }
  EXPECT_EQ(moved.reports[0].mask, still.reports[0].mask);
  EXPECT_EQ(moved.reports[1].mask, still.reports[1].mask);
}

TEST_F(Stale, BitsOfAnOlderMaskAreShownAndMarked) {
  TestRig rig(device_, moving_light(), 128);
  const StereoView views = rig.eyes(kBefore);
  const Mask older = with_noise(rig.ask(kOlder, views), 2);
  rig.set_time(Time(200ms));
  Mask newest = with_noise(rig.ask(kTraced, views), 3);
  for (std::size_t eye = 0; eye < kEyes; ++eye)
    for (std::size_t tile = 0; tile < newest.received_tiles[eye].size(); ++tile)
      newest.received_tiles[eye][tile] = tile % 2;
  std::size_t from_older = 0, wrong = 0;
  const Shown shown = rig.show(views, {newest.traced_mask(), older.traced_mask()}, kPlainReprojection);
  for_covered(shown, [&](Side side, std::uint32_t x, std::uint32_t y, std::uint8_t source) {
    const ShownReport& report = shown.reports[index_of(side)];
    const std::size_t pixel = std::size_t{y} * 128 + x;
    ASSERT_LE(source, 1);
    from_older += source;
    const Mask& mask = source == 1 ? older : newest;
    wrong += report.unknown[pixel] != 0;
    wrong += report.stale[pixel] != (source == 1 ? 0b010u : 0u);  // the newest mask was traced now
    for (const std::uint32_t light : {0u, 2u})
      wrong += report.mask.lit(x, y, light) != mask.bits[index_of(side)].lit(x, y, light);
    // The newest mask lacks the tile there, so the older mask's bit is the best guess.
    if (source == 1) wrong += report.mask.lit(x, y, 1) != older.bits[index_of(side)].lit(x, y, 1);
  });
  EXPECT_EQ(wrong, 0u);
  EXPECT_GT(from_older, 5000u);
}

/// Every bit that has changed on a surface that has not moved is marked as stale.
class StaleOverTime : public OnLavapipe, public testing::WithParamInterface<int> {};

TEST_P(StaleOverTime, MarksAllThatMovingCastersChangedInTheRoom) {
  TestRig rig(device_, bundled("room.glb"), 192);
  const StereoView views = rig.eyes(rig.head());
  rig.set_time(Time(700ms));
  const Mask before = rig.ask(kTraced, views);
  const auto distances = [&] {
    (void)rig.show(views, {});
    return rig.renderer().read_distance();
  };
  const PerEye<Image<float>> then = distances();
  rig.set_time(Time(700ms + GetParam() * 1ms));
  const Mask truth = rig.trace(kNow, views);
  const Shown shown = rig.show(views, {before.traced_mask()}, kPlainReprojection);
  const PerEye<Image<float>> now = rig.renderer().read_distance();
  std::size_t changed = 0, missed = 0, stale = 0, all = 0;
  for_covered(shown, [&](Side side, std::uint32_t x, std::uint32_t y, std::uint8_t source) {
    const std::size_t eye = index_of(side), pixel = std::size_t{y} * 192 + x;
    if (source != 0 || then[eye].at(x, y) != now[eye].at(x, y)) return;
    for (std::uint32_t light = 0; light < 3; ++light) {
      const bool marked = bit(shown.reports[eye].stale, pixel, light);
      const bool differs = before.bits[eye].lit(x, y, light) != truth.bits[eye].lit(x, y, light);
      ++all;
      stale += marked;
      changed += differs;
      missed += differs && !marked;
    }
  });
  RecordProperty("stale_percent",
                 std::to_string(100.0 * static_cast<double>(stale) / static_cast<double>(all)));
  RecordProperty("changed", std::to_string(changed));
  EXPECT_GT(changed, 100u);
  EXPECT_EQ(missed, 0u) << "of " << changed << " changed; " << stale << " of " << all << " are marked";
  EXPECT_LT(stale, all * 3 / 4) << "not everything is marked";
}

INSTANTIATE_TEST_SUITE_P(AfterMs, StaleOverTime, testing::Values(14, 100, 500));

/// A wall, and in front of it a box that moves to the right.
Scene moving_box() {
  SceneBuilder builder;
  builder.add(quad({0, 1, -1}, {4, 0, 0}, {0, 4, 0}));
  builder.move(builder.add(box({-0.2, 1, 0}, {0.4, 0.3, 0.2})), {0.5, 0, 0});
  builder.point_light({0.8, 2, 2.5});
  builder.point_light({-0.8, 2, 2.5});
  return builder.build();
}

TEST_F(Stale, PointsOnMovingMeshesTakeTheBitsOfTheirOldPlaces) {
  TestRig rig(device_, moving_box(), 192);
  const StereoView views = rig.eyes({{1, 0, 0, 0}, {0, 1, 1.5}});
  const Mask traced = with_noise(rig.ask(kTraced, views), 5);
  rig.set_time(Time(300ms));
  const glm::dvec3 travelled(0.15, 0, 0);
  const Shown shown = rig.show(views, {traced.traced_mask()}, kPlainReprojection);
  const PerEye<Image<float>> distance = rig.renderer().read_distance();
  std::size_t on_box = 0, wrong_bits = 0, unflagged = 0, unknown = 0, moved_px = 0;
  for_covered(shown, [&](Side side, std::uint32_t x, std::uint32_t y, std::uint8_t source) {
    const std::size_t eye = index_of(side);
    const View& view = views[eye];
    const glm::dvec3 ray = pixel_ray(tangents_of(view.fov), view.size, {x + 0.5, y + 0.5});
    const glm::dvec3 p = view.stage_from_eye(Point<Eye>{ray * double{distance[eye].at(x, y)}}).v;
    if (std::abs(p.z - 0.2) > 1e-3) return;  // only the box's front
    ++on_box;
    unknown += source == kSourceUnknown;
    if (source == kSourceUnknown) return;
    const glm::dvec2 was = ray_pixel(tangents_of(view.fov), view.size,
                                     inverse(view.stage_from_eye)(Point<Stage>{p - travelled}).v);
    const glm::dvec2 part = was - glm::floor(was);
    if (std::min({part.x, part.y, 1 - part.x, 1 - part.y}) < 0.01) return;  // rounding may decide either way
    const glm::uvec2 there(was);
    moved_px += there != glm::uvec2(x, y);
    const ShownReport& report = shown.reports[eye];
    wrong_bits += !same_bits(report.mask, {x, y}, traced.bits[eye], there);
    unflagged += report.stale[std::size_t{y} * 192 + x] != 0b11;
  });
  EXPECT_GT(on_box, 5000u);
  EXPECT_GT(moved_px, on_box / 2);
  EXPECT_LT(unknown, on_box / 20) << "only the border that the movement uncovers";
  EXPECT_EQ(wrong_bits, 0u) << "of " << on_box;
  EXPECT_EQ(unflagged, 0u) << "a surface that has moved is stale in all lights";
}

TEST_F(Stale, WallBehindAMovingBoxKeepsWhatNothingPassed) {
  TestRig rig(device_, moving_box(), 192);
  const StereoView views = rig.eyes({{1, 0, 0, 0}, {0, 1, 1.5}});
  const Mask traced = rig.ask(kTraced, views);
  rig.set_time(Time(300ms));
  const Shown shown = rig.show(views, {traced.traced_mask()}, kPlainReprojection);
  for (const std::uint32_t light : {0u, 1u}) {
    const PixelLights count = count_of(shown, light);
    EXPECT_GT(count.stale, count.all / 20) << light;
    EXPECT_LT(count.stale, count.all / 2) << light;
  }
}

/// `mask` with random bits for `light`, which is one of up to 8.
Mask with_noise_for(Mask mask, std::uint32_t light, std::uint64_t seed) {
  const Mask noise = with_noise(mask, seed);
  for (std::size_t eye = 0; eye < kEyes; ++eye)
    for (std::uint32_t y = 0; y < mask.bits[eye].size().height; ++y)
      for (std::uint32_t x = 0; x < mask.bits[eye].size().width; ++x) {
        const std::uint32_t own = mask.bits[eye].word(x, y), other = noise.bits[eye].word(x, y);
        mask.bits[eye].set_word(x, y, 0, (own & ~(1u << light)) | (other & 1u << light));
      }
  return mask;
}

TEST_F(Stale, LightsOfOlderMasksHaveNoWeightInFilteredEdges) {
  TestRig rig(device_, moving_light(), 128);
  const StereoView before = rig.eyes(kBefore), views = rig.eyes(moved(kBefore, 0.01, {0.01, 0, 0}));
  const Mask older = rig.ask(kOlder, before);
  rig.set_time(Time(200ms));
  const Mask newest = rig.ask(kTraced, before);
  const auto visibilities = [&](const Mask& old, std::uint32_t light) {
    const Shown shown = rig.show(views, {newest.traced_mask(), old.traced_mask()});
    std::vector<std::uint8_t> result;
    for_covered(shown, [&](Side side, std::uint32_t x, std::uint32_t y, std::uint8_t source) {
      if (source != 0) return;  // other pixels may take their bits from the older mask
      result.push_back(shown.reports[index_of(side)].visibility[(std::size_t{y} * 128 + x) * 3 + light]);
    });
    return result;
  };
  const auto with_bits = [&](std::uint32_t light, std::uint64_t seed) {
    return visibilities(with_noise_for(older, light, seed), light);
  };
  EXPECT_EQ(with_bits(1, 7), with_bits(1, 8)) << "light 1 has moved since the older mask";
  EXPECT_NE(with_bits(0, 7), with_bits(0, 8)) << "light 0 has not moved";
}

/// A box that moves above a point light, and a directional light from straight above.
TEST_F(Stale, IsNothingOnAccountOfWhatMovesBeyondTheLight) {
  SceneBuilder builder;
  builder.add(quad({0, 0, 0}, {0, 0, 4}, {4, 0, 0}));
  builder.move(builder.add(box({0, 4, 0}, {0.1, 0.1, 0.1})), {0.5, 0, 0});
  builder.point_light({0, 2, 0});
  builder.directional_light({0, -1, 0});
  TestRig rig(device_, builder.build(), 128);
  const StereoView views = rig.eyes(kBefore);
  const Mask traced = rig.ask(kTraced, views);
  rig.set_time(Time(300ms));
  const Shown shown = rig.show(views, {traced.traced_mask()}, kPlainReprojection);
  EXPECT_EQ(count_of(shown, 0).stale, 0u) << "the box never stands between floor and point light";
  EXPECT_GT(count_of(shown, 1).stale, 50u) << "the box stands between floor and sun";
}

}  // namespace
}  // namespace farshade
