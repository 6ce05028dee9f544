#include "tests/oracle/random_scenes.h"

#include <cmath>

#include "tests/oracle/scene_builder.h"

namespace farshade {

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

}  // namespace farshade
