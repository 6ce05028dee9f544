#include "vr_client/preview/pixel_facts.h"

#include <gtest/gtest.h>

namespace farshade {
namespace {

using namespace std::chrono_literals;

Scene scene_of_three_lights() {
  Scene scene;
  scene.lights.resize(3);
  scene.lights[1].name = "lamp";
  return scene;
}

LightSet on(std::size_t lights) {
  LightSet set;
  set.lights.resize(lights);
  return set;
}

PixelFacts facts_with(std::uint8_t source) {
  PixelFacts facts{.side = Side::Right, .pixel = {12, 34}, .ages = {20ms, 35ms, 50ms, 0ms, 90ms}, .masks = 3};
  facts.surface = {.distance_m = 2.5f, .normal = {0, 1, 0}, .instance = {}};
  facts.report = {.mask = EyeMask({1, 1}, 3),
                  .sources = {source},
                  .positions = {{7.25f, 8.5f}},
                  .visibility = {255, 0, 102},
                  .unknown = {0b010},
                  .stale = {0b100},
                  .rays = {2}};
  return facts;
}

std::string value_of(const std::vector<Fact>& words, const std::string& name) {
  for (const Fact& fact : words)
    if (fact.name == name) return fact.value;
  return "missing";
}

std::string source_in_words(std::uint8_t source) {
  return value_of(in_words(facts_with(source), scene_of_three_lights(), on(3)), "source");
}

TEST(PixelFacts, NameSurfaceSourceAndEveryLight) {
  EXPECT_EQ(in_words(facts_with(1), scene_of_three_lights(), on(3)),
            (std::vector<Fact>{{"pixel", "right eye, 12, 34"},
                               {"depth", "2.500 m"},
                               {"normal", "0.00, 1.00, 0.00"},
                               {"source", "mask of this eye, 1 older"},
                               {"age", "35 ms"},
                               {"found at", "7.25, 8.50 of that mask"},
                               {"lit at most by", "2 of 3 lights, a shadow ray each"},
                               {"light 0", "lit"},
                               {"lamp", "in shadow, unknown: a guess"},
                               {"light 2", "40 % lit, outdated"}}));
}

TEST(PixelFacts, NameEverySource) {
  EXPECT_EQ(source_in_words(0), "newest mask of this eye");
  EXPECT_EQ(source_in_words(kOtherEye), "newest mask of the other eye");
  EXPECT_EQ(source_in_words(kOtherEye + 2), "mask of the other eye, 2 older");
  EXPECT_EQ(source_in_words(kNeighbour), "newest mask of this eye, nearest pixel on the surface");
  EXPECT_EQ(source_in_words(kFirstFace), "the cube mask");
  EXPECT_EQ(source_in_words(kSourceUnknown), "unknown: no mask has this point");
}

TEST(PixelFacts, LeaveOutWhatThereIsNot) {
  PixelFacts facts = facts_with(kSourceUnknown);
  EXPECT_EQ(value_of(in_words(facts, scene_of_three_lights(), on(3)), "age"), "missing");
  facts = facts_with(0);
  facts.masks = 0;
  EXPECT_EQ(value_of(in_words(facts, scene_of_three_lights(), on(3)), "source"), "shadow maps");
  EXPECT_EQ(value_of(in_words(facts, scene_of_three_lights(), on(3)), "age"), "missing");
  facts = facts_with(0);
  facts.surface.instance = ShownSurface::Instance{5, 1};
  LightSet lights = on(3);
  lights.lights[1].on = false;
  const std::vector<Fact> words = in_words(facts, scene_of_three_lights(), lights);
  EXPECT_EQ(value_of(words, "instance"), "5, detail level 1");
  EXPECT_EQ(value_of(words, "lamp"), "off");
  facts.surface = {};
  EXPECT_EQ(in_words(facts, scene_of_three_lights(), lights),
            (std::vector<Fact>{{"pixel", "right eye, 12, 34"}, {"depth", "no surface"}}));
}

}  // namespace
}  // namespace farshade
