#include "tests/support/watched_sodium.h"

#include <sodium.h>

#include <cstdint>

namespace farshade {
namespace {

thread_local WatchedSodium* watching_sodium = nullptr;

}  // namespace

WatchedSodium::WatchedSodium() {
  watching_sodium = this;
}

WatchedSodium::~WatchedSodium() {
  watching_sodium = nullptr;
}

#ifdef FARSHADE_SHARED_SODIUM

bool WatchedSodium::is_possible() {
  return true;
}

extern "C" void sodium_memzero(void* const bytes, const std::size_t size) {
  auto* const to = static_cast<volatile std::uint8_t*>(bytes);
  for (std::size_t i = 0; i < size; ++i) to[i] = 0;
  if (watching_sodium != nullptr) watching_sodium->wiped.push_back(size);
}

extern "C" int sodium_memcmp(const void* const a, const void* const b, const std::size_t size) {
  const auto* const left = static_cast<const volatile std::uint8_t*>(a);
  const auto* const right = static_cast<const volatile std::uint8_t*>(b);
  unsigned differences = 0;
  for (std::size_t i = 0; i < size; ++i) differences |= static_cast<unsigned>(left[i] ^ right[i]);
  if (watching_sodium != nullptr) watching_sodium->compared.push_back(size);
  return differences == 0 ? 0 : -1;
}

#else

bool WatchedSodium::is_possible() {
  return false;
}

#endif

}  // namespace farshade
