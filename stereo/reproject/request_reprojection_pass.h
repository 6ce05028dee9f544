/// RequestReprojectionPass: reprojects a mask to the views of a request before it is sent, and finds the
/// blocks that the request must ask for (request_reprojection.comp, docs/partial-requests.md).
#pragma once

#include <compare>

#include "stereo/frame/shadow_frame.h"
#include "stereo/gpu/pass.h"
#include "stereo/gpu/upload_buffer.h"
#include "stereo/plan/scene_plan.h"
#include "stereo/raster/depth_ring.h"
#include "stereo/reproject/motion.h"
#include "stereo/reproject/reprojection.h"

namespace farshade {

class RequestReprojectionPass {
 public:
  /// Requested views have at most `traced_size` pixels. `any_depth` is bound before the first frame. Keeps
  /// the references.
  RequestReprojectionPass(gpu::FramesInFlight& frames, const DrawPlan& plan, const DepthPlace& any_depth,
                          Extent traced_size);

  /// The depth of the views of a request, once it is drawn, and that of the mask's views.
  struct Depths {
    DepthPlace requested, base;
  };
  /// Prepares to reproject `base` to the views of `request`. `lights` are those of the request, `since` is
  /// what has moved since the base was traced.
  void prepare(const FrameMoment& request, const Depths& depths, const TracedMask& base,
               const LightSet& lights, const Motion& since);

  /// Creates the pipeline. The result runs it for masks of no pixels.
  [[nodiscard]] gpu::Recording warm_up();

  void record(const vk::raii::CommandBuffer& commands);

  /// Reads the result of the last `record`. Call after the device has finished. Reuses the memory of `into`.
  void read(RequestReprojection& into) const;

  [[nodiscard]] std::size_t pipelines() const { return *pipeline_ ? 1 : 0; }
  [[nodiscard]] std::size_t bindings() const { return bindings_.front().kinds.size(); }

 private:
  const vk::raii::Pipeline& need_pipeline();
  void bind(const gpu::Bindings& bindings, const Depths& depths) const;
  [[nodiscard]] const gpu::Bindings& bindings_now() const { return bindings_[frames_.place()]; }

  const gpu::FramesInFlight& frames_;
  const gpu::Device& device_;
  const DrawPlan& plan_;
  gpu::UploadBuffer frame_buffer_, light_buffer_;
  std::size_t quad_bytes_;                     ///< of one eye
  gpu::UploadBuffer quads_;                    ///< of the base
  gpu::ReadbackBuffer reprojected_, unknown_;  ///< what request_reprojection.comp writes
  vk::raii::Sampler nearest_{nullptr};
  std::vector<gpu::Bindings> bindings_;  ///< by place of the frame in flight
  vk::raii::PipelineLayout layout_{nullptr};
  vk::raii::Pipeline pipeline_{nullptr};
  Extent size_;  ///< of the pass that was prepared last
};

}  // namespace farshade
