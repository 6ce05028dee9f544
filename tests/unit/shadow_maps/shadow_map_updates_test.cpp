#include "stereo/shadow_maps/shadow_map_updates.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <glm/gtc/matrix_transform.hpp>
#include <random>

#include "stereo/shadow_maps/shadow_map_views.h"

namespace farshade {
namespace {

using Kind = LayerUpdate::Kind;

constexpr std::uint32_t kSide = 64;
const glm::dmat4 kOff = clip_from_stage({});
const TexelRect kAll{glm::ivec2(0), glm::ivec2(kSide)};

/// Looks from `x` along -y, from 2 m above; 2 m wide at y = 0 and 64 texels wide.
glm::dmat4 above(double x) {
  return clip_from_stage({.kind = FARSHADE_MAP_WINDOW,
                          .right = {1, 0, 0},
                          .up = {0, 0, -1},
                          .ahead = {0, -1, 0},
                          .origin = {{x, 2, 0}},
                          .texels = glm::dvec2(kSide),
                          .side_px = kSide});
}

CasterPlace at(const glm::dvec3& position) {
  return {{glm::translate(glm::dmat4(1.0), position)}, {glm::dvec3(-0.1), glm::dvec3(0.1)}};
}

/// Two layers, 10 m apart, that look down; a caster that cannot move, and two that can, all 20 cm wide.
class ShadowMapUpdate : public testing::Test {
 protected:
  static Caster caster(bool moves) { return {glm::dvec3(0.0), moves}; }
  static ShadowMapUpdates make(bool can_keep, Redraw redraw = Redraw::WhenMoved) {
    return {{caster(false), caster(true), caster(true)},
            {can_keep, can_keep},
            {.side_px = kSide, .redraw = redraw}};
  }
  std::vector<LayerUpdate> next(ShadowMapUpdates& updates) const { return updates.next(clips_, placed_); }

  /// The first mover is in the first layer's view, the second in none.
  std::vector<glm::dmat4> clips_{above(0), above(10)};
  std::vector<CasterPlace> placed_{at({0, 0, 0}), at({0.5, 0, 0}), at({5, 0, 0})};
};

constexpr LayerUpdate kNothing{};
constexpr LayerUpdate kRedraw{Kind::Redraw, false, {}};

TEST_F(ShadowMapUpdate, KeepsDepthOfLayersThatSeeSomethingThatMoves) {
  ShadowMapUpdates updates = make(true);
  const auto first = next(updates);
  EXPECT_EQ(first[0], (LayerUpdate{Kind::Restore, true, kAll}));
  EXPECT_EQ(first[1], kRedraw);
  EXPECT_EQ(next(updates), (std::vector{kNothing, kNothing}));
}

TEST_F(ShadowMapUpdate, RestoresTheTexelsThatAMovingInstanceHasLeft) {
  ShadowMapUpdates updates = make(true);
  (void)next(updates);
  placed_[1] = at({-0.5, 0, 0});
  const auto moved = next(updates);
  EXPECT_EQ(moved[0].kind, Kind::Restore);
  EXPECT_FALSE(moved[0].keeps);
  // The near side of the box, 1.9 m below the light, is at x = 0.4 to 0.6 m.
  EXPECT_EQ(moved[0].lost.low, glm::ivec2(32 + 0.4 / 2.1 * 64 - 1, 32 - 0.1 / 1.9 * 64 - 1));
  EXPECT_EQ(moved[0].lost.high, glm::ivec2(32 + 0.6 / 1.9 * 64 + 2, 32 + 0.1 / 1.9 * 64 + 2));
  EXPECT_EQ(moved[1], kNothing);
  EXPECT_EQ(next(updates), (std::vector{kNothing, kNothing}));
}

TEST_F(ShadowMapUpdate, DrawsLayersThatAnInstanceEntersOrLeaves) {
  ShadowMapUpdates updates = make(false);
  EXPECT_EQ(next(updates), (std::vector{kRedraw, kRedraw}));
  placed_[1] = at({10.5, 0, 0});
  EXPECT_EQ(next(updates), (std::vector{kRedraw, kRedraw}));
  placed_[1] = at({15, 0, 0});
  EXPECT_EQ(next(updates), (std::vector{kNothing, kRedraw}));
  placed_[1] = at({20, 0, 0});
  EXPECT_EQ(next(updates), (std::vector{kNothing, kNothing}));
}

TEST_F(ShadowMapUpdate, DrawsOnlyTheLayerOfALightThatMoves) {
  ShadowMapUpdates updates = make(true);
  (void)next(updates);
  for (const double x : {0.1, 0.2}) {
    clips_[0] = above(x);
    placed_[1] = at({-x, 0, 0});
    EXPECT_EQ(next(updates), (std::vector{kRedraw, kNothing})) << x;
  }
  placed_[1] = at({0, 0, 0});
  const auto stands = next(updates);
  EXPECT_TRUE(stands[0].kind == Kind::Restore && stands[0].keeps) << "the light stands still again";
}

TEST_F(ShadowMapUpdate, ALayerThatIsOffIsDrawnLaterIfSomethingHasMovedInIt) {
  ShadowMapUpdates updates = make(true);
  (void)next(updates);
  clips_ = {kOff, kOff};
  EXPECT_EQ(next(updates), (std::vector{kNothing, kNothing}));
  placed_[1] = at({0.2, 0, 0});
  (void)next(updates);
  placed_[1] = at({-0.5, 0, 0});
  EXPECT_EQ(next(updates), (std::vector{kNothing, kNothing}));
  clips_ = {above(0), above(10)};
  const auto on = next(updates);
  EXPECT_EQ(on[1], kNothing);
  EXPECT_EQ(on[0].kind, Kind::Restore);
  EXPECT_LT(on[0].lost.low.x, 38) << "where it was while the light was off";
  EXPECT_GT(on[0].lost.high.x, 50) << "where it was drawn";
  clips_ = {kOff, kOff};
  (void)next(updates);
  clips_ = {above(0), above(10)};
  EXPECT_EQ(next(updates), (std::vector{kNothing, kNothing}));
}

TEST_F(ShadowMapUpdate, AlwaysDrawsEverything) {
  ShadowMapUpdates updates = make(false, Redraw::Always);
  for (int frame = 0; frame < 3; ++frame) EXPECT_EQ(next(updates), (std::vector{kRedraw, kRedraw}));
}

TEST(CoveredTexels, ContainEveryPointOfTheBox) {
  std::mt19937_64 random{47};  // the seed
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution(low, high)(random);
  };
  int partial = 0;
  for (int i = 0; i < 2000; ++i) {
    const glm::dvec3 low(between(-3, 3), between(-3, 1), between(-3, 3));
    const Bounds box{low, low + glm::dvec3(between(0, 1), between(0, 1), between(0, 1))};
    const glm::mat4 clip(above(between(-1, 1)));
    const TexelRect rect = covered_texels(clip, box, kSide);
    partial += !rect.empty() && rect != kAll;
    const glm::vec4 p = clip * glm::vec4(between(box.low.x, box.high.x), between(box.low.y, box.high.y),
                                         between(box.low.z, box.high.z), 1.0);
    const glm::vec2 texel = (glm::vec2(p) / p.w * 0.5f + 0.5f) * static_cast<float>(kSide);
    const glm::vec2 side(static_cast<float>(kSide));
    if (p.w <= 0 || glm::any(glm::lessThan(texel, glm::vec2(0.0f))) ||
        glm::any(glm::greaterThanEqual(texel, side)))
      continue;
    EXPECT_TRUE(glm::all(glm::greaterThanEqual(glm::ivec2(texel), rect.low)) &&
                glm::all(glm::lessThan(glm::ivec2(texel), rect.high)))
        << i;
  }
  EXPECT_GT(partial, 100);
}

TEST(CoveredTexels, AreAllTexelsForABoxThatReachesBehindTheView) {
  EXPECT_EQ(covered_texels(glm::mat4(above(0)), {{-0.1, 1.5, -0.1}, {0.1, 2.5, 0.1}}, kSide), kAll);
}

TEST(TexelRects, JoinToTheSmallestThatContainsBoth) {
  const TexelRect a{{1, 5}, {3, 9}}, b{{2, 1}, {8, 6}};
  EXPECT_EQ(joined(a, b), (TexelRect{{1, 1}, {8, 9}}));
  EXPECT_EQ(joined(a, {}), a);
  EXPECT_EQ(joined({}, b), b);
}

}  // namespace
}  // namespace farshade
