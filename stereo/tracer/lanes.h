/// SIMD values of K lanes with the operators of their elements. A comparison gives -1 or 0 in each lane.
///
/// These are the vector extensions of GCC and Clang. GCC does not vectorise plain loops over lanes that
/// contain several masks. Values are passed by reference, since the calling convention for passing them by
/// value depends on the machine's instruction set.
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

/// Loads as many elements as `lanes` has; no alignment needed.
template <class Values>
void load(Values& lanes, const void* from) {
  std::memcpy(&lanes, from, sizeof lanes);
}
template <class Values>
void store(const Values& lanes, void* to) {
  std::memcpy(to, &lanes, sizeof lanes);
}

/// Index of the first lane that is not 0, or -1.
template <class Mask>
int first_of(const Mask& mask) {
  std::uint64_t pairs[sizeof(Mask) / 8];
  std::memcpy(pairs, &mask, sizeof mask);
  for (int i = 0; i < static_cast<int>(sizeof(Mask) / 8); ++i)
    if (pairs[i] != 0) return 2 * i + (static_cast<std::uint32_t>(pairs[i]) != 0 ? 0 : 1);
  return -1;
}

/// The negated sum of lanes that hold negative counts: sums of -1 masks.
template <class Counts>
std::uint64_t counted(const Counts& below_zero) {
  std::int32_t lanes[sizeof(Counts) / 4], sum = 0;
  std::memcpy(lanes, &below_zero, sizeof below_zero);
  for (const std::int32_t lane : lanes) sum -= lane;
  return static_cast<std::uint64_t>(sum);
}

}  // namespace farshade
