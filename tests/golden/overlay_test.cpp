/// The overlays of a frame that has all features: the head has turned since its masks were traced with a
/// guard band, tiles are missing, and there are an older mask and moved instances.
#include "vr_client/report/overlays.h"

#include <numbers>
#include <numeric>
#include <span>

#include "stereo/frame/tiles.h"
#include "tests/golden/goldens.h"
#include "tests/golden/test_rig.h"

namespace farshade {
namespace {

using namespace std::chrono_literals;

constexpr std::uint32_t kOverlaySide_px = 160, kTracedSide_px = 192;
constexpr auto kDrawn = std::span(kOverlays).subspan<1>();  // None draws nothing
constexpr double kDegree_rad = std::numbers::pi / 180;

/// Windows and pixels 1.2 times as large.
StereoView grown(StereoView views) {
  for (View& view : views) {
    const FovTangents window = tangents_of(view.fov);
    const double x = 0.1 * (window.right_tan - window.left_tan), y = 0.1 * (window.up_tan - window.down_tan);
    view.fov = {std::atan(window.left_tan - x), std::atan(window.right_tan + x), std::atan(window.up_tan + y),
                std::atan(window.down_tan - y)};
    view.size = {kTracedSide_px, kTracedSide_px};
  }
  return views;
}

/// Removes a block of tiles in both eyes, and some more tiles that differ between the eyes.
void lose_tiles(Mask& mask, std::uint32_t first_column, std::uint32_t one_in) {
  for (std::size_t eye = 0; eye < kEyes; ++eye) {
    const TileGrid grid{mask.bits[eye].size()};
    for (std::uint32_t tile = 0; tile < grid.count(); ++tile) {
      const std::uint32_t column = tile % grid.columns(), row = tile / grid.columns();
      const bool in_block = column >= first_column && column < first_column + 4 && row >= 4 && row < 8;
      if (in_block || (tile + eye) % one_in == 0) mask.received_tiles[eye][tile] = 0;
    }
  }
}

class OverlayGolden : public OnLavapipe {
 protected:
  OverlayGolden() {
    rig_.set_time(Time(500ms));
    older_ = rig_.ask(kOlder, grown(rig_.eyes(moved(head_, 14 * kDegree_rad, {0.06, 0, 0}))));
    rig_.set_time(Time(650ms));
    traced_ = rig_.ask(kTraced, grown(rig_.eyes(moved(head_, 9 * kDegree_rad, {0.04, 0, 0}))));
    lose_tiles(older_, 7, 11);
    lose_tiles(traced_, 6, 7);
    rig_.set_time(Time(800ms));
    shown_ = rig_.show(now_, {traced_.traced_mask(), older_.traced_mask()});
    reference_ = rig_.show_reference(now_);
  }

  [[nodiscard]] PerEye<Image<Rgb8>> drawn(Overlay overlay) const {
    const TracedMask newest = traced_.traced_mask();
    PerEye<Image<Rgb8>> pictures;
    for (const Side side : kSides) {
      const std::size_t eye = index_of(side);
      pictures[eye] = overlay_picture(overlay, {.side = side,
                                                .view = now_[eye],
                                                .shown = shown_.pictures[eye],
                                                .reference = &reference_[eye],
                                                .report = shown_.reports[eye],
                                                .ages = {170ms, 320ms},
                                                .newest = &newest,
                                                .light = 1});
    }
    return pictures;
  }

  TestRig rig_{device_, bundled("room.glb"), kOverlaySide_px};
  Rigid<Stage, Head> head_ = rig_.head();
  StereoView now_ = rig_.eyes(head_);
  Mask older_, traced_;
  Shown shown_;
  PerEye<Image<Rgb8>> reference_;
};

TEST_F(OverlayGolden, OverlaysAreTheirGoldens) {
  for (const Overlay overlay : kDrawn) expect_golden("overlay", name_of(overlay), drawn(overlay));
}

TEST_F(OverlayGolden, RefusesSwappedEyes) {
  for (const Overlay overlay : kDrawn) {
    SCOPED_TRACE(name_of(overlay));
    const PerEye<Image<Rgb8>> pictures = drawn(overlay);
    expect_refused({pictures[1], pictures[0]}, goldens("overlay", name_of(overlay)));
  }
}

/// These goldens contain every colour of every legend.
TEST_F(OverlayGolden, TheFrameHasEverySource) {
  std::array<std::size_t, 256> sources{};
  std::size_t stale = 0;
  for_covered(shown_, [&](Side side, std::uint32_t x, std::uint32_t y, std::uint8_t source) {
    ++sources[source];
    stale += shown_.reports[index_of(side)].stale[std::size_t{y} * kOverlaySide_px + x] != 0;
  });
  for (const std::uint8_t source : {std::uint8_t{0}, std::uint8_t{1}, kOtherEye, kNeighbour, kSourceUnknown})
    EXPECT_GT(sources[source], 50u) << "from " << int{source};
  EXPECT_GT(stale, 500u);
}

struct RayCase {
  const char* name;
  const char* file;
  LightChanges lights;
};

std::ostream& operator<<(std::ostream& out, const RayCase& tested) {
  return out << tested.name;
}

class RaysNeeded : public OnLavapipe, public testing::WithParamInterface<RayCase> {};

TEST_P(RaysNeeded, AreAboutThoseThatATracerSpends) {
  TestRig rig(device_, bundled(GetParam().file), kOverlaySide_px);
  rig.set_lights(GetParam().lights);
  const StereoView views = rig.eyes(rig.head());
  auto tracer = Tracer::create(rig.scene());
  ASSERT_TRUE(tracer) << tracer.error().what;
  ShadowFrame traced;
  const TraceStats spent = tracer->trace(
      {{.frame = kNow, .display_time = {}, .scene_time = {}, .views = views, .lights = GetParam().lights}},
      traced);
  const Mask older = rig.ask(kTraced, rig.eyes(moved(rig.head(), 3 * kDegree_rad, {0.02, 0, 0})));
  for (const std::vector<TracedMask>& masks : {std::vector<TracedMask>{}, {older.traced_mask()}}) {
    const Shown shown = rig.show(views, masks);
    std::uint64_t needed = 0;
    for (const ShownReport& report : shown.reports) {
      needed = std::accumulate(report.rays.begin(), report.rays.end(), needed);
      for (std::size_t i = 0; i < report.sources.size(); ++i)
        EXPECT_LE(report.rays[i], report.sources[i] == kSourceUncovered ? 0u : report.mask.lights());
    }
    const auto mattering = static_cast<double>(spent.shadow_rays);
    RecordProperty("needed_over_spent", std::to_string(static_cast<double>(needed) / mattering));
    EXPECT_NEAR(static_cast<double>(needed), mattering, 0.02 * mattering);
    EXPECT_GT(spent.full_shadow_rays, needed) << "some rays can be skipped";
  }
}

INSTANTIATE_TEST_SUITE_P(
    , RaysNeeded,
    testing::Values(RayCase{"room", "room.glb", {}},
                    RayCase{"room_without_a_light", "room.glb", {{2}, {{1, {2}, false, {}}}}},
                    RayCase{"box_over_plane", "box_over_plane.gltf", {}}),
    [](const auto& tested) { return std::string(tested.param.name); });

}  // namespace
}  // namespace farshade
