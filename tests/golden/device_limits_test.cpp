/// Devices with other limits than lavapipe draw the same pictures.
#include <algorithm>
#include <random>
#include <stdexcept>

#include "stereo/gpu/memory.h"
#include "tests/golden/test_rig.h"
#include "tests/oracle/random_scenes.h"
#include "tests/oracle/scene_builder.h"

namespace farshade {
namespace {

using namespace std::chrono_literals;

class DeviceLimits : public OnLavapipe {};

void expect_same_bits(const std::vector<Shown>& some, const std::vector<Shown>& others) {
  ASSERT_EQ(some.size(), others.size());
  for (std::size_t i = 0; i < some.size(); ++i)
    for (std::size_t eye = 0; eye < kEyes; ++eye) {
      EXPECT_TRUE(some[i].pictures[eye].pixels == others[i].pictures[eye].pixels) << i << ", eye " << eye;
      EXPECT_TRUE(some[i].reports[eye].visibility == others[i].reports[eye].visibility)
          << i << ", eye " << eye;
    }
}

/// Three masks of noise, so that all pixels are on shadow edges, at another pose and an earlier time.
Shown with_hard_pixels(const gpu::Device& device, Scene scene) {
  constexpr std::uint32_t kSide_px = 160;
  TestRig rig(device, std::move(scene), kSide_px, 4, 0, ShadingPasses::Sorted);
  const Rigid<Stage, Head> head = rig.head();
  rig.set_time(Time(700ms));
  const Mask older = with_noise(rig.ask(kOlder, rig.eyes(moved(head, 0.1, {0, 0, 0}))), 1),
             newest = with_noise(rig.ask(kTraced, rig.eyes(moved(head, 0.05, {0.02, 0, 0}))), 2);
  const std::vector<Mask> cube_mask = rig.ask_cube_mask({head.translation});
  rig.set_time(Time(750ms));
  return rig.show(rig.eyes(head), {newest.traced_mask(), older.traced_mask()}, {}, cube_mask);
}

std::vector<Shown> hard_pictures(const gpu::Device& device) {
  std::mt19937 random{11};  // the seed
  const Scene room = bundled("room.glb");
  Scene figures = bending_figures(random);
  figures.camera = look({0.3, 1.5, 2.6}, {0, 0.8, 0}, 1).stage_from_eye;
  return {with_hard_pixels(device, room), with_hard_pixels(device, figures)};
}

TEST_F(DeviceLimits, ListsOfPixelsFormRows) {
  const std::vector<Shown> in_one_row = hard_pictures(device_);
  device_.max_groups[0] = 3;  // 192 pixels, the width of an eye
  expect_same_bits(hard_pictures(device_), in_one_row);
}

/// Why something is refused; empty if it is not.
template <class Act>
std::string refusal_of(const Act& act) {
  try {
    act();
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

constexpr RendererLimits kSmall{.size = {64, 64}, .traced_size = {64, 64}, .depth_frames = 1};

TEST_F(DeviceLimits, AReportThatIsTooLongIsRefusedWithTheCure) {
  const Scene scene = bundled("box_over_plane.gltf");
  const std::unique_ptr<Renderer> renderer = make_renderer(device_, scene, kSmall);
  const View view = look({0, 1, 3}, {0, 0, 0}, 64);
  const SceneState state = state_at(scene, Time{});
  device_.max_storage_bytes = 100'000;  // two eyes of 64 x 64 records of six words have 196,608 bytes
  const auto draw = [&](PixelReport report) {
    renderer->draw(
        {.views = {view, view}, .state = state, .masks = {}, .reprojection = {}, .report = report});
  };
  EXPECT_EQ(refusal_of([&] { draw(PixelReport::Off); }), "");
  const std::string refusal = refusal_of([&] { draw(PixelReport::On); });
  EXPECT_TRUE(refusal.starts_with("vkCreateBuffer for 'report': " + device_.name)) << refusal;
  EXPECT_NE(refusal.find("allows 0 MiB in one storage buffer, and 1 MiB are needed"), std::string::npos)
      << refusal;
  EXPECT_NE(refusal.find("--reference-every 0"), std::string::npos) << refusal;
  EXPECT_EQ(refusal.find('\n'), std::string::npos) << "one line";
}

TEST_F(DeviceLimits, ImagesBeyondTheLimitsOfTheirFormatAreRefused) {
  vk::ImageFormatProperties limits{.maxExtent = {64, 64, 1}, .maxArrayLayers = 4, .maxResourceSize = 1 << 20};
  device_.image_limits = [&](const auto&, vk::Format format, vk::ImageUsageFlags) {
    return format == vk::Format::eR32Uint ? std::nullopt : std::optional(limits);
  };
  const auto refusal = [&](Extent size, std::uint32_t layers, vk::Format format) {
    return refusal_of([&] {
      (void)gpu::make_image(device_,
                            {.size = size,
                             .layers = layers,
                             .format = format,
                             .usage = vk::ImageUsageFlagBits::eTransferDst | vk::ImageUsageFlagBits::eSampled,
                             .use = gpu::Use::Depth},
                            "large");
    });
  };
  constexpr auto color = vk::Format::eR8G8B8A8Unorm;
  EXPECT_EQ(refusal({64, 64}, 4, color), "");
  const std::string wide = refusal({65, 64}, 4, color);
  EXPECT_NE(wide.find("allows 64 pixels a side, and 65 are needed"), std::string::npos) << wide;
  EXPECT_NE(wide.find("--size"), std::string::npos) << wide;
  EXPECT_NE(refusal({64, 64}, 5, color).find("allows 4 layers, and 5 are needed"), std::string::npos);
  EXPECT_NE(refusal({64, 64}, 1, vk::Format::eR32Uint).find("allows no R32Uint as"), std::string::npos);
  limits.maxExtent = vk::Extent3D{1024, 1024, 1};
  EXPECT_EQ(refusal({512, 512}, 1, color), "");
  EXPECT_NE(refusal({512, 512}, 2, color).find("allows 1 MiB in one image, and 2 MiB are needed"),
            std::string::npos);
}

/// A device is chosen by these formats, so no pass may have others.
TEST_F(DeviceLimits, AllImagesHaveFormatsThatTheChosenDeviceIsAskedFor) {
  std::size_t images = 0;
  device_.image_limits = [&](const auto& physical, vk::Format format, vk::ImageUsageFlags usage) {
    ++images;
    const auto needed = std::ranges::find(gpu::needed_formats(), format, &gpu::NeededFormat::format);
    EXPECT_NE(needed, gpu::needed_formats().end()) << vk::to_string(format);
    if (needed != gpu::needed_formats().end()) {
      EXPECT_FALSE(gpu::features_for(usage) & ~needed->features) << vk::to_string(format);
    }
    return gpu::image_limits(physical, format, usage);
  };
  (void)hard_pictures(device_);
  EXPECT_GE(images, 8u);
}

}  // namespace
}  // namespace farshade
