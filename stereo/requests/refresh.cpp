#include "stereo/requests/refresh.h"

namespace farshade {
namespace {

/// The turn of a tile within the period. Multiples of the golden ratio, modulo 1, are spread evenly (Weyl's
/// sequence).
Duration turn_of(std::uint32_t tile) {
  constexpr std::uint32_t kGoldenRatio = 2654435769;  // 2^32 / 1.618
  const std::uint32_t turn = tile * kGoldenRatio;     // modulo 2^32
  return Duration(static_cast<Duration::rep>(
      std::uint64_t{turn} * static_cast<std::uint64_t>(kRefreshPeriod / Duration(1)) >> 32));
}

}  // namespace

void add_refresh(Time since, Time now, std::uint32_t lights, std::span<const BlockBits> covered,
                 std::span<RequestedTile> tiles) {
  const Duration passed = now - since;
  Duration begin = since.time_since_epoch() % kRefreshPeriod;
  if (begin < Duration::zero()) begin += kRefreshPeriod;
  for (std::uint32_t tile = 0; tile < tiles.size(); ++tile) {
    const Duration turn = turn_of(tile), until = turn > begin ? turn - begin : turn - begin + kRefreshPeriod;
    if (until <= passed) tiles[tile] = all_lights_in(covered[tile], lights);
  }
}

}  // namespace farshade
