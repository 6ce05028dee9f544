/// The measured quality of reprojected pictures for each scene, pose delta and age.
#pragma once

#include <ostream>
#include <span>
#include <vector>

#include "stereo/frame/view.h"

namespace farshade {

/// The quality of a picture against its reference.
struct Judged {
  double psnr_db = 0, ssim = 0, flip = 0;
};

/// With a mask that was traced for `age_ms` before the shown scene time.
struct AtAge {
  int age_ms = 0;
  PerEye<Judged> eyes;
};

struct Row {
  const char* scene;
  const char* pose;
  std::vector<AtAge> ages;
};

inline std::ostream& operator<<(std::ostream& out, const Row& row) {
  return out << row.scene << ' ' << row.pose;
}

[[nodiscard]] std::span<const Row> bundled_rows();
/// For a scene that only some machines have beside the repository.
[[nodiscard]] std::span<const Row> shared_rows();

}  // namespace farshade
