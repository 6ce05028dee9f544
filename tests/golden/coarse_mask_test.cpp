/// Masks with fewer pixels than the shown views: shadow edges are coarser, but not displaced.
#include <cmath>
#include <cstdlib>
#include <numbers>

#include "stereo/image/codec.h"
#include "stereo/image/difference.h"
#include "stereo/math/rotation.h"
#include "stereo/requests/request_plan.h"
#include "tests/golden/test_rig.h"

namespace farshade {
namespace {

using namespace std::chrono_literals;

constexpr std::uint32_t kCoarseSide_px = 256;

/// The views that a request plan asks for at that size.
StereoView requested_views(ViewScale scale, const StereoView& shown, GuardBandUse guard_band) {
  RequestPlan plan({.predictor = PredictorKind::Hold, .guard_band = guard_band});
  plan.shrink(scale);
  StereoView before = shown;  // a head that turns: the guard band widens
  for (View& view : before) view.stage_from_eye.rotation *= rotation_exp({0, 0.02, 0});
  (void)plan.ask({FrameId{1}, Time(0ms), Time{}, before}, 14ms);
  return plan.ask({FrameId{2}, Time(14ms), Time{}, shown}, 14ms)->views;
}

class CoarseMask : public OnLavapipe {
 protected:
  TestRig rig_{device_, bundled("room.glb"), kCoarseSide_px};
  StereoView shown_ = rig_.eyes(moved(rig_.head(), 0.02, {0.02, 0.01, 0.01}));
  PerEye<Image<Rgb8>> reference_ = rig_.show_reference(shown_);

  /// The lower PSNR of the two eyes.
  double psnr_of(const StereoView& traced_for, const Reprojection& reprojection = {}) {
    const Mask traced = rig_.ask(kTraced, traced_for);
    const PerEye<Image<Rgb8>> pictures = rig_.show(shown_, {traced.traced_mask()}, reprojection).pictures;
    if (const char* folder = std::getenv("FARSHADE_KEEP_PICTURES"))
      (void)write_png(std::string(folder) + "/coarse_" + std::to_string(traced_for[0].size.width) + ".png",
                      pictures[0]);
    return std::min(psnr_db(pictures[0], reference_[0]), psnr_db(pictures[1], reference_[1]));
  }
};

TEST_F(CoarseMask, CostsSomeDecibelsAndNoMore) {
  const StereoView requested = rig_.eyes(rig_.head());
  double finer = psnr_of(requested);
  RecordProperty("db_at_8", std::to_string(finer));
  for (const std::uint32_t eighths : {6u, 4u, 2u}) {
    for (const GuardBandUse guard_band : {GuardBandUse::Off, GuardBandUse::Measured}) {
      const double db = psnr_of(requested_views({eighths}, requested, guard_band));
      RecordProperty("db_at_" + std::to_string(eighths), std::to_string(db));
      EXPECT_GT(db, finer - 4) << eighths << " eighths, guard band " << static_cast<int>(guard_band);
      if (guard_band == GuardBandUse::Measured) finer = db;
    }
  }
}

TEST_F(CoarseMask, ReadAtTheShownPixelIsNotShifted) {
  // The guess for unknown points and Lookup::Direct read the traced pixel in the same direction.
  const StereoView fine = rig_.eyes(rig_.head());
  shown_ = fine;
  reference_ = rig_.show_reference(shown_);
  const double placed =
      psnr_of(requested_views({4}, fine, GuardBandUse::Measured), {.lookup = Lookup::Direct});
  RecordProperty("db", std::to_string(placed));
  StereoView turned = requested_views({4}, fine, GuardBandUse::Measured);
  for (View& view : turned) view.stage_from_eye.rotation *= rotation_exp({0, 0.008, 0});  // two shown pixels
  EXPECT_GT(placed, psnr_of(turned, {.lookup = Lookup::Direct}) + 1);
}

}  // namespace
}  // namespace farshade
