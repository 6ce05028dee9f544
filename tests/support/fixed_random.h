/// Makes libsodium's random bytes depend on a seed, so that keys, cookies, session ids and the counters that
/// a server leaves out are the same in every run. Only for fuzz targets and runs in virtual time.
#pragma once

#include <cstdint>

namespace farshade {

/// From now on randombytes_* (libsodium) returns SplitMix64 (Steele, Lea, Flood, OOPSLA 2014) with `seed`.
void fix_random(std::uint64_t seed);

}  // namespace farshade
