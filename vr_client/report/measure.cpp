#include "vr_client/report/measure.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "stereo/image/difference.h"
#include "stereo/metrics/flip.h"
#include "stereo/metrics/pixels_per_degree.h"
#include "stereo/metrics/ssim.h"
#include "stereo/raster/frame_data.h"

namespace farshade {
namespace {

/// Calls `visit(x, y, pixel)` for every covered pixel.
template <class Visit>
void for_covered(const ShownReport& shown, Extent size, const Visit& visit) {
  std::size_t pixel = 0;
  for (std::uint32_t y = 0; y < size.height; ++y)
    for (std::uint32_t x = 0; x < size.width; ++x, ++pixel)
      if (shown.sources[pixel] != kSourceUncovered) visit(x, y, pixel);
}

double& share_from(EyeErrors& errors, std::uint8_t source) {
  if (source == kSourceRays) return errors.own_rays;
  if (source >= kNeighbour) return errors.neighbours;
  if (is_face(source)) return errors.cube_mask;
  if (mask_of(source) > 0) return errors.older;
  return source == 0 ? errors.newest : errors.other_eye;
}

/// Of a picture in which single lights cannot be distinguished.
EyeErrors not_shaded(double psnr) {
  constexpr double kNone = kNotMeasured;
  return {kNone, kNone, psnr, kNone, kNone, kNone, kNone, kNone, kNone, kNone, kNone, std::nullopt};
}

}  // namespace

EyeErrors compare_masks(const ShownReport& shown, const EyeMask& reference) {
  EyeErrors errors;
  const MaskLayout layout = reference.layout();
  const std::size_t lights = layout.lights, planes = layout.planes();
  if (lights == 0) return errors;
  double total = 0, wrong = 0, wrong_unknown = 0;
  for_covered(shown, reference.size(), [&](std::uint32_t x, std::uint32_t y, std::size_t pixel) {
    total += static_cast<double>(lights);
    std::size_t unknown = 0;
    for (std::size_t i = 0; i < lights; ++i) {
      const double k = shown.visibility[pixel * lights + i] / 255.0;
      const double error = std::abs(k - reference.lit(x, y, static_cast<std::uint32_t>(i)));
      const bool is_unknown = (shown.unknown[pixel * planes + i / 32] >> i % 32 & 1u) != 0;
      wrong += error;
      wrong_unknown += is_unknown ? error : 0;
      unknown += is_unknown;
    }
    for (std::size_t plane = 0; plane < planes; ++plane)
      errors.stale += std::popcount(shown.stale[pixel * planes + plane]);
    errors.unknown += static_cast<double>(unknown);
    if (shown.sources[pixel] != kSourceUnknown)
      share_from(errors, shown.sources[pixel]) += static_cast<double>(lights - unknown);
  });
  errors.covered = 0;
  if (total == 0) return errors;
  errors.covered = total / static_cast<double>(lights * reference.size().pixels());
  errors.mask_error = wrong / total;
  errors.known_error = total > errors.unknown ? (wrong - wrong_unknown) / (total - errors.unknown) : 0;
  for (double* share : {&errors.newest, &errors.other_eye, &errors.older, &errors.cube_mask,
                        &errors.neighbours, &errors.own_rays, &errors.unknown, &errors.stale})
    *share /= total;
  return errors;
}

double other_surface_share(const Image<float>& drawn_m, const Image<float>& traced_m) {
  constexpr float kSame = 0.01f;
  if (drawn_m.pixels.empty()) return 0;
  std::size_t others = 0;
  for (std::size_t i = 0; i < drawn_m.pixels.size(); ++i) {
    const float drawn = drawn_m.pixels[i], traced = traced_m.pixels[i];
    others += std::abs(drawn - traced) > kSame * std::min(drawn, traced);
  }
  return static_cast<double>(others) / static_cast<double>(drawn_m.pixels.size());
}

double unmoved_error(const EyeMask& stale, glm::ivec2 offset_px, const ShownReport& shown,
                     const EyeMask& reference) {
  double wrong = 0, total = 0;
  const MaskLayout layout = reference.layout();
  for_covered(shown, reference.size(), [&](std::uint32_t x, std::uint32_t y, std::size_t) {
    const auto sx = static_cast<std::int64_t>(x) + offset_px.x,
               sy = static_cast<std::int64_t>(y) + offset_px.y;
    const bool inside = sx >= 0 && sy >= 0 && sx < stale.size().width && sy < stale.size().height;
    total += layout.lights;
    for (std::uint32_t plane = 0; plane < layout.planes(); ++plane) {
      const std::uint32_t truth = reference.word(x, y, plane);
      if (inside) {
        wrong += std::popcount(
            truth ^ stale.word(static_cast<std::uint32_t>(sx), static_cast<std::uint32_t>(sy), plane));
      } else {
        const int lit = std::popcount(truth), dark = static_cast<int>(layout.lights_in(plane)) - lit;
        wrong += lit * (1.0 - double{kUnknownVisibility}) + dark * double{kUnknownVisibility};
      }
    }
  });
  return total == 0 ? 0 : wrong / total;
}

std::optional<double> guard_band_of(const FrameView& view) {
  if (view.request == nullptr) return std::nullopt;
  return static_cast<double>(view.request->views[0].size.pixels()) /
             static_cast<double>(view.shown.views[0].size.pixels()) -
         1;
}

MaskAges ages_of(const FrameView& view) {
  MaskAges ages;
  for (const TracedMask& mask : view.masks) {
    // `age` is that of the first mask. Another mask was requested earlier, or later, by the difference of
    // their display times.
    const Duration before_first = view.masks[0].display_time - mask.display_time;
    ages.push_back(view.age.value_or(Duration::zero()) + before_first);
  }
  ages.resize(kMaxMasks);
  for (const TracedMask& mask : view.cube_mask) ages.push_back(view.shown.display_time - mask.requested_at);
  return ages;
}

std::uint64_t FrameToMeasure::bytes() const {
  std::uint64_t sum = 0;
  for (std::size_t eye = 0; eye < kEyes; ++eye) {
    const ShownReport& of = report[eye];
    sum += std::as_bytes(std::span(pictures[eye].pixels)).size() + newest[eye].bytes().size() +
           of.mask.bytes().size() + of.sources.size() + of.visibility.size() +
           std::as_bytes(std::span(of.positions)).size() + std::as_bytes(std::span(of.unknown)).size() +
           std::as_bytes(std::span(of.stale)).size() + std::as_bytes(std::span(of.rays)).size();
  }
  return sum;
}

FrameToMeasure read_back(const FrameView& view, Renderer& renderer) {
  FrameToMeasure frame{.shown = view.shown, .state = view.state, .as = view.as, .ages = ages_of(view)};
  if (view.as == ShownAs::Shaded) {
    for (const Side side : kSides) frame.report[index_of(side)] = renderer.report(side);
    if (!view.masks.empty()) {
      frame.traced = view.masks[0].views;
      frame.newest = view.masks[0].masks;
    }
  }
  frame.pictures = renderer.read_shown();
  return frame;
}

PerEye<Image<Rgb8>> draw_traced(const FrameMoment& shown, const SceneState& state, const TracedMask& traced,
                                Renderer& renderer) {
  renderer.draw({.views = shown.views,
                 .state = state,
                 .masks = {&traced, 1},
                 .reprojection = {.lookup = Lookup::Direct},
                 .detail = Detail::Full});
  return renderer.read_shown();
}

PerEye<EyeErrors> measure(FrameToMeasure frame, Renderer& renderer, Reference& reference,
                          MeasuredFrame& into) {
  into.frame = frame.shown.frame;
  into.ages = std::move(frame.ages);
  into.report = std::move(frame.report);
  into.shown = std::move(frame.pictures);
  const TracedMask truth = reference.trace(frame.shown);
  into.reference = draw_traced(frame.shown, frame.state, truth, renderer);
  const PerEye<Image<float>> drawn = renderer.read_distance(), traced = reference.distances(frame.shown);

  const bool shaded = frame.as == ShownAs::Shaded;
  PerEye<EyeErrors> errors;
  tbb::parallel_for(std::size_t{0}, kEyes, [&](std::size_t eye) {
    const double psnr = std::min(psnr_db(into.shown[eye], into.reference[eye]), kEqualPictures_dB);
    errors[eye] = shaded ? compare_masks(into.report[eye], truth.masks[eye]) : not_shaded(psnr);
    errors[eye].psnr_db = psnr;
    const double degree_px = pixels_per_degree(frame.shown.views[eye]);
    into.flip[eye] = flip(into.reference[eye], into.shown[eye], degree_px);
    errors[eye].flip = mean(into.flip[eye]);
    errors[eye].ssim = ssim(into.shown[eye], into.reference[eye]);
    errors[eye].other_surface = other_surface_share(drawn[eye], traced[eye]);
    if (frame.newest[eye].size().pixels() == 0) return;
    errors[eye].unmoved_error =
        unmoved_error(frame.newest[eye], grid_offset_px(frame.shown.views[eye], frame.traced[eye]),
                      into.report[eye], truth.masks[eye]);
  });
  return errors;
}

PerEye<EyeErrors> measure(const FrameView& view, Renderer& renderer, Reference& reference,
                          MeasuredFrame& into) {
  return measure(read_back(view, renderer), renderer, reference, into);
}

}  // namespace farshade
