/// PixelFacts: what the client knows about one pixel of a shown frame, for the pixel inspector of the
/// preview.
#pragma once

#include <string>
#include <vector>

#include "stereo/draw/renderer.h"
#include "vr_client/report/overlays.h"

namespace farshade {

struct PixelFacts {
  Side side = Side::Left;
  glm::uvec2 pixel{0};  ///< of the eye, from the top left
  ShownSurface surface{};
  ShownReport report{};   ///< of this pixel alone
  MaskAges ages;          ///< of the masks that the frame was drawn with, by mask_of(source)
  std::size_t masks = 0;  ///< of views, that the frame was drawn with
};

struct Fact {
  std::string name, value;
  friend bool operator==(const Fact&, const Fact&) = default;
};

/// A line for each fact, then one for each light. `scene` has the names of the lights, and `lights` says
/// which of them are on.
[[nodiscard]] std::vector<Fact> in_words(const PixelFacts& facts, const Scene& scene, const LightSet& lights);

}  // namespace farshade
