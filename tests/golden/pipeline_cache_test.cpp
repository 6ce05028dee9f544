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

  /// Compiles the pipelines of one frame and draws it.
  PerEye<Image<Rgb8>> draw() {
    SceneBuilder builder;
    builder.point_light({0, 0, 1});
    builder.add(quad({0, 0, -2}, {1, 0, 0}, {0, 1, 0}));
    const Scene scene = builder.build();
    const std::unique_ptr<Renderer> renderer_owner = make_renderer(
        device_, scene, {.size = kCacheTestSize, .traced_size = kCacheTestSize, .depth_frames = 1});
    Renderer& renderer = *renderer_owner;
    const View view = look({0, 0, 0}, {0, 0, -1}, kCacheTestSize.width);
    const SceneState state = state_at(scene, Time{});
    renderer.draw({.views = {view, view}, .state = state, .masks = {}, .reprojection = {}});
    return renderer.read_shown();
  }

  ScratchFolder folder_;
};

TEST_F(PipelineCache, StartsWithTheSavedPipelines) {
  EXPECT_FALSE(gpu::load_pipelines(device_, folder())) << "there is no file yet";
  const auto first = draw();
  const std::vector<std::uint8_t> compiled = device_.pipelines.getData();
  ASSERT_TRUE(gpu::save_pipelines(device_, folder()));
  EXPECT_EQ(read_cache_file(file(), 1 << 26).value().size(), compiled.size());

  EXPECT_TRUE(gpu::load_pipelines(device_, folder()));
  EXPECT_EQ(draw()[0].pixels, first[0].pixels);
}

TEST_F(PipelineCache, IgnoresABrokenOrForeignFile) {
  static_cast<void>(gpu::load_pipelines(device_, folder()));
  const auto drawn = draw();
  ASSERT_TRUE(gpu::save_pipelines(device_, folder()));
  std::vector<std::byte> broken = read_file(file(), 1 << 26).value();
  broken[broken.size() / 2] ^= std::byte{1};
  ASSERT_TRUE(write_file_atomically(file(), broken));
  EXPECT_FALSE(gpu::load_pipelines(device_, folder()));

  // Valid for us, but not for the driver.
  ASSERT_TRUE(write_cache_file(file(), std::vector<std::byte>(100, std::byte{7})));
  EXPECT_TRUE(gpu::load_pipelines(device_, folder()));
  EXPECT_EQ(draw()[0].pixels, drawn[0].pixels);
}

TEST_F(PipelineCache, SaysThatItCannotBeSaved) {
  static_cast<void>(gpu::load_pipelines(device_, folder()));
  std::ofstream(folder()) << "a file where the folder should be";
  const auto saved = gpu::save_pipelines(device_, folder());
  ASSERT_FALSE(saved);
  EXPECT_NE(saved.error().what.find(folder().string()), std::string::npos) << saved.error().what;
}

}  // namespace
}  // namespace farshade
