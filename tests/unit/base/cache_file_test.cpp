#include "stereo/base/cache_file.h"

#include <gtest/gtest.h>

#include <array>
#include <fstream>

#include "tests/unit/scratch_folder.h"

namespace farshade {
namespace {

constexpr std::uint64_t kMostBytes = 1000;

std::vector<std::byte> some_bytes(std::size_t count) {
  std::vector<std::byte> bytes(count);
  for (std::size_t i = 0; i < count; ++i) bytes[i] = static_cast<std::byte>(i * 7);
  return bytes;
}

TEST(CacheFile, GivesBackWhatWasWritten) {
  const ScratchFolder folder;
  const auto path = folder.path() / "made" / "on demand" / "file";
  for (const std::size_t size : {0u, 1u, 500u}) {
    ASSERT_TRUE(write_cache_file(path, some_bytes(size)));
    EXPECT_EQ(read_cache_file(path, kMostBytes).value(), some_bytes(size));
  }
}

TEST(CacheFile, IsMissingBeforeItIsWritten) {
  const ScratchFolder folder;
  EXPECT_EQ(read_cache_file(folder.path() / "file", kMostBytes).error().fault, Fault::Missing);
}

TEST(CacheFile, RefusesEveryFlippedByteAndEveryShorterFile) {
  const ScratchFolder folder;
  const auto path = folder.path() / "file";
  ASSERT_TRUE(write_cache_file(path, some_bytes(50)));
  const std::vector<std::byte> whole = read_file(path, kMostBytes).value();
  for (std::size_t i = 0; i < whole.size(); ++i) {
    std::vector<std::byte> broken = whole;
    broken[i] ^= std::byte{1};
    ASSERT_TRUE(write_file_atomically(path, broken));
    EXPECT_EQ(read_cache_file(path, kMostBytes).error().fault, Fault::Malformed) << i;
    ASSERT_TRUE(write_file_atomically(path, std::span(whole).first(i)));
    EXPECT_EQ(read_cache_file(path, kMostBytes).error().fault, Fault::Malformed) << i;
  }
}

TEST(CacheFile, SaysWhereItCannotBeWritten) {
  const ScratchFolder folder;
  const auto path = folder.path() / "taken" / "file";
  std::ofstream(path.parent_path()) << "a file where the folder should be";
  const auto written = write_cache_file(path, some_bytes(5));
  ASSERT_FALSE(written);
  EXPECT_NE(written.error().what.find(path.string()), std::string::npos) << written.error().what;
}

TEST(CacheName, IsHexadecimal) {
  const std::array<std::uint8_t, 3> key{0x01, 0xAF, 0x90};
  EXPECT_EQ(cache_name(key), "01af90");
  EXPECT_EQ(cache_name({}), "");
}

}  // namespace
}  // namespace farshade
