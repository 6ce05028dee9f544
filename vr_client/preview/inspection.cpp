#include "vr_client/preview/inspection.h"

#include <cmath>

#include "stereo/base/check.h"
#include "stereo/image/difference.h"

namespace farshade {

bool shows_through(Overlay overlay) {
  return overlay == Overlay::Source || overlay == Overlay::Age || overlay == Overlay::Light ||
         overlay == Overlay::Rays;
}

Image<Rgb8> seen_through(Image<Rgb8> overlay, const Image<Rgb8>& picture, double share) {
  check(overlay.size == picture.size, "an overlay has the size of its picture");
  const auto through = static_cast<std::uint32_t>(std::lround(share * 256)), rest = 256 - through;
  for (std::size_t i = 0; i < overlay.pixels.size(); ++i) {
    const Rgb8 below = picture.pixels[i];
    // Rec. 709 luma, in 256ths.
    const std::uint32_t grey = (54u * below.r + 183u * below.g + 19u * below.b) >> 8;
    for (int channel = 0; channel < 3; ++channel)
      overlay.pixels[i][channel] =
          static_cast<std::uint8_t>((overlay.pixels[i][channel] * rest + grey * through + 128) >> 8);
  }
  return overlay;
}

Image<Rgb8> overlaid(const OverlayInput& input, const Controls& controls) {
  Image<Rgb8> picture = overlay_picture(controls.overlay, input);
  if (!shows_through(controls.overlay)) return picture;
  return seen_through(std::move(picture), input.shown, controls.picture_share);
}

const PerEye<Image<Rgb8>>& Inspection::shown() {
  if (read_ == Shown::NotRead) frame_.shown = renderer_->read_shown();
  read_ = Shown::Read;
  return frame_.shown;
}

PixelFacts Inspection::pixel(const FrameView& view, Side side, glm::uvec2 pixel) const {
  return {side,
          pixel,
          renderer_->read_surface(side, pixel),
          renderer_->report(side, {pixel.x, pixel.y, pixel.x + 1, pixel.y + 1}),
          ages_of(view),
          view.masks.size()};
}

Image<Rgb8> Inspection::overlaid(Side side, const FrameView& view, const Controls& controls) const {
  const std::size_t eye = index_of(side);
  return farshade::overlaid({.side = side,
                             .view = view.shown.views[eye],
                             .shown = frame_.shown[eye],
                             .reference = measured_ == Measured::Yes ? &frame_.reference[eye] : nullptr,
                             .report = frame_.report[eye],
                             .ages = frame_.ages,
                             .newest = view.masks.empty() ? nullptr : &view.masks[0],
                             .light = controls.light},
                            controls);
}

void Inspection::begin(Renderer& renderer) {
  renderer_ = &renderer;
  errors_.reset();
  read_ = Shown::NotRead;
  measured_ = Measured::No;
}

void Inspection::inspect(const FrameView& view, const Controls& controls, Reference* reference) {
  replacement_.reset();
  // The controls may have changed since the frame was drawn. A frame without a report cannot be inspected.
  if (view.settings.report == PixelReport::Off || view.as == ShownAs::Picture) return;
  // A frame that was measured is no longer in the renderer.
  if (!replaces_pictures(controls) && measured_ == Measured::No) return;
  if (needs_reference(controls) && measured_ == Measured::No) {
    check(reference != nullptr, "a reference exists when the controls need one");
    errors_ = measure(view, *renderer_, *reference, frame_);
    read_ = Shown::Read;
    measured_ = Measured::Yes;  // the renderer now holds the reference's picture
  } else if (measured_ == Measured::No) {
    frame_.ages = ages_of(view);
    for (const Side side : kSides) frame_.report[index_of(side)] = renderer_->report(side);
    (void)shown();
  }
  replacement_ = {overlaid(Side::Left, view, controls), overlaid(Side::Right, view, controls)};
  if (controls.display == DisplayMode::Difference)
    (*replacement_)[1] = difference_x8(frame_.shown[0], frame_.reference[0]);
}

}  // namespace farshade
