/// ForeignRenderer: a small renderer in plain Vulkan, with a device, a queue, command buffers and images of
/// its own. It draws the depth and the surfaces that VisibilityRecorder needs, and knows nothing of this
/// project's passes. The validation layer checks it, with synchronisation.
#pragma once

#include <string>
#include <vector>

#include "stereo/embed/visibility_recorder.h"

namespace farshade {

class ForeignRenderer {
 public:
  /// Draws `scene` without textures, holes and rigs. The image of visibilities has `layers` layers. Throws if
  /// a call of Vulkan fails.
  ForeignRenderer(const Scene& scene, Extent size, std::uint32_t layers);
  ForeignRenderer(const ForeignRenderer&) = delete;
  ForeignRenderer& operator=(const ForeignRenderer&) = delete;
  ~ForeignRenderer();

  [[nodiscard]] gpu::ForeignDevice device() const;
  [[nodiscard]] VisibilityImages images() const;

  /// Begins the command buffer of a frame.
  [[nodiscard]] VkCommandBuffer begin();
  /// Records depth and surfaces of both eyes, and the barriers after which VisibilityRecorder may read them
  /// and write visibilities.
  void draw(const StereoView& views, const SceneState& state);
  /// Records that the visibilities are read: [layer][pixel][channel].
  void read_back();
  /// Submits the frame and waits for it.
  void end();
  [[nodiscard]] std::vector<std::uint8_t> visibilities() const;

  /// Writes twice to one buffer without a barrier between.
  void make_a_hazard();
  /// Of the validation layer.
  [[nodiscard]] const std::vector<std::string>& messages() const { return messages_; }

 private:
  struct Buffer {
    VkBuffer buffer = nullptr;
    VkDeviceMemory memory = nullptr;
    void* bytes = nullptr;  ///< mapped
  };
  struct Image {
    VkImage image = nullptr;
    VkDeviceMemory memory = nullptr;
    VkImageView all = nullptr;
    std::vector<VkImageView> layers;
  };
  struct Mesh {
    Buffer vertices, indices;
    std::uint32_t count = 0;
  };
  void make_instance();
  void choose_device();
  void make_device();
  [[nodiscard]] VkDeviceMemory allocate(const VkMemoryRequirements& needs, VkMemoryPropertyFlags properties);
  [[nodiscard]] Buffer make_buffer(std::size_t bytes, VkBufferUsageFlags usage);
  [[nodiscard]] Image make_image(VkFormat format, VkImageUsageFlags usage, VkImageAspectFlags aspect,
                                 std::uint32_t layers);
  void make_layout();
  void make_pipeline();
  void make_meshes();
  void draw_eye(std::size_t eye, const StereoView& views, const SceneState& state);
  void draw_instance(std::size_t i, std::size_t eye, const StereoView& views, const SceneState& state);

  const Scene& scene_;
  Extent size_;
  std::uint32_t layers_;
  std::vector<std::string> messages_;
  VkInstance instance_ = nullptr;
  VkDebugUtilsMessengerEXT messenger_ = nullptr;
  VkPhysicalDevice physical_ = nullptr;
  VkDevice device_ = nullptr;
  VkQueue queue_ = nullptr;
  std::uint32_t queue_family_ = 0;
  VkCommandPool pool_ = nullptr;
  VkCommandBuffer commands_ = nullptr;
  VkFence done_ = nullptr;
  VkPipelineLayout layout_ = nullptr;
  VkPipeline pipeline_ = nullptr;
  Image depth_, surfaces_, visibility_;
  Buffer read_;
  std::vector<Mesh> meshes_;
  std::vector<Buffer> buffers_;  ///< all that were made
  std::vector<Image> images_made_;
};

}  // namespace farshade
