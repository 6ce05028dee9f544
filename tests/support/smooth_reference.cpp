#include "tests/support/smooth_reference.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "vr_client/report/measure.h"

namespace farshade {
namespace {

/// Linear light of each sRGB value (IEC 61966-2-1), 0 to 1.
std::array<float, 256> linear_of_srgb() {
  std::array<float, 256> linear{};
  for (std::size_t i = 0; i < linear.size(); ++i) {
    const double s = static_cast<double>(i) / 255;
    linear[i] = static_cast<float>(s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4));
  }
  return linear;
}

std::uint8_t srgb_of_linear(float linear) {
  const double s =
      linear <= 0.0031308f ? 12.92 * double{linear} : 1.055 * std::pow(double{linear}, 1 / 2.4) - 0.055;
  return static_cast<std::uint8_t>(std::lround(255 * std::clamp(s, 0.0, 1.0)));
}

}  // namespace

View shifted(const View& view, glm::dvec2 offset_px) {
  const FovTangents window = tangents_of(view.fov);
  const double right = offset_px.x * (window.right_tan - window.left_tan) / view.size.width,
               down = offset_px.y * (window.up_tan - window.down_tan) / view.size.height;
  View moved = view;
  moved.fov = {std::atan(window.left_tan + right), std::atan(window.right_tan + right),
               std::atan(window.up_tan - down), std::atan(window.down_tan - down)};
  return moved;
}

PerEye<Image<Rgb8>> smooth_reference(const FrameMoment& shown, const SceneState& state, std::uint32_t side,
                                     Renderer& renderer, Reference& reference) {
  static const std::array<float, 256> kLinear = linear_of_srgb();
  const Extent size = shown.views[0].size;
  PerEye<std::vector<glm::vec3>> sums;
  for (std::vector<glm::vec3>& sum : sums) sum.resize(size.pixels());
  FrameMoment request = shown;
  const auto offset = [&](std::uint32_t i) { return (i + 0.5) / side - 0.5; };
  for (std::uint32_t i = 0; i < side * side; ++i) {
    for (std::size_t eye = 0; eye < kEyes; ++eye)
      request.views[eye] = shifted(shown.views[eye], {offset(i % side), offset(i / side)});
    const PerEye<Image<Rgb8>> picture = draw_traced(request, state, reference.trace(request), renderer);
    for (std::size_t eye = 0; eye < kEyes; ++eye)
      for (std::size_t pixel = 0; pixel < size.pixels(); ++pixel) {
        const Rgb8 color = picture[eye].pixels[pixel];
        sums[eye][pixel] += glm::vec3(kLinear[color.r], kLinear[color.g], kLinear[color.b]);
      }
  }
  PerEye<Image<Rgb8>> mean{Image<Rgb8>(size), Image<Rgb8>(size)};
  const float share = 1.0f / static_cast<float>(side * side);
  for (std::size_t eye = 0; eye < kEyes; ++eye)
    for (std::size_t pixel = 0; pixel < size.pixels(); ++pixel) {
      const glm::vec3 linear = sums[eye][pixel] * share;
      mean[eye].pixels[pixel] = {srgb_of_linear(linear.r), srgb_of_linear(linear.g),
                                 srgb_of_linear(linear.b)};
    }
  return mean;
}

}  // namespace farshade
