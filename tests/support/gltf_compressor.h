/// Compresses GLB files in memory with the encoders of the libraries that the loader decodes with:
/// meshoptimizer and Draco. Without loss, so that the loader must make the same scene of both files.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace farshade {

enum class IndexCodec { Sequence, Triangles };  ///< Triangles may rotate the corners of triangles

/// Every buffer view that meshoptimizer can encode becomes compressed, with a fallback buffer without bytes.
/// `glb` must be valid and have all of its bytes in its binary chunk.
[[nodiscard]] std::vector<std::byte> compress_with_meshopt(std::span<const std::byte> glb,
                                                           IndexCodec indices = IndexCodec::Sequence);

/// Every indexed primitive of triangles becomes a Draco mesh. `sequential` keeps the order of vertices and
/// triangles; Edgebreaker, the other method, changes it.
enum class DracoMethod { Sequential, Edgebreaker };
[[nodiscard]] std::vector<std::byte> compress_with_draco(std::span<const std::byte> glb,
                                                         DracoMethod method = DracoMethod::Sequential);

}  // namespace farshade
