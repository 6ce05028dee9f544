#include <gtest/gtest.h>

#include <atomic>
#include <fstream>
#include <future>

#include "stereo/messages/fetch_messages.h"
#include "tests/unit/fetch/fetch_bench.h"

namespace farshade {
namespace {

using namespace std::chrono_literals;

TEST(TheSendRate, KeepsToItsRateAndYieldsToMasks) {
  for (const auto& [masks, rate] : {std::pair{SendRate::Masks::Idle, 1e6}, {SendRate::Masks::Sent, 0.25e6}}) {
    SendRate sends(1e6);
    Time now{};
    std::size_t sent = 0;
    while (now < Time(10s)) {
      const Duration wait = sends.take(1000, masks, now);
      sent += wait == Duration::zero() ? 1000 : 0;
      now += wait;
    }
    EXPECT_NEAR(static_cast<double>(sent), rate * 10, rate * 0.05);
  }
}

TEST(TheSendRate, SavesNothingUpWhileNobodyFetches) {
  SendRate sends(1e6);
  std::size_t burst = 0;
  while (sends.take(1000, SendRate::Masks::Idle, Time(100s)) == Duration::zero()) ++burst;
  EXPECT_LE(burst, 6u);
}

TEST_F(FetchTest, BringsAllFilesAndTheLightingOnce) {
  write({{"a.gltf", 5000}, {"b.bin", 300'000}, {"textures/c.png", 1}});
  serve();
  std::uint64_t here = 0, all = 0;
  FetchPlan wanted = plan();
  wanted.progress = [&](std::uint64_t h, std::uint64_t a) { here = h, all = a; };
  const Expected<FetchedScene> first = fetch_scene(wanted);
  ASSERT_TRUE(first.has_value()) << first.error().what;
  EXPECT_EQ(first->fetched_bytes, 305'001u);
  EXPECT_EQ(here, all);
  EXPECT_EQ(all, 305'001u);
  EXPECT_EQ(first->lighting.ambient, 0.25f);
  EXPECT_EQ(first->hash[2], 3);
  EXPECT_EQ(first->scene.filename(), "a.gltf");
  expect_equal_files(*first);
  const Expected<FetchedScene> second = fetch_scene(plan());
  ASSERT_TRUE(second.has_value());
  EXPECT_EQ(second->fetched_bytes, 0u);
  EXPECT_EQ(second->scene, first->scene);
  // The files once, and two offers of a few hundred bytes.
  EXPECT_GT(sender_->counters().sent_bytes, 305'001u);
  EXPECT_LT(sender_->counters().sent_bytes, 306'000u);
}

TEST_F(FetchTest, GoesOnAfterCutsAtRandomPlaces) {
  write({{"a.gltf", 20'000}, {"b.bin", 900'000}, {"c.bin", 100'000}});
  serve();
  std::mt19937 random(11);
  BadPath path{.bytes_per_second = 20e6, .delay = 5ms};
  for (int i = 0; i < 8; ++i) path.cuts.push_back(random() % 250'000);
  TcpProxy proxy(server_, path);
  FetchPlan wanted = plan();
  wanted.servers = {proxy.address()};
  // Each call is a new process: it starts with what the last one kept.
  Expected<FetchedScene> fetched = fetch_scene(wanted);
  ASSERT_TRUE(fetched.has_value()) << fetched.error().what;
  expect_equal_files(*fetched);
  EXPECT_GT(proxy.connections(), 4u);
  // Each cut may lose what was on its way, and the offer is asked for again; nothing comes twice as a whole.
  EXPECT_LT(proxy.passed_bytes(), 1'020'000 * 1.1);
}

TEST_F(FetchTest, WhatWasFetchedIsKeptWhenTheUserStops) {
  write({{"a.glb", 2'000'000}});
  serve({.bytes_per_second = 4e6});
  FetchPlan wanted = plan();
  std::uint64_t here = 0;
  Time requested{};
  wanted.progress = [&](std::uint64_t h, std::uint64_t) { here = h; };
  wanted.stopped = [&] {
    if (here > 500'000 && requested == Time{}) requested = SteadyClock().now();
    return here > 500'000;
  };
  const Expected<FetchedScene> stopped = fetch_scene(wanted);
  ASSERT_FALSE(stopped);
  EXPECT_NE(stopped.error().what.find("the next start goes on from there"), std::string::npos)
      << stopped.error().what;
  const Expected<FetchedScene> rest = fetch_scene(plan());
  ASSERT_TRUE(rest.has_value());
  EXPECT_LE(rest->fetched_bytes, 1'500'000u);
  EXPECT_GT(rest->fetched_bytes, 0u);
  expect_equal_files(*rest);
}

TEST_F(FetchTest, AKeyThatIsTakenOutOfTheRingGetsNoMore) {
  write({{"a.glb", 4'000'000}});
  serve({.bytes_per_second = 2e6});
  FetchPlan wanted = plan();
  wanted.patience = 500ms;
  std::atomic<bool> revoked = false;
  wanted.progress = [&](std::uint64_t here, std::uint64_t) {
    if (here > 200'000 && !revoked.exchange(true)) sender_->set_ring({new_key("another").value()});
  };
  const Expected<FetchedScene> cut = fetch_scene(wanted);
  EXPECT_TRUE(revoked);
  EXPECT_FALSE(cut);
  EXPECT_LT(sender_->counters().sent_bytes, 1'000'000u);
}

TEST_F(FetchTest, TwoClientsAtOnceAndTwoWithOneCache) {
  write({{"a.glb", 1'000'000}});
  serve({.bytes_per_second = 10e6});
  FetchPlan other = plan();
  other.cache = folder_.path() / "other";
  const auto fetch = [](FetchPlan wanted) {
    return std::async(std::launch::async, [wanted = std::move(wanted)] { return fetch_scene(wanted); });
  };
  std::vector<std::future<Expected<FetchedScene>>> fetches;
  fetches.push_back(fetch(plan()));
  fetches.push_back(fetch(plan()));
  fetches.push_back(fetch(other));
  std::uint64_t fetched_bytes = 0;
  for (auto& result : fetches) {
    const Expected<FetchedScene> fetched = result.get();
    ASSERT_TRUE(fetched.has_value()) << fetched.error().what;
    expect_equal_files(*fetched);
    fetched_bytes += fetched->fetched_bytes;
  }
  EXPECT_EQ(fetched_bytes, 2'000'000u) << "the cache that two share is filled once";
}

TEST_F(FetchTest, FetchesTheNewSceneAfterTheServerChanged) {
  write({{"a.glb", 3000}});
  serve();
  ASSERT_TRUE(fetch_scene(plan()));
  sender_.reset();
  ASSERT_TRUE(write_file_atomically(folder_.path() / "scene/a.glb", std::string_view("another scene")));
  serve();
  const Expected<FetchedScene> fetched = fetch_scene(plan());
  ASSERT_TRUE(fetched.has_value());
  EXPECT_EQ(fetched->fetched_bytes, 13u);
  expect_equal_files(*fetched);
}

TEST_F(FetchTest, AFileThatChangesUnderTheServerIsRefused) {
  write({{"a.glb", 3000}});
  serve();
  ASSERT_TRUE(ask_offer(plan()));
  std::ofstream(folder_.path() / "scene/a.glb", std::ios::in) << "in place";
  const Expected<FetchedScene> fetched = fetch_scene(plan());
  ASSERT_FALSE(fetched);
  EXPECT_NE(fetched.error().what.find("restart the server"), std::string::npos) << fetched.error().what;
}

/// It was loaded with other bytes than those that lie there when the sender starts.
TEST_F(FetchTest, AFileThatChangesWhileTheServerStartsIsNotOffered) {
  write({{"a.glb", 3000}});
  std::vector<SceneFile> before = loaded();
  std::filesystem::last_write_time(folder_.path() / "scene/a.glb",
                                   std::filesystem::file_time_type::clock::now() + 1s);
  serve(before, {});
  const auto offer = ask_offer(plan());
  ASSERT_FALSE(offer);
  EXPECT_NE(offer.error().what.find("its log says why"), std::string::npos) << offer.error().what;
  const auto opened = ServedFiles::open(folder_.path() / "scene", before);
  ASSERT_FALSE(opened);
  EXPECT_NE(opened.error().what.find("'a.glb' has changed: restart the server"), std::string::npos);
}

TEST_F(FetchTest, ASceneThatIsTooLargeIsNotOffered) {
  write({{"a.glb", 1}});
  std::filesystem::resize_file(folder_.path() / "scene/a.glb", kMostScene_bytes + 1);  // sparse
  serve();
  const auto offer = ask_offer(plan());
  ASSERT_FALSE(offer);
  EXPECT_NE(offer.error().what.find("--scene"), std::string::npos);
}

TEST_F(FetchTest, AnUnknownKeyIsRefusedWithASentence) {
  write({{"a.glb", 1}});
  serve();
  FetchPlan wanted = plan();
  wanted.key = new_key("stranger").value();
  const auto offer = ask_offer(wanted);
  ASSERT_FALSE(offer);
  EXPECT_NE(offer.error().what.find("has no key with the secret of 'stranger'"), std::string::npos)
      << offer.error().what;
  // A key of the ring whose secret is wrong has another id, so a forged proof needs an id that was seen.
  EXPECT_EQ(sender_->counters().sent_bytes, 0u);
}

}  // namespace
}  // namespace farshade
