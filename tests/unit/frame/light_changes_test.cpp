#include "stereo/frame/light_changes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <random>

namespace farshade {
namespace {

/// The newest change of a light, or nothing.
std::optional<LightChange> of_light(const LightChanges& changes, std::uint32_t light) {
  for (const LightChange& change : changes.lights)
    if (change.light == light) return change;
  return std::nullopt;
}

bool in_order(const LightChanges& changes) {
  for (std::size_t i = 1; i < changes.lights.size(); ++i)
    if (!is_newer(changes.lights[i].revision, changes.lights[i - 1].revision)) return false;
  return changes.lights.empty() || !is_newer(changes.lights.back().revision, changes.revision);
}

LightPose somewhere(double x) {
  return {Point<Stage>{{x, 1, 2}}, Vector<Stage>{{0, -1, 0}}};
}

TEST(LightChanges, KeepTheNewestOfEachLight) {
  LightChanges changes;
  change(changes, 3, false, std::nullopt);
  change(changes, 1, true, somewhere(1));
  change(changes, 3, true, somewhere(2));
  EXPECT_EQ(changes, (LightChanges{{4}, {{1, {3}, true, somewhere(1)}, {3, {4}, true, somewhere(2)}}}));
}

TEST(LightChanges, RevisionsGoOnAfterWraparound) {
  LightChanges changes{{0xfffffffe}, {}};
  for (const std::uint32_t light : {0u, 1u, 2u}) change(changes, light, false, std::nullopt);
  EXPECT_EQ(changes.revision, LightSetRevision{1});
  EXPECT_TRUE(in_order(changes));
  EXPECT_EQ(since(changes, {0xffffffff}, 9).lights.size(), 2u);
  EXPECT_EQ(up_to(changes, {0xffffffff}).lights.size(), 1u);
}

TEST(LightChanges, SinceLeavesOutWhatDoesNotFitAndSaysSo) {
  LightChanges changes;
  for (const std::uint32_t light : {5u, 6u, 5u, 7u}) change(changes, light, false, std::nullopt);
  EXPECT_EQ(since(changes, {1}, 3), changes);
  EXPECT_EQ(since(changes, {1}, 2), (LightChanges{{4}, {{6, {3}, false, {}}, {5, {4}, false, {}}}}));
  EXPECT_EQ(since(changes, {3}, 1), (LightChanges{{4}, {{5, {4}, false, {}}}}));
  EXPECT_EQ(since(changes, {3}, 0), (LightChanges{{3}, {}}));
  EXPECT_EQ(since(changes, {5}, 1), (LightChanges{{5}, {}}));
}

TEST(LightChanges, MergeTakesNothingOlder) {
  LightChanges held;
  merge(held, {{4}, {{1, {3}, false, {}}, {2, {4}, false, {}}}});
  const LightChanges before = held;
  merge(held, {{3}, {{1, {2}, true, {}}, {9, {3}, false, {}}}});
  merge(held, {{4}, {{9, {4}, false, {}}}});
  EXPECT_EQ(held, before);
  merge(held, {{6}, {{2, {2}, true, {}}, {5, {6}, false, {}}}});
  EXPECT_EQ(held, (LightChanges{{6}, {{1, {3}, false, {}}, {2, {4}, false, {}}, {5, {6}, false, {}}}}));
}

/// A viewer changes lights at random. A server receives the updates over a link that loses, duplicates and
/// reorders both the updates and their acknowledgements.
class Convergence : public testing::TestWithParam<std::uint32_t> {
 protected:
  static constexpr std::uint32_t kLights = 12;
  static constexpr std::size_t kMost = 3;

  bool chance(double p) { return std::bernoulli_distribution(p)(random_); }
  std::uint32_t below(std::size_t n) {
    return std::uniform_int_distribution<std::uint32_t>(0, static_cast<std::uint32_t>(n) - 1)(random_);
  }
  template <class T>
  void send(std::deque<T>& link, const T& message) {
    if (chance(0.3)) return;
    for (int copies = chance(0.2) ? 2 : 1; copies > 0; --copies)
      link.insert(link.begin() + below(link.size() + 1), message);
  }
  template <class T>
  std::optional<T> arrive(std::deque<T>& link) {
    if (link.empty() || chance(0.4)) return std::nullopt;
    const T message = link.front();
    link.pop_front();
    return message;
  }
  void change_something() {
    const std::optional<LightPose> pose = chance(0.5) ? std::optional(somewhere(below(1000))) : std::nullopt;
    change(viewer_, below(kLights), chance(0.5), pose);
  }
  void exchange() {
    send(updates_, since(viewer_, acknowledged_, kMost));
    if (const auto update = arrive(updates_)) merge(server_, *update);
    send(acknowledgements_, server_.revision);
    if (const auto revision = arrive(acknowledgements_))
      if (is_newer(*revision, acknowledged_)) acknowledged_ = *revision;
  }
  void expect_claim_holds() const {
    for (std::uint32_t light = 0; light < kLights; ++light) {
      const std::optional<LightChange> newest = of_light(viewer_, light);
      if (newest && is_newer(newest->revision, server_.revision)) continue;
      ASSERT_EQ(of_light(server_, light), newest)
          << "light " << light << " at revision " << server_.revision.value;
    }
    ASSERT_TRUE(in_order(server_));
  }

  std::mt19937 random_{GetParam()};
  LightChanges viewer_, server_;
  LightSetRevision acknowledged_ = kFirstLightSet;
  std::deque<LightChanges> updates_;
  std::deque<LightSetRevision> acknowledgements_;
};

TEST_P(Convergence, TheReceiversRevisionIsTrueAtEveryStepAndReachesTheSenders) {
  SCOPED_TRACE(testing::Message() << "seed " << GetParam());
  viewer_.revision = server_.revision = acknowledged_ =
      GetParam() % 2 == 0 ? kFirstLightSet : LightSetRevision{0xfffffff0};
  std::size_t partial = 0, behind = 0;
  for (int step = 0; step < 1500; ++step) {
    if (chance(0.4)) change_something();
    exchange();
    expect_claim_holds();
    if (HasFatalFailure()) return;
    behind += server_.revision != viewer_.revision;
    partial += since(viewer_, acknowledged_, kMost).revision != viewer_.revision;
  }
  EXPECT_GT(behind, 100u);
  EXPECT_GT(partial, 100u);
  for (int step = 0; step < 300; ++step) exchange();
  EXPECT_EQ(server_, viewer_);
}

INSTANTIATE_TEST_SUITE_P(Seed, Convergence, testing::Range(1u, 21u));

}  // namespace
}  // namespace farshade
