/// What carry.comp and CarryPass both know; see shared.h.
#ifndef FARSHADE_SHADERS_CARRY_DATA_H
#define FARSHADE_SHADERS_CARRY_DATA_H

#define FARSHADE_CARRY_GROUP 64  // invocations of a workgroup, one block each

// Ids of the specialisation constants.
#define FARSHADE_CARRY_LIGHTS 0
#define FARSHADE_CARRY_WORD_BYTES 1  // of a mask on the device
#define FARSHADE_CARRY_BITS_BYTES 2  // of a carried word, which has no edge bits
#define FARSHADE_CARRY_NEAR 3        // distance of the near plane, metres
#define FARSHADE_CARRY_DETAIL 4      // limit of the geometric error of what is drawn, pixels
#define FARSHADE_CARRY_EYE 5         // 0 left, 1 right
#define FARSHADE_CARRY_WHOLE 6       // every block of the mask is known
#define FARSHADE_CARRY_MOVED 7       // an instance has moved since the mask was traced
#define FARSHADE_CARRY_CONSTANTS 8

#endif
