// Requests with positions: the server waits for them until a timeout, and accepts no more than announced.
#include <gtest/gtest.h>

#include "stereo/codec/plane_codec.h"
#include "tests/support/manual_clock.h"
#include "tests/support/virtual_link.h"
#include "tests/unit/link_client.h"

namespace farshade {
namespace {

using namespace std::chrono_literals;
using namespace link_test;

const Welcome kServedPositions{{1, 2, 3}, 3, Welcome{}.most_pixels, kTracedAnswers};
const std::vector<SharedKey> kAda{key_named("ada")};

FrameRequest with_positions(std::uint32_t frame, std::uint32_t slices) {
  FrameRequest request = request_of(frame, {32, 32});
  request.answer = {.kind = Answer::MasksOfPositions, .position_bits = 16, .slices = slices};
  return request;
}

/// A server that records how many position messages each answered request had.
struct PositionsBench {
  explicit PositionsBench(AnswerSet answers = kTracedAnswers) {
    const auto count = [this](const Job& job, FramePacker&) {
      brought.push_back(job.parts.size());
      return AnswerCost{};
    };
    core.emplace(kServedPositions, kAda, answers_from(answers, count), link.server(), clock);
    link.while_waiting(
        [this] {
          while (core->receive(0s)) {
          }
          while (core->work()) {
          }
          core->send_due();
        },
        [this] { return core->next_due(); });
    EXPECT_TRUE(client.connect(1s));
  }

  void say_positions(std::uint32_t frame, std::uint32_t tile = 0) {
    const std::array block{std::byte{1}};
    Bytes message, datagram;
    encode(ClientMessage(PlaneSlice{.frame = {frame},
                                    .kind = PlaneKind::PositionX,
                                    .size = {32, 32},
                                    .word_bytes = 2,
                                    .first_tile = tile,
                                    .tile_count = 1,
                                    .block = block}),
           message);
    client.sealer->seal(message, datagram);
    client.say(datagram);
  }
  void pass(Duration span) {
    const Time until = clock.now() + span;
    while (clock.now() < until) client.hear(until - clock.now());
  }

  ManualClock clock;
  VirtualLink link{clock, {}};
  std::optional<ServerCore> core;
  std::vector<std::size_t> brought;
  PortClient client{link.client(), link.server().local(), kAda[0], kServedPositions};
};

TEST(ServerPositions, ARequestIsAnsweredOnceAllHaveCome) {
  PositionsBench bench;
  bench.client.say(bench.client.ask(with_positions(1, 3)));
  for (std::uint32_t tile = 0; tile < 2; ++tile) bench.say_positions(1, tile);
  bench.pass(1ms);
  EXPECT_TRUE(bench.brought.empty());
  bench.say_positions(1, 2);
  bench.pass(1ms);
  EXPECT_EQ(bench.brought, std::vector<std::size_t>{3});
}

TEST(ServerPositions, AreAwaitedUntilATimeoutAfterTheLastOne) {
  PositionsBench bench;
  bench.client.say(bench.client.ask(with_positions(1, 3)));
  bench.say_positions(1);
  bench.pass(kPartsTimeout - 1ms);
  EXPECT_TRUE(bench.brought.empty());
  bench.pass(2ms);
  EXPECT_EQ(bench.brought, std::vector<std::size_t>{1});
}

TEST(ServerPositions, OfAnotherRequestOrTooManyAreStray) {
  PositionsBench bench;
  bench.say_positions(1);  // before its request
  bench.client.say(bench.client.ask(with_positions(2, 1)));
  bench.say_positions(1);
  bench.pass(1ms);
  EXPECT_EQ(bench.core->counters().sessions.stray, 2u);
  bench.say_positions(2);
  bench.say_positions(2);
  bench.pass(1ms);
  EXPECT_EQ(bench.brought, std::vector<std::size_t>{1});
  EXPECT_EQ(bench.core->counters().sessions.stray, 3u);
  EXPECT_EQ(bench.core->counters().sessions.requests, 1u) << "positions are no requests";
}

TEST(ServerPositions, BlocksAreAskedForWithMasksAndPositionsSentWithTheirOwnKind) {
  PositionsBench bench;
  FrameRequest request = request_of(1, {32, 32});
  request.answer = {.kind = Answer::Masks, .slices = 2};
  const auto say_blocks = [&](std::uint32_t frame, std::uint32_t tile) {
    const std::array block{std::byte{1}};
    Bytes message, datagram;
    encode(ClientMessage(AskSlice{
               .frame = {frame}, .size = {32, 32}, .first_tile = tile, .tile_count = 1, .block = block}),
           message);
    bench.client.sealer->seal(message, datagram);
    bench.client.say(datagram);
  };
  bench.client.say(bench.client.ask(request));
  bench.say_positions(1);
  say_blocks(1, 0);
  bench.pass(1ms);
  EXPECT_TRUE(bench.brought.empty());
  EXPECT_EQ(bench.core->counters().sessions.stray, 1u) << "positions of a request for masks";
  say_blocks(1, 1);
  bench.pass(1ms);
  EXPECT_EQ(bench.brought, std::vector<std::size_t>{2});
  bench.client.say(bench.client.ask(with_positions(2, 1)));
  say_blocks(2, 0);
  bench.pass(1ms);
  EXPECT_EQ(bench.core->counters().sessions.stray, 2u) << "blocks of a request with positions";
}

TEST(ServerPositions, ANewerRequestTakesThePlaceOfOneThatWaitsForThem) {
  PositionsBench bench;
  bench.client.say(bench.client.ask(with_positions(1, 2)));
  bench.say_positions(1);
  bench.client.say(bench.client.ask(with_positions(2, 1)));
  bench.say_positions(2);
  bench.pass(30ms);
  EXPECT_EQ(bench.brought, std::vector<std::size_t>{1});
  EXPECT_EQ(bench.core->counters().sessions.superseded, 1u);
}

TEST(ServerPositions, MoreBytesThanMayWaitAreDropped) {
  PositionsBench bench;
  FrameRequest large = with_positions(1, 65535);
  for (View& view : large.views) view.size = {1024, 1024};
  bench.client.say(bench.client.ask(large));
  const Bytes full(kBaseMessage_bytes - kPlaneSliceHeader_bytes, std::byte{1});
  Bytes message, datagram;
  for (std::size_t i = 0; i * kBaseMessage_bytes < kMostParts_bytes + 100 * kBaseMessage_bytes; ++i) {
    encode(ClientMessage(PlaneSlice{.frame = {1},
                                    .kind = PlaneKind::PositionX,
                                    .size = {1024, 1024},
                                    .tile_count = 1,
                                    .block = full}),
           message);
    bench.client.sealer->seal(message, datagram);
    bench.client.say(datagram);
    if (i % 64 == 0)
      while (bench.core->receive(0s)) {
      }
  }
  while (bench.core->receive(0s)) {
  }
  EXPECT_EQ(bench.core->counters().sessions.stray, 101u);
}

/// Each tile that is decoded costs the worker time, however few bytes it has.
TEST(ServerPositions, MoreTilesThanTheRequestedViewsHaveAreDropped) {
  PositionsBench bench;
  bench.client.say(bench.client.ask(with_positions(1, 65535)));
  const auto say = [&](Extent size, std::uint32_t tiles, PlaneKind kind = PlaneKind::PositionX) {
    const std::array block{std::byte{1}};
    Bytes message, datagram;
    encode(ClientMessage(
               PlaneSlice{.frame = {1}, .kind = kind, .size = size, .tile_count = tiles, .block = block}),
           message);
    bench.client.sealer->seal(message, datagram);
    bench.client.say(datagram);
  };
  say({8192, 8192}, 65535);
  say({32, 32}, 4, PlaneKind::Depth);
  bench.pass(1ms);
  EXPECT_EQ(bench.core->counters().sessions.stray, 2u) << "of another size, and no positions";
  for (int i = 0; i < 100; ++i) say({32, 32}, 4);
  bench.pass(1s);
  EXPECT_EQ(bench.brought, std::vector<std::size_t>{6}) << "two eyes with three coordinates of four tiles";
  EXPECT_EQ(bench.core->counters().sessions.stray, 2u + 94u);
}

TEST(ServerPositions, OfAnotherSizeThanTheRequestedViewAreStray) {
  PositionsBench bench;
  FrameRequest request = with_positions(1, 2);
  request.views[1].size = {32, 48};
  bench.client.say(bench.client.ask(request));
  const auto say = [&](Side eye, Extent size) {
    const std::array block{std::byte{1}};
    Bytes message, datagram;
    encode(ClientMessage(PlaneSlice{.frame = {1},
                                    .eye = eye,
                                    .kind = PlaneKind::PositionX,
                                    .size = size,
                                    .word_bytes = 2,
                                    .tile_count = 1,
                                    .block = block}),
           message);
    bench.client.sealer->seal(message, datagram);
    bench.client.say(datagram);
  };
  say(Side::Left, {32, 48});
  say(Side::Right, {32, 32});
  bench.pass(1ms);
  EXPECT_EQ(bench.core->counters().sessions.stray, 2u);
  say(Side::Left, {32, 32});
  say(Side::Right, {32, 48});
  bench.pass(1ms);
  EXPECT_EQ(bench.core->counters().sessions.stray, 2u);
  EXPECT_EQ(bench.brought, std::vector<std::size_t>{2});
}

TEST(ServerAnswers, PicturesOfEyesOfTwoSizesAreNotDrawn) {
  PositionsBench bench(kEveryAnswer);
  FrameRequest request = request_of(1, {32, 32});
  request.answer.kind = Answer::GBuffer;
  bench.client.say(bench.client.ask(request));
  bench.pass(5ms);
  EXPECT_EQ(bench.brought.size(), 1u) << "eyes of one size are drawn";
  request.frame = {2};
  request.views[1].size = {32, 31};
  bench.client.say(bench.client.ask(request));
  bench.pass(5ms);
  EXPECT_EQ(bench.brought.size(), 1u);
  EXPECT_EQ(bench.core->counters().sessions.unanswered, 1u);
}

TEST(ServerAnswers, RequestsForAnswersThatAreNotOfferedAreCountedAndNotAnswered) {
  PositionsBench bench;
  FrameRequest request = request_of(1, {32, 32});
  request.answer.kind = Answer::GBuffer;
  bench.client.say(bench.client.ask(request));
  bench.pass(5ms);
  EXPECT_TRUE(bench.brought.empty());
  EXPECT_EQ(bench.core->counters().sessions.unanswered, 1u);
}

}  // namespace
}  // namespace farshade
