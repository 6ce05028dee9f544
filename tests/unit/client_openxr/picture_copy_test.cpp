#include "vr_client/openxr/picture_copy.h"

#include <gtest/gtest.h>

#include <random>

#include "stereo/frame/view.h"

namespace farshade::openxr {
namespace {

using Layout = vk::ImageLayout;
constexpr Extent kSize{37, 21}, kLarger{64, 32};
constexpr auto kLayers = static_cast<std::uint32_t>(kEyes);

gpu::Image image(const gpu::Device& device, Extent size, std::uint32_t layers, vk::Format format,
                 vk::ImageUsageFlags usage) {
  return gpu::make_image(device, {.size = size, .layers = layers, .format = format, .usage = usage}, "image");
}

vk::BufferImageCopy whole(const gpu::Image& image) {
  return {.imageSubresource = {image.aspect, 0, 0, image.spec.layers},
          .imageExtent = {image.spec.size.width, image.spec.size.height, 1}};
}

/// Fills all layers with random words, and leaves the image in `layout`.
std::vector<std::uint32_t> fill(const gpu::Device& device, const gpu::Image& image, Layout layout) {
  constexpr unsigned seed = 11;
  std::mt19937 random(seed);
  std::vector<std::uint32_t> words(image.spec.size.pixels() * image.spec.layers);
  for (std::uint32_t& word : words)
    word = static_cast<std::uint32_t>(random() % 0x3f800001u);  // as floats, 0 to 1
  const gpu::StagingBuffer staging = gpu::make_staging_buffer(device, words.size() * 4, "words");
  staging.view<std::uint32_t>().copy(words);
  gpu::run_now(device, [&](const vk::raii::CommandBuffer& commands) {
    gpu::transition(commands, image, Layout::eUndefined, Layout::eTransferDstOptimal);
    commands.copyBufferToImage(*staging.buffer, *image.image, Layout::eTransferDstOptimal, whole(image));
    gpu::transition(commands, image, Layout::eTransferDstOptimal, layout);
  });
  return words;
}

std::vector<std::uint32_t> read(const gpu::Device& device, const gpu::Image& image, Layout layout) {
  const std::size_t words = image.spec.size.pixels() * image.spec.layers;
  const gpu::ReadbackBuffer back =
      gpu::make_readback_buffer(device, words * 4, vk::BufferUsageFlagBits::eTransferDst, "back");
  gpu::run_now(device, [&](const vk::raii::CommandBuffer& commands) {
    gpu::transition(commands, image, layout, Layout::eTransferSrcOptimal);
    commands.copyImageToBuffer(*image.image, Layout::eTransferSrcOptimal, *back.buffer, whole(image));
    gpu::show_copies_to_host(commands);
  });
  const auto span = back.as<std::uint32_t>();
  return {span.begin(), span.begin() + static_cast<std::ptrdiff_t>(words)};
}

/// The pictures go to an sRGB image without conversion; of the depths, layers 2 and 3 of a larger image.
TEST(PictureCopy, KeepsTheBytesOfPictureAndDepth) {
  gpu::DeviceOptions options;
  options.validation = gpu::Validation::On;
  const Expected<gpu::Device> device = gpu::open_device(options);
  if (!device) GTEST_SKIP() << device.error().what;
  using Usage = vk::ImageUsageFlagBits;
  const auto source = Usage::eTransferSrc | Usage::eTransferDst | Usage::eSampled;
  const gpu::Image shown = image(*device, kSize, kLayers, vk::Format::eR8G8B8A8Unorm, source),
                   depth = image(*device, kLarger, 4, vk::Format::eD32Sfloat,
                                 source | Usage::eDepthStencilAttachment),
                   pictures = image(*device, kSize, kLayers, vk::Format::eR8G8B8A8Srgb,
                                    source | Usage::eColorAttachment),
                   depths = image(*device, kSize, kLayers, vk::Format::eD32Sfloat,
                                  source | Usage::eDepthStencilAttachment);
  const auto shown_words = fill(*device, shown, Layout::eGeneral);
  const auto depth_words = fill(*device, depth, Layout::eShaderReadOnlyOptimal);
  const std::array<LayerCopy, 2> copies{
      {{shown, 0, Layout::eGeneral, *pictures.image, Layout::eColorAttachmentOptimal},
       {depth, 2, Layout::eShaderReadOnlyOptimal, *depths.image, Layout::eDepthStencilAttachmentOptimal}}};
  for (int again = 0; again < 2; ++again)  // the second time, layouts are those that the first one left
    gpu::run_now(*device,
                 [&](const vk::raii::CommandBuffer& commands) { record_copies(commands, copies, kSize); });

  EXPECT_EQ(read(*device, pictures, Layout::eColorAttachmentOptimal), shown_words);
  const auto copied = read(*device, depths, Layout::eDepthStencilAttachmentOptimal);
  for (std::size_t eye = 0; eye < kEyes; ++eye)
    for (std::size_t y = 0; y < kSize.height; ++y)
      for (std::size_t x = 0; x < kSize.width; ++x)
        ASSERT_EQ(copied[(eye * kSize.height + y) * kSize.width + x],
                  depth_words[((eye + 2) * kLarger.height + y) * kLarger.width + x])
            << "eye " << eye << ", " << x << ", " << y;
  EXPECT_TRUE(device->validation_log->messages().empty()) << device->validation_log->messages().front();
}

}  // namespace
}  // namespace farshade::openxr
