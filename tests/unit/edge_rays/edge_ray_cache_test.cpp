#include "stereo/edge_rays/edge_ray_cache.h"

#include <gtest/gtest.h>

#include <cstring>
#include <fstream>

#include "stereo/base/cache_file.h"
#include "tests/oracle/scene_builder.h"
#include "tests/unit/scratch_folder.h"

namespace farshade {
namespace {

constexpr std::uint64_t kEnoughTexels = 1 << 27;

Scene boxes_under_lights(float size = 0.4f) {
  SceneBuilder builder;
  for (int x = -3; x < 4; ++x)
    for (int z = -3; z < 4; ++z) builder.add(quad({x, 0, z}, {size, 0, 0}, {0, 0.1f, size}));
  for (int i = 0; i < 3; ++i) builder.point_light({i, 2, 1});
  Scene scene = builder.build();
  scene.nodes[scene.lights[1].node].moving = true;
  return scene;
}

EdgeRayInput input_of(const Scene& scene, std::uint64_t most_texels = kEnoughTexels) {
  return edge_ray_input(scene, plan_for(scene).draw, most_texels);
}

void expect_same(const EdgeRayData& a, const EdgeRayData& b) {
  EXPECT_EQ(a.origin.v, b.origin.v);
  EXPECT_EQ(a.texels.triangles, b.texels.triangles);
  EXPECT_EQ(a.texels.alphas, b.texels.alphas);
  EXPECT_EQ(a.words, b.words);
  ASSERT_EQ(a.lights.size(), b.lights.size());
  for (std::size_t i = 0; i < a.lights.size(); ++i) {
    EXPECT_EQ(a.lights[i].projection.view.kind, b.lights[i].projection.view.kind);
    EXPECT_EQ(a.lights[i].projection.first_layer, b.lights[i].projection.first_layer);
  }
}

class EdgeRayCache : public testing::Test {
 protected:
  [[nodiscard]] std::filesystem::path folder() const { return folder_.path() / "cache"; }
  [[nodiscard]] std::filesystem::path file() const { return edge_ray_file(folder(), input_); }
  [[nodiscard]] CachedEdgeRayData cached() const { return cached_edge_ray_data(input_, folder()); }
  ScratchFolder folder_;
  EdgeRayInput input_ = input_of(boxes_under_lights());
  EdgeRayData made_ = make_edge_ray_data(input_);
};

TEST_F(EdgeRayCache, KeepsWhatWasMade) {
  EXPECT_EQ(made_.buffers(), 2u);
  const CachedEdgeRayData made = cached(), read = cached();
  EXPECT_FALSE(made.from_file);
  EXPECT_TRUE(read.from_file);
  EXPECT_EQ(made.trouble + read.trouble, "");
  expect_same(made.data, made_);
  expect_same(read.data, made_);
}

TEST_F(EdgeRayCache, KeepsDifferentInputsApart) {
  static_cast<void>(cached());
  EdgeRayInput moved = input_, holed = input_;
  moved.lights[0].projection.view.origin.v.x += 1e-9;
  holed.casters.has_holes[3] = true;
  for (const EdgeRayInput& other :
       {input_of(boxes_under_lights(0.5f)), input_of(boxes_under_lights(), 1 << 20), moved, holed})
    EXPECT_FALSE(cached_edge_ray_data(other, folder()).from_file);
  EXPECT_TRUE(cached().from_file);
}

TEST_F(EdgeRayCache, ReplacesABrokenFile) {
  static_cast<void>(cached());
  const std::vector<std::byte> whole = read_file(file(), 1 << 24).value();
  for (const std::size_t at : {std::size_t{0}, std::size_t{33}, whole.size() / 2, whole.size() - 1}) {
    std::vector<std::byte> broken = whole;
    broken[at] ^= std::byte{0x40};
    ASSERT_TRUE(write_file_atomically(file(), broken));
    const CachedEdgeRayData again = cached();
    EXPECT_FALSE(again.from_file) << at;
    EXPECT_NE(again.trouble.find("replaced"), std::string::npos) << again.trouble;
    expect_same(again.data, made_);
    EXPECT_TRUE(cached().from_file) << "the file was replaced";
  }
  for (const std::size_t size : {std::size_t{0}, std::size_t{40}, whole.size() - 5}) {
    ASSERT_TRUE(write_file_atomically(file(), std::span(whole).first(size)));
    const CachedEdgeRayData again = cached();
    EXPECT_FALSE(again.from_file) << size;
    expect_same(again.data, made_);
  }
}

// A file with a valid digest may still have been made by somebody else.
TEST_F(EdgeRayCache, RefusesWordsThatAreNoLightBuffers) {
  static_cast<void>(cached());
  const std::vector<std::byte> content = read_cache_file(file(), 1 << 24).value();
  const auto refused = [&](std::size_t word, std::uint32_t value) {
    std::vector<std::byte> edited = content;
    std::memcpy(&edited.at(32 + 4 * word), &value, sizeof value);
    EXPECT_TRUE(write_cache_file(file(), edited));
    return !cached().from_file;
  };
  const auto lists = static_cast<std::size_t>(
      std::ranges::find_if(made_.words, [](std::uint32_t word) { return word != 0; }) - made_.words.begin());
  const std::size_t lights = input_.lights.size(), last = lights + made_.words.size() - 1;
  EXPECT_TRUE(refused(0, made_.lights[2].projection.first_layer + 1)) << "another number of words";
  EXPECT_TRUE(refused(1, 7)) << "of a light that moves";
  EXPECT_TRUE(refused(lights + lists, 1u << 30)) << "a list out of range";
  EXPECT_TRUE(refused(lights + lists, FARSHADE_DIVIDED | 1u << 30)) << "parts out of range";
  EXPECT_TRUE(refused(lights + lists, FARSHADE_DIVIDED)) << "parts of themselves";
  EXPECT_TRUE(refused(last, FARSHADE_LAST | ((1u << input_.lights[0].depths.number_bits) - 1)))
      << "a triangle out of range";
  EXPECT_TRUE(refused(last, 0)) << "a list without an end";
  EXPECT_FALSE(refused(last, made_.words.back()));
}

TEST_F(EdgeRayCache, WorksWithoutAUsableFolder) {
  std::ofstream(folder()) << "a file where the folder should be";
  const CachedEdgeRayData data = cached();
  EXPECT_FALSE(data.from_file);
  EXPECT_NE(data.trouble, "");
  expect_same(data.data, made_);
}

TEST_F(EdgeRayCache, KeepsNothingThatWasStopped) {
  std::stop_source stop;
  stop.request_stop();
  EXPECT_EQ(cached_edge_ray_data(input_, folder(), stop.get_token()).data.buffers(), 0u);
  EXPECT_FALSE(std::filesystem::exists(file()));
}

}  // namespace
}  // namespace farshade
