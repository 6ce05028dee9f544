/// What anaglyph.frag and the preview's C++ code share; see shared.h.
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
  vec4 place;      // xy = the panel's top left corner in the window, zw = picture pixels per window pixel
  uvec4 pictures;  // x = left, y = right picture: 0, 1 drawn eyes, 2, 3 uploads; z, w = their first columns
};

#ifdef __cplusplus
}  // namespace farshade::gpu
#endif
#endif
