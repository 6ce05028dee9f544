/// libsodium's random bytes, from a seed: keys, cookies and session numbers are the same whenever an input is
/// run. For fuzz targets alone.
#pragma once

#include <cstdint>

namespace farshade::fuzz {

/// From now on randombytes_* (libsodium) is SplitMix64 (Steele, Lea, Flood, OOPSLA 2014), begun at `seed`.
void fix_random(std::uint64_t seed);

}  // namespace farshade::fuzz
