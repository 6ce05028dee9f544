/// Comparison: the pictures of the worst of compared frames, and perceptual metrics against smooth
/// references.
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

  void add(const MeasuredFrame& frame);

  /// Adds the figures `smooth_psnr`, `smooth_flip` and `smooth_ssim` of the frame's worse eye; they may be of
  /// different eyes.
  void add_smooth(const PerEye<View>& views, const PerEye<Image<Rgb8>>& shown,
                  const PerEye<Image<Rgb8>>& smooth);

  /// Writes `{left,right}_{shown,reference,heat}.png` of the frame with the largest FLIP into an existing
  /// folder. Writes nothing if no frame was added.
  [[nodiscard]] Expected<void> write(const std::filesystem::path& folder) const;

 private:
  struct Pictures {
    PerEye<Image<Rgb8>> shown, reference;
    PerEye<Image<float>> flip;
  };
  Figures& figures_;
  Pictures worst_;
  double worst_flip_ = -1;  ///< of the worse eye
};

}  // namespace farshade::study
