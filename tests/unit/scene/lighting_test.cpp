/// Lights of the command line, and what a scene gets whose file has none.
#include "stereo/scene/lighting.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "stereo/options/parse_light.h"
#include "stereo/scene/scene_hash.h"
#include "stereo/scene/scene_state.h"
#include "stereo/scene/viewpoint.h"

namespace farshade {
namespace {

/// A closed box of `half` around the origin of its mesh, counter-clockwise as seen from outside or from
/// inside.
enum class Seen { FromOutside, FromInside };

Scene box_scene(const glm::dvec3& half, Seen seen, const glm::dvec3& at = {}) {
  Scene scene;
  scene.name = "box.glb";
  Mesh mesh;
  for (int i = 0; i < 8; ++i)
    mesh.positions.push_back(glm::vec3(half * glm::dvec3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1)));
  mesh.normals.assign(8, glm::vec3(0, 1, 0));
  for (const glm::uvec4 side : {glm::uvec4(0, 4, 6, 2), glm::uvec4(1, 3, 7, 5), glm::uvec4(0, 1, 5, 4),
                                glm::uvec4(2, 6, 7, 3), glm::uvec4(0, 2, 3, 1), glm::uvec4(4, 5, 7, 6)}) {
    mesh.triangles.emplace_back(side.x, side.y, side.z);
    mesh.triangles.emplace_back(side.x, side.z, side.w);
  }
  if (seen == Seen::FromInside)
    for (glm::uvec3& t : mesh.triangles) std::swap(t.y, t.z);
  scene.triangle_count = mesh.triangles.size();
  scene.materials.emplace_back();
  scene.meshes.push_back(std::move(mesh));
  Node node;
  node.rest.translation = at;
  scene.nodes.push_back(node);
  scene.instances.push_back({0, 0});
  scene.bounds = {at - half, at + half};
  scene.hash = hash_of(scene);
  return scene;
}

std::string refusal(std::string_view text) {
  const Expected<AddedLight> light = parse_light(text);
  return light ? "" : light.error().what;
}

TEST(Lighting, ReadsEveryKindOfLight) {
  const AddedLight point = parse_light("point,at=1:-2:3.5,candela=40,range=10,color=1:0.5:0").value();
  EXPECT_EQ(point.source.kind, LightKind::Point);
  EXPECT_EQ(point.position.v, glm::dvec3(1, -2, 3.5));
  EXPECT_EQ(point.source.intensity, glm::vec3(40, 20, 0));
  EXPECT_EQ(point.source.range_m, 10.0f);
  const AddedLight spot = parse_light("spot,to=0:0:0,at=0:3:0,cone=30,candela=100").value();
  EXPECT_EQ(spot.source.kind, LightKind::Spot);
  EXPECT_EQ(spot.direction.v, glm::dvec3(0, -1, 0));
  EXPECT_NEAR(spot.source.outer_cone_rad, std::numbers::pi / 6, 1e-6);
  EXPECT_LT(spot.source.inner_cone_rad, spot.source.outer_cone_rad);
  const AddedLight directional = parse_light("directional,along=0:-2:0,lux=3").value();
  EXPECT_EQ(directional.source.kind, LightKind::Directional);
  EXPECT_EQ(directional.direction.v, glm::dvec3(0, -1, 0));
  EXPECT_EQ(directional.source.intensity, glm::vec3(3));
}

TEST(Lighting, RefusesWhatMakesNoSenseAndQuotesIt) {
  for (const auto& [text, word] :
       std::vector<std::pair<const char*, const char*>>{{"", "begins with point"},
                                                        {"lamp,at=0:0:0", "begins with point"},
                                                        {"point", "needs a place"},
                                                        {"point,at=0:1", "'at=0:1'"},
                                                        {"point,at=0:1:x", "'at=0:1:x'"},
                                                        {"point,at=0:1:inf", "'at=0:1:inf'"},
                                                        {"point,at=0:1:2,colour=1:1:1", "'colour=1:1:1'"},
                                                        {"point,at=0:1:2,lux=1", "candela"},
                                                        {"point,at=0:1:2,candela=0", "above 0"},
                                                        {"point,at=0:1:2,candela=nan", "'candela=nan'"},
                                                        {"point,at=0:1:2,range=-1", "range"},
                                                        {"point,at=0:1:2,cone=30", "cone"},
                                                        {"point,at=0:1:2,to=0:0:0", "no direction"},
                                                        {"spot,at=0:0:0,to=0:0:0", "no length"},
                                                        {"spot,at=0:0:0,cone=91", "90 degrees"},
                                                        {"spot,at=0:0:0,cone=30,inner=30", "inner"},
                                                        {"directional,candela=3", "lux"},
                                                        {"directional,range=3", "no range"},
                                                        {"point,at=0:1:2,color=-1:1:1", "colour"}})
    EXPECT_NE(refusal(text).find(word), std::string::npos) << text << ": " << refusal(text);
}

TEST(Lighting, TheSunStandsWhereItsAnglesSay) {
  const AddedLight north = parse_sun("0,0").value(), east = parse_sun("90,0,5").value(),
                   zenith = parse_sun("0,90").value();
  EXPECT_LT(glm::length(north.direction.v - glm::dvec3(0, 0, 1)), 1e-12) << "it shines from -z";
  EXPECT_LT(glm::length(east.direction.v - glm::dvec3(-1, 0, 0)), 1e-12) << "it shines from +x";
  EXPECT_LT(glm::length(zenith.direction.v - glm::dvec3(0, -1, 0)), 1e-12);
  EXPECT_EQ(east.source.intensity, glm::vec3(5));
  for (const char* text : {"", "1", "1,2,3,4", "a,2", "0,91", "0,10,0", "0,10,nan"})
    EXPECT_FALSE(parse_sun(text)) << text;
}

/// A scene whose file has lights and a camera.
Scene complete_scene() {
  Scene scene = box_scene({1, 1, 1}, Seen::FromOutside);
  scene.camera = Rigid<Stage, Eye>{.translation = {0, 0, 3}};
  LightSource light;
  light.intensity = glm::vec3(30);
  scene.nodes.emplace_back().rest.translation = {0, 3, 0};
  light.node = 1;
  scene.lights.push_back(light);
  scene.hash = hash_of(scene);
  return scene;
}

TEST(Lighting, ASceneWithLightsAndACameraOfItsOwnDoesNotChange) {
  const Scene scene = complete_scene();
  const LitScene lit = light_scene(scene, {}).value();
  EXPECT_TRUE(lit.notes.empty());
  EXPECT_EQ(lit.scene.hash, scene.hash);
  EXPECT_EQ(lit.scene.lights.size(), 1u);
  EXPECT_EQ(lit.scene.ambient, 0);
}

TEST(Lighting, EachChangeAloneChangesTheHash) {
  const Scene complete = complete_scene();
  Scene without_camera = complete, dark = complete;
  without_camera.camera.reset();
  dark.lights.clear();
  const AddedLight light = parse_light("spot,at=0:3:1,to=0:0:1,candela=50").value();
  struct Case {
    const char* change;
    Scene scene;
    Lighting lighting;
  };
  for (Case& one : std::vector<Case>{{"a chosen viewpoint", without_camera, {.exposure = 1.0f}},
                                     {"an added light", complete, {.lights = {light}, .exposure = 1.0f}},
                                     {"a sun and a lamp", dark, {.ambient = 0.0f, .exposure = 1.0f}},
                                     {"ambient light", complete, {.ambient = 0.1f, .exposure = 1.0f}},
                                     {"an exposure", complete, {.exposure = 2.0f}}}) {
    one.scene.hash = hash_of(one.scene);
    const Scene lit = light_scene(one.scene, one.lighting).value().scene;
    EXPECT_NE(lit.hash, one.scene.hash) << one.change;
    EXPECT_EQ(lit.hash, hash_of(lit)) << one.change;
  }
}

TEST(Lighting, AnAddedLightIsPartOfTheSceneAndOfItsHash) {
  const Scene dark = box_scene({1, 1, 1}, Seen::FromOutside);
  const AddedLight light = parse_light("spot,at=0:3:1,to=0:0:1,candela=50").value();
  const LitScene lit = light_scene(dark, {.lights = {light}}).value();
  EXPECT_TRUE(lit.notes.empty());
  EXPECT_NE(lit.scene.hash, dark.hash);
  EXPECT_EQ(lit.scene.hash, light_scene(dark, {.lights = {light}})->scene.hash);
  EXPECT_NE(lit.scene.hash, light_scene(dark, {.lights = {light}, .ambient = 0.1f})->scene.hash);
  EXPECT_NE(lit.scene.hash, light_scene(dark, {.lights = {light}, .exposure = 2.0f})->scene.hash);
  const LightSet lights = state_at(lit.scene, Time{}).light_set;
  ASSERT_EQ(lights.lights.size(), 1u);
  EXPECT_LT(glm::length(lights.lights[0].position.v - glm::dvec3(0, 3, 1)), 1e-12);
  EXPECT_LT(glm::length(lights.lights[0].direction.v - glm::dvec3(0, -1, 0)), 1e-12);
}

TEST(Lighting, ADarkSceneGetsASunAndALampBesideItsViewpoint) {
  for (const double size : {0.01, 1.0, 1000.0}) {
    const LitScene lit = light_scene(box_scene(glm::dvec3(size), Seen::FromOutside), {}).value();
    ASSERT_EQ(lit.notes.size(), 1u) << size;
    EXPECT_NE(lit.notes[0].find("no lights"), std::string::npos);
    ASSERT_EQ(lit.scene.lights.size(), 2u);
    EXPECT_EQ(lit.scene.lights[0].kind, LightKind::Directional);
    const LightSet lights = state_at(lit.scene, Time{}).light_set;
    EXPECT_LT(lights.lights[0].direction.v.y, -0.5) << "the sun is high";
    const glm::dvec3 eye = viewpoint_of(lit.scene).translation;
    EXPECT_LT(glm::length(lights.lights[1].position.v - eye), size);
    // The lamp is as bright at a scene of any size.
    EXPECT_NEAR(lit.scene.lights[1].intensity.x / (3 * size * size), 0.507, 0.001);
    EXPECT_GT(lit.scene.ambient, 0);
  }
}

TEST(Lighting, AnExposureMultipliesLightsAndAmbientLightAndStaysFinite) {
  const Scene box = box_scene({1, 1, 1}, Seen::FromOutside);
  AddedLight light = parse_light("directional,lux=100000").value();
  EXPECT_EQ(light_scene(box, {.lights = {light}})->scene.lights[0].intensity.x, 100'000) << "none is chosen";
  const Scene lit = light_scene(box, {.lights = {light}, .ambient = 0.25f, .exposure = 2.0f})->scene;
  EXPECT_EQ(lit.lights[0].intensity.x, 200'000);
  EXPECT_EQ(lit.ambient, 0.5f);
  light.source.intensity = glm::vec3(1e30f);
  EXPECT_TRUE(
      std::isfinite(light_scene(box, {.lights = {light}, .exposure = 1e12f})->scene.lights[0].intensity.x));
}

TEST(Lighting, RefusesMoreLightsThanAMaskHasBits) {
  const Lighting many{.lights = std::vector(257, parse_light("point,at=0:1:2").value())};
  const Expected<LitScene> lit = light_scene(box_scene({1, 1, 1}, Seen::FromOutside), many);
  ASSERT_FALSE(lit);
  EXPECT_NE(lit.error().what.find("257 lights"), std::string::npos);
}

TEST(Viewpoint, IsInTheMiddleOfARoomAndLooksAlongIt) {
  const Rigid<Stage, Eye> eye = viewpoint_of(box_scene({4, 1.5, 2}, Seen::FromInside, {5, 1.5, -7}));
  EXPECT_LT(glm::length(eye.translation - glm::dvec3(5, 1.5, -7)), 1e-9);
  EXPECT_NEAR(std::abs(eye(Vector<Eye>{{0, 0, -1}}).v.x), 1, 1e-9);
  EXPECT_NEAR(eye(Vector<Eye>{{0, 1, 0}}).v.y, 1, 1e-9);
}

TEST(Viewpoint, IsNoNearerThan30CmToASurface) {
  for (const double gap : {0.2, 0.4}) {
    // The eye of a room 3 m high stands in the middle of its height.
    Scene room = box_scene({3, 1.5, 3}, Seen::FromInside);
    room.meshes.push_back(box_scene({2.9, 0.1, 2.9}, Seen::FromOutside).meshes[0]);
    room.nodes.emplace_back().rest.translation = {0, -0.1 - gap, 0};
    room.instances.push_back({1, 1});
    room.triangle_count *= 2;
    const glm::dvec3 eye = viewpoint_of(room).translation;
    EXPECT_EQ(glm::length(eye) < 3, gap > 0.3) << eye.x << ", " << eye.y << ", " << eye.z;
  }
}

// Many exporters make every material double-sided, so the side does not tell a room from a solid. A room has
// more than one instance.
TEST(Viewpoint, IsInARoomOfDoubleSidedWallsWithFurnitureButNotInASolid) {
  Scene room = box_scene({3, 1.5, 3}, Seen::FromOutside);
  room.materials[0].double_sided = true;
  EXPECT_GT(viewpoint_of(room).translation.z, 3) << "a solid";
  const Mesh shelf = box_scene({1.3, 0.5, 0.2}, Seen::FromOutside).meshes[0];
  room.meshes.push_back(shelf);
  for (const double z : {-2.0, 2.0}) {
    room.nodes.emplace_back().rest.translation = {0, 0, z};
    room.instances.push_back({1, static_cast<std::uint32_t>(room.nodes.size() - 1)});
    room.triangle_count += shelf.triangles.size();
  }
  EXPECT_LT(glm::length(viewpoint_of(room).translation), 3);
}

/// A lamp at `at` in a scene of nodes without parents.
void add_lamp(Scene& scene, const glm::dvec3& at) {
  LightSource lamp;
  lamp.node = static_cast<std::uint32_t>(scene.nodes.size());
  scene.nodes.emplace_back().rest.translation = at;
  scene.lights.push_back(lamp);
}

TEST(Viewpoint, IsInARoomOfDoubleSidedWallsWhoseLampItSees) {
  const auto eye_with_lamp = [](const glm::dvec3& at, bool shaded) {
    Scene room = box_scene({3, 1.5, 3}, Seen::FromOutside);
    room.materials[0].double_sided = true;
    if (shaded) {
      room.meshes.push_back(box_scene({0.1, 0.1, 0.1}, Seen::FromOutside).meshes[0]);
      room.nodes.emplace_back().rest.translation = at;
      room.instances.push_back({1, 1});
      room.triangle_count *= 2;
    }
    add_lamp(room, at);
    return viewpoint_of(room).translation;
  };
  EXPECT_LT(glm::length(eye_with_lamp({0.5, 1, 0}, false)), 3);
  EXPECT_GT(eye_with_lamp({0.5, 1, 0}, true).z, 3) << "a lamp in a closed box";
  EXPECT_GT(eye_with_lamp({0, 5, 0}, false).z, 3) << "a lamp outside";
}

TEST(Viewpoint, IsInTheRoomWithALamp) {
  for (const double lamp : {-3.0, 3.0}) {
    Scene rooms = box_scene({2.5, 1.5, 2.5}, Seen::FromInside, {-3, 0, 0});
    rooms.meshes.push_back(box_scene({2.5, 1.5, 2.5}, Seen::FromInside).meshes[0]);
    rooms.nodes.emplace_back().rest.translation = {3, 0, 0};
    rooms.instances.push_back({1, 1});
    rooms.triangle_count *= 2;
    rooms.bounds = {{-5.5, -1.5, -2.5}, {5.5, 1.5, 2.5}};
    add_lamp(rooms, {lamp, 1, 0});
    EXPECT_GT(viewpoint_of(rooms).translation.x * lamp, 0) << lamp;
  }
}

TEST(Viewpoint, IsInFrontOfAnObjectOfAnySizeWithAllOfItInView) {
  for (const double size : {0.01, 1.0, 500.0}) {
    const glm::dvec3 at(3 * size, size, -2 * size);
    const Rigid<Stage, Eye> eye = viewpoint_of(box_scene({size, 2 * size, size}, Seen::FromOutside, at));
    EXPECT_GT(eye.translation.z, at.z + size);
    for (int corner = 0; corner < 8; ++corner) {
      const glm::dvec3 p =
          at + size * glm::dvec3(corner & 1 ? 1 : -1, corner & 2 ? 2 : -2, corner & 4 ? 1 : -1);
      const glm::dvec3 seen = inverse(eye)(Point<Stage>{p}).v;
      EXPECT_LT(seen.z, 0);
      EXPECT_LT(std::hypot(seen.x, seen.y), -1.6 * seen.z) << "within 58 degrees";
    }
  }
}

/// The back of a single-sided picture, a plate seen from its edge, and a lying one.
TEST(Viewpoint, IsWhereAFlatThingIsSeen) {
  const auto eye_before = [](const glm::vec3& u, const glm::vec3& v) {
    Scene scene = box_scene({1, 1, 1}, Seen::FromOutside);
    Mesh& mesh = scene.meshes[0];
    mesh.positions = {-u - v, u - v, u + v, v - u};
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    const glm::dvec3 most(glm::abs(u) + glm::abs(v));
    scene.bounds = {-most, most};
    return viewpoint_of(scene).translation;
  };
  for (const float size : {0.005f, 1.0f, 50.0f}) {
    const glm::vec3 x(size, 0, 0), y(0, size, 0), z(0, 0, size);
    EXPECT_GT(eye_before(x, y).z, size);
    EXPECT_LT(eye_before(y, x).z, -size) << "its front is at -z";
    EXPECT_LT(eye_before(z, y).x, -size);
    const glm::dvec3 lying = eye_before(z, x), ceiling = eye_before(x, z);
    EXPECT_GT(lying.y / lying.z, 0.17) << "from above";
    EXPECT_LT(ceiling.y / ceiling.z, -0.3);
  }
}

// glTF 2.0, 3.7.4: a mirrored surface is seen from the same side as before.
TEST(Viewpoint, IsInAMirroredRoomToo) {
  Scene room = box_scene({4, 1.5, 2}, Seen::FromInside);
  room.nodes[0].rest.scale = {-1, 1, 1};
  EXPECT_LT(glm::length(viewpoint_of(room).translation), 0.1);
}

TEST(Viewpoint, IsTheCameraOfTheFileIfThereIsOne) {
  Scene scene = box_scene({1, 1, 1}, Seen::FromOutside);
  scene.camera = Rigid<Stage, Eye>{.translation = {1, 2, 3}};
  EXPECT_EQ(viewpoint_of(scene).translation, glm::dvec3(1, 2, 3));
}

}  // namespace
}  // namespace farshade
