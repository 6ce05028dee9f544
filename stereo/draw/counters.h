/// What drawing costs, counted: so that a test can assert that what a scene does not need is not paid for.
#pragma once

#include "stereo/draw/scene_buffers.h"
#include "stereo/gpu/ledger.h"

namespace farshade {

struct RendererLimits;

struct DrawCounters {
  std::uint64_t pipelines = 0;          ///< made so far
  std::uint64_t bindings = 0;           ///< descriptors in all sets
  std::uint64_t vertex_bytes = 0;       ///< of streams and indices on the device
  std::uint64_t vertex_bytes_read = 0;  ///< of these, what the last frame's draws read, both eyes
  std::uint64_t lookups = 0;  ///< traced views that a point shown in the last frame may be sought in
  gpu::MemoryUse memory;      ///< of the whole device, by use
};

/// The bytes a renderer allocates, by use. Report and ReadBack: once a report is asked for, a picture read
/// back; Staging: the largest, which is gone once the scene is on the device.
[[nodiscard]] gpu::BytesByUse client_memory(const Scene& scene, const DrawPlan& plan,
                                            const RendererLimits& limits);

/// Of what client_memory says, the most that there is at one time.
[[nodiscard]] std::uint64_t most_at_once(const gpu::BytesByUse& memory);

}  // namespace farshade
