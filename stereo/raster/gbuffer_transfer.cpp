#include "stereo/raster/gbuffer_transfer.h"

#include <bit>
#include <utility>

namespace farshade {
namespace {

using ImageLayout = vk::ImageLayout;

constexpr std::uint32_t kColorBits = 0xffffff, kOpaque = 0xff000000;

/// Both eyes' layers of an image, and their offset in a buffer.
struct Part {
  const gpu::Image& image;
  gpu::LayerRange layers;
  std::size_t offset_bytes;
};

vk::BufferImageCopy copy_of(const Part& part, Extent size) {
  return {.bufferOffset = part.offset_bytes,
          .imageSubresource = {part.image.aspect, 0, part.layers.first, part.layers.count},
          .imageExtent = {size.width, size.height, 1}};
}

std::array<Part, 3> parts_of(const GBufferPass& gbuffer, const DepthPlace& place, std::size_t normals,
                             std::size_t depths) {
  return {Part{gbuffer.base_colors(), {0, kEyes}, 0}, Part{gbuffer.surfaces(), {0, kEyes}, normals},
          Part{*place.image, {place.layer, kEyes}, depths}};
}

void make_fit(PixelPlane& plane, Extent size, std::uint32_t word_bytes) {
  plane.size = size;
  plane.word_bytes = word_bytes;
  plane.words.resize(size.pixels());
}

void check_fits(const PixelPlane& plane, Extent size, std::uint32_t word_bytes) {
  check(plane.size == size && plane.words.size() == size.pixels(), "a plane has the renderer's size");
  check_eq(plane.word_bytes, word_bytes, "bytes of a plane's words");
}

/// False for NaN.
bool is_depth(std::uint32_t word) {
  const auto depth = std::bit_cast<float>(word);
  return depth >= 0 && depth <= 1;
}

}  // namespace

GBufferTransfer::Layout GBufferTransfer::layout() const {
  const std::size_t pixels = size_.pixels() * kEyes;
  const bool pairs = gbuffer_.surfaces().spec.format == vk::Format::eR32G32Uint;
  Layout layout{.surface_words = pairs ? 2u : 1u, .normals = pixels * 4, .depths = 0, .bytes = 0};
  layout.depths = layout.normals + pixels * layout.surface_words * 4;
  layout.bytes = layout.depths + pixels * 4;
  return layout;
}

void GBufferTransfer::read(const DepthPlace& place, GBufferPlanes& planes) {
  const Layout at = layout();
  if (readback_.bytes == 0)
    readback_ = gpu::make_readback_buffer(device_, at.bytes, vk::BufferUsageFlagBits::eTransferDst,
                                          "G-buffer read-back");
  gpu::run_now(device_, [&](const vk::raii::CommandBuffer& commands) {
    for (const Part& part : parts_of(gbuffer_, place, at.normals, at.depths)) {
      const auto rest = ImageLayout::eShaderReadOnlyOptimal, source = ImageLayout::eTransferSrcOptimal;
      gpu::transition(commands, part.image, rest, source, part.layers);
      commands.copyImageToBuffer(*part.image.image, source, *readback_.buffer, copy_of(part, size_));
      gpu::transition(commands, part.image, source, rest, part.layers);
    }
    gpu::show_copies_to_host(commands);
  });
  const std::size_t pixels = size_.pixels();
  const auto words = readback_.as<std::uint32_t>();
  const auto colors = words, normals = words.subspan(at.normals / 4), depths = words.subspan(at.depths / 4);
  for (std::size_t eye = 0; eye < kEyes; ++eye) {
    make_fit(planes.base_color[eye], size_, 3);
    make_fit(planes.normal[eye], size_, 4);
    make_fit(planes.depth[eye], size_, 4);
    for (std::size_t i = 0; i < pixels; ++i) {
      planes.base_color[eye].words[i] = colors[eye * pixels + i] & kColorBits;
      planes.normal[eye].words[i] = normals[(eye * pixels + i) * at.surface_words];
      planes.depth[eye].words[i] = depths[eye * pixels + i];
    }
  }
}

GBufferTransfer::Pixel GBufferTransfer::read(const DepthPlace& place, Side side, glm::uvec2 pixel) {
  check(pixel.x < size_.width && pixel.y < size_.height, "the pixel is in the picture");
  constexpr std::size_t depth = 4, surface = 8, bytes = 16;  // a surface of two words is aligned to both
  if (pixel_.bytes == 0)
    pixel_ =
        gpu::make_readback_buffer(device_, bytes, vk::BufferUsageFlagBits::eTransferDst, "pixel read-back");
  gpu::run_now(device_, [&](const vk::raii::CommandBuffer& commands) {
    for (const Part& part : parts_of(gbuffer_, place, surface, depth)) {
      const auto rest = ImageLayout::eShaderReadOnlyOptimal, source = ImageLayout::eTransferSrcOptimal;
      vk::BufferImageCopy copy = copy_of(part, {1, 1});
      copy.imageSubresource.baseArrayLayer += narrow<std::uint32_t>(index_of(side));
      copy.imageSubresource.layerCount = 1;
      copy.imageOffset = vk::Offset3D{narrow<std::int32_t>(pixel.x), narrow<std::int32_t>(pixel.y), 0};
      gpu::transition(commands, part.image, rest, source, part.layers);
      commands.copyImageToBuffer(*part.image.image, source, *pixel_.buffer, copy);
      gpu::transition(commands, part.image, source, rest, part.layers);
    }
    gpu::show_copies_to_host(commands);
  });
  const auto words = pixel_.as<std::uint32_t>();
  return {.normal = words[surface / 4],
          .instance = layout().surface_words > 1 ? words[surface / 4 + 1] >> 16 : 0,
          .depth = std::bit_cast<float>(words[depth / 4])};
}

void GBufferTransfer::prepare(const GBufferPlanes& planes) {
  const Layout at = layout();
  planes_ = frames_.take(at.bytes);
  const std::size_t pixels = size_.pixels();
  const auto words = planes_.view().as<std::uint32_t>();
  for (std::size_t eye = 0; eye < kEyes; ++eye) {
    check_fits(planes.base_color[eye], size_, 3);
    check_fits(planes.normal[eye], size_, 4);
    check_fits(planes.depth[eye], size_, 4);
    const std::uint32_t *const colors = planes.base_color[eye].words.data(),
                               *const normals = planes.normal[eye].words.data(),
                               *const depths = planes.depth[eye].words.data();
    const std::size_t a_surface = at.surface_words;
    words.part(eye * pixels, pixels).generate([=](std::size_t i) { return colors[i] | kOpaque; });
    words.part(at.normals / 4 + eye * pixels * a_surface, pixels * a_surface).generate([=](std::size_t i) {
      return i % a_surface == 0 ? normals[i / a_surface] : 0;
    });
    words.part(at.depths / 4 + eye * pixels, pixels).generate([=](std::size_t i) {
      return is_depth(depths[i]) ? depths[i] : 0;
    });
  }
}

void GBufferTransfer::record(const vk::raii::CommandBuffer& commands, const DepthPlace& place) {
  const Layout at = layout();
  for (const Part& part : parts_of(gbuffer_, place, at.normals, at.depths)) {
    const auto target = ImageLayout::eTransferDstOptimal;
    gpu::transition(commands, part.image, ImageLayout::eUndefined, target, part.layers);
    vk::BufferImageCopy copy = copy_of(part, size_);
    copy.bufferOffset += planes_.offset;
    commands.copyBufferToImage(*planes_.buffer->buffer, *part.image.image, target, copy);
    gpu::transition(commands, part.image, target, ImageLayout::eShaderReadOnlyOptimal, part.layers);
  }
  frames_.keep(std::exchange(planes_, {}).buffer);
}

}  // namespace farshade
