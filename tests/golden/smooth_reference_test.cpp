/// The smooth reference is a picture with many pixels, averaged: the samples of its pixels are the centres of
/// the pixels of a larger picture of the same views.
#include "tests/support/smooth_reference.h"
#include "stereo/gltf/gltf.h"
#include "stereo/raster/frame_data.h"
#include "tests/golden/test_rig.h"
#include "vr_client/report/measure.h"

namespace farshade {
namespace {

constexpr std::uint32_t kSide_px = 64, kSamples = 4;

double linear(std::uint8_t srgb) {
  const double s = srgb / 255.0;
  return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
}

/// The mean of the large picture's green light over pixel (x, y) of the small one.
double mean_green(const Image<Rgb8>& large, std::uint32_t x, std::uint32_t y) {
  double sum = 0;
  for (std::uint32_t i = 0; i < kSamples * kSamples; ++i)
    sum += linear(large.at(x * kSamples + i % kSamples, y * kSamples + i / kSamples).g);
  return sum / (kSamples * kSamples);
}

class SmoothReference : public OnLavapipe {};

TEST_F(SmoothReference, IsALargerPictureOfTheSameViewsAveraged) {
  const Scene scene = bundled("box_over_plane.gltf");
  const SceneState state = state_at(scene, Time{});
  Reference reference(Tracer::create_reference(scene).value());
  const auto renderer_of = [&](std::uint32_t side_px) {
    return make_renderer(device_, scene, RendererLimits{{side_px, side_px}, {side_px, side_px}, 1});
  };
  const auto request_of = [&](std::uint32_t side_px) {
    FrameMoment request;
    request.views = eyes_of(head_at_camera(scene), side_px);
    return request;
  };
  const auto small = renderer_of(kSide_px), large = renderer_of(kSide_px * kSamples);
  const FrameMoment request = request_of(kSide_px), larger = request_of(kSide_px * kSamples);
  const PerEye<Image<Rgb8>> smooth = smooth_reference(request, state, kSamples, *small, reference);
  const PerEye<Image<Rgb8>> steps = draw_traced(request, state, reference.trace(request), *small);
  const PerEye<Image<Rgb8>> many = draw_traced(larger, state, reference.trace(larger), *large);
  for (std::size_t eye = 0; eye < kEyes; ++eye) {
    int other = 0, unlike_steps = 0;
    for_pixels(request.views[eye].size, [&](std::uint32_t x, std::uint32_t y) {
      const double expected = mean_green(many[eye], x, y);
      // 2 levels of 255: a level of rounding in each of both pictures.
      other += std::abs(std::pow(linear(smooth[eye].at(x, y).g), 1 / 2.2) - std::pow(expected, 1 / 2.2)) >
               2 / 255.0;
      unlike_steps += std::abs(smooth[eye].at(x, y).g - steps[eye].at(x, y).g) > 8;
    });
    EXPECT_LE(other, 4) << "samples on a silhouette, eye " << eye;
    EXPECT_GT(unlike_steps, 50) << "the edges of eye " << eye << " are steps";
  }
}

TEST(ShiftedView, SeesThroughAPixelWhatTheViewSeesBesideIt) {
  const View view{{}, {-0.7, 0.8, 0.6, -0.5}, {64, 32}};
  const View moved = shifted(view, {0.25, -0.375});
  for (const glm::dvec2 pixel : {glm::dvec2(0, 0), glm::dvec2(10.5, 3.5), glm::dvec2(64, 32)}) {
    const glm::dvec3 a = pixel_ray(tangents_of(moved.fov), moved.size, pixel),
                     b = pixel_ray(tangents_of(view.fov), view.size, pixel + glm::dvec2(0.25, -0.375));
    EXPECT_LT(glm::length(a - b), 1e-12) << pixel.x << ' ' << pixel.y;
  }
}

}  // namespace
}  // namespace farshade
