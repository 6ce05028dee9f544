#include "stereo/gpu/device.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <string_view>

#include "stereo/gpu/memory.h"
#include "stereo/gpu/pass.h"
#include "tests/support/test_place.h"

namespace farshade::gpu {
namespace {

/// Writes a buffer of 64 MiB 200 times.
void write_much(const Device& device) {
  constexpr std::size_t kBytes = std::size_t{64} << 20;
  const Buffer written = make_device_buffer(device, kBytes, vk::BufferUsageFlagBits::eTransferDst, "written");
  run_now(device, [&](const vk::raii::CommandBuffer& commands) {
    for (std::uint32_t i = 0; i < 200; ++i) commands.fillBuffer(*written.buffer, 0, kBytes, i);
  });
}

TEST(Device, OneThatDoesNotFinishInTimeIsLostAndAnotherCanBeOpened) {
  if (!open_device({})) GTEST_SKIP() << "no Vulkan device";
  DeviceOptions impatient;
  impatient.timeout_ns = 1;
  for (int i = 0; i < 3; ++i) {
    const Device device = open_device(impatient).value();
    EXPECT_THROW(write_much(device), vk::DeviceLostError);
  }  // destroying what the driver still writes to would end the program here
  const Device device = open_device({}).value();
  write_much(device);
}

/// Synchronisation checks are an option of the validation layer, which `check` of scripts/gpu-bundle turns
/// on. It trusts them only if they find this hazard.
TEST(SynchronisationChecks, FindAMissingBarrier) {
  const char* const options = std::getenv("VK_LAYER_ENABLES");
  if (options == nullptr || std::string_view(options).find("SYNCHRONIZATION") == std::string_view::npos)
    GTEST_SKIP() << "VK_LAYER_ENABLES does not turn them on";
  const Expected<Device> device = open_device({.name_contains = test_gpu(), .validation = Validation::On});
  ASSERT_TRUE(device) << device.error().what;
  constexpr std::size_t kBytes = 1024;
  const Buffer written =
      make_device_buffer(*device, kBytes, vk::BufferUsageFlagBits::eTransferDst, "written");
  run_now(*device, [&](const vk::raii::CommandBuffer& commands) {
    for (const std::uint32_t value : {1u, 2u}) commands.fillBuffer(*written.buffer, 0, kBytes, value);
  });
  const std::vector<std::string> messages = device->validation_log->messages();
  ASSERT_FALSE(messages.empty());
  EXPECT_NE(messages[0].find("SYNC-HAZARD-WRITE-AFTER-WRITE"), std::string::npos) << messages[0];
}

TEST(AdoptedDevice, BelongsToItsOwner) {
  const Expected<Device> owner = open_device({.name_contains = test_gpu()});
  if (!owner) GTEST_SKIP() << "no Vulkan device";
  ForeignDevice foreign{*owner->instance, *owner->physical, *owner->logical, *owner->queue,
                        owner->queue_family};
  constexpr std::size_t kBytes = 1024;
  const auto write = [&](const Device& device) {
    const Buffer written =
        make_device_buffer(device, kBytes, vk::BufferUsageFlagBits::eTransferDst, "written");
    run_now(device, [&](const vk::raii::CommandBuffer& commands) {
      commands.fillBuffer(*written.buffer, 0, kBytes, 1);
    });
  };
  {
    const Expected<Device> adopted = adopt_device(foreign);
    ASSERT_TRUE(adopted) << adopted.error().what;
    EXPECT_EQ(adopted->name, owner->name);
    EXPECT_EQ(adopted->max_storage_bytes, owner->max_storage_bytes);
    EXPECT_EQ(adopted->max_texels, owner->max_texels);
    write(*adopted);
  }
  write(*owner);
  foreign.queue_family = 99;
  const Expected<Device> refused = adopt_device(foreign);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().fault, Fault::Missing);
}

/// Queues count with 36 to 64 bits; what stands above them is undefined.
TEST(Timestamps, CountOnWhereTheCounterBeginsAnew) {
  EXPECT_EQ(ticks_between(5, 12, 64), 7u);
  EXPECT_EQ(ticks_between((1ULL << 36) - 3, 4, 36), 7u);
  EXPECT_EQ(ticks_between(0xabc0'0000'0005ULL, 0x1230'0000'000cULL, 36), 7u);
  EXPECT_EQ(ticks_between(~0ULL, 6, 64), 7u);
}

/// Stands for the objects of a driver's libraries, which its threads still use.
struct AbortsAtTheEnd {
  ~AbortsAtTheEnd() { std::abort(); }
};

TEST(Device, AProgramThatAbandonedOneEndsWithItsOwnStatus) {
  if (!open_device({})) GTEST_SKIP() << "no Vulkan device";
  const auto abandon_and_exit = [] {
    static const AbortsAtTheEnd driver;
    DeviceOptions impatient;
    impatient.timeout_ns = 1;
    const Device device = open_device(impatient).value();
    EXPECT_THROW(write_much(device), vk::DeviceLostError);
    std::exit(3);
  };
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(abandon_and_exit(), testing::ExitedWithCode(3), "");
}

TEST(Device, OneThatCannotPresentIsRefusedUnlessPresentingIsOnlyWished) {
  if (!open_device({})) GTEST_SKIP() << "no Vulkan device";
  const Presentation nowhere{.instance_extensions = {"VK_KHR_surface"},
                             .can_present = [](auto...) { return false; }};
  const Presentation unknown{.instance_extensions = {"VK_FARSHADE_no_such_extension"},
                             .can_present = [](auto...) { return true; }};
  for (const Presentation& presentation : {nowhere, unknown}) {
    DeviceOptions options;
    options.presentation = presentation;
    EXPECT_FALSE(open_device(options)) << presentation.instance_extensions[0];
    options.presentation->need = Need::Wished;
    const Expected<Device> device = open_device(options);
    ASSERT_TRUE(device) << device.error().what;
    EXPECT_FALSE(device->presents);
  }
}

TEST(Formats, NameTheOneThatLacksAFeature) {
  const auto all = [](vk::Format) { return ~vk::FormatFeatureFlags{}; };
  EXPECT_EQ(lacking_format(all), "");
  const auto no_storage = [](vk::Format format) {
    return format == vk::Format::eR8G8B8A8Unorm
               ? ~vk::FormatFeatureFlags(vk::FormatFeatureFlagBits::eStorageImage)
               : ~vk::FormatFeatureFlags{};
  };
  EXPECT_EQ(lacking_format(no_storage), "R8G8B8A8Unorm without { StorageImage }");
}

}  // namespace
}  // namespace farshade::gpu
