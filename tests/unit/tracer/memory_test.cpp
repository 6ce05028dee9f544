/// Compares the predicted memory of a tracer with the measured memory.
#include <gtest/gtest.h>

#include "stereo/gltf/gltf.h"
#include "stereo/tracer/tracer.h"

namespace farshade {
namespace {

/// Embree's own memory, independent of the scene.
constexpr double kRoom_bytes = 64 << 10;

void expect_estimated(const std::filesystem::path& path) {
  for (const PlanKind kind : {PlanKind::Needed, PlanKind::Everything}) {
    SCOPED_TRACE(path.filename().string() + (kind == PlanKind::Needed ? ", needed" : ", everything"));
    const auto [scene, plan] = plan_scene(load_scene(path).value(), {.kind = kind});
    const TracerMemory estimated = estimated_memory(scene, plan.trace);
    const TracerMemory held = Tracer::create(scene, plan.trace)->memory();
    EXPECT_EQ(estimated.triangles, held.triangles);
    EXPECT_EQ(estimated.facets, held.facets);
    const auto expect_near = [](std::size_t a, std::size_t b) {
      EXPECT_NEAR(static_cast<double>(a), static_cast<double>(b), 0.1 * static_cast<double>(b) + kRoom_bytes);
    };
    expect_near(estimated.vertices, held.vertices);
    expect_near(estimated.total(), held.total());
    expect_near(estimated.most(), held.most());
  }
}

TEST(TracerMemory, IsEstimatedForEveryBundledScene) {
  for (const char* name : {"room.glb", "box_over_plane.gltf"})
    expect_estimated(std::string(FARSHADE_ASSETS "/") + name);
}

TEST(TracerMemory, IsEstimatedForLargerScenes) {
  const std::filesystem::path shared = FARSHADE_SOURCE "/../shared/scenes";
  if (!std::filesystem::exists(shared / "modern_living_room.glb"))
    GTEST_SKIP() << "there are no scenes beside the repository";
  for (const char* name : {"modern_living_room.glb", "pine_tree.glb"}) expect_estimated(shared / name);
}

}  // namespace
}  // namespace farshade
