#include "stereo/gpu/ledger.h"

#include <gtest/gtest.h>

#include <utility>
#include <vector>

namespace farshade::gpu {
namespace {

TEST(Ledger, CountsPresentAndPeakBytes) {
  const auto ledger = std::make_shared<Ledger>();
  const Charge kept(ledger, Use::Masks, 100);
  { const Charge brief(ledger, Use::Staging, 1000); }
  const Charge later(ledger, Use::Depth, 10);
  const MemoryUse use = ledger->read();
  EXPECT_EQ(use.now[Use::Masks], 100u);
  EXPECT_EQ(use.now[Use::Staging], 0u);
  EXPECT_EQ(use.now.total(), 110u);
  EXPECT_EQ(use.peak[Use::Staging], 1000u);
  EXPECT_EQ(use.peak_total, 1100u) << "the peak at one time, not the sum of the uses' own peaks";
}

TEST(Ledger, EachChargeIsRemovedOnceAfterMoves) {
  const auto ledger = std::make_shared<Ledger>();
  {
    std::vector<Charge> charges;
    for (std::uint64_t bytes = 1; bytes <= 8; ++bytes) charges.emplace_back(ledger, Use::Vertices, bytes);
    charges.erase(charges.begin());
    EXPECT_EQ(ledger->read().now[Use::Vertices], 2u + 3 + 4 + 5 + 6 + 7 + 8);
    charges[0] = Charge(ledger, Use::Textures, 50);
    EXPECT_EQ(ledger->read().now[Use::Vertices], 3u + 4 + 5 + 6 + 7 + 8);
    charges[1] = std::move(charges[0]);
    EXPECT_EQ(ledger->read().now.total(), 50u + 4 + 5 + 6 + 7 + 8);
  }
  EXPECT_EQ(ledger->read().now.total(), 0u);
}

TEST(Ledger, EveryUseHasItsName) {
  for (std::size_t use = 0; use < kUses; ++use) EXPECT_FALSE(to_string(static_cast<Use>(use)).empty());
  EXPECT_EQ(to_string(Use::Vertices), "vertices");
  EXPECT_EQ(to_string(Use::Other), "other");
  EXPECT_EQ(static_cast<std::size_t>(Use::Other), kUses - 1);
}

}  // namespace
}  // namespace farshade::gpu
