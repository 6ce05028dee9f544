/// VisibilityRecorder: records the passes of this project into the command buffers of another renderer, on
/// its device and queue and with its images. They give the visibility of each light at each pixel; the
/// renderer shades with it. docs/embedding.md has the data flow, the formats, and the barriers that the
/// caller owes.
#pragma once

#include <memory>
#include <span>

#include "stereo/base/expected.h"
#include "stereo/draw/renderer.h"
#include "stereo/gpu/foreign_device.h"

namespace farshade {

/// A frame whose visibility is recorded. The fields mean the same as those of ShownFrame. Both views have the
/// size of RendererLimits::size.
struct VisibilityFrame {
  StereoView views;
  const SceneState& state;
  std::span<const TracedMask> masks{};
  std::span<const TracedMask> cube_mask{};
  Reprojection reprojection{};
};

/// Views of the caller's images, as arrays of layers; the first layer of depth and surfaces is the left eye.
struct VisibilityImages {
  VkImageView depth;  ///< 2 layers of D32_SFLOAT in SHADER_READ_ONLY_OPTIMAL: near / distance, 0: no surface
  VkImageView surfaces;    ///< 2 layers of R32G32_UINT in SHADER_READ_ONLY_OPTIMAL
  VkImageView visibility;  ///< visibility_layers() layers of R8G8B8A8_UNORM in GENERAL, usage storage
};

class VisibilityRecorder {
 public:
  /// Loads the scene onto the device and makes the pipelines of the default Reprojection, which takes seconds
  /// where the driver has no cache. Submits to the queue and waits, so nobody else may use the queue
  /// meanwhile. Device and scene must outlive the result. `plan` is a plan for the scene, which has only the
  /// lights that the plan keeps. `passes`: see DrawPlan; by default those that suit the device. Missing if
  /// the device lacks a feature; Unsupported if scene, plan or sizes cannot be used. Throws if a call of
  /// Vulkan fails or the device has too little memory.
  [[nodiscard]] static Expected<VisibilityRecorder> create(
      const gpu::ForeignDevice& device, const Scene& scene, DrawPlan plan, const RendererLimits& limits,
      std::optional<ShadingPasses> passes = std::nullopt);
  VisibilityRecorder(VisibilityRecorder&&) noexcept;
  VisibilityRecorder& operator=(VisibilityRecorder&&) noexcept;
  /// The device has finished all recorded commands.
  ~VisibilityRecorder();

  // All functions that record throw std::invalid_argument if views do not have the sizes of RendererLimits,
  // and exceptions of Vulkan. The caller submits each command buffer once, in the order of the calls; if it
  // drops one, it makes a new recorder.

  /// Begins a frame: each of the record functions can be called once in it. The device has finished the frame
  /// that began RendererLimits::frames calls before. The first frame has begun.
  void begin_frame();

  /// Records the depth of the views of `request`, which its masks need, and reprojects `base` to these views.
  /// Arguments and result are those of Renderer::reproject_to_request. If it returns false, nothing was
  /// recorded, because the depth of `base` is gone: without a base (null) it succeeds.
  [[nodiscard]] bool record_request(VkCommandBuffer commands, const FrameMoment& request, std::size_t slot,
                                    const TracedMask* base, const PerEye<HiddenArea>* hidden = nullptr);

  /// Reads the known bits and the blocks to ask for of the last record_request. The caller has waited for its
  /// commands. Call it before the next record_request, if at all.
  void read_unknown(RequestReprojection& into) const;

  /// Records the depth of requested pairs of faces of the cube mask.
  void record_faces(VkCommandBuffer commands, std::span<const FaceRequest> faces, const SceneState& state);

  /// Records the visibility of each light at the pixels of `frame`. Light i is channel i % 4 of layer
  /// eye * ceil(lights / 4) + i / 4; 0 is dark.
  void record_visibility(VkCommandBuffer commands, const VisibilityFrame& frame,
                         const VisibilityImages& images);

  [[nodiscard]] std::uint32_t visibility_layers() const;

  /// Forgets the depth of all requests and all masks. Call it when frame ids start again.
  void forget();

 private:
  struct State;
  explicit VisibilityRecorder(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace farshade
