/// The compute pipelines of ShadingPass: variants of shade.comp, created when they are first needed.
#pragma once

#include <compare>
#include <map>
#include <set>

#include "stereo/frame/edge_sharpness.h"
#include "stereo/gpu/pass.h"
#include "stereo/reproject/reprojection.h"
#include "stereo/reproject/shading_layout.h"

namespace farshade {

/// What a pipeline is specialised for. Two dispatches with equal keys use one pipeline.
struct ShadingKey {
  std::uint32_t pass = 0;   ///< FARSHADE_PASS_*
  bool reports = false;     ///< writes the report
  bool visibility = false;  ///< writes the visibility of each light instead of a picture
  bool edge_rays = false;   ///< lists pixels at shadow edges apart
  bool other_eye = false;   ///< masks traced for the other eye are sources, too
  bool neighbours = true;   ///< points that no view saw take bits from a neighbour
  bool filters_edges = true;
  bool whole = false;                             ///< every tile of every mask in use is known
  bool moved = false;                             ///< something has moved since a mask in use was traced
  std::uint32_t map_side_px = 0, pcf_radius = 0;  ///< 0: visibilities come from masks
  float sharpness = kEdgeSharpness;               ///< 0: the visibility is the coverage of the pixel
  friend auto operator<=>(const ShadingKey&, const ShadingKey&) = default;

  [[nodiscard]] bool uses_maps() const { return map_side_px > 0; }
};

class ShadingPipelines {
 public:
  /// Keeps the references. `motion`: some instances can move.
  ShadingPipelines(const gpu::Device& device, const DrawPlan& plan, bool motion)
      : device_(device), plan_(plan), motion_(motion) {}

  /// Creates the pipeline if there is none for `key` yet.
  const vk::raii::Pipeline& need(const ShadingKey& key, const vk::raii::PipelineLayout& layout);

  /// Creates the pipelines of all `keys` that there are not yet, side by side.
  void need_all(const std::set<ShadingKey>& keys, const vk::raii::PipelineLayout& layout);

  [[nodiscard]] std::size_t count() const { return pipelines_.size(); }

 private:
  [[nodiscard]] vk::raii::Pipeline make(const ShadingKey& key, const vk::raii::PipelineLayout& layout) const;

  const gpu::Device& device_;
  const DrawPlan& plan_;
  bool motion_;
  std::map<ShadingKey, vk::raii::Pipeline> pipelines_;
};

}  // namespace farshade
