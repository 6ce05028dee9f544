// The examples in PROTOCOL.md are the golden bytes. The encoder must write them and the decoder must read
// them, so that document, encoder and decoder stay equal.
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>
#include <string>

#include "stereo/codec/mask_block.h"
#include "stereo/sealing/handshake.h"
#include "tests/unit/messages/samples.h"

namespace farshade {
namespace {

using namespace wire_samples;

/// The bytes of the block "```hex NAME". A line has bytes in hex, two spaces, and their meaning.
Bytes example(const std::string& name) {
  std::ifstream page(FARSHADE_SOURCE "/stereo/messages/PROTOCOL.md");
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

/// The document omits the zeros.
Bytes padded(Bytes bytes) {
  bytes.resize(kBaseDatagram_bytes);
  return bytes;
}

TEST(Protocol, HelloIsAsThePageSays) {
  const Bytes bytes = padded(example("hello"));
  EXPECT_EQ(enveloped(hello()), bytes);
  EXPECT_EQ(std::get<Hello>(*open_client_envelope(bytes)), hello());
  EXPECT_TRUE(is_proved(hello(), bytes, shared_key()));
}

TEST(Protocol, RetryIsAsThePageSays) {
  EXPECT_EQ(enveloped(retry()), example("retry"));
  EXPECT_EQ(std::get<Retry>(*open_server_envelope(example("retry"))), retry());
}

TEST(Protocol, OpenRefusalIsAsThePageSays) {
  EXPECT_EQ(enveloped(open_refusal()), example("open-refusal"));
  EXPECT_EQ(std::get<OpenRefusal>(*open_server_envelope(example("open-refusal"))), open_refusal());
}

TEST(Protocol, AcceptBeginsAsThePageSays) {
  EXPECT_EQ(enveloped(accept_sample({})), example("accept"));
}

TEST(Protocol, NoSessionIsAsThePageSays) {
  EXPECT_EQ(enveloped(no_session()), example("no-session"));
  EXPECT_EQ(std::get<NoSession>(*open_server_envelope(example("no-session"))), no_session());
}

/// The bytes in the document were made without this library, with ChaCha20-Poly1305 as RFC 8439 defines it.
TEST(Protocol, SealedIsAsThePageSays) {
  const Secret key(counting<32>(0x80));
  Sealer sealer(SessionId{0x0807060504030201}, key, Sealing::On);
  const Bytes message = encoded(ServerMessage(probe()));
  Bytes datagram;
  for (std::uint64_t counter = 0; counter <= 258; ++counter) sealer.seal(message, datagram);
  EXPECT_EQ(datagram, example("sealed"));

  const Bytes bytes = example("sealed");
  Opener opener(key, Sealing::On);
  Bytes opened;
  ASSERT_TRUE(opener.open(std::get<Sealed>(*open_server_envelope(bytes)), bytes, opened));
  EXPECT_EQ(std::get<Probe>(*decode_server(opened)), probe());
}

TEST(Protocol, RequestIsAsThePageSays) {
  EXPECT_EQ(encoded(ClientMessage(request())), example("request"));
  const auto read = std::get<RequestMessage>(*decode_client(example("request")));
  EXPECT_EQ(read.request.frame, request().request.frame);
  EXPECT_EQ(read.newest_received, request().newest_received);
  EXPECT_EQ(read.request.display_time, request().request.display_time);
  EXPECT_EQ(read.request.scene_time, request().request.scene_time);
  EXPECT_EQ(read.request.views, request().request.views);
  EXPECT_EQ(read.request.lights, request().request.lights);
  EXPECT_EQ(read.request.answer, request().request.answer);
  EXPECT_EQ(read.probe_echo, request().probe_echo);
  EXPECT_EQ(read.arrivals.first, request().arrivals.first);
  EXPECT_EQ(read.arrivals.base, request().arrivals.base);
  EXPECT_EQ(read.arrivals.count, request().arrivals.count);
  EXPECT_EQ(read.arrivals.ticks, request().arrivals.ticks);
}

TEST(Protocol, AskSliceIsAsThePageSays) {
  EXPECT_EQ(ask_sample(), example("ask-slice"));
  const Bytes bytes = example("ask-slice");
  std::vector<RequestedTile> requested(4);
  ReceivedTiles known(4);
  EXPECT_EQ(decode_ask_slice(std::get<AskSlice>(*decode_client(bytes)), requested, known).value(), 4u);
  EXPECT_EQ(requested, kSampleRequested);
}

/// The document lists the probabilities with which the coders start.
TEST(Protocol, InitialProbabilitiesAreAsThePageSays) {
  const auto as_bytes = [](const auto& numbers) {
    const auto bytes = std::as_bytes(std::span(numbers));
    return Bytes(bytes.begin(), bytes.end());
  };
  EXPECT_EQ(as_bytes(kInitialMaskModels), example("mask-models"));
  EXPECT_EQ(as_bytes(kInitialAskModels), example("ask-models"));
  EXPECT_EQ(as_bytes(kLikelyBits), example("likely-bits"));
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

TEST(Protocol, ProbeIsAsThePageSays) {
  EXPECT_EQ(encoded(ServerMessage(probe())), example("probe"));
  EXPECT_EQ(std::get<Probe>(*decode_server(example("probe"))), probe());
}

TEST(Protocol, MaskBlockIsAsThePageSays) {
  ShadowFrame frame = frame_of(EyeMask({3, 2}, 2), EyeMask({3, 2}, 2));
  frame.masks[0].set_word(1, 0, 0, 1);
  frame.masks[0].set_word(0, 1, 0, 2);
  frame.masks[1].set_word(2, 1, 0, 2);
  EXPECT_EQ(pack_mask_block(frame), example("mask-block"));
  PerEye<EyeMask> masks{EyeMask({3, 2}, 2), EyeMask({3, 2}, 2)};
  EXPECT_TRUE(decode_mask_block(example("mask-block"), {2}, masks));
  EXPECT_EQ(masks, frame.masks);
}

TEST(Protocol, LeaveAndGoodbyeAreAsThePageSays) {
  EXPECT_EQ(encoded(ClientMessage(Leave{})), example("leave"));
  EXPECT_EQ(std::get<Leave>(*decode_client(example("leave"))), Leave{});
  EXPECT_EQ(encoded(ServerMessage(Goodbye{EndReason::Expired})), example("goodbye"));
  EXPECT_EQ(std::get<Goodbye>(*decode_server(example("goodbye"))), Goodbye{EndReason::Expired});
}

TEST(Protocol, PathProbeIsAsThePageSays) {
  EXPECT_EQ(encoded(ServerMessage(path_probe())), example("path-probe"));
  const Bytes bytes = example("path-probe");
  EXPECT_EQ(std::get<PathProbe>(*decode_server(bytes)).padding.size(), 3u);
}

TEST(Protocol, PlaneSliceIsAsThePageSays) {
  EXPECT_EQ(encoded(ServerMessage(plane_slice())), example("plane-slice"));
  EXPECT_EQ(encoded(ClientMessage(plane_slice())), example("plane-slice"));
  const Bytes bytes = example("plane-slice");
  const auto read = std::get<PlaneSlice>(*decode_client(bytes));
  EXPECT_EQ(read.frame, plane_slice().frame);
  EXPECT_EQ(read.eye, Side::Right);
  EXPECT_EQ(read.kind, PlaneKind::Depth);
  EXPECT_EQ(read.size, (Extent{20, 18}));
  EXPECT_EQ(read.word_bytes, 4u);
  EXPECT_EQ(read.first_tile, 1u);
  EXPECT_EQ(read.tile_count, 2u);
  EXPECT_TRUE(std::ranges::equal(read.block, kThreeBytes));
}

TEST(Protocol, VideoPartIsAsThePageSays) {
  EXPECT_EQ(encoded(ServerMessage(video_part())), example("video-part"));
  const Bytes bytes = example("video-part");
  const auto read = std::get<VideoPart>(*decode_server(bytes));
  EXPECT_EQ(read.frame, video_part().frame);
  EXPECT_EQ(read.after, video_part().after);
  EXPECT_EQ(read.part, 2u);
  EXPECT_EQ(read.parts, 3u);
  EXPECT_TRUE(std::ranges::equal(read.bytes, kThreeBytes));
}

TEST(Protocol, SliceIsAsThePageSays) {
  const ShadowFrame frame = small_frame();
  const auto messages = packed(frame, Side::Right);
  ASSERT_EQ(messages.size(), 1u);
  EXPECT_EQ(messages[0], example("slice"));

  const Bytes bytes = example("slice");
  EyeMask mask({20, 18}, 2);
  ReceivedTiles known(4);
  EXPECT_EQ(decode_slice_tiles(std::get<Slice>(*decode_server(bytes)), {}, mask, known).value(), 4u);
  EXPECT_EQ(mask, frame.masks[1]);
  EXPECT_EQ(known, ReceivedTiles(4, 1));
}

}  // namespace
}  // namespace farshade
