/// ShadingPass: reprojects masks to the shown views and shades the picture (shade.comp). If requested, it
/// writes the report of what each pixel was shaded with.
#pragma once

#include <map>
#include <span>
#include <vector>

#include "stereo/edge_rays/edge_rays.h"
#include "stereo/frame/tiles.h"
#include "stereo/raster/gbuffer.h"
#include "stereo/reproject/device_masks.h"
#include "stereo/reproject/motion.h"
#include "stereo/reproject/reprojection.h"
#include "stereo/reproject/shading_pipelines.h"
#include "stereo/shadow_maps/shadow_maps.h"

namespace farshade {

/// A mask and what has moved since it was traced.
struct DatedMask {
  const TracedMask& mask;
  Motion motion;
};

/// The masks that a picture is shaded with.
struct MasksInUse {
  std::vector<DatedMask> views;      ///< newest first, at most most_masks(plan)
  std::vector<DatedMask> cube_mask;  ///< at most most_cube_mask_pairs(plan)
  std::vector<Sphere> movable{};     ///< of all instances that can move (MotionModel::bounds); for edge rays
};

/// The depth of the views that masks were requested for.
struct MaskDepths {
  const DepthRing& views;
  const DepthRing* faces = nullptr;  ///< of the cube mask, in one image; null if the plan has none
  DepthPlace any;                    ///< bound for masks that a frame does not have
};

/// Images of another renderer, whose layers are the eyes. The pass reads depth and surfaces in layout
/// ShaderReadOnlyOptimal, and writes visibilities in layout General (output.glsl).
struct ForeignImages {
  vk::ImageView depth, surfaces, visibilities;
};

class ShadingPass {
 public:
  /// Shown views have `size` pixels an eye; masks have the layout of the plan. `frame` holds the FrameData
  /// that `prepare` fills. Keeps the references except `motion` and `gbuffer`. Without a G-buffer (null) the
  /// pass writes visibilities instead of a picture, and `bind_images` must come before each `record`.
  /// `edge_rays` is null unless the plan has them.
  ShadingPass(gpu::FramesInFlight& frames, const DrawPlan& plan, const GBufferPass* gbuffer,
              const MaskDepths& depths, DeviceMasks& device_masks, gpu::UploadBuffer& frame,
              const MotionModel& motion, const ShadingBytes& bytes, Extent size,
              EdgeRays* edge_rays = nullptr);

  /// Prepares `record`. Each mask needs its depth in its ring, unless the lookup is Direct. The depth of
  /// `views` will be `shown`, the first layers of an image. If the plan does not reproject masks, the lookup
  /// is Direct.
  void prepare(const DepthPlace& shown, const StereoView& views, const LightSet& lights,
               const MasksInUse& masks, const Reprojection& reprojection);

  /// The same with shadows from `maps`, which must exist until `record` and be readable by shaders there.
  void prepare(const DepthPlace& shown, const StereoView& views, const LightSet& lights,
               const ShadowMaps& maps);

  /// The next `record` reads and writes these images.
  void bind_images(const ForeignImages& images);

  /// Creates the pipelines of every state that `record` can find with these settings. Each result runs one of
  /// them, because some drivers compile at the first dispatch. The FrameData has pictures of no pixels.
  [[nodiscard]] std::vector<gpu::Recording> warm_ups(const Reprojection& reprojection, PixelReport report,
                                                     Changes changes);

  void record(const vk::raii::CommandBuffer& commands, PixelReport report);

  /// The shaded picture: both eyes, sRGB with alpha 255; in layout General after `record`.
  [[nodiscard]] const gpu::Image& shown() const { return shown_; }
  /// The report of the pixels of `part`, of the last `record` with PixelReport::On. Call after the device has
  /// finished.
  [[nodiscard]] ShownReport report(Side side, const TileRect& part) const;

  [[nodiscard]] std::size_t pipelines() const { return pipelines_.count(); }
  [[nodiscard]] std::size_t bindings() const;
  [[nodiscard]] std::size_t lookups() const { return masks_ * (other_eye_ ? 2 : 1) + faces_; }

 private:
  [[nodiscard]] ShadingKey key_of(std::uint32_t pass, PixelReport report) const;
  const vk::raii::PipelineLayout& layout_of(std::uint32_t pass, PixelReport report);
  const vk::raii::Pipeline& need_pipeline(std::uint32_t pass, PixelReport report);
  void make_all_pipelines();
  void assume_nothing();
  void make_buffers(const MotionModel& motion);
  void make_picture();
  /// Set 0. Its depths differ from frame to frame, and so do images of another renderer.
  struct FrameSet {
    gpu::Bindings bindings;
    std::map<std::uint32_t, vk::ImageView> textures{};  ///< by binding
  };
  [[nodiscard]] FrameSet make_set(const GBufferPass* gbuffer) const;
  [[nodiscard]] bool writes_visibilities() const { return !*shown_.image; }
  [[nodiscard]] const FrameSet& set_now() const { return frame_sets_[frames_.place()]; }
  void bind_depths(FrameSet& set, const DepthPlace& shown, std::span<const DatedMask> masks) const;
  void bind_texture(FrameSet& set, std::uint32_t binding, vk::ImageView view) const;
  void write_sources(const StereoView& views, std::span<const DatedMask> masks, gpu::FrameData& frame);
  void write_faces(const StereoView& views, std::span<const DatedMask> cube_mask, gpu::FrameData& frame);
  void write_motion(const StereoView& views, const MasksInUse& masks, gpu::FrameData& frame);
  void write_frame(const StereoView& views, const LightSet& lights, const gpu::FrameData& frame);
  void make_report_buffer();
  const vk::raii::PipelineLayout& need_layout(PixelReport report);
  [[nodiscard]] std::vector<const gpu::Bindings*> sets(PixelReport report) const;
  void bind_sets(const vk::raii::CommandBuffer& commands, PixelReport report);
  void empty_lists(const vk::raii::CommandBuffer& commands) const;
  void copy_arguments(const vk::raii::CommandBuffer& commands) const;
  void bind_ray_sets(const vk::raii::CommandBuffer& commands) const;
  void record_edge_rays(const vk::raii::CommandBuffer& commands);
  void shade_sorted(const vk::raii::CommandBuffer& commands, PixelReport report);
  void bind(const vk::raii::CommandBuffer& commands, std::uint32_t pass, PixelReport report);
  void shade_all(const vk::raii::CommandBuffer& commands, std::uint32_t pass, PixelReport report);
  void shade_listed(const vk::raii::CommandBuffer& commands, std::uint32_t pass, PixelReport report);
  void dispatch_list(const vk::raii::CommandBuffer& commands, const vk::raii::PipelineLayout& layout,
                     std::uint32_t list) const;

  gpu::FramesInFlight& frames_;
  const gpu::Device& device_;
  const DrawPlan& plan_;
  const MaskDepths depths_;
  DeviceMasks& device_masks_;
  gpu::UploadBuffer& frame_buffer_;
  Extent size_;
  ShadingBytes bytes_;
  gpu::UploadBuffer light_buffer_, motion_slots_, motion_buffer_;
  gpu::ReadbackBuffer report_buffer_;
  gpu::Buffer list_buffer_;
  EdgeRays* edge_rays_;
  vk::raii::PipelineLayout ray_layout_{nullptr};  ///< set 0 and that of the rays; null without rays
  std::size_t motion_count_;                      ///< of instances that can move
  gpu::Image shown_;                              ///< null if the pass writes visibilities
  vk::raii::Sampler nearest_{nullptr};
  std::vector<FrameSet> frame_sets_;  ///< by place of the frame in flight
  gpu::Bindings report_bindings_;     ///< the last set; empty until a report is requested
  std::map<std::size_t, vk::raii::PipelineLayout> layouts_;  ///< by the sets that they contain
  ShadingPipelines pipelines_;
  // State of the frame that was prepared last.
  const ShadowMaps* maps_ = nullptr;  ///< null: visibilities come from masks
  Reprojection reprojection_;
  bool other_eye_ = false;  ///< masks traced for the other eye are sources
  std::size_t masks_ = 0, faces_ = 0;
  std::bitset<kMaxLights> off_;  ///< lights that are off
  bool whole_ = false;           ///< every block of every mask is known
  bool traces_rays_ = false;     ///< edges are exact, and rays can be traced to some light
  bool moved_ = false;           ///< something may have moved since a mask in use was traced
};

}  // namespace farshade
