// Reads the masks on the device (stereo/reproject/device_masks.h).

// The upper left one of the four pixels around a position.
ivec2 corner_at(vec2 at) { return ivec2(floor(at - 0.5)); }

// Whether the block of `pixel`, which is in the picture, is known. A tile has 16 bits, one for each block.
bool block_known(SourceData source, ivec2 pixel) {
  if (kWhole) return true;
  const uint in_tile = FARSHADE_TILE_PX / FARSHADE_BLOCK_PX;
  uint columns = (uint(source.per_step.z) + FARSHADE_TILE_PX - 1) / FARSHADE_TILE_PX;
  uvec2 block = uvec2(pixel) / FARSHADE_BLOCK_PX;
  uint tile = block.y / in_tile * columns + block.x / in_tile;
  uint bit = tile % 2 * 16 + block.y % in_tile * in_tile + block.x % in_tile;
  return (known_words[source.place.z + tile / 2] >> bit & 1u) != 0u;
}

// The nearest pixel of the source's picture. A source that is not in use has no pixels; then pixel 0.
ivec2 inside(SourceData source, ivec2 pixel) {
  return clamp(pixel, ivec2(0), max(ivec2(source.per_step.zw) - 1, ivec2(0)));
}

// `pixel` is in the picture.
uint mask_bits(SourceData source, ivec2 pixel, uint plane) {
  uvec2 size = uvec2(source.per_step.zw);
  uint element = (plane * size.y + uint(pixel.y)) * size.x + uint(pixel.x), per_word = 4 / kWordBytes;
  uint word = mask_words[source.place.y + element / per_word];
  return bitfieldExtract(word, int(element % per_word * kWordBytes * 8), int(kWordBytes * 8));
}

// The lights of a plane that have an edge in the cell that contains the position `at` (mask_edges.h).
uint cell_bits(SourceData source, vec2 at, uint plane) {
  return mask_bits(source, inside(source, corner_at(at)), FARSHADE_PLANES(kEdgeBit + 4) + plane);
}

// Whether some light has an edge in the cell that contains the position `at`.
bool near_shadow_edge(SourceData source, ivec2 pixel, vec2 at) {
  bvec2 second = greaterThanEqual(at - vec2(pixel), vec2(0.5));
  uint quarter = uint(second.x) + 2 * uint(second.y);
  return (mask_bits(source, pixel, kEdgeBit / 32) >> (kEdgeBit % 32 + quarter) & 1u) != 0u;
}
