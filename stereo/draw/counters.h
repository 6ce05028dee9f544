/// Counters of what drawing costs. Tests use them to assert that a scene does not pay for features that it
/// does not use.
#pragma once

#include "stereo/frame/view.h"
#include "stereo/gpu/ledger.h"
#include "stereo/lod/levels.h"
#include "stereo/plan/scene_plan.h"
#include "stereo/shadow_maps/shadow_map_settings.h"

namespace farshade {

struct RendererLimits;

struct DrawCounters {
  std::uint64_t pipelines = 0;          ///< created so far
  std::uint64_t bindings = 0;           ///< descriptors in all sets
  std::uint64_t vertex_bytes_read = 0;  ///< that the last frame's draws read, for both eyes
  std::uint64_t lookups = 0;            ///< traced views in which the last frame looked up a point, at most
  std::uint64_t mask_uploads = 0;       ///< copies of a mask, both eyes, to the device so far
  std::uint64_t map_layers_drawn = 0;  ///< of shadow maps, with instances that cannot move, in the last frame
  std::uint64_t map_layers_restored = 0;  ///< from kept depth; only moving instances were drawn
  std::uint64_t meshes_deformed = 0;      ///< so far
  gpu::MemoryUse memory;                  ///< of the whole device, by use
};

/// The bytes that a renderer allocates at most, by use. It allocates Report and ReadBack when they are first
/// requested, Depth as far as the answers are late (depth_slots.h), and frees Staging once the scene is on
/// the device. EdgeRays is the limit, because only their light buffers tell what they take. With `maps` it
/// draws shadow maps, too; then shadow_map_bytes must succeed for them. Use::Uploads is host memory, for
/// frames that write everything.
[[nodiscard]] gpu::BytesByUse client_memory(const Scene& scene, const DrawPlan& plan,
                                            const RendererLimits& limits, const SceneLevels& levels = {},
                                            const ShadowMapSettings* maps = nullptr);

/// At most how many triangles a first G-buffer of `views` at scene time 0 submits, for both eyes: clusters
/// outside of the views are counted. `levels` are those of the scene, or empty.
[[nodiscard]] std::uint64_t gbuffer_triangles(const Scene& scene, const DrawPlan& plan,
                                              const SceneLevels& levels, const StereoView& views);

/// The peak of the sum of all uses, without Use::Uploads.
[[nodiscard]] std::uint64_t most_at_once(const gpu::BytesByUse& memory);

}  // namespace farshade
