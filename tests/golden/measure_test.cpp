/// A measured frame tells whether its picture is the reference's, and whether rasteriser and tracer see the
/// same surfaces.
#include "vr_client/report/measure.h"
#include "tests/golden/test_rig.h"

namespace farshade {
namespace {

constexpr std::uint32_t kSide_px = 64;

class Measure : public OnLavapipe {
 protected:
  /// Measures the reference's own picture of a bundled scene, drawn `late` after the time that is traced.
  PerEye<EyeErrors> errors_of(const char* name, Duration late) {
    const Scene scene = bundled(name);
    Reference reference(Tracer::create_reference(scene).value());
    const std::unique_ptr<Renderer> renderer_owner =
        make_renderer(device_, scene, RendererLimits{{kSide_px, kSide_px}, {kSide_px, kSide_px}, 1});
    Renderer& renderer = *renderer_owner;
    FrameMoment shown;
    shown.views = eyes_of(head_at_camera(scene), kSide_px);
    FrameToMeasure frame{.shown = shown, .state = state_at(scene, Time{} + late), .as = ShownAs::Picture};
    frame.pictures = draw_traced(shown, state_at(scene, Time{}), reference.trace(shown), renderer);
    return measure(std::move(frame), renderer, reference, measured_);
  }

  MeasuredFrame measured_;
};

TEST_F(Measure, APictureOfTheReferenceIsEqualAndShowsTheSameSurfaces) {
  for (const char* name : {"room.glb", "box_over_plane.gltf"})
    for (const EyeErrors& eye : errors_of(name, {})) {
      EXPECT_EQ(eye.psnr_db, kEqualPictures_dB) << name;
      EXPECT_EQ(eye.flip, 0) << name;
      EXPECT_NEAR(eye.ssim, 1, 1e-6) << name;
      EXPECT_LT(eye.other_surface, 0.01) << name << ": pixels on silhouettes";
    }
}

TEST_F(Measure, SurfacesThatMovedAreOtherSurfaces) {
  for (const EyeErrors& eye : errors_of("room.glb", std::chrono::milliseconds(1500))) {
    EXPECT_GT(eye.other_surface, 0.005);
    EXPECT_LT(eye.psnr_db, 60);
    EXPECT_GT(eye.flip, 0.001);
    EXPECT_LT(eye.ssim, 0.999);
  }
  EXPECT_EQ(measured_.flip[1].size, (Extent{kSide_px, kSide_px}));
}

}  // namespace
}  // namespace farshade
