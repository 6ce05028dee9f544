#include "vr_client/report/measured_frame.h"

#include <algorithm>

#include "stereo/image/difference.h"

namespace farshade {

MaskAges ages_of(const FrameView& view) {
  MaskAges ages;
  for (const TracedMask& mask : view.masks) {
    // `age` is that of the newest mask. An older mask was requested earlier by the difference of their
    // display times.
    const Duration since_newest = view.masks[0].display_time - mask.display_time;
    ages.push_back(view.age.value_or(Duration::zero()) + since_newest);
  }
  return ages;
}

PerEye<EyeErrors> measure(const FrameView& view, Renderer& renderer, Reference& reference,
                          MeasuredFrame& into) {
  into.frame = view.shown.frame;
  into.ages = ages_of(view);
  const bool shaded = view.as == ShownAs::Shaded;
  for (const Side side : kSides) into.report[index_of(side)] = shaded ? renderer.report(side) : ShownReport{};
  into.shown = renderer.read_shown();
  const TracedMask truth = reference.trace(view.shown);
  const ShownFrame right{.views = view.shown.views,
                         .state = view.state,
                         .masks = {&truth, 1},
                         .carry_over = {.lookup = Lookup::Direct}};
  if (shaded)
    renderer.shade_again(right);
  else
    renderer.draw(right);
  into.reference = renderer.read_shown();

  PerEye<EyeErrors> errors;
  for (std::size_t eye = 0; eye < kEyes; ++eye) {
    const double psnr = std::min(psnr_db(into.shown[eye], into.reference[eye]), kEqualPictures_dB);
    if (!shaded) {
      errors[eye] = picture_errors(psnr);
      continue;
    }
    errors[eye] = compare_masks(into.report[eye], truth.masks[eye]);
    errors[eye].psnr_db = psnr;
    if (view.masks.empty()) continue;
    const View& traced = view.masks[0].views[eye];
    errors[eye].unmoved_error =
        unmoved_error(view.masks[0].masks[eye], grid_offset_px(view.shown.views[eye], traced),
                      into.report[eye], truth.masks[eye]);
  }
  return errors;
}

}  // namespace farshade
