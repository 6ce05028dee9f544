#include "stereo/base/heap.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <vector>

#include "tests/support/sanitized.h"

namespace farshade {
namespace {

long page_faults() {
  rusage used{};
  getrusage(RUSAGE_SELF, &used);
  return used.ru_minflt;
}

TEST(KeepFreedMemory, SparesThePageFaultsOfTheNextFrame) {
  if (kSanitized) GTEST_SKIP() << "sanitizers bring their own heap";
  keep_freed_memory();
  constexpr std::size_t kBlock_bytes = 16 << 20, kPage_bytes = 4096;
  // Together they are more than what glibc keeps by itself after it has seen one of them.
  const auto faults_of_a_frame = [&] {
    const long before = page_faults();
    const std::vector<std::vector<char>> blocks(4, std::vector<char>(kBlock_bytes, 'a'));
    return page_faults() - before;
  };
  EXPECT_GT(faults_of_a_frame(), 0);
  EXPECT_LT(faults_of_a_frame(), static_cast<long>(kBlock_bytes / kPage_bytes / 100));
}

}  // namespace
}  // namespace farshade
