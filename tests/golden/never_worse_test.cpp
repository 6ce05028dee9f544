/// Reprojection is never worse than no reprojection. Along head recordings, in every frame, the mask error of
/// each eye is at most that of the same stale mask shown without reprojection. Masks are four frames old,
/// without prediction or guard band, and the scene is animated. The same for a head that hardly turns, with
/// one and with four masks, where nothing else moves.
#include <cmath>
#include <cstdio>
#include <numbers>
#include <span>

#include "stereo/gltf/gltf.h"
#include "stereo/head/reader.h"
#include "stereo/raster/frame_data.h"
#include "tests/golden/test_rig.h"
#include "tests/support/nightly.h"
#include "tests/support/test_place.h"
#include "vr_client/report/measure.h"

namespace farshade {
namespace {

constexpr std::uint32_t kSide_px = 256;
constexpr double kRefresh_hz = 72;
constexpr int kLag = 4;  ///< frames

struct Walk {
  const char* name;
  std::string scene, trace;
  int first, every;  ///< frames
};

std::ostream& operator<<(std::ostream& out, const Walk& walk) {
  return out << walk.name;
}

template <class T>
T value_of(Expected<T> value) {
  if (!value) throw std::runtime_error(value.error().what);
  return std::move(*value);
}

class NeverWorse : public OnLavapipe, public testing::WithParamInterface<Walk> {
 protected:
  StereoView views_at(Time since_start) const {
    const Rigid<Stage, Head> head =
        stage_from_recorded_ * head_at(recording_, recording_.start() + since_start.time_since_epoch());
    StereoView views;
    for (const Side side : kSides)
      views[index_of(side)] = {head * head_from_eye(side, recording_.eye_distance_m),
                               recording_.fov[index_of(side)],
                               {kSide_px, kSide_px}};
    return views;
  }

  TestRig rig_{device_, value_of(load_scene(GetParam().scene)), kSide_px};
  /// With its tilt: given axes are not levelled, so the compared frames do not depend on how tilts are found.
  HeadRecording recording_ = value_of(load_head_recording(GetParam().trace, {.axes = Axes()}));
  Rigid<Stage, Recorded> stage_from_recorded_ = place(recording_, *rig_.scene().camera);
};

Time time_of(int frame) {
  return Time(Duration(std::llround(frame * 1e9 / kRefresh_hz)));
}

TEST_P(NeverWorse, ThanTheStaleMaskWithoutReprojection) {
  double sum = 0, sum_unmoved = 0;
  int frames = 0;
  for (int frame = GetParam().first;
       recording_.start() + time_of(frame).time_since_epoch() <= recording_.end();
       frame += GetParam().every, ++frames) {
    const StereoView now = views_at(time_of(frame));
    rig_.set_time(time_of(frame - kLag));
    const Mask stale = rig_.ask(FrameId{static_cast<std::uint32_t>(frame)}, views_at(time_of(frame - kLag)));
    rig_.set_time(time_of(frame));
    const Shown shown = rig_.show(now, {stale.traced_mask()});
    const Mask truth = rig_.trace(FrameId{}, now);
    for (const Side side : kSides) {
      const std::size_t eye = index_of(side);
      const EyeErrors errors = compare_masks(shown.reports[eye], truth.bits[eye]);
      const double unmoved = unmoved_error(stale.bits[eye], grid_offset_px(now[eye], stale.views[eye]),
                                           shown.reports[eye], truth.bits[eye]);
      EXPECT_LE(errors.mask_error, unmoved)
          << "frame " << frame << ", " << name_of(side) << ": unknown " << errors.unknown << ", known error "
          << errors.known_error << ", stale " << errors.stale << ", neighbours " << errors.neighbours;
      sum += errors.mask_error;
      sum_unmoved += unmoved;
    }
  }
  EXPECT_GT(frames, 10);
  RecordProperty("mean_error", std::to_string(sum / (2 * frames)));
  RecordProperty("mean_error_unmoved", std::to_string(sum_unmoved / (2 * frames)));
}

const std::string kRoom = asset("room.glb");

INSTANTIATE_TEST_SUITE_P(, NeverWorse, testing::Values(Walk{"Bundled", kRoom, asset("walk.csv"), 24, 24}),
                         testing::PrintToStringParamName());
#ifdef FARSHADE_SHARED_SCENES
const std::string kLivingRoom = shared_scene("modern_living_room.glb");

std::string user(const std::string& number) {
  return shared_trace("eyenavgs_truck_user" + number + ".csv");
}

INSTANTIATE_TEST_SUITE_P(Recorded, NeverWorse,
                         testing::Values(Walk{"User101", kLivingRoom, user("101"), 144, 288},
                                         Walk{"User102", kRoom, user("102"), 144, 288},
                                         Walk{"User104", kLivingRoom, user("104"), 144, 288}),
                         testing::PrintToStringParamName());
#endif

constexpr std::uint32_t kSlowSide_px = 384;

/// Means over both eyes and all directions, %.
struct SlowErrors {
  double shown = 0, nearest = 0, unmoved = 0;
  double above = -100;  ///< the largest difference between `shown` and `unmoved` in one eye
};

/// A direction, and its mask without error.
struct SlowView {
  double yaw_rad;
  Mask truth;
};

/// The masks were traced one, two... steps ago. A step turns the head by `step_deg`.
class SlowHead : public OnLavapipe {
 protected:
  SlowHead() {
    for (const double yaw_rad : std::span(kYaws).first(nightly<std::size_t>(3, kYaws.size())))
      looks_.push_back({yaw_rad, rig_.trace(FrameId{}, views_after(yaw_rad, 0, 0))});
  }

  StereoView views_after(double yaw_rad, double step_deg, int steps) const {
    const double angle = step_deg * steps / 180 * std::numbers::pi;
    return eyes_of(moved(rig_.head(), yaw_rad + 0.8 * angle, {0.01 * angle, 0, 0}) *
                       Rigid<Head, Head>{glm::angleAxis(0.6 * angle, glm::dvec3(1, 0, 0)), {}},
                   kSlowSide_px);
  }

  /// Of the first of `masks` alone, or of all.
  void add_errors(const SlowView& look, std::span<const Mask> masks, SlowErrors& sum) {
    const StereoView now = views_after(look.yaw_rad, 0, 0);
    std::vector<TracedMask> traced;
    for (const Mask& mask : masks) traced.push_back(mask.traced_mask());
    const Shown shown = rig_.show(now, traced), nearest = rig_.show(now, traced, {.edges = Edges::Nearest});
    for (std::size_t eye = 0; eye < kEyes; ++eye) {
      const auto error_of = [&](const Shown& picture) {
        return 100 * compare_masks(picture.reports[eye], look.truth.bits[eye]).mask_error;
      };
      const double unmoved =
          100 * unmoved_error(masks[0].bits[eye], grid_offset_px(now[eye], masks[0].views[eye]),
                              shown.reports[eye], look.truth.bits[eye]);
      const auto of_all = static_cast<double>(kEyes * looks_.size());
      sum.shown += error_of(shown) / of_all;
      sum.nearest += error_of(nearest) / of_all;
      sum.unmoved += unmoved / of_all;
      sum.above = std::max(sum.above, error_of(shown) - unmoved);
    }
  }

  /// The errors with one mask and with four.
  std::array<SlowErrors, 2> errors_with(double step_deg) {
    std::array<SlowErrors, 2> errors;
    for (const SlowView& look : looks_) {
      std::vector<Mask> masks;
      for (int i = 1; i <= 4; ++i)
        masks.push_back(
            rig_.ask(FrameId{10 - static_cast<std::uint32_t>(i)}, views_after(look.yaw_rad, step_deg, -i)));
      add_errors(look, std::span(masks).first(1), errors[0]);
      add_errors(look, masks, errors[1]);
    }
    return errors;
  }

  static constexpr std::array kYaws{0.0, 1.2, -1.0, 0.8, 2.0, 2.6};
  TestRig rig_{device_, bundled("room.glb"), kSlowSide_px, 8};
  std::vector<SlowView> looks_;
};

// A filter over masks that sample an edge at almost the same places is worse than the nearest sample. The
// default must serve both: it is compared with no reprojection, and with the nearest sample.
TEST_F(SlowHead, IsNeverWorseThanTheStaleMaskWithoutReprojection) {
  constexpr std::array kSteps_deg{0.01, 0.02, 0.05, 0.2, 0.002, 0.03, 2.0};
  for (const double step_deg : std::span(kSteps_deg).first(nightly<std::size_t>(4, kSteps_deg.size()))) {
    const std::array<SlowErrors, 2> errors = errors_with(step_deg);
    for (const int masks : {1, 4}) {
      const SlowErrors& mean = errors[masks == 4];
      std::printf(
          "%d masks, %.3f degrees (%.2f px): mask error %.3f %%, nearest %.3f, unmoved %.3f, "
          "%.3f above it\n",
          masks, step_deg, step_deg * kSlowSide_px / 63, mean.shown, mean.nearest, mean.unmoved, mean.above);
      EXPECT_LE(mean.above, 0.015) << "a few pixels at silhouettes";
      EXPECT_LT(mean.shown, 0.9 * mean.unmoved);
      EXPECT_LE(mean.shown, mean.nearest);
      EXPECT_TRUE(masks < 4 || step_deg < 0.1 || mean.shown < 0.75 * mean.nearest);
    }
  }
}

}  // namespace
}  // namespace farshade
