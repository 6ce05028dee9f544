/// The formats that passes need. A device that lacks one is not chosen.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vulkan/vulkan_raii.hpp>

namespace farshade::gpu {

/// A format with what optimally tiled images of it must be usable for.
struct NeededFormat {
  vk::Format format;
  vk::FormatFeatureFlags features;
};
[[nodiscard]] std::span<const NeededFormat> needed_formats();

/// What images with these usage flags need of their format, besides copies.
[[nodiscard]] vk::FormatFeatureFlags features_for(vk::ImageUsageFlags usage);

/// The first needed format that lacks features, with these; empty if there is none. `offered`: the features
/// of a format's optimally tiled images.
[[nodiscard]] std::string lacking_format(const std::function<vk::FormatFeatureFlags(vk::Format)>& offered);

/// What 2D images of a format and usage may be; empty if there are none.
[[nodiscard]] std::optional<vk::ImageFormatProperties> image_limits(const vk::raii::PhysicalDevice& physical,
                                                                    vk::Format format,
                                                                    vk::ImageUsageFlags usage);

/// Bytes of a pixel of a needed format.
[[nodiscard]] constexpr std::size_t pixel_bytes(vk::Format format) {
  return format == vk::Format::eR32G32Uint ? 8 : 4;
}

}  // namespace farshade::gpu
