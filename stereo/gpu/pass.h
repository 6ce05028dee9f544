/// Building blocks of passes: descriptor bindings, pipelines, timestamps.
#pragma once

#include <span>
#include <vector>

#include "stereo/base/clock.h"
#include "stereo/gpu/memory.h"

namespace farshade::gpu {

/// The push constants of a pipeline layout.
template <class T>
[[nodiscard]] constexpr vk::PushConstantRange push_constants(vk::ShaderStageFlags stages) {
  static_assert(sizeof(T) <= 128, "Vulkan guarantees 128 bytes of push constants");
  return {stages, 0, sizeof(T)};
}

/// The kind of one binding of a descriptor set; `count` > 1 is an array.
struct BindingKind {
  vk::DescriptorType type;
  vk::ShaderStageFlags stages;
  std::uint32_t count = 1;
};

/// A descriptor set; binding i has kind `kinds[i]`.
struct Bindings {
  vk::raii::DescriptorSetLayout layout{nullptr};
  vk::raii::DescriptorPool pool{nullptr};
  vk::raii::DescriptorSet set{nullptr};
  std::vector<BindingKind> kinds;
};

[[nodiscard]] vk::raii::DescriptorSetLayout make_layout(const Device& device,
                                                        std::span<const BindingKind> kinds);
[[nodiscard]] Bindings make_bindings(const Device& device, std::vector<BindingKind> kinds,
                                     const std::string& name);

/// `range`: bytes that the binding shows, from an offset that may be dynamic.
void bind_buffer(const Device& device, const Bindings& bindings, std::uint32_t binding, const Buffer& buffer,
                 std::uint64_t range = VK_WHOLE_SIZE);

/// All of `buffer` as texels, for shaders that fetch them.
[[nodiscard]] vk::raii::BufferView view_texels(const Device& device, const Buffer& buffer, vk::Format format);
void bind_texels(const Device& device, const Bindings& bindings, std::uint32_t binding, vk::BufferView view);

/// `layout` is the layout of the image when the set is used. `sampler` may be null for storage images.
struct ImageBinding {
  vk::ImageView view;
  vk::ImageLayout layout;
  vk::Sampler sampler;
};
void bind_image(const Device& device, const Bindings& bindings, std::uint32_t binding,
                const ImageBinding& image, std::uint32_t element = 0);

/// `constants`: the specialisation constants with ids 0, 1, 2, ..., as 32-bit words.
[[nodiscard]] vk::raii::Pipeline make_compute_pipeline(const Device& device,
                                                       const vk::raii::PipelineLayout& layout,
                                                       std::span<const std::uint32_t> spirv,
                                                       std::span<const std::uint32_t> constants,
                                                       const std::string& name);

/// A vertex stream. Each is a binding of its own, numbered in the order of GraphicsPipeline::streams.
struct VertexStream {
  std::uint32_t location;
  vk::Format format;
  std::uint32_t stride;  ///< bytes
};

/// What differs between graphics pipelines. All of them fill triangles with one sample a pixel, without
/// blending, in one viewport. Viewport and scissor are dynamic.
struct GraphicsPipeline {
  std::span<const std::uint32_t> vertex, fragment{};  ///< SPIR-V; `fragment` may be empty: writes depth only
  std::vector<std::uint32_t> constants{};             ///< of the fragment shader, as in make_compute_pipeline
  std::vector<VertexStream> streams{};
  std::vector<vk::Format> colors{};  ///< of the colour attachments
  enum class Writes : std::uint8_t { Colors, DepthOnly } writes = Writes::Colors;
  vk::Format depth = vk::Format::eUndefined;           ///< of the depth attachment; eUndefined: there is none
  vk::CompareOp depth_test = vk::CompareOp::eGreater;  ///< what passes is written
  std::vector<vk::DynamicState> dynamic{};             ///< besides viewport and scissor
};
[[nodiscard]] vk::raii::Pipeline make_graphics_pipeline(const Device& device,
                                                        const vk::raii::PipelineLayout& layout,
                                                        const GraphicsPipeline& wanted,
                                                        const std::string& name);

/// The ticks between two timestamps of a queue whose timestamps have `bits` valid bits. The counter may have
/// begun anew between them.
[[nodiscard]] constexpr std::uint64_t ticks_between(std::uint64_t from, std::uint64_t to,
                                                    std::uint32_t bits) {
  return (to - from) & (~std::uint64_t{0} >> (64 - bits));
}

/// Timestamps 0 to count - 1.
class Timestamps {
 public:
  Timestamps(const Device& device, std::uint32_t count);
  /// Timestamps are reset before they are written.
  void reset(const vk::raii::CommandBuffer& commands, std::uint32_t first, std::uint32_t count) const;
  void write(const vk::raii::CommandBuffer& commands, std::uint32_t index) const;
  /// The time between two timestamps, `from` < `to`. They and all between them have been written. Call after
  /// the device has finished.
  [[nodiscard]] Duration between(std::uint32_t from, std::uint32_t to) const;

 private:
  vk::raii::QueryPool pool_;
  std::uint32_t bits_;
  double period_ns_;
};

}  // namespace farshade::gpu
