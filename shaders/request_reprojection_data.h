/// What request_reprojection.comp and RequestReprojectionPass both know; see shared.h.
#ifndef FARSHADE_SHADERS_REQUEST_REPROJECTION_DATA_H
#define FARSHADE_SHADERS_REQUEST_REPROJECTION_DATA_H

#define FARSHADE_REQUEST_REPROJECTION_GROUP 64  // invocations of a workgroup, one block each

// In the word of a block, above the shares: some pixel of it has a surface.
#define FARSHADE_REQUEST_REPROJECTION_COVERED 0x100u

// Ids of the specialisation constants.
#define FARSHADE_REQUEST_REPROJECTION_LIGHTS 0
#define FARSHADE_REQUEST_REPROJECTION_WORD_BYTES 1  // of a mask
#define FARSHADE_REQUEST_REPROJECTION_NEAR 2        // distance of the near plane, metres
#define FARSHADE_REQUEST_REPROJECTION_DETAIL 3      // limit of the geometric error of what is drawn, pixels
#define FARSHADE_REQUEST_REPROJECTION_MOVED 4       // an instance has moved since the mask was traced
#define FARSHADE_REQUEST_REPROJECTION_CONSTANTS 5

#endif
