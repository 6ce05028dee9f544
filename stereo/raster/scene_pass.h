/// ScenePass: draws the scene for both eyes in one layered pass, with pipelines that are specialised for what
/// each mesh needs according to the plan. G-buffer, depth of requested views and shadow maps differ only in
/// their outputs.
#pragma once

#include <memory>

#include "stereo/raster/detail.h"
#include "stereo/raster/frame_data.h"
#include "stereo/raster/hidden_pass.h"
#include "stereo/raster/scene_buffers.h"
#include "stereo/raster/scene_pipeline.h"

namespace farshade {

/// Which instances are drawn into a layer.
enum class Casters : std::uint8_t {
  None,
  All,     ///< that cast shadows
  Fixed,   ///< those of them that cannot move
  Moving,  ///< the others of them
  Seen,    ///< also a sky, which casts none: for pictures
};

/// One pass of shadow maps, into two layers of an image.
struct CasterDraws {
  std::size_t pair = 0;                ///< layers 2 * pair and 2 * pair + 1 of the maps
  PerEye<glm::dmat4> clip_from_stage;  ///< of both layers; the same in all passes of a pair
  PerEye<Casters> casters{Casters::None, Casters::None};
};

class ScenePass {
 public:
  /// Keeps the references. `frame` holds a FrameData. A frame draws into at most `pairs` pairs of layers.
  /// `pipelines` are those of the passes with the same outputs, and become more.
  ScenePass(gpu::FramesInFlight& frames, const Scene& scene, const DrawPlan& plan,
            const SceneBuffers& buffers, const gpu::UploadBuffer& frame, Outputs outputs,
            std::size_t pairs = 1,
            std::shared_ptr<ScenePipelines> pipelines = std::make_shared<ScenePipelines>());

  /// Creates the pipelines of all meshes.
  void make_all_pipelines();
  /// Prepares a draw with each pipeline that covers no pixel: some drivers compile at the first draw.
  void prepare_warm_up();

  /// Prepares the draws for `views` and creates the pipelines that they need. Call before `record`.
  void prepare(const StereoView& views, const SceneState& state, Detail detail);
  /// The same for passes of shadow maps with layers of `size` texels. Not for the G-buffer.
  void prepare(std::span<const CasterDraws> passes, Extent size, const SceneState& state);

  /// Deforms the meshes that rigs move; `prepare` does it, too.
  void deform(const SceneState& state) { deformed_ = &buffers_.deformed->at(state); }
  /// The box of an instance's mesh at the time of the last `deform`, relative to its center.
  [[nodiscard]] const Bounds& box_of(std::size_t instance) const;
  [[nodiscard]] const DeformedVertices::Pose& deformed() const { return *deformed_; }

  /// Draws one pass into two layers: `size` pixels from the top left corner of the attachments. Before that
  /// it clears `clears` of the depth to zero. `hidden`, if any, has the same outputs and was prepared.
  void record(const vk::raii::CommandBuffer& commands, Extent size,
              std::span<const vk::RenderingAttachmentInfo> colors, const vk::RenderingAttachmentInfo& depth,
              std::size_t pass = 0, std::span<const vk::ClearRect> clears = {},
              const HiddenPass* hidden = nullptr) const;

  /// The level of detail at which an instance was drawn when levels were last used. Not of shadow maps.
  [[nodiscard]] std::uint32_t level_of(std::uint32_t instance) const { return last_levels_.at(instance); }

  [[nodiscard]] std::size_t pipelines() const { return pipelines_->size(); }
  [[nodiscard]] std::size_t bindings() const { return bindings_.kinds.size(); }
  /// Bytes of vertex streams and indices that the draws of the last `prepare` read.
  [[nodiscard]] std::uint64_t vertex_bytes_read() const { return vertex_bytes_read_; }
  /// Triangles that the draws of the last `prepare` submit, both layers of all pairs together.
  [[nodiscard]] std::uint64_t triangles() const { return triangles_; }

 private:
  struct Draw {
    std::uint32_t instance = 0;
    std::uint32_t data = 0;                 ///< index of its InstanceData
    std::uint32_t first_eye = 0, eyes = 0;  ///< whose views its bounding box may intersect
    float distance = 0;
    bool mirrored = false;
    std::uint32_t level = 0;             ///< 0: the mesh itself
    std::uint32_t first = 0, count = 0;  ///< indices of the level
  };
  [[nodiscard]] SceneVariant variant_of(std::size_t mesh) const;
  void need_pipeline(SceneVariant variant);
  [[nodiscard]] std::uint64_t bytes_read(std::size_t mesh, const Draw& draw) const;
  [[nodiscard]] PerEye<std::uint32_t> levels_for(std::uint32_t instance, const gpu::InstanceData& data,
                                                 const PerEye<Extent>& sizes);
  void add_visible(Draw draw, const gpu::InstanceData& data, std::vector<Draw>& draws);
  void add_draw(const Draw& draw, std::vector<Draw>& draws);
  void clear_counts();
  /// `seen_as` makes an instance's InstanceData from its transform to the stage.
  template <class SeenAs>
  void add_draws(std::size_t pass, const CasterDraws& wanted, const SceneState& state,
                 const PerEye<Extent>& sizes, Detail detail, const SeenAs& seen_as);
  [[nodiscard]] bool wants(Casters casters, std::size_t instance) const;
  void record_uploads(const vk::raii::CommandBuffer& commands, const HiddenPass* hidden) const;
  void draw_instance(const vk::raii::CommandBuffer& commands, const Draw& draw) const;

  const gpu::Device& device_;
  const Scene& scene_;
  const DrawPlan& plan_;
  const SceneBuffers& buffers_;
  const gpu::UploadBuffer& frame_;
  Outputs outputs_;
  gpu::UploadBuffer instances_;
  const DeformedVertices::Pose* deformed_;
  gpu::Bindings bindings_;
  vk::raii::PipelineLayout layout_{nullptr};
  std::shared_ptr<ScenePipelines> pipelines_;
  std::vector<std::vector<Draw>> draws_;    ///< for each pass
  std::vector<std::uint32_t> last_levels_;  ///< of the instances; not for shadow maps
  std::uint64_t vertex_bytes_read_ = 0, triangles_ = 0;
};

/// An attachment that is cleared to zero and stored.
[[nodiscard]] vk::RenderingAttachmentInfo cleared(vk::ImageView view, vk::ImageLayout layout);

}  // namespace farshade
