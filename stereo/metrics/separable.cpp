#include "stereo/metrics/separable.h"

#include <algorithm>
#include <cstddef>

namespace farshade {
namespace {

// The outer loops run over taps and the inner loops over pixels, so that compilers vectorise the inner loops.

void start(const EvenKernel& kernel, const float* centre, float* result, std::size_t count) {
  for (std::size_t x = 0; x < count; ++x) result[x] = kernel.sum * centre[x];
}

void start(const OddKernel&, const float*, float* result, std::size_t count) {
  std::fill_n(result, count, 0.0f);
}

void add_tap(const EvenKernel& kernel, std::size_t tap, const float* before, const float* centre,
             const float* after, float* result, std::size_t count) {
  const float weight = kernel.sides[tap];
  for (std::size_t x = 0; x < count; ++x)
    result[x] += weight * ((after[x] - centre[x]) + (before[x] - centre[x]));
}

void add_tap(const OddKernel& kernel, std::size_t tap, const float* before, const float*, const float* after,
             float* result, std::size_t count) {
  const float weight = kernel.sides[tap];
  for (std::size_t x = 0; x < count; ++x) result[x] += weight * (after[x] - before[x]);
}

template <class Kernel>
Image<float> filter_rows(const Image<float>& picture, const Kernel& kernel) {
  Image<float> result(picture.size);
  if (picture.pixels.empty()) return result;
  const std::size_t width = picture.size.width, radius = kernel.sides.size();
  std::vector<float> padded(width + 2 * radius);
  const float* centre = padded.data() + radius;
  for (std::size_t y = 0; y < picture.size.height; ++y) {
    const float* row = picture.pixels.data() + y * width;
    float* out = result.pixels.data() + y * width;
    std::fill_n(padded.begin(), radius, row[0]);
    std::copy_n(row, width, padded.data() + radius);
    std::fill_n(padded.data() + radius + width, radius, row[width - 1]);
    start(kernel, centre, out, width);
    for (std::size_t tap = 0; tap < radius; ++tap)
      add_tap(kernel, tap, centre - (tap + 1), centre, centre + (tap + 1), out, width);
  }
  return result;
}

template <class Kernel>
Image<float> filter_columns(const Image<float>& picture, const Kernel& kernel) {
  Image<float> result(picture.size);
  if (picture.pixels.empty()) return result;
  const std::size_t width = picture.size.width, last = picture.size.height - 1;
  const auto row = [&](std::size_t y) { return picture.pixels.data() + y * width; };
  for (std::size_t y = 0; y <= last; ++y) {
    float* out = result.pixels.data() + y * width;
    start(kernel, row(y), out, width);
    for (std::size_t tap = 0; tap < kernel.sides.size(); ++tap) {
      const std::size_t distance = tap + 1;
      add_tap(kernel, tap, row(y > distance ? y - distance : 0), row(y), row(std::min(y + distance, last)),
              out, width);
    }
  }
  return result;
}

}  // namespace

Image<float> along_rows(const Image<float>& picture, const EvenKernel& kernel) {
  return filter_rows(picture, kernel);
}
Image<float> along_rows(const Image<float>& picture, const OddKernel& kernel) {
  return filter_rows(picture, kernel);
}
Image<float> along_columns(const Image<float>& picture, const EvenKernel& kernel) {
  return filter_columns(picture, kernel);
}
Image<float> along_columns(const Image<float>& picture, const OddKernel& kernel) {
  return filter_columns(picture, kernel);
}

}  // namespace farshade
