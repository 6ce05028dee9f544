#include "stereo/base/write_only.h"

#include <gtest/gtest.h>

#include <array>
#include <numeric>
#include <vector>

namespace farshade {
namespace {

template <class View>
concept HasElements = requires(View view) {
  view[0];
};
template <class View>
concept HasData = requires(View view) {
  view.data();
};
template <class View>
concept HasFront = requires(View view) {
  view.front();
};
template <class View>
concept HasIterators = requires(View view) {
  view.begin();
};
template <class View>
concept IsARange = requires(View view) {
  std::ranges::begin(view);
};

static_assert(HasElements<std::span<int>> && HasData<std::span<int>> && HasFront<std::span<int>> &&
                  HasIterators<std::span<int>> && IsARange<std::span<int>>,
              "the concepts find what reads");
static_assert(!HasElements<WriteOnly<int>> && !HasData<WriteOnly<int>> && !HasFront<WriteOnly<int>> &&
              !HasIterators<WriteOnly<int>> && !IsARange<WriteOnly<int>>);
static_assert(!std::is_convertible_v<WriteOnly<int>, std::span<int>> &&
              !std::is_constructible_v<std::span<const int>, WriteOnly<int>>);

TEST(WriteOnly, WritesWhereItIsTold) {
  std::vector<int> memory(10, -1);
  const WriteOnly<int> view{std::span(memory)};
  ASSERT_EQ(view.size(), 10u);
  view.part(0, 3).generate([](std::size_t i) { return static_cast<int>(10 * i); });
  view.write(3, 7);
  view.part(4, 6).copy(std::array{1, 2});
  view.part(8, 2).fill(5);
  EXPECT_EQ(memory, (std::vector{0, 10, 20, 7, 1, 2, -1, -1, 5, 5}));
}

TEST(WriteOnly, ShowsBytesAsWholeElements) {
  alignas(4) std::array<std::byte, 11> memory{};
  const WriteOnly<std::byte> bytes{std::span(memory)};
  const auto words = bytes.part(4, 7).as<std::uint32_t>();
  ASSERT_EQ(words.size(), 1u);
  words.write(0, 0x04030201);
  EXPECT_EQ(memory[4], std::byte{1});
  EXPECT_EQ(memory[7], std::byte{4});
  EXPECT_EQ(
      std::accumulate(memory.begin(), memory.end(), 0, [](int sum, std::byte b) { return sum + int(b); }),
      10);
}

TEST(WriteOnlyDeathTest, RefusesWhatLiesOutside) {
  alignas(4) std::array<int, 4> memory{};
  const WriteOnly<int> view{std::span(memory)};
  EXPECT_DEATH(view.write(4, 1), "an element lies in its view");
  EXPECT_DEATH((void)view.part(2, 3), "a part lies in its view");
  EXPECT_DEATH((void)view.part(5, 0), "a part lies in its view");
  EXPECT_DEATH(view.part(3, 1).copy(std::array{1, 2}), "the values fit the view");
  const WriteOnly<std::byte> bytes{std::as_writable_bytes(std::span(memory))};
  EXPECT_DEATH((void)bytes.part(1, 8).as<int>(), "a view is aligned to its elements");
}

}  // namespace
}  // namespace farshade
