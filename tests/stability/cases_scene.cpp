/// Extreme geometry: sizes, places, shapes of triangles, instances, holes.
#include <cmath>
#include <random>

#include "tests/oracle/scene_builder.h"
#include "tests/stability/cases.h"

namespace farshade::stability {
namespace {

Setting at_scale(double scale) {
  return ordinary({.scale = scale});
}

Setting at_origin(const glm::dvec3& origin) {
  return ordinary({.origin = origin});
}

/// The ordinary scene with one more mesh.
Setting with(const Mesh& mesh, nlohmann::json place = nlohmann::json::object()) {
  Setting setting = ordinary();
  setting.scene.add(mesh, std::move(place));
  return setting;
}

/// A fence of slivers, each `length_m` long and aspect times narrower.
Mesh slivers(float length_m, float aspect) {
  std::vector<glm::vec3> corners;
  const float width = length_m / aspect;
  for (int i = 0; i < 24; ++i) {
    const float z = -0.6f + 0.05f * static_cast<float>(i), x = -length_m / 2, y = 0.3f;
    corners.insert(corners.end(), {{x, y, z}, {x + length_m, y, z}, {x + length_m, y + width, z}});
  }
  return triangle_soup(corners);
}

/// A floor 1e4 m wide, of two triangles, with a box of 5 cm in front of the head.
Setting huge_floor() {
  Setting setting;
  setting.scene.add(quad({0, 0, 0}, {0, 0, 5000}, {5000, 0, 0}));
  setting.scene.add(box({0, 0.025f, 0}, {0.025f, 0.025f, 0.025f}));
  setting.scene.point_light({0.3, 0.5, 0.2}, 0.3);
  setting.scene.sun({0.3, -1, -0.6}, 0.8);
  setting.head =
      recorded({.from = {0.05, 0.25, 0.35}, .target = {0, 0, 0}, .drift_m_s = {0.05, 0.02, -0.03}}, 1);
  return setting;
}

/// A box close to the eyes, and a distant wall.
Setting depth_ratio(float near_m, float far_m) {
  Setting setting = ordinary();
  setting.scene.add(box({0.5f, 1.6f, 2.5f - near_m}, glm::vec3(0.2f * near_m)));
  setting.scene.add(quad({0, 0, -far_m}, {far_m, 0, 0}, {0, far_m, 0}));
  return setting;
}

Setting z_fighting(float gap_m) {
  Setting setting = ordinary();
  setting.scene.add(quad({-0.9f, gap_m, 0.6f}, {0, 0, 0.5f}, {0.5f, 0, 0}));
  return setting;
}

Setting many_triangles() {
  const unsigned seed = 20260101;
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> place(-1.5f, 1.5f), up(0.05f, 1.2f), size(-0.02f, 0.02f);
  std::vector<glm::vec3> corners;
  for (int i = 0; i < 20'000; ++i) {
    const glm::vec3 a(place(random), up(random), place(random));
    for (int k = 0; k < 3; ++k) corners.push_back(a + glm::vec3(size(random), size(random), size(random)));
  }
  return with(triangle_soup(corners));
}

Setting zero_area() {
  std::vector<glm::vec3> corners;
  for (int i = 0; i < 60; ++i) {
    const glm::vec3 a(-1.0f + 0.03f * static_cast<float>(i), 0.8f, 0.2f);
    corners.insert(corners.end(), {a, a, a, a, a + glm::vec3(0.3f, 0.2f, 0), a + glm::vec3(0.6f, 0.4f, 0)});
  }
  return with(triangle_soup(corners));
}

Setting duplicated() {
  Setting setting = ordinary();
  const std::uint32_t mesh = setting.scene.mesh(box({-0.7f, 0.25f, 0.3f}, {0.15f, 0.25f, 0.15f}));
  for (int i = 0; i < 5; ++i) setting.scene.show(mesh);
  return setting;
}

Setting by_node_matrix(const glm::dmat3& linear) {
  Setting setting = ordinary();
  setting.scene.add(box({0, 0, 0}, {0.2f, 0.25f, 0.2f}), by_matrix(linear, {-0.7, 0.3, 0.3}));
  return setting;
}

/// A single-sided panel that its node mirrors: in glTF this exchanges the visible side.
Setting mirrored() {
  Setting setting = ordinary();
  Mesh panel = box({0, 0, 0}, {0.2f, 0.25f, 0.2f});
  panel.material = setting.scene.material({{"doubleSided", false}});
  setting.scene.add(panel, at({-0.7, 0.3, 0.3}, {-1, 1, 1}));
  return setting;
}

Setting flattened(double thickness) {
  return by_node_matrix(glm::dmat3({1, 0, 0}, {0, thickness, 0}, {0, 0, 1}));
}

/// Vertices far from the origin, moved back by their node, as exporters make it of a site in map coordinates.
Setting vertices_far_out(float away_m) {
  Setting setting = ordinary();
  setting.scene.add(box({away_m, 0.25f, 0.25f}, {0.25f, 0.25f, 0.25f}), at({-0.75 - away_m, 0, 0}));
  return setting;
}

/// Vertex colours let alpha fall from 1 to 0 over a panel; the cutoff is in its middle.
Setting alpha_edge(double cutoff) {
  Setting setting = ordinary();
  Mesh panel = quad({-0.6f, 0.6f, 0.4f}, {0.4f, 0, 0}, {0, 0.4f, 0});
  panel.material = setting.scene.material({{"doubleSided", true},
                                           {"alphaMode", "MASK"},
                                           {"alphaCutoff", cutoff},
                                           {"pbrMetallicRoughness", {{"baseColorFactor", {1, 1, 1, 0.5}}}}});
  setting.scene.add(panel);
  return setting;
}

/// Posts of the given width. 3 cm are about one pixel.
Setting thin_posts(float width_m) {
  std::vector<glm::vec3> corners;
  Setting setting = ordinary();
  for (int i = 0; i < 12; ++i)
    setting.scene.add(
        box({-1.1f + 0.17f * static_cast<float>(i), 0.4f, 0.8f}, {width_m / 2, 0.4f, width_m / 2}));
  return setting;
}

Setting coplanar() {
  Setting setting = ordinary();
  for (int i = 0; i < 4; ++i)
    setting.scene.add(quad({-0.9f + 0.1f * static_cast<float>(i), 0, 0.7f}, {0, 0, 0.4f}, {0.4f, 0, 0}));
  return setting;
}

Setting moving(double speed_m_s) {
  Setting setting = ordinary();
  const std::uint32_t node = setting.scene.add(box({0, 0, 0}, {0.15f, 0.15f, 0.15f}), at({-1.2, 0.3, 0.5}));
  setting.scene.move(node, {-1.2, 0.3, 0.5}, {speed_m_s, 0, 0});
  return setting;
}

Setting one_triangle() {
  Setting setting;
  setting.scene.add(triangle_soup({{-1, 0, -1}, {1, 0, -1}, {0, 0, 1}}));
  setting.scene.sun({0.3, -1, -0.6}, 0.8);
  setting.head = recorded({}, 1);
  return setting;
}

Setting many_instances() {
  Setting setting = ordinary();
  const std::uint32_t mesh = setting.scene.mesh(box({0, 0, 0}, glm::vec3(0.01f)));
  for (int row = 0; row < 40; ++row)
    for (int column = 0; column < 50; ++column)
      setting.scene.show(mesh, at({-1.5 + 0.06 * column, 0.02, -1.2 + 0.06 * row}));
  return setting;
}

Case like_many_triangles(Case tested) {
  tested.like = "many-triangles";
  return tested;
}

std::vector<Case> scales_and_origins() {
  return {
      {.name = "ordinary", .extreme = "nothing", .make = [] { return ordinary(); }},
      {.name = "scale-1mm", .extreme = "a scene 4 mm wide", .make = [] { return at_scale(1e-3); }},
      {.name = "scale-10km", .extreme = "a scene 40 km wide", .make = [] { return at_scale(1e4); }},
      {.name = "origin-1000km",
       .extreme = "all of it 1,000 km out",
       .make =
           [] {
             return at_origin({1e6, 2e3, -7e5});
           }},
      {.name = "origin-9e8m",
       .extreme = "all of it near the loader's limit of 1e9 m",
       .make =
           [] {
             return at_origin({9e8, 0, 0});
           }},
      {.name = "vertices-1km-out",
       .extreme = "vertices 1 km out, node brings them back",
       .make = [] { return vertices_far_out(1e3f); }},
      {.name = "vertices-1000km-out",
       .extreme = "vertices 1,000 km out, node brings them back",
       .make = [] { return vertices_far_out(0x1p20f); }},
      {.name = "huge-floor-tiny-box",
       .extreme = "floor of two triangles 10 km wide, box of 5 cm",
       .make = huge_floor},
  };
}

std::vector<Case> degenerate_geometry() {
  return {
      {.name = "triangle-aspect-1e4",
       .extreme = "slivers 1e4 times longer than wide",
       .make = [] { return with(slivers(1.6f, 1e4f)); }},
      {.name = "triangle-aspect-1e6",
       .extreme = "slivers 1e6 times longer than wide",
       .make = [] { return with(slivers(1.6f, 1e6f)); }},
      {.name = "triangle-zero-area", .extreme = "120 triangles without area", .make = zero_area},
      {.name = "triangle-duplicated", .extreme = "five boxes in one place", .make = duplicated},
      {.name = "z-fighting-1mm",
       .extreme = "two sheets 1 mm apart",
       .make = [] { return z_fighting(1e-3f); }},
      {.name = "z-fighting-0.1mm",
       .extreme = "two sheets 0.1 mm apart",
       .make = [] { return z_fighting(1e-4f); }},
      {.name = "coplanar", .extreme = "five sheets in one plane", .make = coplanar},
      {.name = "depth-ratio-1e5",
       .extreme = "things 1 cm and 1 km ahead",
       .make = [] { return depth_ratio(0.01f, 1e3f); }},
      {.name = "depth-ratio-1e7",
       .extreme = "things 1 mm and 10 km ahead",
       .make = [] { return depth_ratio(1e-3f, 1e4f); }},
  };
}

std::vector<Case> transforms_and_motion() {
  const glm::dmat3 sheared({1, 0, 0}, {0.9, 1, 0}, {0, 0.7, 1});
  const glm::dmat3 nearly_singular({1, 0, 0}, {1, 1e-4, 0}, {0, 0, 1});
  return {
      {.name = "mirrored-single-sided", .extreme = "a negative scale turns sides over", .make = mirrored},
      {.name = "sheared",
       .extreme = "a sheared instance",
       .make = [sheared] { return by_node_matrix(sheared); }},
      {.name = "nearly-singular",
       .extreme = "a shear that leaves 1e-4 of the volume",
       .make = [nearly_singular] { return by_node_matrix(nearly_singular); }},
      {.name = "flattened-1e-6",
       .extreme = "a box scaled to 0.25 um of height",
       .make = [] { return flattened(1e-6); }},
      {.name = "scaled-unevenly-1e5",
       .extreme = "scales of 1e-3, 1 and 100",
       .make =
           [] {
             return by_node_matrix(glm::dmat3({1e-3, 0, 0}, {0, 1, 0}, {0, 0, 1e2}));
           }},
      {.name = "alpha-at-cutoff",
       .extreme = "alpha equal to its cutoff",
       .make = [] { return alpha_edge(0.5); }},
      {.name = "alpha-below-cutoff",
       .extreme = "a panel that is one hole",
       .make = [] { return alpha_edge(0.5001); }},
      {.name = "one-pixel-posts",
       .extreme = "posts about a pixel wide",
       .make = [] { return thin_posts(0.03f); }},
      {.name = "hair",
       .extreme = "posts of a hundredth of a pixel",
       .make = [] { return thin_posts(3e-4f); }},
      {.name = "moving-1-m-s",
       .extreme = "nothing: a caster moves",
       .make = [] { return moving(1); },
       .like = "moving-1-m-s"},
      {.name = "moving-100-m-s",
       .extreme = "a caster at 100 m/s",
       .make = [] { return moving(100); },
       .like = "moving-1-m-s"},
      {.name = "one-triangle", .extreme = "nothing but one triangle", .make = one_triangle},
      like_many_triangles(
          {.name = "many-triangles", .extreme = "20,000 small triangles", .make = many_triangles}),
      like_many_triangles(
          {.name = "many-instances", .extreme = "2,000 instances of one box", .make = many_instances}),
  };
}

}  // namespace

std::vector<Case> scene_cases() {
  return joined({scales_and_origins(), degenerate_geometry(), transforms_and_motion()});
}

}  // namespace farshade::stability
