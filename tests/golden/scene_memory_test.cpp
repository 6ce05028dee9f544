/// The scene on the device: the number of allocations is small for any number of meshes and textures, and
/// every mesh is drawn from its own part of the shared buffers.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/common.hpp>
#include <random>
#include <stdexcept>

#include "stereo/gpu/upload.h"
#include "stereo/raster/scene_buffers.h"
#include "tests/golden/test_rig.h"
#include "tests/oracle/scene_builder.h"

namespace farshade {
namespace {

constexpr Extent kDrawnSize{256, 256};
constexpr RendererLimits kOneFrame{.size = kDrawnSize, .traced_size = kDrawnSize, .depth_frames = 1};

struct SceneDrawn {
  PerEye<Image<Rgb8>> pictures;
  std::uint64_t allocations = 0, vertex_bytes = 0;
};

class SceneMemory : public OnLavapipe {
 protected:
  SceneDrawn drawn(const Scene& scene) {
    const std::uint64_t before = device_.ledger->read().allocations;
    const std::unique_ptr<Renderer> renderer_owner = make_renderer(device_, scene, kOneFrame);
    Renderer& renderer = *renderer_owner;
    const View view = look({0, 0, 0}, {0, 0, -1}, kDrawnSize.width);
    const SceneState state = state_at(scene, Time{});
    renderer.draw({.views = {view, view}, .state = state, .masks = {}, .reprojection = {}});
    const DrawPlan plan = plan_for(scene, {.all_lights = true}).draw;
    static_cast<void>(renderer.finish());  // a first frame takes memory for its uploads piece by piece
    return {renderer.read_shown(), device_.ledger->read().allocations - before,
            stream_bytes(scene, plan, {}).total()};
  }
};

/// The number of pixels with a channel that differs by more than `levels`.
std::size_t differing(const Image<Rgb8>& a, const Image<Rgb8>& b, int levels) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    const glm::ivec3 off = glm::abs(glm::ivec3(a.pixels[i]) - glm::ivec3(b.pixels[i]));
    count += std::max({off.x, off.y, off.z}) > levels;
  }
  return count;
}

/// Triangle `i` of a wall of `columns` x `columns` at z = -2: corners, and a colour unlike its neighbours'.
std::array<glm::vec3, 3> corners_of(std::uint32_t i, std::uint32_t columns) {
  const float step = 3.0f / static_cast<float>(columns);
  const auto column = i % columns, row = i / columns;
  const glm::vec3 at(step * static_cast<float>(column) - 1.5f, step * static_cast<float>(row) - 1.5f, -2.0f);
  return {at, at + glm::vec3(step, 0, 0), at + glm::vec3(0, step, 0)};
}
glm::u8vec4 color_of(std::uint32_t i) {
  return {50 + i * 37 % 200, 50 + i * 91 % 200, 50 + i * 53 % 200, 255};
}

/// Two triangles in three have a colour; the others are white and have no colour stream.
bool is_colored(std::uint32_t i) {
  return i % 3 != 0;
}

Mesh mesh_of(const std::vector<std::uint32_t>& triangles, std::uint32_t columns, bool colored) {
  std::vector<glm::vec3> corners;
  for (const std::uint32_t i : triangles)
    for (const glm::vec3& corner : corners_of(i, columns)) corners.push_back(corner);
  Mesh mesh = triangle_soup(corners);
  for (const std::uint32_t i : triangles)
    if (colored) mesh.colors.insert(mesh.colors.end(), 3, color_of(i));
  return mesh;
}

/// `count` triangles, as one mesh each or all in two meshes.
enum class Meshes : std::uint8_t { One, Each };
Scene wall_of(std::uint32_t count, Meshes meshes) {
  const auto columns = static_cast<std::uint32_t>(std::ceil(std::sqrt(count)));
  SceneBuilder builder;
  builder.point_light({0, 0, 1});
  std::vector<std::uint32_t> colored, white;
  for (std::uint32_t i = 0; i < count; ++i) {
    if (meshes == Meshes::Each) builder.add(mesh_of({i}, columns, is_colored(i)));
    (is_colored(i) ? colored : white).push_back(i);
  }
  if (meshes == Meshes::One) {
    builder.add(mesh_of(colored, columns, true));
    builder.add(mesh_of(white, columns, false));
  }
  return builder.build();
}

TEST_F(SceneMemory, TwentyThousandMeshesTakeAsManyAllocationsAsTwoAndLookTheSame) {
  constexpr std::uint32_t kMeshes = 20'000;
  const SceneDrawn one = drawn(wall_of(kMeshes, Meshes::One)), each = drawn(wall_of(kMeshes, Meshes::Each));
  EXPECT_EQ(each.allocations, one.allocations);
  EXPECT_LE(each.allocations, 24u);
  // The three indices of a mesh, of two bytes each, are padded to eight bytes.
  EXPECT_EQ(each.vertex_bytes + 4, one.vertex_bytes + 2 * kMeshes);
  // A small mesh far from its origin is drawn relative to its centre, so rounding moves a few edges.
  for (std::size_t eye = 0; eye < kEyes; ++eye)
    EXPECT_LT(differing(each.pictures[eye], one.pictures[eye], 0), kDrawnSize.pixels() / 200) << eye;
  const auto lit = std::ranges::count_if(one.pictures[0].pixels, [](Rgb8 p) { return p != Rgb8(0); });
  EXPECT_GT(lit, kDrawnSize.pixels() / 4) << "the wall is in view";
}

/// The colours of a mesh lie behind its texture coordinates, or, if it has none, behind its normals.
TEST_F(SceneMemory, AMeshHasItsOwnColorsBesideATexture) {
  const auto wall = [](bool textured) {
    SceneBuilder builder;
    builder.point_light({0, 0, 1});
    Material material;
    material.double_sided = true;
    if (textured) {
      Texture white{.image = Image<Rgba8>({4, 4})};
      std::ranges::fill(white.image.pixels, Rgba8(255));
      material.texture = builder.texture(white);
    }
    Mesh mesh = quad({0, 0, -2}, {1.5f, 0, 0}, {0, 1.5f, 0});
    for (std::uint32_t corner = 0; corner < mesh.positions.size(); ++corner)
      mesh.colors.push_back(color_of(corner + 1));
    builder.add(mesh, builder.material(material));
    return builder.build();
  };
  const SceneDrawn textured = drawn(wall(true)), plain = drawn(wall(false));
  for (std::size_t eye = 0; eye < kEyes; ++eye)
    EXPECT_EQ(differing(textured.pictures[eye], plain.pictures[eye], 1), 0u) << eye;
  const auto colored =
      std::ranges::count_if(plain.pictures[0].pixels, [](Rgb8 p) { return p.x != p.y || p.y != p.z; });
  EXPECT_GT(colored, kDrawnSize.pixels() / 2);
}

float linear_of(std::uint8_t level) {
  const float c = static_cast<float>(level) / 255;
  return c <= 0.04045f ? c / 12.92f : std::pow((c + 0.055f) / 1.055f, 2.4f);
}

/// A row of `count` quads. Each has another colour, from a texture or from its material.
enum class ColorFrom : std::uint8_t { Texture, Material };
Scene colored_row(std::uint32_t count, ColorFrom from) {
  SceneBuilder builder;
  builder.point_light({0, 0, 1});
  const float half = 1.5f / static_cast<float>(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    const glm::u8vec4 color = color_of(i);
    Material material;
    if (from == ColorFrom::Texture) {
      Texture texture{.image = Image<Rgba8>({1 + i % 5, 1 + i % 3})};
      std::ranges::fill(texture.image.pixels, Rgba8(color));
      texture.wrap_u = static_cast<Wrap>(i % 3);
      material.texture = builder.texture(texture);
    } else {
      material.base_color = {linear_of(color.r), linear_of(color.g), linear_of(color.b), 1};
    }
    const float x = half * (2.0f * static_cast<float>(i) + 1) - 1.5f;
    builder.add(quad({x, 0, -2}, {half, 0, 0}, {0, 1.5f, 0}), builder.material(material));
  }
  return builder.build();
}

TEST_F(SceneMemory, TexturesShareAllocationsAndKeepTheirColors) {
  const SceneDrawn one = drawn(colored_row(1, ColorFrom::Texture)),
                   many = drawn(colored_row(60, ColorFrom::Texture)),
                   plain = drawn(colored_row(60, ColorFrom::Material));
  EXPECT_EQ(many.allocations, one.allocations);
  EXPECT_EQ(many.allocations, plain.allocations + 1);
  for (std::size_t eye = 0; eye < kEyes; ++eye)
    EXPECT_LT(differing(many.pictures[eye], plain.pictures[eye], 2), 200u)
        << "except at borders of quads; " << eye;
  EXPECT_GT(differing(many.pictures[0], one.pictures[0], 2), kDrawnSize.pixels() / 4) << "the colours differ";
}

/// A square with white and black stripes of one texel, about seven a pixel, or one as bright as their mean.
enum class Square : std::uint8_t { Striped, Grey };
Scene lit_square(Square kind) {
  SceneBuilder builder;
  Material material;
  if (kind == Square::Grey) material.base_color = glm::vec4(0.5f, 0.5f, 0.5f, 1);
  if (kind == Square::Striped) {
    Texture stripes{.image = Image<Rgba8>({1024, 64}, Rgba8(0, 0, 0, 255))};
    for (std::uint32_t y = 0; y < 64; ++y)
      for (std::uint32_t x = 0; x < 1024; x += 2) stripes.image.at(x, y) = Rgba8(255);
    material.texture = builder.texture(stripes);
  }
  builder.add(quad({0, 0, -2}, {1, 0, 0}, {0, 1, 0}), builder.material(material));
  Scene scene = builder.build();
  scene.ambient = 0.5f;
  return scene;
}

TEST_F(SceneMemory, FineStripesAreAsBrightAsTheirMean) {
  const SceneDrawn striped = drawn(lit_square(Square::Striped)), grey = drawn(lit_square(Square::Grey));
  const auto lit = std::ranges::count_if(grey.pictures[0].pixels, [](Rgb8 p) { return p.r > 50; });
  EXPECT_GT(lit, 20'000) << "the square is in view";
  for (std::size_t eye = 0; eye < kEyes; ++eye)
    EXPECT_EQ(differing(striped.pictures[eye], grey.pictures[eye], 2), 0u) << eye;
}

TEST_F(SceneMemory, ASceneThatNeedsTooManyAllocationsIsRefusedWithTheLimit) {
  const Scene scene = wall_of(4, Meshes::One);
  device_.max_allocations = device_.ledger->read().allocations + 3;
  try {
    static_cast<void>(make_renderer(device_, scene, kOneFrame));
    FAIL() << "a fourth allocation was made";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("allows 3 allocations"), std::string::npos) << error.what();
  }
  EXPECT_EQ(device_.ledger->read().allocations, 0u);
}

TEST_F(SceneMemory, AnAllocationThatIsTooLargeIsRefusedWithTheLimit) {
  device_.max_allocation_bytes = 1 << 20;
  try {
    (void)gpu::make_device_buffer(device_, 3 << 20, vk::BufferUsageFlagBits::eStorageBuffer, "too much");
    FAIL() << "3 MiB were allocated";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("'too much'"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("allows 1 MiB in one allocation"), std::string::npos)
        << error.what();
  }
}

TEST_F(SceneMemory, AnImageThatIsTooLargeIsRefusedWithTheLimit) {
  const auto refusal = [&](const Extent& size, std::uint32_t layers) -> std::string {
    try {
      (void)gpu::make_image(
          device_,
          {.size = size,
           .layers = layers,
           .format = vk::Format::eR8G8B8A8Unorm,
           .usage = vk::ImageUsageFlagBits::eTransferDst | vk::ImageUsageFlagBits::eSampled},
          "large");
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "";
  };
  device_.max_image_side_px = 64;
  device_.max_image_layers = 8;
  EXPECT_EQ(refusal({64, 64}, 8), "");
  EXPECT_NE(refusal({65, 64}, 8).find("allows 64 pixels a side, and 65 are needed"), std::string::npos);
  EXPECT_NE(refusal({64, 64}, 9).find("allows 8 layers, and 9 are needed"), std::string::npos);
}

TEST_F(SceneMemory, UploadsArriveWhateverTheirSizeAgainstTheStagingBuffer) {
  constexpr std::size_t kBytes = 5000, kStaging = 256;
  std::mt19937 random(6);  // the seed
  std::vector<std::byte> content(kBytes);
  for (std::byte& byte : content) byte = static_cast<std::byte>(random());
  const gpu::Buffer target = gpu::make_device_buffer(
      device_, kBytes, vk::BufferUsageFlagBits::eTransferDst | vk::BufferUsageFlagBits::eTransferSrc,
      "target");
  gpu::BufferUpload uploads(device_, kStaging);
  for (std::size_t at = 0; at < kBytes;) {
    const std::size_t size = std::min<std::size_t>(random() % 700, kBytes - at);
    uploads.write(target, at, std::span(content).subspan(at, size));
    at += size;
  }
  uploads.flush();
  const gpu::ReadbackBuffer readback =
      gpu::make_readback_buffer(device_, kBytes, vk::BufferUsageFlagBits::eTransferDst, "read-back");
  gpu::run_now(device_, [&](const vk::raii::CommandBuffer& commands) {
    commands.copyBuffer(*target.buffer, *readback.buffer, vk::BufferCopy{.size = kBytes});
  });
  EXPECT_EQ(std::memcmp(readback.as<std::byte>().data(), content.data(), kBytes), 0);
}

}  // namespace
}  // namespace farshade
