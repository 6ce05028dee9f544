/// VideoUnit: reads what an access unit announces before a decoder sees it (H.264, 7.3). A few bytes may
/// announce a picture of any size, and a decoder allocates what is announced.
#pragma once

#include <cstddef>
#include <span>

#include "stereo/base/expected.h"
#include "stereo/frame/view.h"

namespace farshade {

/// Most reference pictures that a stream may keep. VideoEncoder's keep one.
inline constexpr std::uint32_t kMostReferences = 4;
/// Each slice costs time up to that of a whole picture. VideoEncoder's have about VideoFormat::slice_bytes.
inline constexpr std::size_t kLeastMeanSlice_bytes = 256, kMostShortSlices = 8;

struct VideoUnit {
  bool holds_key_frame = false;  ///< an instantaneous decoder refresh
};

/// What `unit` (Annex B) contains. `size`: pixels of the picture that was asked for. OutOfRange: a parameter
/// set announces another size or more than kMostReferences. Unsupported: the format is not VideoEncoder's
/// (High, Main or Baseline, progressive, 4:2:0 of 8 bits, without scaling lists). Malformed: a parameter set
/// or slice header ends early, slices are not in the order of their blocks, or there are more than
/// kMostShortSlices and one for each kLeastMeanSlice_bytes.
[[nodiscard]] Expected<VideoUnit> examine_unit(std::span<const std::byte> unit, Extent size);

}  // namespace farshade
