/// A viewer switches and moves lights. Masks of an older light set are used for unchanged lights. For changed
/// lights they are used exactly as for lights that an animation has moved.
#include <random>

#include "tests/golden/test_rig.h"

namespace farshade {
namespace {

constexpr std::uint32_t kChanged = 1;  // of the room's three lights
const LightPose kElsewhere{Point<Stage>{{0.2, 2.3, 0.4}}, Vector<Stage>{{0, -1, 0}}};

/// `mask` with random bits for `light`.
Mask with_noise_in(Mask mask, std::uint32_t light, std::uint64_t seed) {
  const Mask noise = with_noise(mask, seed);
  for (std::size_t eye = 0; eye < kEyes; ++eye)
    for (std::uint32_t y = 0; y < mask.bits[eye].size().height; ++y)
      for (std::uint32_t x = 0; x < mask.bits[eye].size().width; ++x) {
        const std::uint32_t bit = 1u << light;
        mask.bits[eye].set_word(
            x, y, 0, (mask.bits[eye].word(x, y, 0) & ~bit) | (noise.bits[eye].word(x, y, 0) & bit));
      }
  return mask;
}

/// The same mask with every other tile lost.
Mask half_known(Mask mask) {
  for (ReceivedTiles& tiles : mask.received_tiles)
    for (std::size_t tile = 0; tile < tiles.size(); ++tile) tiles[tile] = tile % 2;
  return mask;
}

struct Counts {
  std::size_t all = 0, from_older = 0, unknown = 0, stale = 0;
  std::size_t shown = 0;  ///< shown with some of the light, and not because of the rule for unknown bits
};

/// Counts over covered pixels, for one light.
Counts count_of(const Shown& shown, std::uint32_t light) {
  Counts counts;
  for_covered(shown, [&](Side side, std::uint32_t x, std::uint32_t y, std::uint8_t source) {
    const ShownReport& report = shown.reports[index_of(side)];
    const std::size_t pixel = std::size_t{y} * report.mask.size().width + x;
    ++counts.all;
    counts.from_older += source == 1;

    counts.unknown += report.unknown[pixel] >> light & 1u;
    counts.stale += report.stale[pixel] >> light & 1u;
    counts.shown += report.visibility[pixel * report.mask.lights() + light] > 0 &&
                    (report.unknown[pixel] >> light & 1u) == 0;
  });
  return counts;
}

void expect_same(const PerEye<Image<Rgb8>>& a, const PerEye<Image<Rgb8>>& b) {
  for (const Side side : kSides)
    EXPECT_TRUE(a[index_of(side)].pixels == b[index_of(side)].pixels) << name_of(side);
}

class LightSets : public OnLavapipe {
 protected:
  static LightChanges changed(bool on, const std::optional<LightPose>& pose) {
    LightChanges changes;
    change(changes, kChanged, on, pose);
    return changes;
  }

  TestRig rig_{device_, bundled("room.glb"), 160};
  StereoView views_ = rig_.eyes(rig_.head());
};

TEST_F(LightSets, ALightThatIsOffAddsNothingWhateverMasksSay) {
  Scene without = bundled("room.glb");
  without.lights[kChanged].intensity = glm::vec3(0.0f);
  TestRig dark(device_, std::move(without), 160);
  rig_.set_lights(changed(false, std::nullopt));
  expect_same(rig_.show_reference(views_), dark.show_reference(views_));

  rig_.set_lights({});
  const Mask traced = rig_.ask(kTraced, views_);
  rig_.set_lights(changed(false, std::nullopt));
  const Shown shown = rig_.show(views_, {traced.traced_mask()}),
              spoilt = rig_.show(views_, {with_noise_in(traced, kChanged, 4).traced_mask()});
  (void)dark.ask(kTraced, views_);
  expect_same(shown.pictures, dark.show(views_, {traced.traced_mask()}).pictures);
  for (const Shown* each : {&shown, &spoilt}) {
    const Counts counts = count_of(*each, kChanged);
    EXPECT_EQ(counts.shown + counts.unknown + counts.stale, 0u);
  }
}

TEST_F(LightSets, OnlyTheChangedLightIsStaleInTheNewestMask) {
  const Mask traced = with_noise(rig_.ask(kTraced, views_), 1);
  const Shown before = rig_.show(views_, {traced.traced_mask()}, kPlainReprojection);
  rig_.set_lights(changed(true, kElsewhere));
  const Shown after = rig_.show(views_, {traced.traced_mask()}, kPlainReprojection);
  for (const std::uint32_t light : {0u, 1u, 2u}) {
    EXPECT_EQ(count_of(before, light).stale, 0u) << light;
    const Counts counts = count_of(after, light);
    EXPECT_EQ(counts.stale, light == kChanged ? counts.all : 0u) << light;
    EXPECT_EQ(counts.unknown, 0u) << "the newest mask is the best available: shown, and flagged";
  }
  for (const Side side : kSides)
    EXPECT_EQ(after.reports[index_of(side)].mask, before.reports[index_of(side)].mask);
}

TEST_F(LightSets, AMaskOfTheNewSetIsNotStaleAndGivesTheReference) {
  (void)rig_.ask(kOlder, views_);
  rig_.set_lights(changed(true, kElsewhere));
  const Mask traced = rig_.ask(kTraced, views_);
  const Shown shown = rig_.show(views_, {traced.traced_mask()}, kPlainReprojection);
  EXPECT_EQ(count_of(shown, kChanged).stale, 0u);
  expect_same(shown.pictures, rig_.show_reference(views_));
}

TEST_F(LightSets, AnOlderMaskIsNotAskedAboutALightThatWasChangedSince) {
  const Mask older = rig_.ask(kOlder, views_);
  rig_.set_lights(changed(true, kElsewhere));
  const Mask newest = half_known(rig_.ask(kTraced, views_));
  const Shown plain = rig_.show(views_, {newest.traced_mask(), older.traced_mask()}, kPlainReprojection);
  const Counts counts = count_of(plain, kChanged);
  EXPECT_GT(counts.from_older, counts.all / 4);
  EXPECT_EQ(counts.unknown, counts.from_older);
  for (const std::uint32_t light : {0u, 2u}) EXPECT_EQ(count_of(plain, light).unknown, 0u);
  // The bits of the changed light change nothing; the bits of an unchanged light do. Edges are left out,
  // because the bits of all lights decide which pixels are near an edge.
  const auto with_older = [&](const Mask& mask) {
    return rig_.show(views_, {newest.traced_mask(), mask.traced_mask()}, {.edges = Edges::Nearest}).pictures;
  };
  expect_same(with_older(older), with_older(with_noise_in(older, kChanged, 7)));
  EXPECT_FALSE(with_older(older)[0].pixels == with_older(with_noise_in(older, 2, 7))[0].pixels);
}

TEST_F(LightSets, ALightSwitchedOnAgainDoesNotShowTheBitsFromBeforeItWasOff) {
  const Mask older = rig_.ask(kOlder, views_);
  LightChanges changes = changed(false, std::nullopt);
  rig_.set_lights(changes);
  const Mask newest = half_known(rig_.ask(kTraced, views_));
  change(changes, kChanged, true, std::nullopt);
  rig_.set_lights(changes);
  const Shown shown = rig_.show(views_, {newest.traced_mask(), older.traced_mask()}, kPlainReprojection);
  const Counts counts = count_of(shown, kChanged);
  EXPECT_EQ(counts.unknown, counts.from_older);
  EXPECT_EQ(counts.stale, counts.all - counts.from_older);
  EXPECT_EQ(counts.shown, 0u) << "dark as in the newest mask, and marked as stale or unknown";
}

}  // namespace
}  // namespace farshade
