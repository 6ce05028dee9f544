#include "stereo/messages/bytes.h"

#include <gtest/gtest.h>

#include "tests/unit/messages/samples.h"

namespace farshade {
namespace {

using namespace wire_samples;

TEST(ByteWriter, PutsTheLowestByteFirst) {
  Bytes bytes;
  ByteWriter out(bytes);
  out.u8(0x01);
  out.u16(0x0203);
  out.u32(0x04050607u);
  out.ns(Duration(-2));
  out.f64(1.0);
  EXPECT_EQ(bytes, bytes_of({0x01, 0x03, 0x02, 0x07, 0x06, 0x05, 0x04, 0xfe, 0xff, 0xff, 0xff, 0xff,
                             0xff, 0xff, 0xff, 0,    0,    0,    0,    0,    0,    0xf0, 0x3f}));
}

TEST(ByteWriterDeathTest, StopsAtAValueItsFieldCannotHold) {
  Bytes bytes;
  EXPECT_DEATH(ByteWriter(bytes).u16(65536), "narrowing keeps the value");
  EXPECT_DEATH(ByteWriter(bytes).u8(-1), "narrowing keeps the value");
}

TEST(ByteReader, ChangesNothingBeyondTheEnd) {
  const Bytes bytes = bytes_of({1, 2, 3});
  ByteReader in(bytes);
  std::uint32_t word = 77;
  std::uint64_t number = 78;
  std::array<std::uint8_t, 4> four{};
  EXPECT_FALSE(in.u32(word));
  EXPECT_FALSE(in.u64(number));
  EXPECT_FALSE(in.array(four));
  EXPECT_EQ(word, 77u);
  EXPECT_EQ(number, 78u);
  EXPECT_EQ(in.remaining(), 3u);
  EXPECT_TRUE(in.u16(word));
  EXPECT_EQ(word, 0x0201u);
  EXPECT_FALSE(in.u16(word));
  EXPECT_TRUE(in.u8(word));
  EXPECT_EQ(word, 3u);
}

TEST(ByteReader, RestIsAViewOfWhatIsLeft) {
  const Bytes bytes = bytes_of({1, 2, 3});
  ByteReader in(bytes);
  std::uint8_t first = 0;
  std::span<const std::byte> rest;
  ASSERT_TRUE(in.u8(first) && in.rest(rest));
  EXPECT_EQ(rest.data(), bytes.data() + 1);
  EXPECT_EQ(rest.size(), 2u);
  EXPECT_EQ(in.remaining(), 0u);
}

}  // namespace
}  // namespace farshade
