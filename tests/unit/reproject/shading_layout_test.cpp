#include "stereo/reproject/shading_layout.h"

#include <gtest/gtest.h>

#include "stereo/frame/view.h"

namespace farshade {
namespace {

/// The least that Vulkan guarantees.
constexpr GroupCounts kGuaranteed{65'535, 65'535};

TEST(ShadingDispatches, FitEveryDeviceAtEverySize) {
  for (const Extent size :
       {Extent{1, 1}, Extent{2048, 2048}, Extent{2064, 2208}, Extent{kMaxViewSide_px, kMaxViewSide_px}})
    EXPECT_TRUE(fits_dispatches(size, kGuaranteed)) << size.width;
}

TEST(ShadingDispatches, OfListsHaveRowsOfFullLength) {
  constexpr std::uint32_t row = row_groups(kGuaranteed[0]);
  EXPECT_EQ(listed_groups(0, row), (GroupCounts{0, 0}));
  EXPECT_EQ(listed_groups(1, row), (GroupCounts{1, 1}));
  EXPECT_EQ(listed_groups(65, row), (GroupCounts{2, 1}));
  // All pixels of an eye of a headset. In one row they would be 71,208 groups.
  EXPECT_EQ(listed_groups(Extent{2064, 2208}.pixels(), row), (GroupCounts{65'535, 2}));
  EXPECT_EQ(listed_groups(65'535 * 64, row), (GroupCounts{65'535, 1}));
  EXPECT_EQ(listed_groups(65'535 * 64 + 1, row), (GroupCounts{65'535, 2}));
  EXPECT_EQ(row_groups(1 << 30), row) << "no longer on devices that allow more";
}

TEST(ShadingDispatches, DoNotFitADeviceWithLess) {
  EXPECT_FALSE(fits_dispatches({2064, 2208}, {65'535, 2207}));
  EXPECT_FALSE(fits_dispatches({2064, 2208}, {32, 65'535}));
  EXPECT_FALSE(fits_dispatches({8192, 16}, {128, 15})) << "rows of lists";
}

}  // namespace
}  // namespace farshade
