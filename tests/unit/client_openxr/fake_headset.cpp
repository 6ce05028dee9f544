#include "tests/unit/client_openxr/fake_headset.h"

#include <dlfcn.h>

#include <cstdlib>

#include "stereo/gpu/frame_commands.h"

namespace farshade::openxr {
namespace {

using Usage = vk::ImageUsageFlagBits;

gpu::Image cleared(const gpu::Device& device, vk::Format format, vk::ImageUsageFlags usage,
                   vk::ImageLayout layout) {
  gpu::Image image = gpu::make_image(device,
                                     {.size = kEyeSize,
                                      .layers = static_cast<std::uint32_t>(kEyes),
                                      .format = format,
                                      .usage = usage | Usage::eTransferSrc | Usage::eSampled},
                                     "picture");
  gpu::run_now(device, [&](const vk::raii::CommandBuffer& commands) {
    gpu::transition(commands, image, vk::ImageLayout::eUndefined, layout);
  });
  return image;
}

Expected<gpu::Device> open_device_of(const HeadsetSystem& system) {
  gpu::DeviceOptions options;
  options.validation = gpu::Validation::On;
  options.maker = system.vulkan();
  return gpu::open_device(options);
}

}  // namespace

fake_openxr::Runtime& restart_fake() {
  static const auto restart = [] {
    ::setenv("XR_RUNTIME_JSON", FARSHADE_FAKE_OPENXR_MANIFEST, 1);
    ::setenv("XR_LOADER_DEBUG", "none", 1);
    void* const library = ::dlopen(FARSHADE_FAKE_OPENXR, RTLD_NOW);
    check(library != nullptr, "the fake runtime can be loaded");
    return reinterpret_cast<fake_openxr::Restart*>(::dlsym(library, "farshade_fake_openxr_restart"));
  }();
  return *restart();
}

Expected<ShownPictures> make_pictures(const HeadsetSystem& system) {
  return open_device_of(system).map([](gpu::Device&& device) {
    gpu::Image shown =
                   cleared(device, vk::Format::eR8G8B8A8Unorm, Usage::eStorage, vk::ImageLayout::eGeneral),
               depth = cleared(device, vk::Format::eD32Sfloat, Usage::eDepthStencilAttachment,
                               vk::ImageLayout::eShaderReadOnlyOptimal);
    return ShownPictures{std::move(device), std::move(shown), std::move(depth)};
  });
}

Expected<ShownPictures> make_pictures() {
  return HeadsetSystem::open().and_then([](auto&& system) { return make_pictures(*system); });
}

/// Never destroyed: at the end of the process the driver may be gone.
ShownPictures* pictures() {
  static ShownPictures* const shared = [] {
    static_cast<void>(restart_fake());
    Expected<ShownPictures> made = make_pictures();
    return made ? new ShownPictures(std::move(*made)) : nullptr;
  }();
  return shared;
}

void FakeHeadset::SetUp() {
  if (!pictures()) GTEST_SKIP() << "no Vulkan device";
  fake = &restart_fake();
}

void FakeHeadset::TearDown() {
  if (!fake) return;
  runtime.reset();
  system.reset();
  EXPECT_EQ(fake->living, fake_openxr::Living{});
  EXPECT_EQ(fake->misuses, std::vector<std::string>{});
  EXPECT_EQ(pictures()->device.validation_log->messages(), std::vector<std::string>{});
}

HeadsetSetup FakeHeadset::setup() const {
  return {.start = {},
          .eye_size = kEyeSize,
          .wants_to_end = [] { return false; },
          .idle = [] {},
          .depth =
              [] {
                return HeadsetDepth{pictures()->depth, 0};
              },
          .sleep = [](Duration) {}};
}

bool FakeHeadset::open(HeadsetSetup setup) {
  Expected<std::unique_ptr<HeadsetSystem>> found = HeadsetSystem::open();
  if (!found) {
    error = found.error().what;
    return false;
  }
  system = std::move(*found);
  auto opened = system->open_runtime(pictures()->device, pictures()->shown, std::move(setup));
  if (!opened) {
    error = opened.error().what;
    return false;
  }
  runtime = std::move(*opened);
  return true;
}

bool FakeHeadset::show() {
  const std::optional<FrameTiming> timing = runtime->wait_frame();
  if (!timing) return false;
  shown.push_back(runtime->locate_views(timing->display_time));
  submit(timing->display_time);
  return true;
}

void FakeHeadset::submit(Time display_time) {
  gpu::FrameCommands frame(pictures()->device);
  runtime->add_output([&](const gpu::Recording& record) { frame.record(record); });
  frame.submit();
  runtime->end_frame(display_time);
}

void FakeHeadset::show_until(std::size_t most) {
  while (shown.size() < most && show()) {
  }
}

void FakeHeadset::finish() {
  if (const Expected<void> done = runtime->finish(); !done) error = done.error().what;
}

}  // namespace farshade::openxr
