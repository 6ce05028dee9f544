#include "stereo/gpu/frame_commands.h"

#include <gtest/gtest.h>

#include "stereo/base/clock.h"
#include "stereo/gpu/memory.h"
#include "tests/unit/gpu/validated_device.h"

namespace farshade::gpu {
namespace {

constexpr std::size_t kWords = 16, kManyBytes = std::size_t{64} << 20;

/// With a timeline, and with fences as on a device that a headset's runtime makes.
class FrameCommandsOf : public testing::TestWithParam<bool> {
 protected:
  void SetUp() override {
    Expected<Device> opened = open_validated_device();
    if (!opened) GTEST_SKIP() << opened.error().what;
    device.emplace(std::move(*opened));
    device->timelines = GetParam();
    words.emplace(make_readback_buffer(*device, kWords * 4, vk::BufferUsageFlagBits::eTransferDst, "words"));
    much.emplace(make_device_buffer(*device, kManyBytes, vk::BufferUsageFlagBits::eTransferDst, "much"));
  }
  void TearDown() override {
    if (device) {
      EXPECT_EQ(device->validation_log->messages(), std::vector<std::string>{});
    }
  }
  /// Fills a word.
  [[nodiscard]] Recording fill(std::size_t word, std::uint32_t value) const {
    return [this, word, value](const vk::raii::CommandBuffer& commands) {
      commands.fillBuffer(*words->buffer, word * 4, 4, value);
      show_copies_to_host(commands);
    };
  }
  /// Takes long.
  [[nodiscard]] Recording toil() const {
    return [this](const vk::raii::CommandBuffer& commands) {
      for (std::uint32_t i = 0; i < 20; ++i) {
        commands.fillBuffer(*much->buffer, 0, VK_WHOLE_SIZE, i);
        show_copies_to_host(commands);
        const vk::MemoryBarrier2 again{.srcStageMask = vk::PipelineStageFlagBits2::eTransfer,
                                       .srcAccessMask = vk::AccessFlagBits2::eTransferWrite,
                                       .dstStageMask = vk::PipelineStageFlagBits2::eTransfer,
                                       .dstAccessMask = vk::AccessFlagBits2::eTransferWrite};
        commands.pipelineBarrier2({.memoryBarrierCount = 1, .pMemoryBarriers = &again});
      }
    };
  }
  [[nodiscard]] std::uint32_t word(std::size_t i) const { return words->as<std::uint32_t>()[i]; }
  [[nodiscard]] std::uint64_t submissions() const { return device->use->submissions; }
  [[nodiscard]] std::uint64_t waits() const { return device->use->waits; }

  std::optional<Device> device;
  std::optional<ReadbackBuffer> words;
  std::optional<Buffer> much;
};

TEST_P(FrameCommandsOf, AFrameOfSeveralPartsIsSubmittedAndNothingWaitsForIt) {
  FrameCommands frame(*device);
  frame.record(fill(0, 11));
  frame.record(fill(1, 22));
  const FrameCommands::Part last = frame.record(fill(0, 33));
  EXPECT_EQ(submissions(), 0u);
  frame.submit();
  frame.submit();
  EXPECT_EQ(submissions(), GetParam() ? 1u : 3u);
  EXPECT_EQ(waits(), 0u);
  frame.wait(last);
  EXPECT_EQ(waits(), 1u);
  EXPECT_EQ(word(0), 33u) << "parts run in the order in which they were recorded";
  EXPECT_EQ(word(1), 22u);
  frame.wait(last);
  EXPECT_EQ(waits(), 1u) << "what has finished is not waited for";
}

TEST_P(FrameCommandsOf, WaitsForAPartWhileTheDeviceWorksOnTheNext) {
  FrameCommands frame(*device);
  const FrameCommands::Part first = frame.record(fill(2, 5)), second = frame.record(toil());
  const Stopwatch watch;
  frame.submit();
  frame.wait(first);
  const Duration until_first = watch.elapsed();
  EXPECT_EQ(word(2), 5u);
  frame.wait(second);
  EXPECT_LT(until_first, watch.elapsed() / 2);
}

TEST_P(FrameCommandsOf, RecordsTheNextFrameWhileTheDeviceWorks) {
  FrameCommands frame(*device);
  FrameCommands::Part last = 0;
  for (std::uint32_t number = 1; number <= 6; ++number) {
    frame.record(toil());
    last = frame.record(fill(3, number));
    frame.submit();
  }
  EXPECT_EQ(submissions(), GetParam() ? 6u : 12u);
  frame.wait(last);
  EXPECT_EQ(word(3), 6u);
}

TEST_P(FrameCommandsOf, ASubmissionThatIsNeededIsMadeByTheWait) {
  FrameCommands frame(*device);
  frame.wait(frame.record(fill(4, 9)));
  EXPECT_EQ(word(4), 9u);
  frame.wait(0);
  EXPECT_EQ(submissions(), 1u);
}

TEST_P(FrameCommandsOf, TheEndWaitsForWhatIsUnderWay) {
  {
    FrameCommands frame(*device);
    frame.record(toil());
    frame.record(fill(5, 7));
    frame.submit();
  }
  EXPECT_EQ(word(5), 7u);
}

TEST_P(FrameCommandsOf, ADeviceThatDoesNotFinishInTimeIsLost) {
  DeviceOptions impatient;
  impatient.timeout_ns = 1;
  Device lost = open_device(impatient).value();
  lost.timelines = GetParam();
  const Buffer written =
      make_device_buffer(lost, kManyBytes, vk::BufferUsageFlagBits::eTransferDst, "written");
  FrameCommands frame(lost);
  const FrameCommands::Part last = frame.record([&](const vk::raii::CommandBuffer& commands) {
    for (std::uint32_t i = 0; i < 200; ++i) commands.fillBuffer(*written.buffer, 0, VK_WHOLE_SIZE, i);
  });
  EXPECT_THROW(frame.wait(last), vk::DeviceLostError);
}  // destroying what the driver still writes to would end the program here

INSTANTIATE_TEST_SUITE_P(ADevice, FrameCommandsOf, testing::Bool(),
                         [](const auto& each) { return each.param ? "WithTimelines" : "WithFences"; });

}  // namespace
}  // namespace farshade::gpu
