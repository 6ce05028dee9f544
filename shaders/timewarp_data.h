/// What timewarp.comp and TimewarpPass share; see shared.h.
#ifndef FARSHADE_SHADERS_TIMEWARP_DATA_H
#define FARSHADE_SHADERS_TIMEWARP_DATA_H

#ifdef __cplusplus
#include <cstdint>
#include <glm/vec4.hpp>
namespace farshade::gpu {
using glm::uvec4;
using glm::vec4;
#endif

#define FARSHADE_TIMEWARP_GROUP 64         // invocations of a workgroup, one pixel each
#define FARSHADE_TIMEWARP_CONSTANT_ADDS 0  // id of the specialisation constant

struct TimewarpData {
  vec4 from_shown[2 * 3];  // for each eye the columns of a matrix: shown pixel to position in the picture
  uvec4 size;              // xy = pixels of a shown eye, zw = of the picture's
};

#ifdef __cplusplus
}  // namespace farshade::gpu
#endif
#endif
