#include "stereo/sealing/layout.h"

#include <gtest/gtest.h>

#include <vector>

#include "stereo/messages/message_codec.h"

namespace farshade {
namespace {

/// A message whose fields a test chooses: `record` has the field list.
unsigned hash_of(const auto& record, ProtocolVersion version = kProtocolVersion) {
  LayoutRecorder io(version);
  record(io);
  return io.hash();
}

TEST(Layout, TheVersionHasTheHashOfAllFields) {
  EXPECT_EQ(layout_hash(kProtocolVersion), kLayoutHash)
      << "the fields have changed: raise kProtocolNumber, set kPreviousVersion and kLayoutHash";
  EXPECT_EQ(number_of(kProtocolVersion), kProtocolNumber);
  EXPECT_EQ(kProtocolVersion & 0x3ff, kLayoutHash);
  check_layout();
}

TEST(Layout, ThePreviousVersionHasTheFieldsThatItHad) {
  EXPECT_EQ(layout_hash(kPreviousVersion), 117u) << "new fields need io.since(kProtocolNumber)";
  EXPECT_LT(number_of(kPreviousVersion), kProtocolNumber);
}

TEST(Layout, ServersSpeakTwoVersions) {
  EXPECT_TRUE(is_spoken(kProtocolVersion));
  EXPECT_TRUE(is_spoken(kPreviousVersion));
  EXPECT_FALSE(is_spoken(kProtocolVersion ^ 1)) << "another layout with the same number";
  EXPECT_FALSE(is_spoken(kProtocolNumber)) << "the number without a hash";
  EXPECT_FALSE(is_spoken(0));
}

TEST(LayoutRecorder, EveryChangeOfFieldsChangesTheHash) {
  std::uint32_t number = 0;
  double real = 0;
  Duration span{};
  enum class Code : std::uint8_t { Any } reason{};
  std::array<std::uint8_t, 16> half{};
  std::array<std::uint8_t, 32> whole{};
  std::span<const std::byte> rest;
  const std::vector<unsigned> hashes{
      hash_of([&](auto& io) { io.u16(number), io.u32(number); }),
      hash_of([&](auto& io) { io.u32(number), io.u16(number); }),
      hash_of([&](auto& io) { io.u16(number), io.u16(number); }),
      hash_of([&](auto& io) { io.u16(number); }),
      hash_of([&](auto& io) { io.u16(number), io.f64(real); }),
      hash_of([&](auto& io) { io.u16(number), io.ns(span); }),
      hash_of([&](auto& io) { io.u16(number), io.code(reason); }),
      hash_of([&](auto& io) { io.u16(number), io.u8(number); }),
      hash_of([&](auto& io) { io.u16(number), io.array(half); }),
      hash_of([&](auto& io) { io.u16(number), io.array(whole); }),
      hash_of([&](auto& io) { io.u16(number), io.rest(rest); }),
      hash_of([&](auto& io) { io.type(1), io.u16(number); }),
      hash_of([&](auto& io) { io.type(2), io.u16(number); }),
  };
  for (std::size_t i = 0; i < hashes.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) EXPECT_NE(hashes[i], hashes[j]) << i << " and " << j;
}

TEST(LayoutRecorder, SeesTheElementsOfListsAndOptionalFields) {
  LayoutRecorder none(kProtocolVersion), any(kProtocolVersion);
  std::uint8_t count = 0;
  none.u8(count);
  any.u8(count);
  ASSERT_GT(count, 0) << "a list is not empty, and each flag is set";
  for (int i = 0; i < count; ++i) any.u32(count);
  EXPECT_NE(none.hash(), any.hash());
}

/// Version 11 added `newer`.
struct Grown {
  std::uint32_t older = 0, newer = 0;
};
bool fields(auto& io, codec::Either<Grown> auto& message) {
  return io.u16(message.older) && (!io.since(11) || io.u8(message.newer));
}

TEST(VersionedFields, AFieldExistsFromItsVersionOn) {
  for (const auto& [version, size] : {std::pair(kPreviousVersion, 2u), std::pair(kProtocolVersion, 3u)}) {
    std::vector<std::byte> bytes;
    ByteWriter out(bytes, version);
    const Grown written{7, 9};
    ASSERT_TRUE(fields(out, written));
    EXPECT_EQ(bytes.size(), size);
    ByteReader in(bytes, version);
    Grown read;
    ASSERT_TRUE(fields(in, read));
    EXPECT_EQ(in.remaining(), 0u);
    EXPECT_EQ(read.older, 7u);
    EXPECT_EQ(read.newer, size == 3 ? 9u : 0u);
  }
  Grown message;
  const auto list = [&](auto& io) { fields(io, message); };
  EXPECT_NE(hash_of(list, kPreviousVersion), hash_of(list, kProtocolVersion));
}

}  // namespace
}  // namespace farshade
