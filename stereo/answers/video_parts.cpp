#include "stereo/answers/video_parts.h"

#include <algorithm>
#include <array>

#include "stereo/messages/messages.h"

namespace farshade {
namespace {

/// The beginning of a NAL unit in Annex B (H.264, B.1). No NAL unit contains these bytes.
constexpr std::array kStartCode{std::byte{0}, std::byte{0}, std::byte{1}};

/// The length of the first part.
std::size_t first_part_bytes(std::span<const std::byte> unit) {
  if (unit.size() <= kVideoPart_bytes) return unit.size();
  // The next part may begin anywhere from the second byte up to the first byte that does not fit.
  const auto window = unit.first(std::min(unit.size(), kVideoPart_bytes + kStartCode.size())).subspan(1);
  const auto last = std::find_end(window.begin(), window.end(), kStartCode.begin(), kStartCode.end());
  return last == window.end() ? kVideoPart_bytes : static_cast<std::size_t>(last - window.begin()) + 1;
}

}  // namespace

VideoUnitParts video_parts(std::span<const std::byte> unit) {
  VideoUnitParts parts;
  while (!unit.empty()) {
    const std::size_t bytes = first_part_bytes(unit);
    parts.push_back(unit.first(bytes));
    unit = unit.subspan(bytes);
  }
  return parts;
}

VideoUnitParts full_parts(std::span<const std::byte> bytes) {
  VideoUnitParts parts;
  for (; !bytes.empty(); bytes = bytes.subspan(parts.back().size()))
    parts.push_back(bytes.first(std::min(bytes.size(), kVideoPart_bytes)));
  return parts;
}

}  // namespace farshade
