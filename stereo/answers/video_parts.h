/// Cuts a coded picture into the parts that VideoParts carry. A part begins where a NAL unit begins, so what
/// has come can be decoded although other parts are lost. A block of masks has no such places.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace farshade {

using VideoUnitParts = std::vector<std::span<const std::byte>>;

/// The parts of an access unit in Annex B, in order; they point into it. Each has as many whole NAL units as
/// fit into kVideoPart_bytes. A NAL unit that fits into no part is cut.
[[nodiscard]] VideoUnitParts video_parts(std::span<const std::byte> unit);

/// The parts of bytes that are of use only as a whole: all but the last have kVideoPart_bytes.
[[nodiscard]] VideoUnitParts full_parts(std::span<const std::byte> bytes);

}  // namespace farshade
