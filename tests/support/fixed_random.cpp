#include "tests/support/fixed_random.h"

#include <sodium.h>

#include <atomic>

#include "stereo/base/check.h"

namespace farshade {
namespace {

std::atomic<std::uint64_t> state = 0;

std::uint64_t next() {
  std::uint64_t z = state += 0x9e3779b97f4a7c15;
  z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9;
  z = (z ^ z >> 27) * 0x94d049bb133111eb;
  return z ^ z >> 31;
}

void fill(void* const to, const std::size_t size) {
  for (std::size_t i = 0; i < size; ++i)
    static_cast<std::uint8_t*>(to)[i] = static_cast<std::uint8_t>(next());
}

}  // namespace

void fix_random(std::uint64_t seed) {
  static randombytes_implementation fixed{.implementation_name = [] { return "fixed"; },
                                          .random = [] { return static_cast<std::uint32_t>(next()); },
                                          .stir = nullptr,
                                          .uniform = nullptr,
                                          .buf = fill,
                                          .close = nullptr};
  state = seed;
  static const int set = randombytes_set_implementation(&fixed);
  check_eq(set, 0, "libsodium uses this generator");
}

}  // namespace farshade
