/// Lights that KHR_animation_pointer changes: their values over time, what a file may not say, and what is
/// fixed for all times (plan, hash).
#include <gtest/gtest.h>

#include "stereo/scene/lighting.h"
#include "stereo/scene/scene_hash.h"
#include "stereo/scene/scene_state.h"
#include "tests/unit/gltf/gltf_builder.h"

namespace farshade {
namespace {

using nlohmann::json;

/// A triangle, a spot light above it, and one animation without channels.
GltfBuilder lamp_file(const json& light = {{"type", "spot"}, {"spot", json::object()}}) {
  GltfBuilder file = triangle_file();
  file.node({{"extensions", file.light(light)}, {"translation", {0, 0, 3}}});
  file.json["extensionsUsed"] = {"KHR_lights_punctual", "KHR_animation_pointer"};
  file.json["animations"] = {{{"samplers", json::array()}, {"channels", json::array()}}};
  return file;
}

void add_channel(GltfBuilder& file, const std::string& pointer, std::uint32_t output, std::uint32_t input,
                 const char* interpolation = "LINEAR") {
  json& animation = file.json["animations"][0];
  animation["channels"].push_back(
      {{"sampler", animation["samplers"].size()},
       {"target",
        {{"path", "pointer"}, {"extensions", {{"KHR_animation_pointer", {{"pointer", pointer}}}}}}}});
  animation["samplers"].push_back({{"input", input}, {"output", output}, {"interpolation", interpolation}});
}

/// Animates a property of light 0 between 0 s and 2 s.
void animate(GltfBuilder& file, const std::string& property, const std::vector<float>& values,
             const char* interpolation = "LINEAR") {
  const bool is_color = property == "color";
  const auto output = file.accessor(file.view(values), 5126, is_color ? "VEC3" : "SCALAR",
                                    is_color ? values.size() / 3 : values.size());
  const auto input = file.accessor(file.view<float>({0, 2}), 5126, "SCALAR", 2);
  add_channel(file, "/extensions/KHR_lights_punctual/lights/0/" + property, output, input, interpolation);
}

Scene loaded(const GltfBuilder& file) {
  auto scene = load(file);
  EXPECT_TRUE(scene) << scene.error().what;
  return scene ? *scene : Scene{};
}

Light at(const Scene& scene, double seconds) {
  return state_at(scene, Time(duration_from_ms(seconds * 1e3))).light_set.lights.at(0);
}

void expect_near(const glm::vec3& a, const glm::vec3& b) {
  EXPECT_LT(glm::length(a - b), 1e-5f) << a.x << " " << a.y << " " << a.z;
}

TEST(AnimatedLights, ColourTimesIntensityFollowsBoth) {
  GltfBuilder file = lamp_file({{"type", "point"}, {"color", {1, 0.5, 0}}, {"intensity", 8}});
  animate(file, "intensity", {2, 6});
  expect_near(at(loaded(file), 0.5).intensity, {3, 1.5, 0});
  animate(file, "color", {1, 0, 0, 0, 0, 1});
  const Scene scene = loaded(file);
  EXPECT_TRUE(scene.warnings.empty());
  EXPECT_EQ(scene.animation_length_s, 2);
  expect_near(at(scene, 0.5).intensity, {2.25, 0, 0.75});
  expect_near(at(scene, 2.5).intensity, {2.25, 0, 0.75});
  EXPECT_FALSE(scene.nodes[scene.lights[0].node].moving);
}

TEST(AnimatedLights, RangeAndConesFollow) {
  GltfBuilder file = lamp_file();
  animate(file, "range", {1, 3}, "STEP");
  animate(file, "spot/outerConeAngle", {0.5f, 0.9f});
  animate(file, "spot/innerConeAngle", {0.1f, 1.5f});
  const Scene scene = loaded(file);
  EXPECT_EQ(at(scene, 1.9).range_m, 1);
  EXPECT_FLOAT_EQ(at(scene, 1).outer_cone_rad, 0.7f);
  EXPECT_FLOAT_EQ(at(scene, 0.5).inner_cone_rad, 0.45f);
  EXPECT_EQ(at(scene, 1.5).inner_cone_rad, at(scene, 1.5).outer_cone_rad) << "never wider than the outer one";
  EXPECT_EQ(at(scene, 0).widest_cone_rad, 0.9f);
  EXPECT_EQ(scene.lights[0].range_m, 3.0f) << "the largest";
}

TEST(AnimatedLights, ASplineStaysWithinWhatThePropertyCanBe) {
  GltfBuilder file = lamp_file();
  animate(file, "intensity", {0, 1, -9, 9, 1, 0}, "CUBICSPLINE");
  animate(file, "spot/outerConeAngle", {0, 1, 9, -9, 1, 0}, "CUBICSPLINE");
  animate(file, "range", {0, 1, -9, 9, 1, 0}, "CUBICSPLINE");
  const Scene scene = loaded(file);
  expect_near(at(scene, 1).intensity, glm::vec3(0));
  EXPECT_FLOAT_EQ(at(scene, 1).outer_cone_rad, 1.5707964f);
  EXPECT_GT(at(scene, 1).range_m, 0) << "0 is no range";
  for (double t = 0; t < 2; t += 0.1) {
    EXPECT_LE(at(scene, t).outer_cone_rad, scene.lights[0].outer_cone_rad) << t;
    EXPECT_LE(at(scene, t).range_m, scene.lights[0].range_m) << t;
    EXPECT_LE(at(scene, t).intensity.x, scene.lights[0].intensity.x) << t;
  }
}

TEST(AnimatedLights, ConstantTracksAreNoAnimation) {
  GltfBuilder file = lamp_file();
  animate(file, "intensity", {7, 7});
  const Scene scene = loaded(file);
  EXPECT_FALSE(scene.lights[0].animation);
  EXPECT_EQ(scene.animation_length_s, 0);
  expect_near(at(scene, 1).intensity, glm::vec3(7));
}

TEST(AnimatedLights, EveryNodeThatCarriesTheLightHasThem) {
  GltfBuilder file = lamp_file();
  file.node({{"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}, {"translation", {5, 0, 3}}});
  animate(file, "intensity", {2, 6});
  const SceneState state = state_at(loaded(file), time_from_ns(1'000'000'000));
  ASSERT_EQ(state.light_set.lights.size(), 2u);
  for (const Light& light : state.light_set.lights) expect_near(light.intensity, glm::vec3(4));
}

TEST(AnimatedLights, AStateIsUpdatedEvenIfNothingMoves) {
  GltfBuilder file = lamp_file();
  animate(file, "intensity", {2, 6});
  const Scene scene = loaded(file);
  SceneState state = state_at(scene, Time{});
  advance(scene, time_from_ns(1'000'000'000), {}, state);
  expect_near(state.light_set.lights[0].intensity, glm::vec3(4));
}

TEST(AnimatedLights, ArePartOfTheHash) {
  GltfBuilder first = lamp_file(), second = lamp_file();
  animate(first, "intensity", {2, 6});
  animate(second, "intensity", {3, 6});
  EXPECT_NE(loaded(first).hash, loaded(second).hash);
  Scene scene = loaded(first);
  scene.lights[0].animation->exposure = 2;
  EXPECT_NE(hash_of(scene), loaded(first).hash);
}

TEST(AnimatedLights, AreMultipliedByTheUsersExposureAtEachTime) {
  GltfBuilder file = lamp_file({{"type", "point"}});
  animate(file, "intensity", {0, 1e6});
  const Scene lit = light_scene(loaded(file), {.exposure = 1e-5f})->scene;
  EXPECT_NEAR(lit.lights[0].intensity.x, 10, 1e-5);
  EXPECT_NEAR(at(lit, 1).intensity.x, 5, 1e-5);
  EXPECT_EQ(at(lit, 0).intensity.x, 0);
}

/// A channel that makes lamp_file() wrong, and what the sentence says.
struct WrongChannel {
  const char* name;
  const char* pointer;
  std::vector<float> values;
  const char* type;
  std::size_t count;
  const char* says;
};
void PrintTo(const WrongChannel& wrong, std::ostream* out) {
  *out << wrong.name;
}

#define LIGHT "/extensions/KHR_lights_punctual/lights/"
class AnimatedLightRepair : public testing::TestWithParam<WrongChannel> {};

TEST_P(AnimatedLightRepair, StandsStillAndNamesWhatIsWrong) {
  const WrongChannel& wrong = GetParam();
  GltfBuilder file = lamp_file();
  file.light({{"type", "point"}});
  const auto output = file.accessor(file.view(wrong.values), 5126, wrong.type, wrong.count);
  add_channel(file, wrong.pointer, output, file.accessor(file.view<float>({0, 2}), 5126, "SCALAR", 2));
  const auto scene = load(file);
  EXPECT_NE(outcome_of(scene).find("repaired: animation 0, light channel 0"), std::string::npos);
  EXPECT_NE(outcome_of(scene).find(wrong.says), std::string::npos) << outcome_of(scene);
  EXPECT_EQ(scene.value().animation_length_s, 0);
}

INSTANTIATE_TEST_SUITE_P(
    Pointers, AnimatedLightRepair,
    testing::Values(
        WrongChannel{"IndexOutOfRange",
                     LIGHT "7/intensity",
                     {1, 2},
                     "SCALAR",
                     2,
                     "light channel 0: there is no light 7"},
        WrongChannel{"ColourForIntensity",
                     LIGHT "0/intensity",
                     {1, 2, 3, 4, 5, 6},
                     "VEC3",
                     2,
                     "has a type that intensity cannot have"},
        WrongChannel{"NumberForColour", LIGHT "0/color", {1, 2}, "SCALAR", 2, "has a type that color"},
        WrongChannel{"ConeOfAPoint", LIGHT "1/spot/outerConeAngle", {1, 1}, "SCALAR", 2, "is no spot light"},
        WrongChannel{"TooFewValues", LIGHT "0/intensity", {1}, "SCALAR", 1, "has 1 elements, should have 2"},
        WrongChannel{"Negative", LIGHT "0/intensity", {1, -2}, "SCALAR", 2, "element 1 is a value that"},
        WrongChannel{"NoRange", LIGHT "0/range", {1, 0}, "SCALAR", 2, "element 1 is a value that range"},
        WrongChannel{"WideCone", LIGHT "0/spot/outerConeAngle", {1, 2}, "SCALAR", 2, "element 1 is a value"}),
    [](const auto& made) { return made.param.name; });

TEST(AnimatedLights, IntegersAreNormalised) {
  const auto with_normalized = [](bool normalized) {
    GltfBuilder file = lamp_file();
    const auto output =
        file.accessor(file.view<std::uint16_t>({0, 65535}), 5123, "SCALAR", 2, {{"normalized", normalized}});
    add_channel(file, LIGHT "0/intensity", output,
                file.accessor(file.view<float>({0, 2}), 5126, "SCALAR", 2));
    return load(file);
  };
  EXPECT_EQ(outcome_of(with_normalized(true)), "drawn");
  const std::string plain = outcome_of(with_normalized(false));
  EXPECT_NE(plain.find("has a type that intensity cannot have; it stands still"), std::string::npos) << plain;
}

TEST(AnimatedLights, OfTheSamePropertyTheFirstOneCounts) {
  GltfBuilder file = lamp_file();
  animate(file, "intensity", {2, 6});
  animate(file, "intensity", {2, 6});
  const auto scene = load(file);
  EXPECT_NE(outcome_of(scene).find("an earlier channel moves the same property; it stands still"),
            std::string::npos)
      << outcome_of(scene);
  EXPECT_EQ(scene->lights.at(0).animation.value().tracks.size(), 1u);
}

TEST(AnimatedLights, OtherPropertiesStandStillWithAWarning) {
  for (const char* pointer :
       {LIGHT "0/name", LIGHT "0/spot", LIGHT "x/intensity", LIGHT "/intensity", LIGHT "99999999999/range",
        LIGHT "-1/intensity", LIGHT "0/intensity/0", LIGHT}) {
    GltfBuilder file = lamp_file();
    const auto number = file.accessor(file.view<float>({0, 2}), 5126, "SCALAR", 2);
    add_channel(file, pointer, number, number);
    const Scene scene = loaded(file);
    EXPECT_EQ(scene.animation_length_s, 0) << pointer;
    ASSERT_EQ(scene.warnings.size(), 1u) << pointer;
    EXPECT_NE(scene.warnings[0].find("only nodes and lights are animated"), std::string::npos);
  }
}
#undef LIGHT

}  // namespace
}  // namespace farshade
