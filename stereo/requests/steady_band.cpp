#include "stereo/requests/steady_band.h"

#include <algorithm>

namespace farshade {
namespace {

/// Two seconds at 72 Hz: the memory of GuardBand.
constexpr std::size_t kMemory_requests = 144;

struct Axis {
  std::uint32_t low, high;
};

Axis steady(Axis needed, std::uint32_t most) {
  const std::uint32_t both = needed.low + needed.high;
  if (both == 0) return {0, 0};
  const std::uint32_t growth = both <= most / 2 ? most / 2 : most;
  const std::uint32_t low = growth * needed.low / both;
  return {low, growth - low};
}

}  // namespace

Sides<std::uint32_t> SteadyBand::margins_px(const Sides<std::uint32_t>& needed_px, Extent size) {
  if (needed_px_.size() < kMemory_requests)
    needed_px_.push_back(needed_px);
  else
    needed_px_[next_] = needed_px;
  next_ = (next_ + 1) % kMemory_requests;
  const auto most_of = [&](std::uint32_t Sides<std::uint32_t>::*side) {
    return std::ranges::max(needed_px_, {}, side).*side;
  };
  using Margins = Sides<std::uint32_t>;
  const Extent most = largest_traced(size);
  const Axis across = steady({most_of(&Margins::left), most_of(&Margins::right)}, most.width - size.width);
  const Axis along = steady({most_of(&Margins::up), most_of(&Margins::down)}, most.height - size.height);
  return {across.low, across.high, along.low, along.high};
}

}  // namespace farshade
