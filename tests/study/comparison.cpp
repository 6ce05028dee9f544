#include "tests/study/comparison.h"

#include <algorithm>

#include "stereo/image/codec.h"
#include "stereo/image/difference.h"
#include "stereo/metrics/flip.h"
#include "stereo/metrics/pixels_per_degree.h"
#include "stereo/metrics/ssim.h"
#include "tests/support/heat_map.h"

namespace farshade::study {

void Comparison::add(const MeasuredFrame& frame) {
  const double worse = std::max(mean(frame.flip[0]), mean(frame.flip[1]));
  if (worse > worst_flip_) worst_flip_ = worse, worst_ = {frame.shown, frame.reference, frame.flip};
}

void Comparison::add_smooth(const PerEye<View>& views, const PerEye<Image<Rgb8>>& shown,
                            const PerEye<Image<Rgb8>>& smooth) {
  double worse_psnr_db = kEqualPictures_dB, worse_flip = 0, worse_ssim = 1;
  for (std::size_t eye = 0; eye < kEyes; ++eye) {
    worse_psnr_db = std::min(worse_psnr_db, psnr_db(shown[eye], smooth[eye]));
    worse_flip = std::max(worse_flip, mean(flip(smooth[eye], shown[eye], pixels_per_degree(views[eye]))));
    worse_ssim = std::min(worse_ssim, ssim(smooth[eye], shown[eye]));
  }
  figures_.add(Group::Error, "smooth_psnr", worse_psnr_db, Worse::Low);
  figures_.add(Group::Error, "smooth_flip", worse_flip);
  figures_.add(Group::Error, "smooth_ssim", worse_ssim, Worse::Low);
}

Expected<void> Comparison::write(const std::filesystem::path& folder) const {
  if (worst_flip_ < 0) return {};
  for (const Side side : kSides) {
    const std::size_t eye = index_of(side);
    const auto path = [&](const char* what) { return folder / (std::string(name_of(side)) + what); };
    for (const Expected<void>& done : {write_png(path("_shown.png"), worst_.shown[eye]),
                                       write_png(path("_reference.png"), worst_.reference[eye]),
                                       write_png(path("_heat.png"), heat_map(worst_.flip[eye]))})
      if (!done) return done;
  }
  return {};
}

}  // namespace farshade::study
