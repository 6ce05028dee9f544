#include "stereo/edge_rays/edge_ray_data.h"

#include <gtest/gtest.h>

#include <thread>

#include "tests/oracle/scene_builder.h"

namespace farshade {
namespace {

constexpr std::uint64_t kManyTexels = 1 << 27;

/// A floor of `side` x `side` quads under lights in a row.
Scene floor_under_lights(int side, int lights) {
  SceneBuilder builder;
  for (int x = 0; x < side; ++x)
    for (int z = 0; z < side; ++z) builder.add(quad({2 * x, 0, 2 * z}, {0.9f, 0, 0}, {0, 0, 0.9f}));
  for (int i = 0; i < lights; ++i) builder.point_light({i, 2, 1});
  return builder.build();
}

EdgeRayData data_of(const Scene& scene, std::uint64_t most_texels = kManyTexels,
                    const std::stop_token& stop = {}) {
  return make_edge_ray_data(edge_ray_input(scene, plan_for(scene).draw, most_texels), stop);
}

TEST(EdgeRayData, HasABufferForEachLightAndTheCornersOfEachTriangle) {
  const EdgeRayData data = data_of(floor_under_lights(3, 4));
  EXPECT_EQ(data.lights.size(), 4u);
  EXPECT_EQ(data.buffers(), 4u);
  EXPECT_EQ(data.texels.triangles.size(), 9u * 2 * 3 + 1) << "and one texture, for all without any";
  EXPECT_EQ(data.bytes(),
            data.texels.triangles.size() * 16 + data.texels.alphas.size() + data.words.size() * 4);
}

TEST(EdgeRayData, KeepsTheBuffersThatFit) {
  const Scene scene = floor_under_lights(3, 4);
  const EdgeRayData all = data_of(scene);
  const std::size_t third = all.lights[2].projection.first_layer,
                    fourth = all.lights[3].projection.first_layer;
  const EdgeRayData three = data_of(scene, fourth), two = data_of(scene, fourth - 1);
  EXPECT_EQ(three.buffers(), 3u);
  EXPECT_EQ(three.words.size(), fourth);
  EXPECT_EQ(two.buffers(), 2u);
  EXPECT_EQ(two.words.size(), third);
  const EdgeRayData none = data_of(scene, all.texels.triangles.size() - 1);
  EXPECT_EQ(none.bytes(), 0u) << "not even the triangles fit";
  EXPECT_EQ(none.buffers(), 0u);
  EXPECT_EQ(none.lights.size(), 4u);
}

TEST(EdgeRayData, LeavesOutLightsThatMove) {
  Scene scene = floor_under_lights(3, 4);
  scene.nodes[scene.lights[1].node].moving = true;
  const EdgeRayData data = data_of(scene);
  EXPECT_EQ(data.buffers(), 3u);
  EXPECT_EQ(data.lights[1].projection.view.kind, std::uint32_t{FARSHADE_MAP_NONE});
}

/// The whole work takes about a minute.
TEST(EdgeRayData, AreNotMadeToTheEndOnceTheyAreStopped) {
  const Scene scene = floor_under_lights(100, 200);
  EdgeRayData data;
  std::jthread work([&](const std::stop_token& stop) { data = data_of(scene, kManyTexels, stop); });
  work.request_stop();
  work.join();
  EXPECT_LT(data.buffers(), 10u);
}

}  // namespace
}  // namespace farshade
