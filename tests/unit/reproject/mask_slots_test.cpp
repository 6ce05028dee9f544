/// Each mask is uploaded once while it stays in use, whatever order masks arrive and leave in.
#include "stereo/reproject/mask_slots.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>

namespace farshade {
namespace {

std::size_t uploads(std::span<const MaskSlots::Assignment> assignments) {
  return static_cast<std::size_t>(std::ranges::count(assignments, true, &MaskSlots::Assignment::must_upload));
}

/// Masks `newest`, `newest` - 1, ... as a client lists them.
std::vector<MaskVersion> newest_first(std::uint32_t newest, std::uint32_t count) {
  std::vector<MaskVersion> masks;
  for (std::uint32_t age = 0; age < count && age < newest; ++age) masks.push_back({FrameId{newest - age}});
  return masks;
}

TEST(MaskSlots, AFrameUploadsOnlyTheMaskThatArrivedForIt) {
  MaskSlots slots(4);
  for (std::uint32_t newest = 1; newest < 40; ++newest)
    EXPECT_EQ(uploads(slots.assign(newest_first(newest, 4))), 1u) << "frame " << newest;
  EXPECT_EQ(uploads(slots.assign(newest_first(39, 4))), 0u) << "no mask arrived";
}

TEST(MaskSlots, AMaskWithNewBitsIsUploadedAgainIntoItsSlot) {
  MaskSlots slots(4);
  std::vector<MaskVersion> masks = newest_first(9, 4);
  const auto before = slots.assign(masks);
  masks[0].content = 1;
  const auto after = slots.assign(masks);
  EXPECT_EQ(uploads(after), 1u);
  EXPECT_TRUE(after[0].must_upload);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(after[i].slot, before[i].slot);
}

TEST(MaskSlots, TheLeastRecentlyUsedMaskLosesItsSlot) {
  MaskSlots slots(3);
  (void)slots.assign(std::vector<MaskVersion>{{FrameId{1}}, {FrameId{2}}, {FrameId{3}}});
  (void)slots.assign(std::vector<MaskVersion>{{FrameId{1}}, {FrameId{3}}});
  (void)slots.assign(std::vector<MaskVersion>{{FrameId{1}}, {FrameId{4}}});  // evicts 2
  EXPECT_EQ(uploads(slots.assign(std::vector<MaskVersion>{{FrameId{3}}, {FrameId{4}}, {FrameId{1}}})), 0u);
  EXPECT_EQ(uploads(slots.assign(std::vector<MaskVersion>{{FrameId{2}}})), 1u);
}

TEST(MaskSlots, AfterClearEveryMaskIsUploaded) {
  MaskSlots slots(4);
  (void)slots.assign(newest_first(9, 4));
  slots.clear();
  EXPECT_EQ(uploads(slots.assign(newest_first(9, 4))), 4u);
}

TEST(MaskSlots, RandomListsUploadWhatTheFrameBeforeDidNotUseAndShareNoSlot) {
  std::mt19937 random(8);  // the seed
  std::uniform_int_distribution<std::uint32_t> id(1, 9), number(0, 4);
  MaskSlots slots(4);
  std::set<std::uint32_t> used_before;
  for (int frame = 0; frame < 2000; ++frame) {
    std::set<std::uint32_t> expected;
    const std::size_t count = number(random);
    while (expected.size() < count) expected.insert(id(random));
    std::vector<MaskVersion> masks;
    for (const std::uint32_t frame_id : expected) masks.push_back({FrameId{frame_id}});
    std::shuffle(masks.begin(), masks.end(), random);
    const auto assignments = slots.assign(masks);
    std::set<std::size_t> taken;
    for (std::size_t i = 0; i < masks.size(); ++i) {
      taken.insert(assignments[i].slot);
      EXPECT_LT(assignments[i].slot, 4u);
      if (used_before.contains(masks[i].frame.value)) {
        EXPECT_FALSE(assignments[i].must_upload) << "frame " << frame;
      }
    }
    EXPECT_EQ(taken.size(), masks.size()) << "frame " << frame;
    used_before = expected;
  }
}

}  // namespace
}  // namespace farshade
