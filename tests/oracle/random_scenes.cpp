#include "tests/oracle/random_scenes.h"

#include <cmath>

#include "tests/oracle/scene_builder.h"

namespace farshade {

namespace {

/// An upright tube from y = 0 to 2, `radius` thick. Its vertices follow joint 0 at the bottom, 1 in the
/// middle, 2 at the top, and two of them in between. The only morph target makes it thicker.
Mesh bending_tube(std::uint32_t triangles, float radius) {
  constexpr std::uint32_t kAround = 20;
  const std::uint32_t rings = std::max(triangles / (2 * kAround), 2u) + 1;
  Mesh mesh;
  Deformable& to = mesh.deformable.emplace();
  to.targets.resize(1);
  for (std::uint32_t ring = 0; ring < rings; ++ring)
    for (std::uint32_t i = 0; i < kAround; ++i) {
      const float angle = 6.2831853f * static_cast<float>(i) / kAround;
      const float y = 2.0f * static_cast<float>(ring) / static_cast<float>(rings - 1);
      const glm::vec3 out(std::cos(angle), 0, std::sin(angle));
      to.positions.push_back(radius * out + glm::vec3(0, y, 0));
      to.normals.push_back(out);
      to.targets[0].positions.push_back(0.5f * radius * out);
      to.targets[0].normals.emplace_back(0.0f);
      const bool upper = y > 1;
      const float weight = upper ? y - 1 : y;
      to.influences.push_back(
          {upper ? glm::u16vec4(1, 2, 0, 0) : glm::u16vec4(0, 1, 0, 0), glm::vec4(1 - weight, weight, 0, 0)});
      if (ring + 1 == rings) continue;
      const std::uint32_t a = ring * kAround + i, b = ring * kAround + (i + 1) % kAround;
      mesh.triangles.emplace_back(a, a + kAround, b);
      mesh.triangles.emplace_back(b, a + kAround, b + kAround);
    }
  mesh.positions = to.positions, mesh.normals = to.normals;
  return mesh;
}

/// A box whose flat sides follow two joints, the lower and the upper end; the morph target makes it wider.
Mesh bending_box(const glm::vec3& center, const glm::vec3& half) {
  Mesh mesh = box(center, half);
  Mesh flat;
  Deformable& to = flat.deformable.emplace();
  to.targets.resize(1);
  for (const glm::uvec3& t : mesh.triangles) {
    const auto first = static_cast<std::uint32_t>(to.positions.size());
    for (const std::uint32_t vertex : {t.x, t.y, t.z}) {
      const glm::vec3 p = mesh.positions[vertex];
      to.positions.push_back(p);
      to.targets[0].positions.emplace_back(0.7f * (p.x - center.x), 0, 0);
      const bool upper = p.y > center.y;
      to.influences.push_back(
          {glm::u16vec4(0, 1, 0, 0), upper ? glm::vec4(0.2f, 0.8f, 0, 0) : glm::vec4(1, 0, 0, 0)});
    }
    flat.triangles.emplace_back(first, first + 1, first + 2);
  }
  flat.positions = to.positions, flat.normals.resize(to.positions.size());
  return flat;
}

}  // namespace

Scene random_soup(std::mt19937& random) {
  std::uniform_real_distribution<float> place(-2, 2), unit(0, 1);
  SceneBuilder build;
  for (const float y : {-2.0f, 2.0f}) build.add(quad({0, y, 0}, {3, 0, 0}, {0, 0, -3}));
  for (const float x : {-3.0f, 3.0f}) build.add(quad({x, 0, 0}, {0, 2, 0}, {0, 0, -3}));
  for (int i = 0; i < 8; ++i)  // plates that lie almost on the floor
    build.add(quad({place(random), -2 + 0.1f * std::pow(unit(random), 3.0f), place(random)},
                   {0.8f * unit(random), 0, 0}, {0, 0, -0.8f * unit(random)}));
  std::vector<glm::vec3> corners;
  for (int i = 0; i < 40; ++i) {
    const glm::vec3 at(place(random), place(random), place(random));
    const float size = 0.6f * unit(random) * unit(random);
    for (int corner = 0; corner < 3; ++corner)
      corners.push_back(at + size * glm::vec3(place(random), place(random), place(random)));
  }
  build.add(triangle_soup(corners));
  build.move(build.add(box({place(random), place(random), place(random)}, {0.3f, 0.2f, 0.4f})),
             {0.8, 0.2, -0.5});
  const bool surrounds = unit(random) < 0.5f;
  for (int i = 0; i < 3; ++i) {
    const glm::dvec3 at(place(random), place(random), place(random));
    NodeTransform around;
    around.translation = at;
    if (i == 1 && surrounds)
      build.turn(build.add(lampshade(0.3f + unit(random), 0.5f + unit(random)), 0, around), 1.0);
    if (i == 2 && surrounds)
      build.move(build.add(box({0, 0, 0}, glm::vec3(0.5f)), 0, around), {-0.7, 0.3, 0.6});
    const glm::dvec3 toward(place(random), -2.5 + place(random), place(random));
    build.point_light(at, i == 0 ? std::optional<float>(1.0f + 2 * unit(random)) : std::nullopt);
    build.spot_light(at * 0.9, toward, 0.3f + unit(random));
    build.directional_light(toward);
  }
  build.point_light({place(random), 50, place(random)});
  return build.build();
}

Scene changing_lights(std::mt19937& random) {
  std::uniform_real_distribution<float> place(-2, 2), unit(0, 1);
  SceneBuilder build;
  build.add(quad({0, -2, 0}, {3, 0, 0}, {0, 0, -3}));
  for (int i = 0; i < 20; ++i)
    build.add(box({place(random), place(random), place(random)}, 0.3f * glm::vec3(unit(random))));
  for (int i = 0; i < 3; ++i) {
    build.point_light({place(random), 1.5, place(random)}, 1.0f);
    build.change(LightProperty::Range, glm::vec4(1 + 3 * unit(random)), glm::vec4(1 + 5 * unit(random)));
    build.change(LightProperty::Intensity, glm::vec4(0), glm::vec4(1));
    build.spot_light({place(random), 2, place(random)}, {0.3 * place(random), -1, 0.3 * place(random)}, 0.5f);
    build.change(LightProperty::OuterCone, glm::vec4(0.1f + unit(random)), glm::vec4(0.1f + unit(random)));
  }
  return build.build();
}

Scene bending_figures(std::mt19937& random, std::uint32_t triangles, const glm::dvec3& shift,
                      BendingBoxes boxes) {
  std::uniform_real_distribution<float> place(-1, 1), unit(0, 1);
  SceneBuilder build(shift);
  build.add(quad({0, 0, 0}, {3, 0, 0}, {0, 0, -3}));
  build.add(quad({0, 1.5f, -3}, {3, 0, 0}, {0, 1.5f, 0}));
  const auto weights = [&](float most) { return WeightTrack{Interpolation::Linear, {0, 1}, {0, most}}; };
  const auto hip = build.joint(std::nullopt, {place(random), 0, place(random)});
  const auto knee = build.joint(hip, {0, 1, 0}), ankle = build.joint(knee, {0, 1, 0});
  const auto bound_at = [](double y) {
    glm::dmat4 inverse(1.0);
    inverse[3].y = -y;
    return inverse;
  };
  build.turn(hip, 1 + unit(random));
  build.swing(knee, 0.5 + unit(random));
  build.swing(ankle, 0.5 + unit(random));
  build.add_deformed(
      {bending_tube(triangles, 0.15f)},
      {.joints = {{hip}, {knee, bound_at(1)}, {ankle, bound_at(2)}}, .weights = {0}, .track = weights(1)});
  const auto low = build.joint(std::nullopt, {place(random), 0.5, place(random)});
  const auto high = build.joint(low, {0, 0.4, 0});
  build.swing(high, 1 + 0.3 * unit(random));
  Material grey;
  grey.double_sided = false;
  Mesh single = bending_box({0, 0.2f, 0}, {0.2f, 0.3f, 0.1f});
  single.material = build.material(grey);
  Mesh torn = bending_box({0.6f, 0.3f, 0}, {0.2f, 0.3f, 0.2f}),
       cloth = bending_box({0, 0.9f, 0}, {0.3f, 0.2f, 0.3f});
  Material holed;
  holed.alpha_cutoff = 0.5f, holed.double_sided = true;
  torn.material = build.material(holed);
  for (std::size_t i = 0; i < torn.positions.size(); ++i)
    torn.colors.emplace_back(255, 255, 255, i % 3 == 0 ? 0 : 255);
  for (Mesh* const open : {&single, &cloth}) open->triangles.resize(6);  // their inner sides are seen, too
  if (boxes == BendingBoxes::Some)
    build.add_deformed({torn, cloth, single},
                       {.joints = {{low}, {high, bound_at(0.4)}}, .weights = {0}, .track = weights(1)});
  build.point_light({2 * place(random), 2.8, 2 * place(random)});
  build.directional_light({place(random), -1.5, place(random)});
  build.move(build.point_light({2 * place(random), 2.5, 2}, 6.0f), {0.5, 0.2, -0.3});
  return build.build();
}

}  // namespace farshade
