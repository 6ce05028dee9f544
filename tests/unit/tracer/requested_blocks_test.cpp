// Traces of what is asked for: these bits are those of a trace of the whole views, and all others are 0.
#include <gtest/gtest.h>

#include <bit>

#include "stereo/base/check.h"
#include "stereo/gltf/gltf.h"
#include "stereo/tracer/block_groups.h"
#include "tests/oracle/agreement.h"
#include "tests/oracle/random_scenes.h"
#include "tests/oracle/scene_builder.h"
#include "tests/support/sanitized.h"

namespace farshade {
namespace {

const View kRequestedLeft = look({0.1, 3.0, 2.9}, {0.03, 0.0, -0.1}, 64);
const View kRequestedRight = look({0.2, 3.0, 2.9}, {0.03, 0.0, -0.1}, 64);

Scene requested_floor(int lights) {
  SceneBuilder build;
  build.add(quad({0, 0, 0}, {4, 0, 0}, {0, 0, -4}));
  build.add(box({0, 1, 0}, {0.5f, 0.5f, 0.5f}));
  for (int i = 0; i < lights; ++i) build.point_light({-2.0 + 0.1 * i, 2.5, 0.03 * i - 0.4});
  return build.build();
}

/// Each block with probability `share`. A quarter of the tiles has all blocks or none instead.
BlockBits random_blocks(std::mt19937& random, double share) {
  std::bernoulli_distribution requested(share), uniform(0.25);
  if (uniform(random)) return requested(random) ? kAllBlocks : kNoBlocks;
  BlockBits bits = kNoBlocks;
  for (std::uint32_t block = 0; block < 16; ++block)
    if (requested(random)) bits = static_cast<BlockBits>(bits | 1u << block);
  return bits;
}

/// Half of the tiles are asked for in all lights, the others in each share of the lights apart.
std::vector<RequestedTile> random_tiles(std::mt19937& random, Extent size, std::uint32_t lights,
                                        double share) {
  std::vector<RequestedTile> tiles(TileGrid{size}.count());
  std::bernoulli_distribution in_all(0.5);
  for (RequestedTile& tile : tiles) {
    tile = all_lights_in(random_blocks(random, share), lights);
    if (in_all(random)) continue;
    for (std::uint32_t i = 0; i < shares_of(lights); ++i) tile.shares[i] = random_blocks(random, share);
  }
  return tiles;
}

/// The bits of a mask word that are asked for at a pixel.
std::uint32_t requested_bits(const FrameRequest& request, std::size_t eye, std::uint32_t x, std::uint32_t y) {
  if (request.requested.tiles[eye].empty()) return ~0u;
  const TileGrid grid{request.views[eye].size};
  const RequestedTile& tile =
      request.requested.tiles[eye][y / kTileSide_px * grid.columns() + x / kTileSide_px];
  const auto block = std::countr_zero(block_bit(x % kTileSide_px, y % kTileSide_px));
  return tile.at(static_cast<std::uint32_t>(block)) * 0x01010101u;
}

bool is_requested(const FrameRequest& request, std::size_t eye, std::uint32_t x, std::uint32_t y) {
  return requested_bits(request, eye, x, y) != 0;
}

std::uint64_t requested_pixels(const FrameRequest& request, std::size_t eye) {
  std::uint64_t pixels = 0;
  for (std::uint32_t y = 0; y < request.views[eye].size.height; ++y)
    for (std::uint32_t x = 0; x < request.views[eye].size.width; ++x)
      pixels += is_requested(request, eye, x, y) ? 1u : 0u;
  return pixels;
}

/// Expects the bits of `whole` where they are asked for, and 0 elsewhere.
void expect_part_of(const ShadowFrame& whole, const ShadowFrame& part, const FrameRequest& request) {
  for (std::size_t eye = 0; eye < kEyes; ++eye) {
    const EyeMask &all = whole.masks[eye], &mask = part.masks[eye];
    ASSERT_EQ(mask.size(), all.size());
    ASSERT_EQ(mask.layout(), all.layout());
    for (std::uint32_t plane = 0; plane < all.layout().planes(); ++plane)
      for (std::uint32_t y = 0; y < all.size().height; ++y)
        for (std::uint32_t x = 0; x < all.size().width; ++x)
          ASSERT_EQ(mask.word(x, y, plane), all.word(x, y, plane) & requested_bits(request, eye, x, y))
              << "eye " << eye << ", plane " << plane << ", pixel " << x << ", " << y;
  }
}

/// Traces `request`, and expects words and counts that follow from the whole views. `frame` has all bits set
/// before, so that a word that nobody writes is noticed.
TraceStats expect_part(Tracer& tracer, const FrameRequest& request) {
  FrameRequest all = request;
  all.requested = {};
  ShadowFrame whole, part;
  const TraceStats most = tracer.trace(all, whole);
  part = whole;
  for (EyeMask& mask : part.masks) std::ranges::fill(mask.bytes(), std::byte{0xff});
  const TraceStats s = tracer.trace(request, part);
  expect_part_of(whole, part, request);
  EXPECT_EQ(s.shadow_rays + s.turned_away + s.out_of_range + s.out_of_cone, s.full_shadow_rays);
  EXPECT_EQ(s.primary_rays, requested_pixels(request, 0) + requested_pixels(request, 1));
  EXPECT_LE(s.full_shadow_rays, most.full_shadow_rays);
  return s;
}

FrameRequest random_request(std::mt19937& random, const StereoView& views, std::uint32_t lights, double share,
                            Time time = {}) {
  FrameRequest request = request_for(views, time);
  for (std::size_t eye = 0; eye < kEyes; ++eye)
    request.requested.tiles[eye] = random_tiles(random, views[eye].size, lights, share);
  return request;
}

void expect_parts(Tracer& tracer, std::mt19937& random, const StereoView& views, std::size_t lights,
                  Time time = {}) {
  for (const double share : {0.02, 0.11, 0.5, 0.95}) {
    SCOPED_TRACE(share);
    expect_part(tracer, random_request(random, views, narrow<std::uint32_t>(lights), share, time));
  }
}

TEST(TracerRequestedBlocks, BlocksOfRandomSoupsHaveTheWordsOfWholeViews) {
  const unsigned seed = 20270301;
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  for (int i = 0; i < (kSanitized ? 3 : 8); ++i) {
    SCOPED_TRACE(i);
    const Scene scene = random_soup(random);
    const double angle = 0.8 * i;
    const glm::dvec3 eye(2.5 * std::sin(angle), 0.3, 2.5 * std::cos(angle));
    const StereoView views{look(eye, {0.1, -0.8, 0}, 144),
                           look(eye + glm::dvec3(0, 0.06, 0), {0.1, -0.8, 0}, 144)};
    Tracer proving = Tracer::create(scene).value(), reference = Tracer::create_reference(scene).value();
    for (Tracer* const tracer : {&proving, &reference})
      expect_parts(*tracer, random, views, scene.lights.size(), time_from_ns(std::int64_t{i} * 90'000'000));
  }
}

TEST(TracerRequestedBlocks, BlocksOfTheRoomHaveTheWordsOfWholeViews) {
  const Scene scene = load_scene(FARSHADE_ASSETS "/room.glb").value();
  const unsigned seed = 20270302;
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  const Rigid<Stage, Eye> camera = scene.camera.value();
  StereoView views;
  for (std::size_t eye = 0; eye < kEyes; ++eye)
    views[eye] = {{camera.rotation, camera(Point<Eye>{{eye == 0 ? -0.032 : 0.032, 0, 0}}).v},
                  {-0.8, 0.8, 0.74, -0.85},
                  {200, 136}};
  Tracer proving = Tracer::create(scene).value(), reference = Tracer::create_reference(scene).value();
  for (Tracer* const tracer : {&proving, &reference})
    expect_parts(*tracer, random, views, scene.lights.size(), time_from_ns(1'300'000'000));
}

TEST(TracerRequestedBlocks, SizesNeedNotBeMultiplesOfTilesOrBlocks) {
  const Scene scene = requested_floor(3);
  const unsigned seed = 20270303;
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  Tracer tracer = Tracer::create(scene).value();
  for (const Extent size : {Extent{1, 1}, {3, 70}, {17, 33}, {66, 5}, {75, 97}, {140, 131}}) {
    SCOPED_TRACE(size.width);
    StereoView views{kRequestedLeft, kRequestedRight};
    views[0].size = size;
    expect_parts(tracer, random, views, 3);
  }
}

TEST(TracerRequestedBlocks, EveryPlaneOfManyLightsIsPartlyTraced) {
  const unsigned seed = 20270304;
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  for (const std::uint32_t lights : {9u, 32u, 40u, 64u}) {
    SCOPED_TRACE(lights);
    const Scene scene = requested_floor(narrow<int>(lights));
    Tracer tracer = Tracer::create(scene).value();
    expect_part(tracer, random_request(random, {kRequestedLeft, kRequestedRight}, lights, 0.3));
  }
}

TEST(TracerRequestedBlocks, NoBlocksNoBitsAndNoRays) {
  const Scene scene = requested_floor(2);
  Tracer tracer = Tracer::create(scene).value();
  FrameRequest request = request_for({kRequestedLeft, kRequestedRight});
  for (auto& tiles : request.requested.tiles)
    tiles.assign(TileGrid{kRequestedLeft.size}.count(), RequestedTile{});
  const TraceStats stats = expect_part(tracer, request);
  EXPECT_EQ(stats.primary_rays, 0u);
  EXPECT_EQ(stats.full_shadow_rays, 0u);
}

TEST(TracerRequestedBlocks, OneEyeIsWholeAndTheOtherPartial) {
  const Scene scene = requested_floor(2);
  Tracer tracer = Tracer::create(scene).value();
  const unsigned seed = 20270305;
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  for (const std::size_t whole : {0u, 1u}) {
    SCOPED_TRACE(whole);
    FrameRequest request = random_request(random, {kRequestedLeft, kRequestedRight}, 2, 0.2);
    request.requested.tiles[whole].clear();
    const TraceStats stats = expect_part(tracer, request);
    EXPECT_EQ(stats.primary_rays, 64u * 64 + requested_pixels(request, 1 - whole));
  }
}

TEST(TracerRequestedBlocks, AllBlocksAreTheWholeView) {
  const Scene scene = requested_floor(2);
  Tracer tracer = Tracer::create(scene).value();
  FrameRequest request = request_for({kRequestedLeft, kRequestedRight});
  ShadowFrame whole, all;
  const TraceStats expected = tracer.trace(request, whole);
  for (auto& tiles : request.requested.tiles)
    tiles.assign(TileGrid{kRequestedLeft.size}.count(), all_lights_in(kAllBlocks, 2));
  const TraceStats stats = tracer.trace(request, all);
  EXPECT_EQ(all.masks, whole.masks);
  EXPECT_EQ(stats.primary_rays, expected.primary_rays);
  EXPECT_EQ(stats.full_shadow_rays, expected.full_shadow_rays);
  EXPECT_EQ(stats.shadow_rays, expected.shadow_rays);
}

TEST(TracerRequestedBlocks, CoincidingViewsWithDifferentBlocksAreBothTraced) {
  const Scene scene = requested_floor(2);
  Tracer tracer = Tracer::create(scene).value();
  const unsigned seed = 20270306;
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  expect_part(tracer, random_request(random, {kRequestedLeft, kRequestedLeft}, 2, 0.3));
  FrameRequest one_whole = random_request(random, {kRequestedLeft, kRequestedLeft}, 2, 0.3);
  one_whole.requested.tiles[0].clear();
  expect_part(tracer, one_whole);
}

TEST(TracerRequestedBlocks, CoincidingViewsWithTheSameBlocksAreTracedOnce) {
  const Scene scene = requested_floor(2);
  Tracer tracer = Tracer::create(scene).value(), reference = Tracer::create_reference(scene).value();
  std::mt19937 random(20270307);
  FrameRequest request = random_request(random, {kRequestedLeft, kRequestedLeft}, 2, 0.3);
  request.requested.tiles[1] = request.requested.tiles[0];
  ShadowFrame whole, part;
  tracer.trace(request_for({kRequestedLeft, kRequestedLeft}), whole);
  const TraceStats once = tracer.trace(request, part);
  expect_part_of(whole, part, request);
  EXPECT_EQ(once.primary_rays, requested_pixels(request, 0));
  EXPECT_EQ(once.full_shadow_rays, reference.trace(request, part).full_shadow_rays);
}

TEST(TracerRequestedBlocks, CoveredPixelsOfRequestedBlocksAreCounted) {
  const Scene scene = requested_floor(3);
  Tracer tracer = Tracer::create(scene).value();
  const unsigned seed = 20270308;
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  const View up = look({0.1, 1.0, 2.9}, {0.03, 1.2, -0.1}, 64);  // the upper half sees nothing
  const FrameRequest request = random_request(random, {kRequestedLeft, up}, 3, 0.3);
  std::uint64_t covered = 0;
  for (std::size_t eye = 0; eye < kEyes; ++eye) {
    const auto truth = oracle::trace(scene, state_at(scene, Time{}), request.views[eye]);
    for (std::uint32_t y = 0; y < 64; ++y)
      for (std::uint32_t x = 0; x < 64; ++x)
        if (truth.covered[y * 64 + x])
          covered += static_cast<std::uint64_t>(std::popcount(requested_bits(request, eye, x, y) & 7u));
  }
  EXPECT_EQ(expect_part(tracer, request).full_shadow_rays, covered);
}

TEST(TracerRequestedBlocks, LightsThatAreOffLeaveNoBits) {
  const Scene scene = requested_floor(2);
  Tracer tracer = Tracer::create(scene).value();
  std::mt19937 random(20270309);
  FrameRequest request = random_request(random, {kRequestedLeft, kRequestedRight}, 2, 0.5);
  change(request.lights, 0, false, std::nullopt);
  expect_part(tracer, request);
}

TEST(TracerRequestedBlocksDeathTest, EyesHaveASetForEachTileOrNone) {
  const Scene scene = requested_floor(1);
  Tracer tracer = Tracer::create(scene).value();
  ShadowFrame frame;
  FrameRequest request = request_for({kRequestedLeft, kRequestedRight});
  request.requested.tiles[1].assign(15, all_lights_in(kAllBlocks, 1));
  EXPECT_DEATH(tracer.trace(request, frame), "a set of blocks for each tile");
}

TEST(TracerRequestedBlocksDeathTest, PositionsAreThoseOfWholeViews) {
  const Scene scene = requested_floor(1);
  Tracer tracer = Tracer::create(scene).value();
  ShadowFrame frame;
  FrameRequest request = request_for({kRequestedLeft, kRequestedRight});
  request.requested.tiles[1].assign(16, all_lights_in(kAllBlocks, 1));
  const PositionGrid grid = grid_of({scene.bounds.low}, {scene.bounds.high}, 16);
  EXPECT_DEATH(tracer.trace(request, PerEye<PositionPlanes>{}, grid, frame), "whole views");
}

/// The blocks of all groups, in their order.
std::vector<BlockPlace> blocks_of(const std::vector<BlockGroup>& groups) {
  std::vector<BlockPlace> blocks;
  for (const BlockGroup& group : groups)
    blocks.insert(blocks.end(), group.blocks.begin(), group.blocks.begin() + group.count);
  return blocks;
}

TEST(BlockGroups, TilesOfAWholeViewAreGroups) {
  const TileGrid grid{{40, 20}};
  const std::vector<BlockGroup> groups = groups_of(grid.size, 1, {});
  ASSERT_EQ(groups.size(), grid.count());
  for (std::uint32_t tile = 0; tile < grid.count(); ++tile) {
    EXPECT_EQ(groups[tile].count, 16);
    EXPECT_EQ(groups[tile].blocks[0].x, grid.rect(tile).x0);
    EXPECT_EQ(groups[tile].blocks[0].y, grid.rect(tile).y0);
    EXPECT_EQ(groups[tile].blocks, group_of(grid.rect(tile), 1).blocks);
  }
}

TEST(BlockGroups, BlocksOfNeighbouringTilesShareAGroup) {
  std::vector<RequestedTile> requested(4);
  requested[0].shares = {block_bit(12, 4), 0}, requested[3].shares = {0, block_bit(8, 0)};
  requested[1].shares = {block_bit(0, 4), static_cast<BlockBits>(block_bit(0, 4) | block_bit(4, 8))};
  const std::vector<BlockGroup> groups = groups_of({32, 32}, 2, requested);
  ASSERT_EQ(groups.size(), 1u);
  EXPECT_EQ(blocks_of(groups), (std::vector<BlockPlace>{{12, 4}, {16, 4}, {20, 8}, {24, 16}}));
  EXPECT_EQ(groups[0].requested, (RequestedTile{{0b0011, 0b1110}}));
}

TEST(BlockGroups, DistantBlocksShareNoGroup) {
  std::vector<RequestedTile> requested(64);
  requested.front() = requested.back() = all_lights_in(block_bit(0, 0), 1);
  EXPECT_EQ(groups_of({1024, 16}, 1, requested).size(), 2u);
}

TEST(BlockGroups, BlocksOutsideOfThePictureAreLeftOut) {
  const std::vector<RequestedTile> requested(2, all_lights_in(kAllBlocks, 1));
  EXPECT_EQ(blocks_of(groups_of({21, 3}, 1, requested)),
            (std::vector<BlockPlace>{{0, 0}, {4, 0}, {8, 0}, {12, 0}, {16, 0}, {20, 0}}));
}

TEST(BlockGroups, EveryRequestedBlockIsInOneGroup) {
  const unsigned seed = 20270310;
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  for (const double share : {0.02, 0.3, 0.9}) {
    const Extent size{176, 144};
    const std::vector<RequestedTile> requested = random_tiles(random, size, 3, share);
    std::vector<RequestedTile> found(requested.size());
    std::size_t blocks = 0, expected = 0;
    for (const BlockGroup& group : groups_of(size, 3, requested)) {
      for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(group.count); ++i) {
        const BlockPlace place = group.blocks[i];
        RequestedTile& tile =
            found[place.y / kTileSide_px * TileGrid{size}.columns() + place.x / kTileSide_px];
        for (std::uint32_t share_number = 0; share_number < 3; ++share_number)
          if ((group.requested.at(i) >> share_number & 1) != 0)
            tile.shares[share_number] |= block_bit(place.x % kTileSide_px, place.y % kTileSide_px);
      }
      blocks += static_cast<std::size_t>(group.count);
    }
    for (const RequestedTile& tile : requested)
      expected += static_cast<std::size_t>(std::popcount(tile.any()));
    EXPECT_EQ(found, requested);
    EXPECT_EQ(blocks, expected);
  }
}

}  // namespace
}  // namespace farshade
