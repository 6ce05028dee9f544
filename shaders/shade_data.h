/// What shade.comp and the C++ code that runs it both know: the ids of its specialisation constants, the size
/// of its workgroups, and the layout of its report. The structs that it reads are in shared.h.
#ifndef FARSHADE_SHADERS_SHADE_DATA_H
#define FARSHADE_SHADERS_SHADE_DATA_H

#define FARSHADE_SHADE_GROUP 64  // invocations of a workgroup, one pixel each

// What one dispatch does. DIRECT reads the newest mask at the shown pixel. The others reproject masks: EASY
// shades all pixels that the newest mask is enough for and lists the others; HARD shades the listed pixels;
// MOVING shades the listed pixels on instances that can move. SINGLE shades all pixels alone, without lists.
#define FARSHADE_PASS_DIRECT 0
#define FARSHADE_PASS_EASY 1
#define FARSHADE_PASS_HARD 2
#define FARSHADE_PASS_MOVING 3
#define FARSHADE_PASS_SINGLE 4
// With edge rays, EASY lists edges apart from hard pixels. RAYS (edge_rays.comp) lists those where a bit of the mask is
// wrong or unknown, which FLIPPED shades with the right bits, and those that it cannot decide, which are hard.
#define FARSHADE_PASS_RAYS 5
#define FARSHADE_PASS_FLIPPED 6

// For at most so many lights, a variant of HARD, MOVING and SINGLE filters the edges of each light on its own.
#define FARSHADE_FEW_LIGHTS 4

// Bindings of images. Those of depth change from frame to frame, and the others if they are not ours.
#define FARSHADE_BINDING_SHOWN_DEPTH 4
#define FARSHADE_BINDING_BASE_COLORS 5
#define FARSHADE_BINDING_SURFACES 6
#define FARSHADE_BINDING_OUTPUT 7
#define FARSHADE_BINDING_MASK_DEPTHS 9  // and the next ones, of each mask

// Ids of the specialisation constants.
#define FARSHADE_CONSTANT_LIGHTS 0
#define FARSHADE_CONSTANT_WORD_BYTES 1          // of a mask: 1, 2 or 4
#define FARSHADE_CONSTANT_PASS 2                // HARD or MOVING; the others are variants of the shader
#define FARSHADE_CONSTANT_OTHER_EYE 3           // masks traced for the other eye are sources, too
#define FARSHADE_CONSTANT_RANGES_AND_CONES 4    // some light has a range or a cone
#define FARSHADE_CONSTANT_NEAR 5                // distance of the near plane, metres
#define FARSHADE_CONSTANT_UNKNOWN_VISIBILITY 6  // factor of the guess for unknown visibility
#define FARSHADE_CONSTANT_WHOLE 7               // every tile of every mask is known
#define FARSHADE_CONSTANT_MOVED 8               // something has moved since a mask in use was traced
#define FARSHADE_CONSTANT_NEIGHBOURS 9          // points that no view saw take bits from a neighbour
#define FARSHADE_CONSTANT_EDGES 10              // shadow edges are filtered
#define FARSHADE_CONSTANT_SHARPNESS 11          // contrast of a filtered shadow edge
#define FARSHADE_CONSTANT_EDGE_BIT 12           // the first of a mask's four edge bits: mask_edges.h
#define FARSHADE_CONSTANT_MAP_SIDE 13           // texels of a shadow map
#define FARSHADE_CONSTANT_PCF_RADIUS 14         // texels
#define FARSHADE_CONSTANT_DETAIL 15             // limit of the geometric error of what is drawn, pixels
#define FARSHADE_CONSTANT_CUBE_MASK 16          // points that no view's mask knows are looked up in the cube mask
#define FARSHADE_CONSTANT_ROW_GROUPS 17         // workgroups in a row of a dispatch over listed pixels
#define FARSHADE_CONSTANT_EDGE_RAYS 18          // the client's own rays decide at shadow edges
#define FARSHADE_CONSTANT_HOLES 19              // some surface has holes
#define FARSHADE_CONSTANTS 20

// Devices guarantee so many workgroups along each side of a dispatch, so the groups of longer lists form rows.
// All rows but a single one have full length, so a list of a little more than a row runs twice as many groups.
#define FARSHADE_ROW_GROUPS 65535

// The lists of an eye (lists.glsl): hard pixels, those on instances that can move, pixels at shadow edges, and pixels whose
// bits rays have changed.
#define FARSHADE_LIST_HARD 0
#define FARSHADE_LIST_MOVING 1
#define FARSHADE_LIST_EDGES 2
#define FARSHADE_LIST_FLIPPED 3
#define FARSHADE_LISTS 4
#define FARSHADE_FEWEST_EDGES 65536  // that fit into an eye's list, or all pixels: small pictures have more edges
#define FARSHADE_PIXELS_PER_EDGE 2  // at least; if there are more edges, all are hard

// The report: one record of 32-bit words per pixel, the left eye's pixels first. A record begins with these
// words; the others' places depend on the number of lights.
#define FARSHADE_REPORT_SOURCE 0  // and from bit 16 on, how many lights would shine here without shadows
#define FARSHADE_REPORT_X 1       // float bits: position in the source's view, pixels
#define FARSHADE_REPORT_Y 2
#define FARSHADE_REPORT_VISIBILITY 3  // 8 bits a light, 255 = fully visible

#define FARSHADE_QUADS(lights) (((lights) + 3) / 4)     // words of visibilities
#define FARSHADE_PLANES(lights) (((lights) + 31) / 32)  // words with one bit a light

// Words with one bit a light: shown by the rule for unknown visibility; something has moved since.
#define FARSHADE_REPORT_UNKNOWN(lights) (FARSHADE_REPORT_VISIBILITY + FARSHADE_QUADS(lights))
#define FARSHADE_REPORT_STALE(lights) (FARSHADE_REPORT_UNKNOWN(lights) + FARSHADE_PLANES(lights))
#define FARSHADE_REPORT_WORDS(lights) (FARSHADE_REPORT_STALE(lights) + FARSHADE_PLANES(lights))

// What a pixel was shaded with: the source that gave its bits, plus FARSHADE_NEIGHBOUR if the source's view
// saw only the surface beside the point. FARSHADE_SOURCE_RAYS: the newest mask does not know the point, and edge rays have
// decided all lights. FARSHADE_SOURCE_UNCOVERED: the pixel shows no surface.
#define FARSHADE_NEIGHBOUR 64u
#define FARSHADE_SOURCE_RAYS 253u
#define FARSHADE_SOURCE_UNKNOWN 254u
#define FARSHADE_SOURCE_UNCOVERED 255u

#endif
