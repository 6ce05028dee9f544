// Writes the binary seeds: fuzz_seeds tests/fuzz/corpus. Those of text formats are written by hand.
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <random>

#include "gltf_builder.h"
#include "stereo/base/check.h"
#include "stereo/base/files.h"
#include "stereo/wire/tile_codec.h"
#include "wire_samples.h"

namespace {

using namespace farshade;
using wire_samples::Bytes;
namespace fs = std::filesystem;

void save(const fs::path& path, const Bytes& bytes) {
  fs::create_directories(path.parent_path());
  check(write_file_atomically(path, bytes).has_value(), "a seed is written");
}

/// JSON and buffer in the form of gltf.cpp.
Bytes parts(GltfBuilder file) {
  Bytes bytes = bytes_of_text(file.json.dump());
  bytes.push_back(std::byte{0});
  bytes.insert(bytes.end(), file.bytes().begin(), file.bytes().end());
  return bytes;
}

/// The choices of slice_and_tiles.cpp for this slice, then `bytes`.
Bytes slice_input(unsigned form, const Slice& slice, std::span<const std::byte> bytes) {
  Bytes input =
      wire_samples::bytes_of({form, slice.lights >> 8, slice.lights & 255, slice.size.width - 1,
                              slice.size.height - 1, slice.plane, slice.first_tile, slice.tile_count - 1});
  input.insert(input.end(), bytes.begin(), bytes.end());
  return input;
}

void save_slices(const fs::path& folder, const std::string& name, const EyeMask& mask) {
  const ShadowFrame frame = wire_samples::frame_of(mask, mask);
  const TileGrid grid{mask.size()};
  SlicePacker packer;
  packer.start(frame, Side::Left);
  while (const std::optional<Slice> slice = packer.next()) {
    const std::string place =
        name + "_" + std::to_string(slice->plane) + "_" + std::to_string(slice->first_tile);
    save(folder / (place + "_block"), slice_input(0, *slice, slice->block));
    Bytes tiles;
    for (std::uint32_t i = 0; i < slice->tile_count; ++i)
      write_tile(split_tile(mask, grid.rect(slice->first_tile + i), slice->plane),
                 mask.layout().lights_in(slice->plane), tiles);
    save(folder / (place + "_tiles"), slice_input(1, *slice, tiles));
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return std::fprintf(stderr, "usage: %s CORPUS\n", argv[0]), EXIT_FAILURE;
  const fs::path corpus = argv[1];
  save(corpus / "gltf" / "triangle.glb", triangle_file().glb());
  save(corpus / "gltf" / "triangle.gltf", triangle_file().gltf());
  save(corpus / "gltf" / "rich.glb", rich_file().glb());
  save(corpus / "gltf" / "rich.gltf", rich_file().gltf());
  save(corpus / "gltf" / "triangle.parts", parts(triangle_file()));
  save(corpus / "gltf" / "rich.parts", parts(rich_file()));
  std::mt19937 random(1);
  const fs::path slices = corpus / "slice_and_tiles";
  save_slices(slices, "none", EyeMask({16, 16}, 0));
  save_slices(slices, "small", wire_samples::small_frame().masks[0]);
  save_slices(slices, "edges", wire_samples::edge_mask({72, 40}, 11, random));
  save_slices(slices, "many", wire_samples::edge_mask({40, 24}, 70, random));
  save_slices(slices, "noise", wire_samples::noise_mask({16, 16}, 20, random));
  return EXIT_SUCCESS;
}
