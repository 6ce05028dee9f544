// Pictures that are shaded with the cube mask alone, and with a view's mask and the cube mask.
#include <gtest/gtest.h>

#include <cstdio>
#include <numbers>

#include "stereo/frame/cube_mask.h"
#include "stereo/image/difference.h"
#include "tests/golden/test_rig.h"

namespace farshade {
namespace {

using namespace std::chrono_literals;

constexpr std::uint32_t kSide = 256;

class CubeMaskLookup : public OnLavapipe {
 protected:
  /// The share of wrong bits and of bits from faces, over covered pixels of both eyes.
  struct Counts {
    std::size_t pixels = 0, from_faces = 0, unknown = 0, wrong = 0, lights = 0;
    [[nodiscard]] double wrong_share() const {
      return static_cast<double>(wrong) / static_cast<double>(pixels * lights);
    }
  };
  static Counts counted(const Shown& shown, const Mask& truth) {
    Counts counts{.lights = truth.bits[0].layout().lights};
    for_covered(shown, [&](Side side, std::uint32_t x, std::uint32_t y, std::uint8_t source) {
      ++counts.pixels;
      counts.from_faces += is_face(source);
      counts.unknown += source == kSourceUnknown;
      const ShownReport& report = shown.reports[index_of(side)];
      for (std::uint32_t light = 0; light < counts.lights; ++light)
        counts.wrong += report.mask.lit(x, y, light) != truth.bits[index_of(side)].lit(x, y, light);
    });
    return counts;
  }
};

TEST_F(CubeMaskLookup, ServesEveryDirectionAlsoBehindTheHead) {
  TestRig rig(device_, bundled("room.glb"), kSide);
  const std::vector<Mask> faces = rig.ask_cube_mask({rig.head().translation});
  for (const double yaw : {0.0, 0.8, 1.6, 2.4, 3.1, -2.2, -0.8})
    for (const double pitch : {-0.9, 0.0, 0.9}) {
      const Rigid<Stage, Head> head =
          moved(rig.head(), yaw, {}) * Rigid<Head, Head>{glm::angleAxis(pitch, glm::dvec3(1, 0, 0)), {}};
      const StereoView views = rig.eyes(head);
      const Mask truth = rig.trace(kNow, views);
      const Counts counts = counted(rig.show(views, {}, {}, faces), truth);
      const Counts guessed = counted(rig.show(views, {}, {}), truth);
      if (counts.pixels < 5000) continue;
      const auto what = testing::Message() << yaw << ' ' << pitch;
      EXPECT_GT(counts.from_faces, counts.pixels * 96 / 100) << what;
      EXPECT_LT(counts.unknown, counts.pixels / 25) << what;
      EXPECT_LT(counts.wrong_share(), guessed.wrong_share() / 5) << what;
    }
}

TEST_F(CubeMaskLookup, OnlyFillsWhatTheViewsMasksDoNotKnow) {
  TestRig rig(device_, bundled("room.glb"), kSide);
  const StereoView before = rig.eyes(rig.head()), now = rig.eyes(moved(rig.head(), 0.5, {}));
  const Mask mask = rig.ask(kTraced, before);
  const std::vector<Mask> faces = rig.ask_cube_mask({rig.head().translation});
  const Shown without = rig.show(now, {mask.traced_mask()}, {.gaps = Gaps::Unknown}),
              with = rig.show(now, {mask.traced_mask()}, {.gaps = Gaps::Unknown}, faces);
  std::size_t filled = 0, changed = 0, left = 0;
  for_covered(with, [&](Side side, std::uint32_t x, std::uint32_t y, std::uint8_t source) {
    const std::uint8_t then = without.reports[index_of(side)].sources[y * kSide + x];
    if (then == kSourceUnknown) {
      filled += is_face(source);
      left += source == kSourceUnknown;
    } else {
      changed += source != then;
    }
  });
  EXPECT_EQ(changed, 0u);
  EXPECT_GT(filled, 10'000u);
  EXPECT_LT(left, filled / 50);
  const Mask truth = rig.trace(kNow, now);
  EXPECT_LT(counted(with, truth).wrong, counted(without, truth).wrong / 4);
}

TEST_F(CubeMaskLookup, ASurfaceThatNoFaceSawIsUnknown) {
  TestRig rig(device_, bundled("room.glb"), kSide);
  // From far to the side: what the room's things hid from there is unknown.
  const std::vector<Mask> faces = rig.ask_cube_mask({rig.head().translation + glm::dvec3(1.5, 0, -1)});
  const StereoView views = rig.eyes(rig.head());
  const Counts counts = counted(rig.show(views, {}, {.gaps = Gaps::Unknown}, faces), rig.trace(kNow, views));
  EXPECT_GT(counts.unknown, counts.pixels / 50);
  EXPECT_GT(counts.from_faces, counts.pixels / 2);
}

TEST_F(CubeMaskLookup, MarksWhatMovedSinceItWasTracedAndFollowsMovingThings) {
  TestRig rig(device_, bundled("room.glb"), kSide);
  rig.set_time(Time(700ms));
  const std::vector<Mask> faces = rig.ask_cube_mask({rig.head().translation});
  for (const Duration later : {Duration(100ms), Duration(400ms)}) {
    rig.set_time(Time(700ms + later));
    // The head looks back at what moves from each side.
    std::size_t changed = 0, missed = 0, stale = 0, all = 0;
    for (const double yaw : {0.0, 1.6, 3.1, -1.6}) {
      const StereoView views = rig.eyes(moved(rig.head(), yaw, {}));
      const Shown shown = rig.show(views, {}, kPlainReprojection, faces);
      const Mask truth = rig.trace(kNow, views);
      rig.set_time(Time(700ms));
      const Mask then = rig.trace(kOlder, views);
      rig.set_time(Time(700ms + later));
      for_covered(shown, [&](Side side, std::uint32_t x, std::uint32_t y, std::uint8_t source) {
        if (!is_face(source)) return;
        const std::size_t eye = index_of(side), pixel = std::size_t{y} * kSide + x;
        for (std::uint32_t light = 0; light < truth.bits[eye].layout().lights; ++light) {
          const bool marked = (shown.reports[eye].stale[pixel] >> light & 1u) != 0;
          const bool differs = then.bits[eye].lit(x, y, light) != truth.bits[eye].lit(x, y, light);
          ++all;
          stale += marked;
          changed += differs;
          missed += differs && !marked;
        }
      });
    }
    EXPECT_GT(changed, 500u);
    EXPECT_LT(missed, changed / 20) << "pixels whose surface moved away between the two pictures";
    EXPECT_LT(stale, all * 3 / 4) << "not everything is marked";
  }
}

/// The room, in which nothing moves but the node of this name and what hangs on it.
Scene room_in_which_moves(std::string_view name) {
  Scene room = bundled("room.glb");
  const auto is_other = [&](const Channel& channel) { return room.nodes[channel.node].name != name; };
  EXPECT_EQ(std::erase_if(room.channels, is_other), 1u) << name;
  for (Node& node : room.nodes)
    node.moving = node.name == name || (node.parent && room.nodes[*node.parent].moving);
  return room;
}

class MovesBehindTheHead : public CubeMaskLookup, public testing::WithParamInterface<const char*> {};

// The head looks away from what moves, and turns to it within 200 ms: its view's mask shows another part of
// the room. Of the pictures with and without a cube mask, only the former is like that of a full trace, in
// both eyes.
TEST_P(MovesBehindTheHead, AndIsRightWhenTheHeadHasTurnedToIt) {
  TestRig rig(device_, room_in_which_moves(GetParam()), kSide);
  rig.set_time(Time(700ms));
  const Mask mask = rig.ask(kTraced, rig.eyes(moved(rig.head(), std::numbers::pi, {})));
  const std::vector<Mask> faces = rig.ask_cube_mask({rig.head().translation});
  rig.set_time(Time(900ms));
  const StereoView views = rig.eyes(moved(rig.head(), 0.3, {0.02, 0, 0}));
  const Shown with = rig.show(views, {mask.traced_mask()}, {}, faces),
              without = rig.show(views, {mask.traced_mask()}, {});
  const PerEye<Image<Rgb8>> right = rig.show_reference(views);
  std::size_t stale = 0;
  for (const Side side : kSides) {
    const std::size_t eye = index_of(side);
    const double db = psnr_db(with.pictures[eye], right[eye]);
    std::printf("%s, %s eye: %.1f dB, without a cube mask %.1f\n", GetParam(), name_of(side), db,
                psnr_db(without.pictures[eye], right[eye]));
    EXPECT_GT(db, 20) << name_of(side);
    EXPECT_GT(db, psnr_db(without.pictures[eye], right[eye]) + 7) << name_of(side);
    for (const std::uint32_t bits : with.reports[eye].stale) stale += bits != 0;
  }
  EXPECT_GT(stale, 100u) << "something moved that can be seen";
}

INSTANTIATE_TEST_SUITE_P(Room, MovesBehindTheHead, testing::Values("pendant pivot", "orrery pivot"),
                         [](const auto& tested) { return std::string(tested.param).substr(0, 6); });

TEST_F(CubeMaskLookup, SwappedFacesOrAnotherPlaceGiveNothing) {
  TestRig rig(device_, bundled("room.glb"), kSide);
  std::vector<Mask> faces = rig.ask_cube_mask({rig.head().translation});
  for (Mask& pair : faces) std::swap(pair.views[0], pair.views[1]);
  const StereoView views = rig.eyes(rig.head());
  const Counts counts = counted(rig.show(views, {}, {.gaps = Gaps::Unknown}, faces), rig.trace(kNow, views));
  EXPECT_LT(counts.from_faces, counts.pixels / 5) << "the depth of the opposite face is another";
}

}  // namespace
}  // namespace farshade
