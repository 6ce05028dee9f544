/// What the lenses hide: hidden pixels have no surface, all others are as without a lens, and requests do not
/// ask for what surely stays hidden.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include "stereo/base/check.h"
#include "tests/golden/test_rig.h"
#include "vr_client/modes/make_pipeline.h"

namespace farshade {
namespace {

constexpr double kLensDegree = std::numbers::pi / 180;
constexpr std::uint32_t kLensSide_px = 256;
constexpr double kLens_tan = 0.55;  ///< of the seen circle's edge
/// The edge is a polygon, and pixels have a size: pixels at the edge are not looked at.
constexpr double kUnsure_tan = 0.006;

/// A round lens about the axis of each eye.
PerEye<HiddenArea> lenses(double radius = kLens_tan) {
  constexpr int kCorners = 64;
  HiddenArea area;
  const auto at = [](int i, double distance) {
    const double angle = 2 * std::numbers::pi * i / kCorners;
    return glm::vec2(distance * std::cos(angle), distance * std::sin(angle));
  };
  for (int i = 0; i < kCorners; ++i)
    for (const glm::vec2& corner :
         {at(i, radius), at(i, 2), at(i + 1, 2), at(i, radius), at(i + 1, 2), at(i + 1, radius)})
      area.corners.push_back(corner);
  return {area, area};
}

/// The tangent of the angle between a pixel's ray and the axis.
double distance_from_axis(const View& view, std::uint32_t x, std::uint32_t y) {
  return glm::length(glm::dvec2(pixel_ray(tangents_of(view.fov), view.size, {x + 0.5, y + 0.5})));
}

bool is_hidden(const View& view, std::uint32_t x, std::uint32_t y, double radius = kLens_tan) {
  return distance_from_axis(view, x, y) > radius + kUnsure_tan;
}
bool is_seen(const View& view, std::uint32_t x, std::uint32_t y, double radius = kLens_tan) {
  return distance_from_axis(view, x, y) < radius - kUnsure_tan;
}

/// The share of pixels of both eyes for which `is` holds.
double share(const StereoView& views,
             const std::function<bool(std::size_t, std::uint32_t, std::uint32_t)>& is) {
  std::size_t count = 0;
  for (std::size_t eye = 0; eye < kEyes; ++eye)
    for_pixels(views[eye].size, [&](std::uint32_t x, std::uint32_t y) { count += is(eye, x, y); });
  return static_cast<double>(count) / static_cast<double>(kEyes * views[0].size.pixels());
}

class HiddenAreas : public OnLavapipe {
 protected:
  /// Every side of the room is a surface.
  TestRig rig_{device_, bundled("room.glb"), kLensSide_px};
};

TEST_F(HiddenAreas, HaveNoSurfaceAndLeaveAllOtherPixelsAsTheyAre) {
  const StereoView views = rig_.eyes(rig_.head());
  const Mask mask = rig_.ask(kTraced, rig_.eyes(moved(rig_.head(), kLensDegree, {0.01, 0, 0})));
  const Shown whole = rig_.show(views, {mask.traced_mask()});
  rig_.hide(lenses());
  const Shown seen = rig_.show(views, {mask.traced_mask()});
  const PerEye<Image<float>> distance = rig_.renderer().read_distance();
  for (std::size_t eye = 0; eye < kEyes; ++eye) {
    std::size_t wrong_hidden = 0, wrong_seen = 0, hidden = 0, seen_count = 0;
    for_pixels(views[eye].size, [&](std::uint32_t x, std::uint32_t y) {
      const std::size_t i = std::size_t{y} * kLensSide_px + x;
      if (is_hidden(views[eye], x, y)) {
        ++hidden;
        wrong_hidden += seen.reports[eye].sources[i] != kSourceUncovered || distance[eye].pixels[i] != 0 ||
                        seen.pictures[eye].pixels[i] != seen.pictures[0].pixels[0];
      } else if (is_seen(views[eye], x, y)) {
        ++seen_count;
        const std::size_t lights = seen.reports[eye].mask.lights();
        const auto visibility = [&](const Shown& shown) {
          return std::span(shown.reports[eye].visibility).subspan(i * lights, lights);
        };
        wrong_seen += seen.pictures[eye].pixels[i] != whole.pictures[eye].pixels[i] ||
                      seen.reports[eye].sources[i] != whole.reports[eye].sources[i] ||
                      !std::ranges::equal(visibility(seen), visibility(whole));
      }
    });
    EXPECT_EQ(wrong_hidden, 0u) << eye;
    EXPECT_EQ(wrong_seen, 0u) << eye;
    EXPECT_GT(hidden, 10'000u);
    EXPECT_GT(seen_count, 30'000u);
  }
}

/// The lens is the same in directions, whatever part of the plane the picture shows.
TEST_F(HiddenAreas, FollowAFieldOfViewThatChanges) {
  StereoView views = rig_.eyes(rig_.head());
  views[0].fov = {-0.7, 0.4, 0.3, -0.75};
  static_cast<void>(rig_.show(views, {}));
  const PerEye<Image<float>> whole = rig_.renderer().read_distance();
  rig_.hide(lenses());
  static_cast<void>(rig_.show(views, {}));
  const PerEye<Image<float>> seen = rig_.renderer().read_distance();
  EXPECT_EQ(share(views,
                  [&](std::size_t eye, std::uint32_t x, std::uint32_t y) {
                    const std::size_t i = std::size_t{y} * kLensSide_px + x;
                    const float distance = seen[eye].pixels[i];
                    return (is_hidden(views[eye], x, y) && distance > 0) ||
                           (is_seen(views[eye], x, y) && distance != whole[eye].pixels[i]);
                  }),
            0);
}

TEST_F(HiddenAreas, AreNotAskedFor) {
  const StereoView before = rig_.eyes(rig_.head());
  const StereoView views = rig_.eyes(moved(rig_.head(), 3 * kLensDegree, {0.05, 0, 0}));
  const Mask base = rig_.ask(kTraced, before);
  const RequestReprojection whole = rig_.reproject_to_request(kNow, views, base).value();
  rig_.hide(lenses());
  const RequestReprojection seen = rig_.reproject_to_request(kNow, views, base).value();
  const double surely = std::tan(std::atan(kLens_tan) + (kLeastTurn_deg + 1.5) * kLensDegree);
  const auto requested = [&](const RequestReprojection& reprojected) {
    return [&](std::size_t eye, std::uint32_t x, std::uint32_t y) {
      return requested_bits(reprojected.requested, eye, views[eye].size, {x, y}) != 0;
    };
  };
  const auto covered = [&](const RequestReprojection& reprojected, std::size_t eye, std::uint32_t x,
                           std::uint32_t y) {
    const std::size_t tile = y / kTileSide_px * TileGrid{views[eye].size}.columns() + x / kTileSide_px;
    return (reprojected.covered[eye][tile] & block_bit(x % kTileSide_px, y % kTileSide_px)) != 0;
  };
  const double requested_whole = share(views, requested(whole)),
               requested_seen = share(views, requested(seen));
  RecordProperty("asked_percent_whole", std::to_string(100 * requested_whole));
  RecordProperty("asked_percent_seen", std::to_string(100 * requested_seen));
  EXPECT_GT(requested_whole, 0.02);
  EXPECT_LT(requested_seen, requested_whole);
  EXPECT_EQ(share(views,
                  [&](std::size_t eye, std::uint32_t x, std::uint32_t y) {
                    const bool hidden = is_hidden(views[eye], x, y, surely);
                    return hidden && (requested(seen)(eye, x, y) || covered(seen, eye, x, y));
                  }),
            0);
  EXPECT_EQ(share(views,
                  [&](std::size_t eye, std::uint32_t x, std::uint32_t y) {
                    const bool is = is_seen(views[eye], x, y);
                    return is && (requested(seen)(eye, x, y) != requested(whole)(eye, x, y) ||
                                  covered(seen, eye, x, y) != covered(whole, eye, x, y));
                  }),
            0);
}

/// A request hides less than the frame does: its mask is used when the eyes have turned. `edge` is the part
/// of the seen circle that was hidden by the same lenses at the traced views, and is within them now.
TEST_F(HiddenAreas, LeaveMasksKnownWhereTheEyesTurnTo) {
  const StereoView traced = rig_.eyes(rig_.head());
  const Mask base = rig_.ask(kOlder, traced);
  // The mask is used at these views; its depth is that of what `hidden` leaves.
  const auto unknown_at_edge = [&](const PerEye<HiddenArea>& hidden, double yaw_rad) {
    rig_.hide(hidden);
    static_cast<void>(rig_.reproject_to_request(kTraced, traced, base));
    const Mask mask = rig_.trace(kTraced, traced);
    const StereoView views = rig_.eyes(moved(rig_.head(), yaw_rad, {}));
    const Shown shown = rig_.show(views, {mask.traced_mask()}, kPlainReprojection);
    return share(views, [&](std::size_t eye, std::uint32_t x, std::uint32_t y) {
      return is_seen(views[eye], x, y, 0.45) && distance_from_axis(views[eye], x, y) > 0.42 &&
             shown.reports[eye].sources[std::size_t{y} * kLensSide_px + x] == kSourceUnknown;
    });
  };
  for (const double yaw_rad : {1.8 * kLensDegree, -1.8 * kLensDegree}) {
    const double without = unknown_at_edge({}, yaw_rad), with = unknown_at_edge(lenses(0.45), yaw_rad);
    std::printf("unknown at the edge: %.5f without lenses, %.5f with them\n", without, with);
    EXPECT_LE(with, without + 0.0002);
  }
}

TEST_F(HiddenAreas, NeedPipelinesOnlyIfSomethingIsHidden) {
  const StereoView views = rig_.eyes(rig_.head());
  static_cast<void>(rig_.show(views, {}));
  const std::size_t before = rig_.renderer().counters().pipelines;
  rig_.hide({});
  static_cast<void>(rig_.show(views, {}));
  EXPECT_EQ(rig_.renderer().counters().pipelines, before);
  rig_.hide(lenses());
  static_cast<void>(rig_.show(views, {}));
  EXPECT_EQ(rig_.renderer().counters().pipelines, before + 1);
}

/// Shows one frame of a head that does not move, through lenses.
class OneFrame final : public Runtime {
 public:
  explicit OneFrame(const StereoView& views) : views_(views) {}
  [[nodiscard]] std::optional<FrameTiming> wait_frame() override {
    if (std::exchange(shown_, true)) return std::nullopt;
    return FrameTiming{Time(std::chrono::seconds(1)), std::chrono::milliseconds(11)};
  }
  [[nodiscard]] StereoView locate_views(Time) override { return views_; }
  [[nodiscard]] const PerEye<HiddenArea>* hidden() const override { return &hidden_; }

 private:
  StereoView views_;
  PerEye<HiddenArea> hidden_ = lenses();
  bool shown_ = false;
};

class HiddenAreasOfModes : public OnLavapipe, public testing::WithParamInterface<Mode> {};

TEST_P(HiddenAreasOfModes, AreThoseOfTheRuntime) {
  const Scene scene = bundled("room.glb");
  const std::unique_ptr<Renderer> renderer_owner = make_renderer(
      device_, scene, RendererLimits{{kLensSide_px, kLensSide_px}, {kLensSide_px, kLensSide_px}, 2});
  Renderer& renderer = *renderer_owner;
  const StereoView views = eyes_of(head_at_camera(scene), kLensSide_px);
  OneFrame runtime(views);
  const FrameSettings settings;
  const RunContext context{.scene = scene,
                           .runtime = runtime,
                           .renderer = renderer,
                           .mode = {.mode = GetParam()},
                           .settings = settings,
                           .policy = {}};
  ASSERT_TRUE(run(
      context, *make_pipeline(context), [](const FrameView&) {}, [] { return false; }));
  const PerEye<Image<float>> distance = renderer.read_distance();
  EXPECT_EQ(distance[0].pixels[0], 0);
  EXPECT_GT(distance[0].pixels[kLensSide_px * kLensSide_px / 2 + kLensSide_px / 2], 0);
}

INSTANTIATE_TEST_SUITE_P(ThatDraw, HiddenAreasOfModes, testing::Values(Mode::Hybrid, Mode::Local, Mode::Full),
                         [](const auto& mode) { return std::string(name_of(mode.param)); });

}  // namespace
}  // namespace farshade
