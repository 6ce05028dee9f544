// PROTOCOL.md's examples are the goldens: its bytes are read here and compared both ways, so that the page,
// the encoder and the decoder cannot drift apart.
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>
#include <string>

#include "wire_samples.h"

namespace farshade {
namespace {

using namespace wire_samples;

/// The bytes of the page's block "```hex NAME": a line is bytes in hex, two spaces, and what they mean.
Bytes example(const std::string& name) {
  std::ifstream page(FARSHADE_SOURCE "/stereo/wire/PROTOCOL.md");
  EXPECT_TRUE(page) << "PROTOCOL.md is missing";
  Bytes bytes;
  std::string line;
  while (std::getline(page, line) && line != "```hex " + name) {
  }
  while (std::getline(page, line) && line != "```") {
    std::istringstream digits(line.substr(0, line.find("  ")));
    for (std::string byte; digits >> byte;)
      bytes.push_back(static_cast<std::byte>(std::stoul(byte, nullptr, 16)));
  }
  EXPECT_FALSE(bytes.empty()) << "PROTOCOL.md has no example " << name;
  return bytes;
}

TEST(Protocol, HelloIsAsThePageSays) {
  EXPECT_EQ(encoded(ClientMessage(hello())), example("hello"));
  EXPECT_EQ(std::get<Hello>(*decode_client(example("hello"))), hello());
}

TEST(Protocol, RequestIsAsThePageSays) {
  EXPECT_EQ(encoded(ClientMessage(request())), example("request"));
  const auto read = std::get<RequestMessage>(*decode_client(example("request")));
  EXPECT_EQ(read.request.frame, request().request.frame);
  EXPECT_EQ(read.newest_received, request().newest_received);
  EXPECT_EQ(read.request.display_time, request().request.display_time);
  EXPECT_EQ(read.request.scene_time, request().request.scene_time);
  EXPECT_EQ(read.request.views, request().request.views);
}

TEST(Protocol, WelcomeIsAsThePageSays) {
  EXPECT_EQ(encoded(ServerMessage(welcome())), example("welcome"));
  EXPECT_EQ(std::get<Welcome>(*decode_server(example("welcome"))), welcome());
}

TEST(Protocol, RefusalIsAsThePageSays) {
  EXPECT_EQ(encoded(ServerMessage(refusal())), example("refusal"));
  EXPECT_EQ(std::get<Refusal>(*decode_server(example("refusal"))), refusal());
}

TEST(Protocol, FrameReportIsAsThePageSays) {
  EXPECT_EQ(encoded(ServerMessage(report())), example("frame-report"));
  EXPECT_EQ(std::get<FrameReport>(*decode_server(example("frame-report"))), report());
}

TEST(Protocol, SliceIsAsThePageSays) {
  const ShadowFrame frame = small_frame();
  const auto datagrams = packed(frame, Side::Right);
  ASSERT_EQ(datagrams.size(), 1u);
  EXPECT_EQ(datagrams[0], example("slice"));

  const Bytes bytes = example("slice");
  EyeMask mask({20, 18}, 2);
  KnownTiles known(4);
  EXPECT_EQ(decode_slice_tiles(std::get<Slice>(*decode_server(bytes)), mask, known).value(), 4u);
  EXPECT_EQ(mask, frame.masks[1]);
  EXPECT_EQ(known, KnownTiles(4, 1));
}

}  // namespace
}  // namespace farshade
