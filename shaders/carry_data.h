/// What carry.comp and CarryPass both know; see shared.h.
#ifndef FARSHADE_SHADERS_CARRY_DATA_H
#define FARSHADE_SHADERS_CARRY_DATA_H

#define FARSHADE_CARRY_GROUP 64  // invocations of a workgroup, one block each

// In the word of a block, above the shares: some pixel of it has a surface.
#define FARSHADE_CARRY_COVERED 0x100u

// Ids of the specialisation constants.
#define FARSHADE_CARRY_LIGHTS 0
#define FARSHADE_CARRY_WORD_BYTES 1  // of a mask
#define FARSHADE_CARRY_NEAR 2        // distance of the near plane, metres
#define FARSHADE_CARRY_DETAIL 3      // limit of the geometric error of what is drawn, pixels
#define FARSHADE_CARRY_MOVED 4       // an instance has moved since the mask was traced
#define FARSHADE_CARRY_CONSTANTS 5

#endif
