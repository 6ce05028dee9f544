/// Comparison: the perceptual metrics of compared frames, and the pictures of the worst one.
#pragma once

#include <filesystem>

#include "stereo/frame/view.h"
#include "tests/study/figures.h"
#include "vr_client/report/measure.h"

namespace farshade::study {

class Comparison {
 public:
  /// `figures` must outlive this.
  explicit Comparison(Figures& figures) : figures_(figures) {}

  /// Adds the figures `flip` and `ssim` of the frame's worse eye; they may be of different eyes. If the frame
  /// has a smooth reference, `smooth_flip` and `smooth_ssim` are those against it.
  void add(const PerEye<View>& views, const MeasuredFrame& frame);

  /// Writes `{left,right}_{shown,reference,heat}.png` of the frame with the largest FLIP into an existing
  /// folder. Writes nothing if no frame was added.
  [[nodiscard]] Expected<void> write(const std::filesystem::path& folder) const;

 private:
  void add_smooth(const PerEye<View>& views, const MeasuredFrame& frame);
  struct ComparedFrame {
    PerEye<Image<Rgb8>> shown, reference;
    PerEye<Image<float>> error;
    double flip = -1;  ///< the worse eye's
  };
  Figures& figures_;
  ComparedFrame worst_;
};

}  // namespace farshade::study
