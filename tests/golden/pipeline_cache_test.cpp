/// Compiled pipelines on disk: a device starts with those of its own driver, and a file that is broken,
/// foreign or not writable does no harm.
#include "stereo/gpu/pipeline_cache.h"

#include <gtest/gtest.h>

#include <fstream>

#include "stereo/base/cache_file.h"
#include "tests/golden/test_rig.h"
#include "tests/oracle/scene_builder.h"
#include "tests/unit/scratch_folder.h"

namespace farshade {
namespace {

constexpr Extent kCacheTestSize{32, 32};

class PipelineCache : public OnLavapipe {
 protected:
  [[nodiscard]] std::filesystem::path folder() const { return folder_.path() / "cache"; }
  [[nodiscard]] std::filesystem::path file() const { return gpu::pipeline_file(device_, folder()); }

  /// The bytes of pipelines that the device has now.
  [[nodiscard]] std::size_t known_bytes() const { return device_.pipelines.getData().size(); }

  /// Compiles the pipelines of one frame and draws it.
  PerEye<Image<Rgb8>> draw() {
    SceneBuilder builder;
    builder.point_light({0, 0, 1});
    builder.add(quad({0, 0, -2}, {1, 0, 0}, {0, 1, 0}));
    const Scene scene = builder.build();
    Renderer renderer(device_, scene,
                      {.size = kCacheTestSize, .traced_size = kCacheTestSize, .depth_frames = 1});
    const View view = look({0, 0, 0}, {0, 0, -1}, kCacheTestSize.width);
    const SceneState state = state_at(scene, Time{});
    renderer.draw({.views = {view, view}, .state = state, .masks = {}, .carry_over = {}});
    return renderer.read_shown();
  }

  ScratchFolder folder_;
};

TEST_F(PipelineCache, StartsWithTheSavedPipelines) {
  gpu::load_pipelines(device_, folder());
  const auto first = draw();
  const std::size_t compiled = known_bytes();
  ASSERT_TRUE(gpu::save_pipelines(device_, folder()));

  gpu::load_pipelines(device_, folder());
  EXPECT_EQ(known_bytes(), compiled);
  EXPECT_EQ(draw()[0].pixels, first[0].pixels);
  EXPECT_EQ(known_bytes(), compiled) << "nothing was compiled again";
}

TEST_F(PipelineCache, IgnoresABrokenOrForeignFile) {
  gpu::load_pipelines(device_, folder());
  const std::size_t empty = known_bytes();
  const auto drawn = draw();
  ASSERT_TRUE(gpu::save_pipelines(device_, folder()));
  std::vector<std::byte> broken = read_file(file(), 1 << 26).value();
  broken[broken.size() / 2] ^= std::byte{1};
  ASSERT_TRUE(write_file_atomically(file(), broken));
  gpu::load_pipelines(device_, folder());
  EXPECT_EQ(known_bytes(), empty);

  // Valid for us, but not for the driver.
  ASSERT_TRUE(write_cache_file(file(), std::span(broken).first(100)));
  gpu::load_pipelines(device_, folder());
  EXPECT_EQ(draw()[0].pixels, drawn[0].pixels);
}

TEST_F(PipelineCache, SaysThatItCannotBeSaved) {
  gpu::load_pipelines(device_, folder());
  std::ofstream(folder()) << "a file where the folder should be";
  const auto saved = gpu::save_pipelines(device_, folder());
  ASSERT_FALSE(saved);
  EXPECT_NE(saved.error().what.find(folder().string()), std::string::npos) << saved.error().what;
}

}  // namespace
}  // namespace farshade
