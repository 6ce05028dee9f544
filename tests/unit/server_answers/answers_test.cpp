// Answers of a server, without a client: answers after a loss, and answers that cannot be made.
#include <gtest/gtest.h>

#include <random>

#include "rt_server/answers/answer_renderer.h"
#include "rt_server/answers/video.h"
#include "stereo/answers/assembler.h"
#include "stereo/base/check.h"
#include "stereo/codec/ask_coder.h"
#include "stereo/frame/tiles.h"
#include "stereo/gltf/gltf.h"

namespace farshade {
namespace {

constexpr Extent kEye{64, 48};

PerEye<Image<Rgb8>> grey(Extent eye, std::uint8_t level) {
  PerEye<Image<Rgb8>> eyes{Image<Rgb8>(eye), Image<Rgb8>(eye)};
  for (Image<Rgb8>& image : eyes) std::ranges::fill(image.pixels, Rgb8(level));
  return eyes;
}

struct Coded {
  FrameId after;
  std::vector<std::byte> unit;
  std::vector<std::vector<std::byte>> parts;
};

/// No value if the unit could not be sent.
std::optional<Coded> code(Streams& streams, FrameId frame, const PerEye<Image<Rgb8>>& eyes,
                          Coding coding = Coding::AfterLast, std::uint64_t session = 1) {
  Job job{};
  job.session = {session};
  job.request.frame = frame;
  job.request.answer = {.kind = Answer::Video,
                        .bits_per_second = kMostVideo_bits,
                        .interval = std::chrono::seconds(10),
                        .coding = coding};
  FramePacker packer;
  packer.begin();
  try {
    streams.code(job, eyes, packer);
  } catch (const std::runtime_error&) {
    return std::nullopt;
  }
  Coded coded{};
  for (const std::vector<std::byte>& message : packer.finish({.frame = frame})) {
    const Decoded<ServerMessage> decoded = decode_server(message);
    const auto* const part = decoded ? std::get_if<VideoPart>(&*decoded) : nullptr;
    if (part == nullptr) continue;
    coded.after = part->after;
    coded.unit.insert(coded.unit.end(), part->bytes.begin(), part->bytes.end());
    coded.parts.emplace_back(part->bytes.begin(), part->bytes.end());
  }
  return coded;
}

class StreamsCode : public testing::Test {
 protected:
  void SetUp() override {
    if (!has_video()) GTEST_SKIP() << video_version();
  }
  Streams streams_{kMemory_bytes};
};

TEST_F(StreamsCode, ARequestedKeyFrameDependsOnNoPicture) {
  EXPECT_EQ(code(streams_, {1}, grey(kEye, 40))->after, FrameId{1}) << "the first is a key frame in any case";
  const Coded next = *code(streams_, {2}, grey(kEye, 90));
  EXPECT_EQ(next.after, FrameId{1});
  const Coded alone = *code(streams_, {3}, grey(kEye, 140), Coding::Alone);
  EXPECT_EQ(alone.after, FrameId{3});
  const auto late = VideoDecoder::create().value();
  EXPECT_FALSE(late->decode(next.unit, side_by_side_size(kEye))) << "depends on the first";
  const Image<Rgb8>* const shown = late->decode(alone.unit, side_by_side_size(kEye)).value();
  EXPECT_NEAR(shown->at(5, 5).g, 140, 2);
}

/// Between two pictures, requests of other kinds may move the numbers of frames by half of their range,
/// twice.
TEST_F(StreamsCode, APictureThatIsNotNewerThanTheLastDependsOnNone) {
  const auto decoder = VideoDecoder::create().value();
  std::uint8_t level = 40;
  for (const std::uint32_t frame :
       {0u, 0xffffffffu, 0x7fffffffu, 0xffffffffu, 0x7fffffffu, 0x7fffffffu, 0x7ffffffeu}) {
    level = static_cast<std::uint8_t>(level + 20);
    const Coded coded = *code(streams_, {frame}, grey(kEye, level));
    EXPECT_EQ(coded.after, FrameId{frame});
    EXPECT_NEAR(decoder->decode(coded.unit, side_by_side_size(kEye)).value()->at(5, 5).g, level, 2);
  }
  EXPECT_EQ(code(streams_, {0x7fffffff}, grey(kEye, 90))->after, FrameId{0x7ffffffe});
}

TEST_F(StreamsCode, EachSessionHasItsOwn) {
  EXPECT_EQ(code(streams_, {7}, grey(kEye, 40))->after, FrameId{7});
  EXPECT_EQ(code(streams_, {9}, grey(kEye, 40), Coding::AfterLast, 2)->after, FrameId{9});
  EXPECT_EQ(code(streams_, {8}, grey(kEye, 40))->after, FrameId{7});
}

TEST_F(StreamsCode, AnotherSizeBeginsAnew) {
  EXPECT_EQ(code(streams_, {1}, grey(kEye, 40))->after, FrameId{1});
  EXPECT_EQ(code(streams_, {2}, grey({96, 48}, 40))->after, FrameId{2});
}

/// So what has come can be decoded although other parts are lost.
TEST_F(StreamsCode, EachPartBeginsWithASlice) {
  PerEye<Image<Rgb8>> noise = grey({256, 256}, 0);
  std::mt19937 random(7);
  for (std::uint32_t frame = 1; frame <= 30; ++frame) {
    for (Image<Rgb8>& image : noise)
      for (Rgb8& pixel : image.pixels) pixel = Rgb8(static_cast<std::uint8_t>(100 + random() % 60));
    const Coded coded = *code(streams_, {frame}, noise);
    ASSERT_GT(coded.parts.size(), 10u);
    for (const std::vector<std::byte>& part : coded.parts) {
      const bool is_long = part[2] == std::byte{0};
      EXPECT_EQ(part[0], std::byte{0});
      EXPECT_EQ(part[1], std::byte{0});
      EXPECT_EQ(part[is_long ? 3 : 2], std::byte{1}) << "frame " << frame;
    }
  }
}

/// The encoder continues after a picture that had too many bytes to send; the client must be told.
TEST_F(StreamsCode, ThePictureAfterOneTooLargeToSendDependsOnIt) {
  constexpr Extent large{2048, 2048};
  PerEye<Image<Rgb8>> noise = grey(large, 0);
  std::mt19937 random(7);
  for (Image<Rgb8>& image : noise)
    for (Rgb8& pixel : image.pixels) pixel = Rgb8(random() & 255, random() & 255, random() & 255);
  EXPECT_EQ(code(streams_, {1}, grey(large, 90))->after, FrameId{1});
  EXPECT_FALSE(code(streams_, {2}, noise)) << "larger than the parts of a frame";
  EXPECT_EQ(code(streams_, {3}, grey(large, 90))->after, FrameId{2});
}

class ServerAnswers : public testing::Test {
 protected:
  ServerAnswers() {
    for (View& view : job_.request.views) view = {{}, {-0.7, 0.8, 0.6, -0.5}, {256, 192}};
    job_.request.frame = {1};
  }

  /// The picture of a client that receives everything.
  const RequestRecord& received() {
    packer_.begin();
    answers_.answer(job_, packer_, {});
    assembler_ = Assembler();
    assembler_.expect(job_.request, {lights_}, kFirstLightSet);
    for (const std::vector<std::byte>& message : packer_.finish({.frame = job_.request.frame})) {
      const Decoded<ServerMessage> decoded = decode_server(message);
      if (const auto* slice = decoded ? std::get_if<Slice>(&*decoded) : nullptr) assembler_.accept(*slice);
      if (const auto* part = decoded ? std::get_if<VideoPart>(&*decoded) : nullptr) assembler_.accept(*part);
    }
    return *assembler_.find(job_.request.frame);
  }

  Scene scene_ = load_scene(FARSHADE_ASSETS "/room.glb").value();
  std::uint32_t lights_ = narrow<std::uint32_t>(scene_.lights.size());
  ScenePlan plan_ = plan_for(scene_, {.all_lights = true});
  Tracer tracer_ = Tracer::create(scene_, plan_.trace).value();
  RequestHandlers answers_ = make_answers({.scene = scene_, .plan = plan_, .tracer = tracer_});
  Job job_{};
  FramePacker packer_;
  Assembler assembler_;
};

/// A tile is traced only if all three coordinates of this request have arrived.
TEST_F(ServerAnswers, MasksOfPositionsCoverOnlyReceivedPositions) {
  constexpr std::array kAxes{PlaneKind::PositionX, PlaneKind::PositionY, PlaneKind::PositionZ};
  job_.request.answer = {.kind = Answer::MasksOfPositions, .position_bits = 14};
  const PositionGrid grid = grid_of({scene_.bounds.low}, {scene_.bounds.high}, 14);
  PositionPlanes planes;
  PlanePacker packer;
  std::mt19937 random(3);  // noise packs badly and needs several slices
  std::vector<float> distances_m(job_.request.views[0].size.pixels());
  for (float& distance : distances_m) distance = 1 + static_cast<float>(random() % 1000) / 1000;
  std::uint32_t lost_from = 0, lost = 0;
  std::vector<std::byte> of_left_y;
  for (const Side side : kSides) {
    const View& view = job_.request.views[index_of(side)];
    positions_of(view, distances_m, grid, planes);
    for (std::size_t axis = 0; axis < kAxes.size(); ++axis) {
      packer.start(job_.request.frame, side, kAxes[axis], planes[axis]);
      while (const std::optional<PlaneSlice> slice = packer.next()) {
        std::vector<std::byte> message;
        encode(ClientMessage(*slice), message);
        const bool losable = side == Side::Left && axis == 1 && of_left_y.empty();
        if (losable) of_left_y = message, lost_from = slice->first_tile, lost = slice->tile_count;
        if (!losable) job_.parts.push_back(message);
      }
    }
  }
  const RequestRecord& part = received();
  EXPECT_TRUE(part.complete(Side::Right));
  ASSERT_LT(lost, part.received_tiles[0].size()) << "a slice holds only a part of the eye";
  for (std::uint32_t tile = 0; tile < part.received_tiles[0].size(); ++tile)
    EXPECT_EQ(part.received_tiles[0][tile] != 0, tile < lost_from || tile >= lost_from + lost) << tile;
  job_.parts.push_back(of_left_y);
  EXPECT_TRUE(received().complete(Side::Left));
  job_.parts.clear();
  EXPECT_FALSE(received().anything_known()) << "nothing of the earlier request is left";
}

TEST_F(ServerAnswers, ABlockHasTheMasksOfTheSlices) {
  job_.request.views[1].stage_from_eye.translation.x = 0.5;
  const PerEye<EyeMask> truth = received().masks;
  EXPECT_NE(truth[0], truth[1]);
  job_.request.answer.coding = Coding::Lz4;
  const RequestRecord& block = received();
  EXPECT_TRUE(block.complete());
  EXPECT_EQ(block.masks, truth);
  EXPECT_GT(block.video.parts_known, 1u);
  EXPECT_EQ(assembler_.counters().refused.total(), 0u);
}

/// Only what has come in AskSlices is traced and sent.
TEST_F(ServerAnswers, MasksOfRequestedBlocksCoverOnlyReceivedAskSlices) {
  std::mt19937 random(5);  // noise packs badly and needs several slices
  for (View& view : job_.request.views) view.size = {1024, 1024};
  const PerEye<EyeMask> truth = received().masks;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> lost;
  AskPacker packer;
  RequestedBlocks requested;
  for (const Side side : kSides) {
    std::vector<RequestedTile>& tiles = requested.tiles[index_of(side)];
    tiles.resize(TileGrid{job_.request.views[0].size}.count());
    for (RequestedTile& tile : tiles)
      for (std::uint32_t share = 0; share < shares_of(lights_); ++share)
        tile.shares[share] = static_cast<BlockBits>(random() & random());
    packer.start(job_.request.frame, side, job_.request.views[0].size, lights_, tiles);
    while (const std::optional<AskSlice> slice = packer.next()) {
      ++job_.request.answer.slices;
      const bool is_lost = side == Side::Left && slice->first_tile > 0 && lost.empty();
      if (is_lost)
        lost.emplace_back(slice->first_tile, slice->first_tile + slice->tile_count);
      else
        encode(ClientMessage(*slice), job_.parts.emplace_back());
    }
  }
  ASSERT_EQ(lost.size(), 1u) << "an eye needs several slices";
  // The client knows what it has asked for; the server must find out.
  FrameRequest expected = job_.request;
  expected.requested = requested;
  packer_.begin();
  answers_.answer(job_, packer_, {});
  Assembler assembler;
  assembler.expect(expected, {lights_}, kFirstLightSet);
  for (const std::vector<std::byte>& message : packer_.finish({.frame = job_.request.frame})) {
    const Decoded<ServerMessage> decoded = decode_server(message);
    if (const auto* slice = decoded ? std::get_if<Slice>(&*decoded) : nullptr) assembler.accept(*slice);
  }
  const RequestRecord& part = *assembler.find(job_.request.frame);
  EXPECT_TRUE(part.complete(Side::Right));
  const TileGrid grid{truth[0].size()};
  for (std::size_t eye = 0; eye < kEyes; ++eye)
    for (std::uint32_t tile = 0; tile < grid.count(); ++tile) {
      const bool is_lost = eye == 0 && tile >= lost[0].first && tile < lost[0].second;
      if (requested.at(eye, tile) == kNoBlocks) continue;
      ASSERT_EQ(part.received_tiles[eye][tile] != 0, !is_lost) << tile;
      const TileRect rect = grid.rect(tile);
      std::size_t wrong = 0;
      for (std::uint32_t y = rect.y0; y < rect.y1; ++y)
        for (std::uint32_t x = rect.x0; x < rect.x1; ++x) {
          const auto block = std::countr_zero(block_bit(x - rect.x0, y - rect.y0));
          const std::uint32_t come =
              is_lost ? 0 : requested.tiles[eye][tile].at(static_cast<std::uint32_t>(block));
          wrong += part.masks[eye].word(x, y) != (truth[eye].word(x, y) & come);
        }
      ASSERT_EQ(wrong, 0u) << tile;
    }
}

/// Pictures after a device loss equal those before it.
TEST_F(ServerAnswers, AReopenedDeviceDrawsTheSamePicture) {
  AnswerRenderer renderer({.scene = scene_, .plan = plan_, .tracer = tracer_});
  if (const Expected<void> can = renderer.can_draw(); !can) GTEST_SKIP() << can.error().what;
  const PerEye<Image<Rgb8>> before = renderer.draw(job_).renderer.read_shown();
  ASSERT_TRUE(renderer.reopen());
  const PerEye<Image<Rgb8>> after = renderer.draw(job_).renderer.read_shown();
  for (std::size_t eye = 0; eye < kEyes; ++eye) EXPECT_EQ(before[eye].pixels, after[eye].pixels) << eye;
}

/// A guard band changes the size of pictures, and a hostile client may change it with each request. A
/// renderer is kept while its memory lasts; a size that comes back gives the same picture.
TEST_F(ServerAnswers, SizesThatComeBackGiveTheSamePicture) {
  constexpr MemoryShare small{.limit_bytes = 64 << 20};
  AnswerRenderer renderer({.scene = scene_, .plan = plan_, .tracer = tracer_, .memory = small});
  if (const Expected<void> can = renderer.can_draw(); !can) GTEST_SKIP() << can.error().what;
  const auto drawn = [&](std::uint32_t width) {
    for (View& view : job_.request.views) view.size = {width, 48};
    return renderer.draw(job_).renderer.read_shown();
  };
  std::vector<PerEye<Image<Rgb8>>> first;
  constexpr std::uint32_t sizes = 6;  // more than are kept
  for (std::uint32_t i = 0; i < sizes; ++i) first.push_back(drawn(48 + 16 * i));
  for (std::uint32_t i = 0; i < sizes; ++i) EXPECT_EQ(drawn(48 + 16 * i), first[i]) << i;
}

/// Clients of many sizes take turns without a renderer or an encoder being made anew.
TEST_F(ServerAnswers, SizesOfManyClientsAreKept) {
  if (!has_video()) GTEST_SKIP() << video_version();
  const auto renderer =
      std::make_shared<AnswerRenderer>(AnswerContext{.scene = scene_, .plan = plan_, .tracer = tracer_});
  if (const Expected<void> can = renderer->can_draw(); !can) GTEST_SKIP() << can.error().what;
  const std::unique_ptr<RequestHandler> video = make_video(renderer);
  job_.request.answer = {
      .kind = Answer::Video, .bits_per_second = 1'000'000, .interval = std::chrono::milliseconds(14)};
  for (std::uint32_t round = 0; round < 3; ++round)
    for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(Rebuilds::kPerSecond); ++i) {
      job_.session.value = i;
      for (View& view : job_.request.views) view.size = {48 + 16 * i, 48};
      packer_.begin();
      ++job_.request.frame.value;
      EXPECT_NO_THROW(video->answer(job_, packer_)) << "round " << round << ", size " << i;
    }
}

/// So a large picture is given up when it has taken too long, although nothing interrupts a device.
TEST_F(ServerAnswers, ADrawnAnswerIsGivenUpBetweenItsStages) {
  const auto renderer =
      std::make_shared<AnswerRenderer>(AnswerContext{.scene = scene_, .plan = plan_, .tracer = tracer_});
  if (const Expected<void> can = renderer->can_draw(); !can) GTEST_SKIP() << can.error().what;
  std::vector<std::unique_ptr<RequestHandler>> handlers;
  handlers.push_back(make_gbuffer(renderer));
  if (has_video()) handlers.push_back(make_video(renderer));
  job_.request.answer = {
      .kind = Answer::Video, .bits_per_second = 1'000'000, .interval = std::chrono::milliseconds(14)};
  for (const std::unique_ptr<RequestHandler>& handler : handlers) {
    std::atomic<int> requested = 0, most = std::numeric_limits<int>::max();
    job_.is_given_up = [&] { return ++requested > most; };
    packer_.begin();
    EXPECT_NO_THROW(handler->answer(job_, packer_));
    const int all = requested;
    for (int stage = 1; stage <= 3; ++stage) {
      requested = 0, most = all - stage;
      packer_.begin();
      EXPECT_THROW(handler->answer(job_, packer_), AnswerGivenUp)
          << "before the last stage but " << stage - 1;
    }
    requested = 0, most = all - 4;
    EXPECT_THROW(handler->answer(job_, packer_), TraceGivenUp) << "no other stage asks";
  }
}

/// An answer that no codec and no device can make does not end the server.
TEST_F(ServerAnswers, AnswersThatCannotBeMadeAreLeftOut) {
  if (!has_video()) GTEST_SKIP() << video_version();
  job_.request.answer = {
      .kind = Answer::Video, .bits_per_second = 1'000'000, .interval = std::chrono::milliseconds(14)};
  const auto messages = [&](Extent size) {
    for (View& view : job_.request.views) view.size = size;
    packer_.begin();
    answers_.answer(job_, packer_, {});
    return packer_.finish({.frame = {1}}).size();
  };
  EXPECT_EQ(messages({8, 8}), 1u) << "too small for the codec: only the report";
  EXPECT_GT(messages({64, 64}), 1u) << "the next request is answered";
}

}  // namespace
}  // namespace farshade
