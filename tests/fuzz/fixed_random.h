/// Makes libsodium's random bytes depend on a seed, so that keys, cookies and session ids are the same in
/// every run of an input. Only for fuzz targets.
#pragma once

#include <cstdint>

namespace farshade::fuzz {

/// From now on randombytes_* (libsodium) returns SplitMix64 (Steele, Lea, Flood, OOPSLA 2014) with `seed`.
void fix_random(std::uint64_t seed);

}  // namespace farshade::fuzz
