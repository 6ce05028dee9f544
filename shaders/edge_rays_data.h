/// What edge_rays.comp and the C++ code that makes its buffers both know.
#ifndef FARSHADE_SHADERS_EDGE_RAYS_DATA_H
#define FARSHADE_SHADERS_EDGE_RAYS_DATA_H

#define FARSHADE_LIGHT_BUFFER_SIDE 64   // texels of an undivided layer of a light buffer
#define FARSHADE_LIGHT_BUFFER_PARTS 4   // a side of a divided texel
#define FARSHADE_LIGHT_BUFFER_DIVISIONS 2
#define FARSHADE_RAY_LIGHT_ROWS 6       // texels of a ShadowMapData
#define FARSHADE_DIVIDED 0x80000000u    // flag of a texel
#define FARSHADE_LAST 0x80000000u       // flag of a triangle in a list
#define FARSHADE_UNKNOWN_HOLES (-1.0f)  // instead of the index of a triangle's alpha
#define FARSHADE_WRAP_REPEATED 0  // Wrap of scene.h
#define FARSHADE_WRAP_MIRRORED 1
#define FARSHADE_WRAP_CLAMPED 2

#endif
