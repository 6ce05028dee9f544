/// What the anaglyph in the preview's window is told: shared by C++ and GLSL, written once.
#ifndef FARSHADE_SHADERS_ANAGLYPH_DATA_H
#define FARSHADE_SHADERS_ANAGLYPH_DATA_H

#ifdef __cplusplus
#include <cstdint>
#include <glm/vec4.hpp>
namespace farshade::gpu {
using glm::uvec4;
using glm::vec4;
#endif

struct AnaglyphData {
  vec4 place;      // the panel's left top corner in the window, and picture pixels per window pixel
  uvec4 pictures;  // left, right: 0, 1 eyes as drawn, 2, 3 uploads; zw: the first column of either
};

#ifdef __cplusplus
}  // namespace farshade::gpu
#endif
#endif
