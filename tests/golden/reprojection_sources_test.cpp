/// The reprojection features that kPlainReprojection turns off: masks of the other eye, neighbours on the
/// same plane, filtered shadow edges. Also the guard band.
#include <cmath>
#include <numbers>

#include "stereo/frame/tiles.h"
#include "stereo/requests/guard_band.h"
#include "tests/golden/test_rig.h"
#include "tests/oracle/scene_builder.h"
#include "vr_client/report/measure.h"

namespace farshade {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

Reprojection plain_and(Eyes eyes, Gaps gaps = Gaps::Unknown, Edges edges = Edges::Nearest) {
  return {.lookup = Lookup::Reproject, .eyes = eyes, .gaps = gaps, .edges = edges};
}

std::uint8_t source_of(const Shown& shown, Side side, std::uint32_t x, std::uint32_t y) {
  const ShownReport& report = shown.reports[index_of(side)];
  return report.sources[std::size_t{y} * report.mask.size().width + x];
}

class ReprojectionSources : public OnLavapipe {};

/// `mask` with all tiles of one eye unknown.
Mask without(Mask mask, Side side) {
  std::ranges::fill(mask.received_tiles[index_of(side)], std::uint8_t{0});
  return mask;
}

TEST_F(ReprojectionSources, OtherEyeComesAfterThisEyesNewestAndBeforeOlderMasks) {
  TestRig rig(device_, bundled("room.glb"), 192);
  const auto turned = [&](double degrees, double step_m) {
    return rig.eyes(moved(rig.head(), degrees * kDegree, {step_m, 0, 0}));
  };
  const Mask older = with_noise(rig.ask(kOlder, turned(12, 0.1)), 11),
             newest = with_noise(rig.ask(kTraced, turned(-6, -0.05)), 12);
  const StereoView now = turned(0, 0);
  const Shown all = rig.show(now, {newest.traced_mask(), older.traced_mask()}, plain_and(Eyes::Both));
  const std::array<std::uint8_t, 4> in_order{0, kOtherEye, 1, kOtherEye + 1};
  for (const Side side : kSides) {
    // Compare the known pixels and the bits of each source separately.
    const std::array alone{rig.show(now, {newest.traced_mask()}, kPlainReprojection),
                           rig.show(now, {without(newest, side).traced_mask()}, plain_and(Eyes::Both)),
                           rig.show(now, {older.traced_mask()}, kPlainReprojection),
                           rig.show(now, {without(older, side).traced_mask()}, plain_and(Eyes::Both))};
    std::array<std::size_t, 4> used{};
    std::size_t wrong_source = 0, wrong_bits = 0;
    for_covered(all, [&](Side of, std::uint32_t x, std::uint32_t y, std::uint8_t source) {
      if (of != side) return;
      std::size_t first = 0;
      while (first < 4 && source_of(alone[first], side, x, y) == kSourceUnknown) ++first;
      wrong_source += source != (first < 4 ? in_order[first] : kSourceUnknown);
      if (first == 4) return;
      ++used[first];
      const std::size_t eye = index_of(side);
      wrong_bits += !same_bits(all.reports[eye].mask, {x, y}, alone[first].reports[eye].mask, {x, y});
    });
    EXPECT_EQ(wrong_source, 0u) << name_of(side);
    EXPECT_EQ(wrong_bits, 0u) << name_of(side);
    EXPECT_GT(used[0], 10'000u) << name_of(side);
    for (const std::size_t source : {1u, 2u, 3u})
      EXPECT_GT(used[source], 30u) << source << ", " << name_of(side);
  }
}

TEST_F(ReprojectionSources, OtherEyeSeesBehindWhatHidesAPointFromThis) {
  SceneBuilder builder;
  builder.add(quad({0, 0, -3}, {4, 0, 0}, {0, 4, 0}));
  builder.add(quad({0, 0, -0.5}, {0.1, 0, 0}, {0, 4, 0}));  // a post close to the eyes
  builder.point_light({1, 1, 1});
  TestRig rig(device_, builder.build(), 192);
  const auto eyes_at = [&](double x) { return rig.eyes({{1, 0, 0, 0}, {x, 0, 1}}); };
  const Mask traced = rig.ask(kTraced, eyes_at(0));
  const Shown one = rig.show(eyes_at(0.02), {traced.traced_mask()}, plain_and(Eyes::This)),
              both = rig.show(eyes_at(0.02), {traced.traced_mask()}, plain_and(Eyes::Both));
  const auto count = [](const Shown& shown, std::uint8_t expected) {
    std::size_t found = 0;
    for_covered(
        shown, [&](Side, std::uint32_t, std::uint32_t, std::uint8_t source) { found += source == expected; });
    return found;
  };
  EXPECT_GT(count(one, kSourceUnknown), 300u);
  EXPECT_GT(count(both, kOtherEye), count(one, kSourceUnknown) / 4);
  EXPECT_EQ(count(both, kOtherEye) + count(both, kSourceUnknown), count(one, kSourceUnknown));
  EXPECT_EQ(count(both, 0), count(one, 0)) << "this eye's own view comes first";
}

/// A floor, a wall that meets it, and a box in front of both: steps and creases.
Scene corner_with_box() {
  SceneBuilder builder;
  builder.add(quad({0, 0, 0}, {0, 0, 4}, {4, 0, 0}));
  builder.add(quad({0, 2, -2}, {4, 0, 0}, {0, 2, 0}));
  builder.add(box({0, 0.5, 0}, {0.5, 0.5, 0.5}));
  for (int i = 0; i < 3; ++i) builder.point_light({0.3 * i, 3, 2});
  return builder.build();
}

/// The number of the plane of corner_with_box that contains a point, from 1; 0 near an edge.
std::uint32_t plane_of(const glm::dvec3& p) {
  const std::array distances{std::abs(p.y),       std::abs(p.z + 2),   std::abs(p.y - 1),
                             std::abs(p.z - 0.5), std::abs(p.x + 0.5), std::abs(p.x - 0.5)};
  std::uint32_t on = 0;
  for (std::uint32_t i = 0; i < distances.size(); ++i) {
    const bool of_box = i >= 2;
    const glm::dvec3 off = glm::abs(p - glm::dvec3(0, 0.5, 0)) - 0.5;
    if (of_box && std::max({off.x, off.y, off.z}) > 0.03) continue;
    if (distances[i] > 0.03) continue;
    if (on != 0) return 0;
    on = i + 1;
  }
  return on;
}

struct Planes {
  PerEye<std::vector<std::uint32_t>> of;  ///< for each pixel; 0: no plane, or uncertain
};

Planes planes_seen(TestRig& rig, const StereoView& views) {
  const Shown shown = rig.show(views, {});
  const PerEye<Image<float>> distance = rig.renderer().read_distance();
  Planes planes;
  for (std::size_t eye = 0; eye < kEyes; ++eye) planes.of[eye].resize(views[eye].size.pixels());
  for_covered(shown, [&](Side side, std::uint32_t x, std::uint32_t y, std::uint8_t) {
    const View& view = views[index_of(side)];
    const glm::dvec3 ray = pixel_ray(tangents_of(view.fov), view.size, {x + 0.5, y + 0.5});
    const Point<Eye> p{ray * double{distance[index_of(side)].at(x, y)}};
    planes.of[index_of(side)][std::size_t{y} * view.size.width + x] = plane_of(view.stage_from_eye(p).v);
  });
  return planes;
}

/// A mask in which the bits of each pixel are the number of the plane that the pixel shows.
Mask painted_by_plane(Mask mask, const Planes& planes) {
  for (std::size_t eye = 0; eye < kEyes; ++eye)
    for (std::uint32_t y = 0; y < mask.views[eye].size.height; ++y)
      for (std::uint32_t x = 0; x < mask.views[eye].size.width; ++x)
        mask.bits[eye].set_word(x, y, 0, planes.of[eye][std::size_t{y} * mask.views[eye].size.width + x]);
  return mask;
}

class Neighbours : public OnLavapipe {
 protected:
  TestRig rig_{device_, corner_with_box(), 192};
  StereoView views_ = rig_.eyes(head_looking({0.8, 1.7, 3.2}, {0, 0.6, 0}));
};

TEST_F(Neighbours, AreOfThePointsOwnPlane) {
  const Planes planes = planes_seen(rig_, views_);
  Mask holed = painted_by_plane(rig_.ask(kTraced, views_), planes);
  for (std::size_t eye = 0; eye < kEyes; ++eye)  // a chequerboard of tiles
    for (std::uint32_t tile = 0; tile < holed.received_tiles[eye].size(); ++tile)
      holed.received_tiles[eye][tile] = (tile / 12 + tile % 12) % 2;
  const Shown shown = rig_.show(views_, {holed.traced_mask()}, plain_and(Eyes::This, Gaps::Neighbours));
  std::size_t beside = 0, of_another = 0, unknown = 0;
  for_covered(shown, [&](Side side, std::uint32_t x, std::uint32_t y, std::uint8_t source) {
    const std::uint32_t own = planes.of[index_of(side)][std::size_t{y} * 192 + x];
    const bool known = holed.received_tiles[index_of(side)][y / 16 * 12 + x / 16] != 0;
    EXPECT_EQ(source == 0, known);
    if (known || own == 0) return;
    unknown += source == kSourceUnknown;
    if (source == kSourceUnknown) return;
    ASSERT_EQ(source, kNeighbour);
    ++beside;
    const std::uint32_t taken = shown.reports[index_of(side)].mask.word(x, y);
    of_another += taken != own && taken != 0;
  });
  EXPECT_GT(beside, 10'000u);
  EXPECT_LT(unknown, beside / 20) << "the middle of a tile is 8 pixels from its border";
  EXPECT_LE(of_another, beside / 1000) << "a pixel on a crease belongs to both planes";
}

TEST_F(Neighbours, ReachNoFurtherThan32Pixels) {
  Mask strip = rig_.ask(kTraced, views_);
  for (std::size_t eye = 0; eye < kEyes; ++eye)  // all but the leftmost tiles
    for (std::uint32_t tile = 0; tile < strip.received_tiles[eye].size(); ++tile)
      strip.received_tiles[eye][tile] = tile % 12 == 0;
  std::size_t near = 0, far = 0;
  for_covered(rig_.show(views_, {strip.traced_mask()}, plain_and(Eyes::This, Gaps::Neighbours)),
              [&](Side, std::uint32_t x, std::uint32_t, std::uint8_t source) {
                near += source == kNeighbour && x < 16 + 16;
                far += source == kNeighbour && x >= 16 + 32;
              });
  EXPECT_GT(near, 1000u);
  EXPECT_EQ(far, 0u);

  // Points outside of a view that looks in another direction.
  const Mask aside =
      rig_.ask(kOlder, rig_.eyes(moved(head_looking({0.8, 1.7, 3.2}, {0, 0.6, 0}), 14 * kDegree, {})));
  const Shown shown = rig_.show(views_, {aside.traced_mask()}, plain_and(Eyes::This, Gaps::Neighbours));
  std::size_t beside = 0, unknown = 0;
  for_covered(shown, [&](Side side, std::uint32_t x, std::uint32_t y, std::uint8_t source) {
    unknown += source == kSourceUnknown;
    if (source != kNeighbour) return;
    ++beside;
    const auto at = shown.reports[index_of(side)].positions[std::size_t{y} * 192 + x];
    for (const float coordinate : at) {
      EXPECT_GE(coordinate, -32.01f);
      EXPECT_LE(coordinate, 192 - 1 + 32.01f);
    }
  });
  EXPECT_GT(beside, 1000u);
  EXPECT_GT(unknown, 1000u) << "14 degrees are more than 32 pixels";
}

TEST_F(Neighbours, ChangeNothingThatAViewHasSeen) {
  TestRig rig(device_, bundled("room.glb"), 192);
  const StereoView now = rig.eyes(rig.head());
  const Mask stale = with_noise(rig.ask(kTraced, rig.eyes(moved(rig.head(), 3 * kDegree, {0.03, 0, 0}))), 4);
  const Shown without = rig.show(now, {stale.traced_mask()}, plain_and(Eyes::Both)),
              with = rig.show(now, {stale.traced_mask()}, plain_and(Eyes::Both, Gaps::Neighbours));
  std::size_t filled = 0, changed = 0;
  for_covered(with, [&](Side side, std::uint32_t x, std::uint32_t y, std::uint8_t source) {
    const std::uint8_t before = source_of(without, side, x, y);
    filled += source == kNeighbour;
    if (before == kSourceUnknown)
      changed += source != kNeighbour && source != kSourceUnknown;
    else
      changed += source != before || !same_bits(with.reports[index_of(side)].mask, {x, y},
                                                without.reports[index_of(side)].mask, {x, y});
  });
  EXPECT_EQ(changed, 0u);
  EXPECT_GT(filled, 500u);
}

struct EdgeMove {
  const char* name;
  const char* file;
  double yaw_degrees;
  glm::dvec3 step_m;
};

class FilteredEdges : public OnLavapipe, public testing::WithParamInterface<EdgeMove> {};

/// Whether the four pixels of `mask` around the position `at` differ.
bool differs_about(const EyeMask& mask, const std::array<float, 2>& at) {
  const auto corner = [](float position, std::uint32_t side) {
    return static_cast<std::uint32_t>(
        std::clamp(std::floor(position - 0.5f), 0.0f, static_cast<float>(side - 2)));
  };
  const std::uint32_t x = corner(at[0], mask.size().width), y = corner(at[1], mask.size().height);
  return !same_bits(mask, {x, y}, mask, {x + 1, y}) || !same_bits(mask, {x, y}, mask, {x, y + 1}) ||
         !same_bits(mask, {x, y}, mask, {x + 1, y + 1});
}

TEST_P(FilteredEdges, AreNearerToTheTruthAndChangeNothingElse) {
  const EdgeMove& move = GetParam();
  TestRig rig(device_, bundled(move.file), 256, 8);
  const auto moved_by = [&](double times) {
    return rig.eyes(moved(rig.head(), move.yaw_degrees * kDegree * times, move.step_m * times));
  };
  std::vector<Mask> masks;
  for (std::uint32_t i = 0; i < 4; ++i) masks.push_back(rig.ask({10 - i}, moved_by(1 + 0.37 * i)));
  std::vector<TracedMask> traced_masks;
  for (const Mask& mask : masks) traced_masks.push_back(mask.traced_mask());
  const StereoView now = moved_by(0);
  const Mask truth = rig.trace(kNow, now);
  const Shown nearest = rig.show(now, traced_masks, plain_and(Eyes::Both, Gaps::Neighbours)),
              filtered = rig.show(now, traced_masks, plain_and(Eyes::Both, Gaps::Neighbours, Edges::Line));
  double nearest_error = 0, filtered_error = 0;
  for (std::size_t eye = 0; eye < kEyes; ++eye) {
    const EyeErrors a = compare_masks(nearest.reports[eye], truth.bits[eye]),
                    b = compare_masks(filtered.reports[eye], truth.bits[eye]);
    nearest_error += a.mask_error;
    filtered_error += b.mask_error;
    EXPECT_EQ(a.newest, b.newest);
    EXPECT_EQ(a.unknown, b.unknown);
  }
  RecordProperty("nearest_percent", std::to_string(50 * nearest_error));
  RecordProperty("filtered_percent", std::to_string(50 * filtered_error));
  EXPECT_LT(filtered_error, 0.95 * nearest_error);
  const std::size_t lights = truth.bits[0].lights();
  std::size_t touched = 0, away_from_edges = 0;
  for_covered(filtered, [&](Side side, std::uint32_t x, std::uint32_t y, std::uint8_t source) {
    const ShownReport &a = nearest.reports[index_of(side)], &b = filtered.reports[index_of(side)];
    const std::size_t pixel = std::size_t{y} * 256 + x;
    if (source != 0) return;
    bool same = true;
    for (std::size_t i = 0; i < lights; ++i)
      same = same && a.visibility[pixel * lights + i] == b.visibility[pixel * lights + i];
    touched += !same;
    away_from_edges += !same && !differs_about(masks[0].bits[index_of(side)], b.positions[pixel]);
  });
  EXPECT_GT(touched, 20u) << "the filter does something";
  EXPECT_EQ(away_from_edges, 0u) << "of " << touched;
}

INSTANTIATE_TEST_SUITE_P(, FilteredEdges,
                         testing::Values(EdgeMove{"BoxTurn", "box_over_plane.gltf", 1, {0, 0, 0}},
                                         EdgeMove{"BoxStep", "box_over_plane.gltf", 0, {0.02, 0, 0}},
                                         EdgeMove{"RoomTurn", "room.glb", 1, {0, 0, 0}},
                                         EdgeMove{"RoomStep", "room.glb", 0, {0.02, 0.01, 0}},
                                         EdgeMove{"RoomBoth", "room.glb", 2, {0.01, 0, -0.02}}),
                         [](const auto& tested) { return std::string(tested.param.name); });

class GuardBandOf : public OnLavapipe {
 protected:
  static constexpr Sides<std::uint32_t> kMargins{.left = 32, .right = 16, .up = 16, .down = 32};
  static StereoView widened_views(const StereoView& views) {
    return {widened(views[0], kMargins), widened(views[1], kMargins)};
  }
  TestRig rig_{device_, bundled("room.glb"), 192};
  StereoView views_ = rig_.eyes(rig_.head());

  /// Covered pixels that do not show the bits of the same pixel of `wide`.
  static std::size_t unlike(const Shown& shown, const Mask& wide) {
    std::size_t found = 0;
    for_covered(shown, [&](Side side, std::uint32_t x, std::uint32_t y, std::uint8_t source) {
      found += source != 0 || !same_bits(shown.reports[index_of(side)].mask, {x, y},
                                         wide.bits[index_of(side)], {x + kMargins.left, y + kMargins.up});
    });
    return found;
  }
};

TEST_F(GuardBandOf, IdenticalPoseIsExactlyTheMaskReadDirectly) {
  const Mask wide = with_noise(rig_.trace(kTraced, widened_views(views_)), 8);
  EXPECT_EQ(unlike(rig_.show(views_, {wide.traced_mask()}, {.lookup = Lookup::Direct}), wide), 0u);
  Mask truth = rig_.trace(kNow, views_);
  const Mask wide_truth = rig_.trace(kTraced, widened_views(views_));
  std::size_t differing = 0;
  for (std::size_t eye = 0; eye < kEyes; ++eye)
    for (std::uint32_t y = 0; y < 192; ++y)
      for (std::uint32_t x = 0; x < 192; ++x)
        differing +=
            !same_bits(truth.bits[eye], {x, y}, wide_truth.bits[eye], {x + kMargins.left, y + kMargins.up});
  EXPECT_LE(differing, 40u) << "of 73,728: rounding moves rays by 1e-16, which matters only at edges";
}

TEST_F(GuardBandOf, IdenticalPoseIsExactlyTheMaskReprojected) {
  const Mask wide = with_noise(rig_.ask(kTraced, widened_views(views_)), 9);
  EXPECT_EQ(unlike(rig_.show(views_, {wide.traced_mask()}, kPlainReprojection), wide), 0u);
}

TEST_F(GuardBandOf, HasWhatATurnUncovers) {
  const auto outcome_after = [&](const StereoView& traced, double degrees, FrameId frame) {
    const Mask mask = rig_.ask(frame, traced);
    const StereoView now = rig_.eyes(moved(rig_.head(), degrees * kDegree, {}));
    const Shown shown = rig_.show(now, {mask.traced_mask()}, kPlainReprojection);
    const Mask truth = rig_.trace(kNow, now);
    return compare_masks(shown.reports[0], truth.bits[0]);
  };
  const EyeErrors bare = outcome_after(views_, 5, kOlder),
                  wide = outcome_after(widened_views(views_), 5, kTraced);
  EXPECT_GT(bare.unknown, 0.12);
  EXPECT_LT(wide.unknown, 0.05) << "the remaining pixels are hidden, not outside";
  EXPECT_NEAR(wide.known_error, bare.known_error, 0.01);
  EXPECT_GT(outcome_after(widened_views(views_), -9, kTraced).unknown, 0.05)
      << "the band on the right side is narrower";
}

}  // namespace
}  // namespace farshade
