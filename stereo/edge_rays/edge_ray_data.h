/// EdgeRayData: what the client's own shadow rays can meet: the triangles that cast and never move, the alpha
/// of those with holes, and a LightBuffer for each light that rests. Pure; no device needed.
#pragma once

#include <future>

#include "stereo/edge_rays/caster_texels.h"
#include "stereo/edge_rays/light_buffer.h"
#include "stereo/plan/scene_plan.h"

namespace farshade {

/// Light buffers, triangles and alpha take at most this. If alpha does not fit, holes are unknown
/// (caster_texels.h). From the first light on whose buffer would take more, lights have none.
inline constexpr std::size_t kMostEdgeRayBytes = 64 << 20;

struct EdgeRayData {
  /// A light of the scene where its buffer was made for it, also if it has none.
  struct Buffered {
    Light light;
    ListDepths depths{};
    LightShadowMaps projection;  ///< with the buffer's first word; FARSHADE_MAP_NONE: it has no buffer
  };
  Point<Stage> origin;  ///< of the corners
  CasterTexels texels;
  std::vector<std::uint32_t> words{};  ///< of all buffers
  std::vector<Buffered> lights{};      ///< those of the scene

  [[nodiscard]] std::size_t bytes() const { return texels.bytes() + words.size() * sizeof(std::uint32_t); }
  [[nodiscard]] std::size_t buffers() const;  ///< lights that have one
};

/// Data that are made meanwhile. Invalid: they will never be there.
using FutureEdgeRayData = std::shared_future<EdgeRayData>;

/// What EdgeRayData are made from.
struct EdgeRayInput {
  CasterTriangles casters;
  CasterTexels texels;
  std::vector<EdgeRayData::Buffered> lights;  ///< FARSHADE_MAP_NONE: it gets no buffer
  std::uint64_t most_words = 0;               ///< of all buffers
};

/// For a device whose buffers have at most `most_texels`. Without casters and words if there are too many
/// casters.
[[nodiscard]] EdgeRayInput edge_ray_input(const Scene& scene, const DrawPlan& plan,
                                          std::uint64_t most_texels);

/// The data before their buffers are made: `words` is empty, and lights are as in the input.
[[nodiscard]] EdgeRayData without_buffers(const EdgeRayInput& input);

/// Uses all cores, on threads with the priority of the calling one. Once `stop` is requested, it returns
/// soon, and no further light has a buffer.
[[nodiscard]] EdgeRayData make_edge_ray_data(const EdgeRayInput& input, const std::stop_token& stop = {});

}  // namespace farshade
