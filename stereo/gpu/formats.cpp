#include "stereo/gpu/formats.h"

#include <array>

namespace farshade::gpu {

std::span<const NeededFormat> needed_formats() {
  using Feature = vk::FormatFeatureFlagBits;
  static const std::array needed{
      NeededFormat{vk::Format::eD32Sfloat, Feature::eDepthStencilAttachment | Feature::eSampledImage},
      // base colours and textures
      NeededFormat{vk::Format::eR8G8B8A8Srgb,
                   Feature::eColorAttachment | Feature::eSampledImage | Feature::eSampledImageFilterLinear},
      // surfaces of the G-buffer
      NeededFormat{vk::Format::eR32Uint, Feature::eColorAttachment | Feature::eSampledImage},
      NeededFormat{vk::Format::eR32G32Uint, Feature::eColorAttachment | Feature::eSampledImage},
      // shown pictures; windows and screenshots
      NeededFormat{vk::Format::eR8G8B8A8Unorm, Feature::eStorageImage | Feature::eSampledImage |
                                                   Feature::eColorAttachment | Feature::eBlitSrc}};
  return needed;
}

vk::FormatFeatureFlags features_for(vk::ImageUsageFlags usage) {
  using Usage = vk::ImageUsageFlagBits;
  using Feature = vk::FormatFeatureFlagBits;
  vk::FormatFeatureFlags features;
  if (usage & Usage::eColorAttachment) features |= Feature::eColorAttachment;
  if (usage & Usage::eDepthStencilAttachment) features |= Feature::eDepthStencilAttachment;
  if (usage & Usage::eSampled) features |= Feature::eSampledImage;
  if (usage & Usage::eStorage) features |= Feature::eStorageImage;
  return features;
}

std::string lacking_format(const std::function<vk::FormatFeatureFlags(vk::Format)>& offered) {
  for (const NeededFormat& needed : needed_formats())
    if (const vk::FormatFeatureFlags missing = needed.features & ~offered(needed.format))
      return vk::to_string(needed.format) + " without " + vk::to_string(missing);
  return {};
}

std::optional<vk::ImageFormatProperties> image_limits(const vk::raii::PhysicalDevice& physical,
                                                      vk::Format format, vk::ImageUsageFlags usage) try {
  return physical.getImageFormatProperties(format, vk::ImageType::e2D, vk::ImageTiling::eOptimal, usage, {});
} catch (const vk::FormatNotSupportedError&) {
  return std::nullopt;
}

}  // namespace farshade::gpu
