#include "stereo/base/heap.h"

#include <cstdlib>
#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace farshade {

void keep_freed_memory() {
#ifdef __GLIBC__
  constexpr int kKept_bytes = 256 << 20, kLargestBlock_bytes = 32 << 20;  // the latter is glibc's limit
  mallopt(M_TRIM_THRESHOLD, kKept_bytes);
  mallopt(M_MMAP_THRESHOLD, kLargestBlock_bytes);
#endif
}

}  // namespace farshade
