/// What the turn pass is told, in C++ and GLSL. See shared.h.
#ifndef FARSHADE_SHADERS_TURN_DATA_H
#define FARSHADE_SHADERS_TURN_DATA_H

#ifdef __cplusplus
#include <cstdint>
#include <glm/vec4.hpp>
namespace farshade::gpu {
using glm::uvec4;
using glm::vec4;
#endif

struct TurnData {
  vec4 from_shown[2 * 3];  // of each eye three columns: where a shown pixel's direction lies in the picture
  uvec4 size;              // xy = pixels of an eye
};

#ifdef __cplusplus
}  // namespace farshade::gpu
#endif
#endif
