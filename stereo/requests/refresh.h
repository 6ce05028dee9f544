/// Refresh: the tiles that a request asks for although they are known, so that nothing wrong lives longer
/// than a second (docs/partial-requests.md).
#pragma once

#include <span>

#include "stereo/base/clock.h"
#include "stereo/frame/requested_blocks.h"

namespace farshade {

/// Every tile is asked for once in this time.
inline constexpr Duration kRefreshPeriod = std::chrono::seconds(1);

/// Asks for all of `lights` lights in the blocks `covered` of the tiles (one entry each) whose turn comes
/// after display time `since` and until `now`. Their turns are spread evenly over the period and over the
/// picture.
void add_refresh(Time since, Time now, std::uint32_t lights, std::span<const BlockBits> covered,
                 std::span<RequestedTile> tiles);

}  // namespace farshade
