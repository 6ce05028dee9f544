#include "stereo/gpu/upload_buffer.h"

#include <gtest/gtest.h>

#include <array>
#include <numeric>
#include <optional>
#include <random>

#include "stereo/gpu/frame_commands.h"
#include "tests/unit/gpu/validated_device.h"

namespace farshade::gpu {
namespace {

constexpr std::size_t kElements = 1000;
using Words = std::vector<std::uint32_t>;

class UploadBuffers : public testing::Test {
 protected:
  void SetUp() override {
    Expected<Device> opened = open_validated_device();
    if (!opened) GTEST_SKIP() << opened.error().what;
    device_.emplace(std::move(*opened));
    frames_.emplace(*device_, 2);
    upload_ = make(kElements);
  }
  void TearDown() override {
    if (device_) {
      EXPECT_EQ(device_->validation_log->messages(), std::vector<std::string>{});
    }
  }
  [[nodiscard]] UploadBuffer make(std::size_t elements) {
    return make_upload_buffer(*frames_, elements * 4, vk::BufferUsageFlagBits::eTransferSrc, "upload");
  }
  void fill(std::size_t first, std::size_t count, std::uint32_t word) {
    upload_.view<std::uint32_t>(first, count).fill(word);
  }
  [[nodiscard]] ReadbackBuffer make_back() const {
    return make_readback_buffer(*device_, kElements * 4, vk::BufferUsageFlagBits::eTransferDst, "back");
  }
  /// Copies what was written to the device, and then to `back`.
  void record(const vk::raii::CommandBuffer& commands, const ReadbackBuffer& back) const {
    record_uploads(commands, {&upload_});
    commands.copyBuffer(*upload_.buffer().buffer, *back.buffer, vk::BufferCopy{.size = back.bytes});
    show_copies_to_host(commands);
  }
  /// What the device has.
  [[nodiscard]] Words content() const {
    const ReadbackBuffer back = make_back();
    run_now(*device_, [&](const vk::raii::CommandBuffer& commands) { record(commands, back); });
    const auto words = back.as<std::uint32_t>().first(kElements);
    return {words.begin(), words.end()};
  }
  [[nodiscard]] std::uint64_t host_bytes() const { return device_->ledger->read().now[Use::Uploads]; }

  std::optional<Device> device_;
  std::optional<FramesInFlight> frames_;
  UploadBuffer upload_;
};

TEST_F(UploadBuffers, OnlyWhatWasWrittenSinceIsCopied) {
  fill(0, kElements, 1);
  Words expected(kElements, 1);
  EXPECT_EQ(content(), expected);
  for (const auto& [first, word] : {std::pair(990u, 2u), {0u, 3u}, {500u, 4u}}) {
    fill(first, 10, word);
    std::fill_n(expected.begin() + first, 10, word);
    EXPECT_EQ(content(), expected);
  }
}

/// Random parts, in any order, over each other, of several frames: the last write counts.
TEST_F(UploadBuffers, TheLastWriteCounts) {
  std::mt19937 random{3};  // the seed
  fill(0, kElements, 0);
  Words expected(kElements, 0);
  for (std::uint32_t word = 1; word <= 400; ++word) {
    const std::size_t first = random() % kElements, count = random() % (kElements - first) % 90;
    fill(first, count, word);
    std::fill_n(expected.begin() + static_cast<std::ptrdiff_t>(first), count, word);
    if (word % 7 == 0) frames_->next();
    if (word % 40 == 0) {
      EXPECT_EQ(content(), expected) << word;
    }
  }
}

TEST_F(UploadBuffers, NeighboursAreOneCopyAndTakeMemoryOnce) {
  for (std::uint32_t i = 0; i < kElements; ++i) upload_.write(i, i);
  Words expected(kElements);
  std::iota(expected.begin(), expected.end(), 0u);
  EXPECT_EQ(content(), expected);
  const std::uint64_t once = host_bytes();
  for (int frame = 0; frame < 20; ++frame) {
    frames_->next();
    fill(0, kElements, 7);
    EXPECT_EQ(content(), Words(kElements, 7));
  }
  EXPECT_LE(host_bytes(), 2 * once) << "two frames in flight";
}

TEST_F(UploadBuffers, AFrameThatBeginsAgainUsesItsMemoryAgain) {
  for (std::uint32_t word = 0; word < 400; ++word) {
    fill(0, kElements, word);
    EXPECT_EQ(content(), Words(kElements, word));
    frames_->restart();
  }
  EXPECT_LE(host_bytes(), std::uint64_t{512} << 10) << "of 1.6 MB that were written";
}

/// What is copied only some frames later keeps its memory until then.
TEST_F(UploadBuffers, NothingIsLostThatIsCopiedLate) {
  UploadBuffer other = make(kElements);
  fill(0, kElements, 5);
  for (std::uint32_t frame = 0; frame < 5; ++frame) {
    frames_->next();
    other.view<std::uint32_t>().fill(frame);
    run_now(*device_, [&](const vk::raii::CommandBuffer& commands) { record_uploads(commands, {&other}); });
  }
  EXPECT_EQ(content(), Words(kElements, 5));
}

/// The host writes the next frame while the device has not begun the last one.
TEST_F(UploadBuffers, AFrameInFlightIsNotDisturbed) {
  std::vector<ReadbackBuffer> seen;
  FrameCommands commands(*device_);
  std::array<FrameCommands::Part, 2> ends{};
  for (std::uint32_t frame = 0; frame < 6; ++frame) {
    commands.wait(ends[frames_->place()]);
    fill(0, kElements, 100 + frame);
    const ReadbackBuffer& back = seen.emplace_back(make_back());
    ends[frames_->place()] =
        commands.record([&](const vk::raii::CommandBuffer& into) { record(into, back); });
    if (frame % 2 == 1) commands.submit();
    frames_->next();
  }
  commands.wait(commands.newest());
  for (std::uint32_t frame = 0; frame < 6; ++frame)
    EXPECT_EQ(seen[frame].as<std::uint32_t>()[kElements / 2], 100 + frame);
}

TEST_F(UploadBuffers, WhatAFrameKeepsLivesUntilItsPlaceComesAgain) {
  const auto used = std::make_shared<int>(1);
  frames_->keep(used);
  frames_->next();
  EXPECT_EQ(used.use_count(), 2);
  frames_->next();
  EXPECT_EQ(used.use_count(), 1);
}

}  // namespace
}  // namespace farshade::gpu
