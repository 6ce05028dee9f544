/// What edge_rays.glsl and the C++ code that makes its buffers both know.
#ifndef FARSHADE_SHADERS_EDGE_RAYS_DATA_H
#define FARSHADE_SHADERS_EDGE_RAYS_DATA_H

#define FARSHADE_LIGHT_BUFFER_SIDE 64   // texels of an undivided layer of a light buffer
#define FARSHADE_LIGHT_BUFFER_PARTS 4   // a side of a divided texel
#define FARSHADE_LIGHT_BUFFER_DIVISIONS 2
#define FARSHADE_RAY_LIGHT_ROWS 6       // texels of a ShadowMapData
#define FARSHADE_DIVIDED 0x80000000u    // flag of a texel
#define FARSHADE_LAST 0x80000000u       // flag of a triangle in a list

#endif
