/// K numbers side by side as one value, with the operators of its elements; comparisons give -1 or 0. The
/// vector extension of GCC and Clang, since GCC leaves loops over lanes scalar as soon as they hold a few
/// masks, and then a proof costs more than the rays that it saves.
///
/// Passed by reference, for how they travel by value is not the same on all machines.
#pragma once

#include <cstdint>
#include <cstring>

namespace farshade {

template <int K>
struct LaneTypes {
  typedef float Floats __attribute__((vector_size(4 * K)));
  typedef std::int32_t Ints __attribute__((vector_size(4 * K)));
};
template <int K>
using Floats = typename LaneTypes<K>::Floats;
template <int K>
using Ints = typename LaneTypes<K>::Ints;

/// As many elements as `lanes` has.
template <class Values>
void load(Values& lanes, const void* from) {
  std::memcpy(&lanes, from, sizeof lanes);
}
template <class Values>
void store(const Values& lanes, void* to) {
  std::memcpy(to, &lanes, sizeof lanes);
}

/// The first lane that is not 0, or -1.
template <class Mask>
int first_of(const Mask& mask) {
  std::uint64_t pairs[sizeof(Mask) / 8];
  std::memcpy(pairs, &mask, sizeof mask);
  for (int i = 0; i < static_cast<int>(sizeof(Mask) / 8); ++i)
    if (pairs[i] != 0) return 2 * i + (static_cast<std::uint32_t>(pairs[i]) != 0 ? 0 : 1);
  return -1;
}

/// Of lanes that hold counts below 0: minus their sum.
template <class Counts>
std::uint64_t counted(const Counts& below_zero) {
  std::int32_t lanes[sizeof(Counts) / 4], sum = 0;
  std::memcpy(lanes, &below_zero, sizeof below_zero);
  for (const std::int32_t lane : lanes) sum -= lane;
  return static_cast<std::uint64_t>(sum);
}

}  // namespace farshade
