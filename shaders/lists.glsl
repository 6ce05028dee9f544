// Lists of pixels that later dispatches of a frame work on, each as long as it has become. Every eye has
// FARSHADE_LISTS of them. Pixels of an eye that do not fit into its list of edges are listed as hard.

#ifdef MOTION
#define LISTS_BINDING 15  // after those of motion.glsl
#else
#define LISTS_BINDING 13
#endif
layout(std430, binding = LISTS_BINDING) buffer Lists {
  // xyz = dispatch size, w = length. The dispatch has rows of kRowGroups workgroups; if there is one row only, it may be
  // shorter.
  uvec4 lists[2 * FARSHADE_LISTS];
  // For each eye a word for every pixel: hard pixels, and backwards from the end those on instances that can move. Then
  // for each eye edge_capacity entries each: pixels at edges, and pixels whose bits rays have changed, with kPlanes
  // words of bits. A pixel is x and y in 16 bits each.
  uint list_words[];
};

uint list_of(uint kind) { return shown_eye * FARSHADE_LISTS + kind; }

// Adds an entry to a list, and returns its place.
uint append(uint kind) {
  uint list = list_of(kind), i = atomicAdd(lists[list].w, 1);
  if (i % gl_WorkGroupSize.x == 0) {
    uint group = i / gl_WorkGroupSize.x;
    if (group < kRowGroups) atomicAdd(lists[list].x, 1);
    if (group % kRowGroups == 0) atomicAdd(lists[list].y, 1);
  }
  return i;
}

// The entry of a dispatch over a list that this invocation works on.
uint listed_entry() { return gl_GlobalInvocationID.y * (kRowGroups * gl_WorkGroupSize.x) + gl_GlobalInvocationID.x; }

uint packed(ivec2 pixel) { return pixel.x | pixel.y << 16; }
ivec2 unpacked(uint pixel) { return ivec2(pixel & 0xFFFFu, pixel >> 16); }

uint shown_pixels() { return uint(frame.eye[0].size_px.x) * uint(frame.eye[0].size_px.y); }

uint hard_word(uint i, bool can_move) { return shown_pixels() * shown_eye + (can_move ? shown_pixels() - 1 - i : i); }

void list_as_hard(ivec2 pixel, bool can_move) {
  uint i = append(can_move ? FARSHADE_LIST_MOVING : FARSHADE_LIST_HARD);
  list_words[hard_word(i, can_move)] = packed(pixel);
}

uint edge_capacity() {
  uint share = (shown_pixels() + FARSHADE_PIXELS_PER_EDGE - 1) / FARSHADE_PIXELS_PER_EDGE;
  return max(share, min(shown_pixels(), FARSHADE_FEWEST_EDGES));
}
uint edge_word(uint i) { return 2 * shown_pixels() + shown_eye * (2 + kPlanes) * edge_capacity() + i; }
// Word 0 of an entry is the pixel, word 1 + plane its bits.
uint flipped_word(uint i, uint word) { return edge_word(edge_capacity() + i * (1 + kPlanes) + word); }

// Whether the pixel fits into the list of edges.
bool list_as_edge(ivec2 pixel) {
  uint i = append(FARSHADE_LIST_EDGES);
  if (i < edge_capacity()) list_words[edge_word(i)] = packed(pixel);
  return i < edge_capacity();
}
