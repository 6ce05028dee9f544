#include "stereo/metrics/flip.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <glm/vec2.hpp>
#include <numbers>
#include <numeric>

#include "stereo/base/check.h"
#include "stereo/metrics/separable.h"

namespace farshade {
namespace {

using std::numbers::pi;

/// The contrast sensitivity of a channel over the frequency f in cycles per degree is a sum of terms a exp(-b
/// f^2) (paper, table 1). In space it is a sum of terms a sqrt(pi / b) exp(-pi^2 x^2 / b), with x in degrees
/// from the pixel.
struct Sensitivity {
  double a, b;
};
constexpr Sensitivity kLight{1, 0.0047}, kRedGreen{1, 0.0053}, kBlueYellow[] = {{34.1, 0.04}, {13.5, 0.025}};
constexpr double kFeatureWidth_deg = 0.082;
constexpr float kColourExponent = 0.7f, kFeatureExponent = 0.5f;
constexpr float kKneeAt = 0.4f,
                kKneeTo = 0.95f;  // a share of the largest colour difference, and the error that it maps to

/// The weights at the end of a kernel that are too small for float are left out.
std::vector<float> trimmed(const std::vector<double>& sides) {
  std::size_t count = sides.size();
  while (count > 0 && std::abs(sides[count - 1]) < 1e-10) --count;
  std::vector<float> result(count);
  std::transform(sides.begin(), sides.begin() + static_cast<std::ptrdiff_t>(count), result.begin(),
                 [](double weight) { return static_cast<float>(weight); });
  return result;
}

double sum_of(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

/// Values of `weight` at 1, 2, ... radius.
std::vector<double> sampled(int radius, auto weight) {
  std::vector<double> result;
  for (int x = 1; x <= radius; ++x) result.push_back(weight(static_cast<double>(x)));
  return result;
}

EvenKernel gaussian(double sigma, int radius) {
  auto sides = sampled(radius, [&](double x) { return std::exp(-x * x / (2 * sigma * sigma)); });
  const double sum = 1 + 2 * sum_of(sides);
  for (double& weight : sides) weight /= sum;
  return {1, trimmed(sides)};
}

/// First derivative of a Gaussian. The positive weights add up to 1, the negative ones to -1. The common
/// factor of all weights is divided out before it can underflow.
OddKernel edge_detector(double sigma, int radius) {
  auto sides = sampled(radius, [&](double x) { return x * std::exp((1 - x * x) / (2 * sigma * sigma)); });
  const double sum = sum_of(sides);
  for (double& weight : sides) weight /= sum;
  return {trimmed(sides)};
}

/// Second derivative of a Gaussian, normalised likewise: negative within sigma of the centre, positive
/// beyond.
EvenKernel point_detector(double sigma, int radius) {
  const double variance = sigma * sigma, nearest = std::floor(sigma) + 1;
  auto inner = sampled(radius, [&](double x) {
    return x < nearest ? (1 - x * x / variance) * std::exp(-x * x / (2 * variance)) : 0.0;
  });
  auto outer = sampled(radius, [&](double x) {
    return x < nearest ? 0.0 : (x * x - variance) * std::exp((nearest * nearest - x * x) / (2 * variance));
  });
  const double inner_sum = 1 + 2 * sum_of(inner), outer_sum = 2 * sum_of(outer);
  for (std::size_t i = 0; i < inner.size(); ++i) inner[i] = outer[i] / outer_sum - inner[i] / inner_sum;
  return {0, trimmed(inner)};
}

/// XYZ of the sRGB primaries (IEC 61966-2-1). Each coordinate is divided by that of D65 white (0.3127,
/// 0.3290), so that white is (1, 1, 1) and neither YCxCz nor L*a*b* needs another white point.
const glm::dmat3 kXyzFromRgb{{0.433887345566, 0.212639005872, 0.017750040071},
                             {0.376224009137, 0.715168678768, 0.109447620855},
                             {0.189888645296, 0.072192315361, 0.872802339074}};

const std::array<float, 256>& linear_from_srgb() {
  static const auto table = [] {
    std::array<float, 256> values{};
    for (std::size_t i = 0; i < values.size(); ++i) {
      const double c = static_cast<double>(i) / 255;
      values[i] = static_cast<float>(c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4));
    }
    return values;
  }();
  return table;
}

/// YCxCz without its factors and offset, because the inverse transform removes them again: Y, X - Y, Y - Z.
struct Opponents {
  Image<float> light, red_green, blue_yellow;
};

Opponents opponents_of(const Image<Rgb8>& picture) {
  const auto& linear = linear_from_srgb();
  const glm::mat3 xyz_from_rgb(kXyzFromRgb);
  Opponents result{Image<float>(picture.size), Image<float>(picture.size), Image<float>(picture.size)};
  for (std::size_t i = 0; i < picture.pixels.size(); ++i) {
    const Rgb8 p = picture.pixels[i];
    const glm::vec3 xyz = xyz_from_rgb * glm::vec3(linear[p.r], linear[p.g], linear[p.b]);
    result.light.pixels[i] = xyz.y;
    result.red_green.pixels[i] = xyz.x - xyz.y;
    result.blue_yellow.pixels[i] = xyz.y - xyz.z;
  }
  return result;
}

Image<float> blurred(const Image<float>& picture, const EvenKernel& kernel) {
  return along_columns(along_rows(picture, kernel), kernel);
}

/// The eye's blur of each channel. All kernels reach as far as three deviations of the widest one. A sum of
/// two Gaussians is not separable, but each Gaussian is. Their shares are proportional to the sums of their
/// samples.
Opponents blurred_by_eye(const Opponents& sharp, double pixels_per_degree) {
  const auto sigma_px = [&](double b) { return std::sqrt(b / 2) / pi * pixels_per_degree; };
  const int radius = static_cast<int>(std::ceil(3 * sigma_px(kBlueYellow[0].b)));
  const auto by_eye = [&](const Image<float>& channel, Sensitivity s) {
    return blurred(channel, gaussian(sigma_px(s.b), radius));
  };
  const auto total = [&](Sensitivity s) {
    const double variance = std::pow(sigma_px(s.b), 2);
    const double along_axis =
        1 + 2 * sum_of(sampled(radius, [&](double x) { return std::exp(-x * x / (2 * variance)); }));
    return s.a * std::sqrt(pi / s.b) * along_axis * along_axis;
  };
  const double first = total(kBlueYellow[0]), second = total(kBlueYellow[1]);
  const float share = static_cast<float>(second / (first + second));
  Opponents result{by_eye(sharp.light, kLight), by_eye(sharp.red_green, kRedGreen),
                   by_eye(sharp.blue_yellow, kBlueYellow[0])};
  const Image<float> narrower = by_eye(sharp.blue_yellow, kBlueYellow[1]);
  for (std::size_t i = 0; i < narrower.pixels.size(); ++i) {
    float& wider = result.blue_yellow.pixels[i];
    wider += share * (narrower.pixels[i] - wider);
  }
  return result;
}

/// CIE L*a*b* of XYZ relative to white, with the chroma scaled by lightness (Hunt effect).
glm::vec3 hunt_lab(glm::vec3 xyz) {
  constexpr float kDelta = 6.0f / 29;
  const auto f = [](float t) {
    return t > kDelta * kDelta * kDelta ? std::cbrt(t) : t / (3 * kDelta * kDelta) + 4.0f / 29;
  };
  const float x = f(xyz.x), y = f(xyz.y), z = f(xyz.z);
  const float lightness = 116 * y - 16;
  return {lightness, 0.01f * lightness * 500 * (x - y), 0.01f * lightness * 200 * (y - z)};
}

Image<glm::vec3> seen_colours(const Opponents& channels) {
  const glm::mat3 xyz_from_rgb(kXyzFromRgb), rgb_from_xyz(glm::inverse(kXyzFromRgb));
  Image<glm::vec3> result(channels.light.size);
  for (std::size_t i = 0; i < result.pixels.size(); ++i) {
    const float y = channels.light.pixels[i];
    const glm::vec3 xyz(y + channels.red_green.pixels[i], y, y - channels.blue_yellow.pixels[i]);
    // The channels are blurred differently, so their sum may be a colour that no display shows.
    result.pixels[i] = hunt_lab(xyz_from_rgb * glm::clamp(rgb_from_xyz * xyz, 0.0f, 1.0f));
  }
  return result;
}

/// The lengths of the vectors whose coordinates are in two pictures.
Image<float> magnitudes(Image<float> along_x, const Image<float>& along_y) {
  std::ranges::transform(along_x.pixels, along_y.pixels, along_x.pixels.begin(),
                         [](float x, float y) { return std::sqrt(x * x + y * y); });
  return along_x;
}

/// HyAB distance, compressed (Abasi, Tehran and Fairchild, "Distance metrics for very large color
/// differences", 2020; exponent of the paper).
float colour_difference(glm::vec3 a, glm::vec3 b) {
  const glm::vec2 chroma(a.y - b.y, a.z - b.z);
  return std::pow(std::abs(a.x - b.x) + glm::length(chroma), kColourExponent);
}

/// Maps 0 to `largest` onto 0 to 1. Values below the knee get nearly the whole range.
float redistributed(float difference, float largest) {
  const float knee = kKneeAt * largest;
  if (difference < knee) return kKneeTo / knee * difference;
  return std::min(1.0f, kKneeTo + (difference - knee) / (largest - knee) * (1 - kKneeTo));
}

}  // namespace

SeenPicture see(const Image<Rgb8>& picture, double pixels_per_degree) {
  check(pixels_per_degree >= 1e-6 && pixels_per_degree <= 1e5, "pixels a degree lie within 1e-6 and 1e5");
  const Opponents sharp = opponents_of(picture);
  const double sigma = 0.5 * kFeatureWidth_deg * pixels_per_degree;
  const int radius = static_cast<int>(std::ceil(3 * sigma));
  const EvenKernel smooth = gaussian(sigma, radius), point = point_detector(sigma, radius);
  const OddKernel edge = edge_detector(sigma, radius);
  const Image<float> smooth_down = along_columns(sharp.light, smooth),
                     smooth_across = along_rows(sharp.light, smooth);
  return {pixels_per_degree, seen_colours(blurred_by_eye(sharp, pixels_per_degree)),
          magnitudes(along_rows(smooth_down, edge), along_columns(smooth_across, edge)),
          magnitudes(along_rows(smooth_down, point), along_columns(smooth_across, point))};
}

Image<float> flip(const SeenPicture& reference, const SeenPicture& test) {
  check(reference.colour.size == test.colour.size, "compared pictures have one size");
  check_eq(test.pixels_per_degree, reference.pixels_per_degree, "compared pictures' pixels a degree");
  const glm::mat3 xyz_from_rgb(kXyzFromRgb);
  // The largest difference between two displayable colours is that of green and blue.
  const float largest = colour_difference(hunt_lab(xyz_from_rgb[1]), hunt_lab(xyz_from_rgb[2]));
  Image<float> error(reference.colour.size);
  for (std::size_t i = 0; i < error.pixels.size(); ++i) {
    const float colour =
        redistributed(colour_difference(reference.colour.pixels[i], test.colour.pixels[i]), largest);
    const float features = std::max(std::abs(reference.edges.pixels[i] - test.edges.pixels[i]),
                                    std::abs(reference.points.pixels[i] - test.points.pixels[i]));
    const float feature = std::min(1.0f, std::pow(features / std::numbers::sqrt2_v<float>, kFeatureExponent));
    error.pixels[i] = colour > 0 ? std::pow(colour, 1 - feature) : 0.0f;
  }
  return error;
}

Image<float> flip(const Image<Rgb8>& reference, const Image<Rgb8>& test, double pixels_per_degree) {
  return flip(see(reference, pixels_per_degree), see(test, pixels_per_degree));
}

double mean(const Image<float>& error) {
  if (error.pixels.empty()) return 0;
  return std::accumulate(error.pixels.begin(), error.pixels.end(), 0.0) /
         static_cast<double>(error.pixels.size());
}

}  // namespace farshade
