// Writes the binary seeds: fuzz_seeds tests/fuzz/corpus. The seeds of text formats are written by hand.
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <random>

#include "stereo/base/check.h"
#include "stereo/base/files.h"
#include "stereo/codec/ask_coder.h"
#include "stereo/codec/plane_codec.h"
#include "stereo/codec/plane_tile.h"
#include "stereo/video/video.h"
#include "tests/support/gltf_compressor.h"
#include "tests/support/largest_word.h"
#include "tests/unit/client_record/capture_samples.h"
#include "tests/unit/gltf/gltf_builder.h"
#include "tests/unit/image/webp_files.h"
#include "tests/unit/messages/samples.h"

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

/// A GLB in the form of gltf.cpp.
Bytes parts(const Bytes& glb) {
  std::size_t text_bytes = 0;
  for (std::size_t i = 0; i < 4; ++i) text_bytes |= std::to_integer<std::size_t>(glb[12 + i]) << 8 * i;
  Bytes bytes(glb.begin() + 20, glb.begin() + 20 + static_cast<std::ptrdiff_t>(text_bytes));
  bytes.push_back(std::byte{0});
  bytes.insert(bytes.end(), glb.begin() + 28 + static_cast<std::ptrdiff_t>(text_bytes), glb.end());
  return bytes;
}

/// A file for each decoder of what a glTF file compresses, and one with instances and variants.
void save_compressed(const fs::path& folder) {
  const Bytes plain = rich_file().glb();
  save(folder / "meshopt.parts", parts(compress_with_meshopt(plain)));
  save(folder / "meshopt_triangles.parts", parts(compress_with_meshopt(plain, IndexCodec::Triangles)));
  save(folder / "draco.parts", parts(compress_with_draco(triangle_file().glb())));
  save(folder / "draco_edgebreaker.parts",
       parts(compress_with_draco(triangle_file().glb(), DracoMethod::Edgebreaker)));
  GltfBuilder file = rich_file();
  file.json["images"][0]["bufferView"] = file.view(make_noise_webp({4, 4}));
  const auto places = file.positions({{0, 0, 0}, {5, 0, 0}});
  file.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {{"TRANSLATION", places}};
  auto& primitive = file.json["meshes"][0]["primitives"][0];
  primitive["extensions"]["KHR_materials_variants"]["mappings"] = {{{"material", 0}, {"variants", {0}}}};
  file.json["animations"][0]["channels"][0]["target"] = {
      {"path", "pointer"},
      {"extensions", {{"KHR_animation_pointer", {{"pointer", "/nodes/0/translation"}}}}}};
  save(folder / "wild.parts", parts(file));
}

/// The numbers of slice_and_tiles.cpp for this slice, the requested blocks, then the slice's block.
Bytes slice_input(unsigned kind, const auto& slice, std::uint32_t lights, std::uint32_t plane,
                  std::span<const RequestedTile> requested) {
  Bytes input =
      wire_samples::bytes_of({kind, lights >> 8, lights & 255, slice.size.width - 1, slice.size.height - 1,
                              plane, slice.first_tile, slice.tile_count - 1});
  for (const RequestedTile& tile : requested)
    for (std::uint32_t share = 0; share < shares_of(lights); ++share) {
      input.push_back(static_cast<std::byte>(tile.shares[share] >> 8));
      input.push_back(static_cast<std::byte>(tile.shares[share] & 255));
    }
  input.insert(input.end(), slice.block.begin(), slice.block.end());
  return input;
}

/// The slices of a mask, of some of its blocks, and those that ask for these blocks.
void save_slices(const fs::path& folder, const std::string& name, const EyeMask& mask) {
  const ShadowFrame frame = wire_samples::frame_of(mask, mask);
  const std::uint32_t lights = mask.lights();
  std::vector<RequestedTile> some(TileGrid{mask.size()}.count(), all_lights_in(0x0f36, lights));
  some[0] = all_lights_in(kAllBlocks, lights);
  std::vector<RequestedTile> apart = some;
  for (std::uint32_t i = 0; i < apart.size(); ++i)
    for (std::uint32_t share = 0; share < shares_of(lights); ++share)
      apart[i].shares[share] = static_cast<BlockBits>(i == 0 ? 0xffff : 0x2310u << (share + i) % 3);
  SlicePacker packer;
  const auto save_all = [&](unsigned kind, const std::string& suffix,
                            std::span<const RequestedTile> requested) {
    packer.start(frame, Side::Left, requested);
    while (const std::optional<Slice> slice = packer.next())
      save(folder /
               (name + "_" + std::to_string(slice->plane) + "_" + std::to_string(slice->first_tile) + suffix),
           slice_input(kind, *slice, slice->lights, slice->plane, requested));
  };
  save_all(0, "_whole", {});
  save_all(1, "_some", some);
  save_all(1, "_apart", apart);
  const auto save_requested = [&](const std::string& suffix, std::span<const RequestedTile> requested) {
    AskPacker asking;
    asking.start(FrameId{1}, Side::Left, mask.size(), lights, requested);
    while (const std::optional<AskSlice> slice = asking.next())
      save(folder / (name + suffix), slice_input(2, *slice, lights, 0, {}));
  };
  save_requested("_ask", some);
  save_requested("_ask_apart", apart);
}

/// The form and the other numbers of plane_slice.cpp, then a block or the tiles that it decompresses to.
void save_planes(const fs::path& folder, const std::string& name, PlaneKind kind, const PixelPlane& plane) {
  PlanePacker packer;
  packer.start(FrameId{}, Side::Left, kind, plane);
  const TileGrid grid{plane.size};
  while (const std::optional<PlaneSlice> slice = packer.next()) {
    const auto input = [&](unsigned form, std::span<const std::byte> bytes) {
      Bytes made = wire_samples::bytes_of({form, static_cast<unsigned>(kind), plane.word_bytes - 1,
                                           plane.size.width - 1, plane.size.height - 1, slice->first_tile,
                                           slice->tile_count - 1});
      made.insert(made.end(), bytes.begin(), bytes.end());
      return made;
    };
    const std::string place = name + "_" + std::to_string(slice->first_tile);
    save(folder / (place + "_block"), input(0, slice->block));
    Bytes tiles;
    for (std::uint32_t i = 0; i < slice->tile_count; ++i) {
      TileWords words;
      load_tile(plane, grid.rect(slice->first_tile + i), words);
      write_plane_tile(words, lanes_of(kind, plane.word_bytes), tiles);
    }
    save(folder / (place + "_tiles"), input(1, tiles));
  }
}

/// A plane with the words `word(x, y)`.
template <class Word>
PixelPlane plane_of(Extent size, std::uint32_t word_bytes, Word word) {
  PixelPlane plane(size, word_bytes);
  for (std::uint32_t y = 0; y < size.height; ++y)
    for (std::uint32_t x = 0; x < size.width; ++x)
      plane.words[y * size.width + x] = word(x, y) & largest_word(word_bytes);
  return plane;
}

/// An input with the number `first` and the bytes `rest`.
Bytes after(unsigned first, const Bytes& rest) {
  Bytes input = wire_samples::bytes_of({first});
  input.insert(input.end(), rest.begin(), rest.end());
  return input;
}

void save_envelopes(const fs::path& folder) {
  using namespace wire_samples;
  const Bytes sealed(24, std::byte{0x5e});
  Bytes foreign = enveloped(hello());
  foreign[4] = std::byte{9};  // version
  foreign[5] = std::byte{0};
  Hello of_previous = hello();
  of_previous.version = kPreviousVersion;
  save(folder / "hello", after(0, enveloped(hello())));
  save(folder / "hello_of_version_9", after(0, foreign));
  save(folder / "hello_of_the_previous_version", after(0, enveloped(of_previous)));
  save(folder / "sealed_to_server", after(0, enveloped(Sealed{SessionId{1}, 2, sealed})));
  save(folder / "retry", after(1, enveloped(retry())));
  save(folder / "open_refusal", after(1, enveloped(open_refusal())));
  save(folder / "accept", after(1, enveloped(accept_sample(sealed))));
  save(folder / "no_session", after(1, enveloped(no_session())));
  save(folder / "sealed_to_client", after(1, enveloped(Sealed{SessionId{1}, 2, sealed})));
}

void save_messages(const fs::path& folder) {
  using namespace wire_samples;
  save(folder / "request", after(0, encoded(ClientMessage(request()))));
  RequestMessage block = request();
  block.request.answer = {.coding = Coding::Lz4};
  save(folder / "request_for_a_block", after(0, encoded(ClientMessage(block))));
  save(folder / "welcome", after(1, encoded(ServerMessage(welcome()))));
  save(folder / "refusal", after(1, encoded(ServerMessage(refusal()))));
  save(folder / "report", after(1, encoded(ServerMessage(report()))));
  save(folder / "probe", after(1, encoded(ServerMessage(probe()))));
  save(folder / "slice", after(1, packed(small_frame(), Side::Left).front()));
  save(folder / "ask_slice", after(0, ask_sample()));
  save(folder / "plane_slice", after(0, encoded(ClientMessage(plane_slice()))));
  save(folder / "leave", after(0, encoded(ClientMessage(Leave{}))));
  save(folder / "goodbye", after(1, encoded(ServerMessage(Goodbye{EndReason::Revoked}))));
  save(folder / "path_probe", after(1, encoded(ServerMessage(path_probe()))));
  Bytes part = encoded(ServerMessage(video_part()));
  save(folder / "video_part", after(1, part));
  part.resize(kBaseMessage_bytes + 1);
  save(folder / "video_part_too_long", after(1, part));
}

/// The form and the other numbers of handshake.cpp; then changes: place (two bytes) and xor.
void save_handshakes(const fs::path& folder) {
  using wire_samples::bytes_of;
  save(folder / "accept", bytes_of({0}));
  save(folder / "accept_other_session", bytes_of({0, 0, 0, 23, 1}));
  save(folder / "accept_other_point", bytes_of({0, 0, 0, 62, 0x80}));
  save(folder / "accept_other_tag", bytes_of({0, 0, 0, 99, 1}));
  save(folder / "accept_short", bytes_of({0, 3, 0, 79}));
  save(folder / "retry", bytes_of({1}));
  save(folder / "retry_other_echo", bytes_of({1, 0, 0, 7, 1}));
  save(folder / "hello_bare", bytes_of({2, 0, 0, 0, 0}));
  save(folder / "hello", bytes_of({2, 1, 0, 0, 0}));
  save(folder / "hello_elsewhere", bytes_of({2, 1, 1, 0, 0}));
  save(folder / "hello_late", bytes_of({2, 1, 0, 0x13, 0x88}));
  save(folder / "hello_other_proof", bytes_of({2, 1, 0, 0, 0, 0, 0, 100, 1}));
  save(folder / "hello_outsider", bytes_of({2, 2, 0, 0, 0}));
  save(folder / "hello_version", bytes_of({2, 1, 0, 0, 0, 0, 0, 4, 1}));
}

/// Steps of server_sequence.cpp: kind, address, parameters.
void save_server_sequences(const fs::path& folder) {
  using wire_samples::bytes_of;
  save(folder / "say", bytes_of({0, 2, 8, 0x46, 0x44, 0x53, 0x48, 2, 0, 6, 1, 0, 1, 1, 9}));
  save(folder / "repeat", bytes_of({3, 0, 4, 0, 20, 1, 0, 0, 0, 1, 2, 1, 0, 0, 1, 4, 2, 0, 0}));
  save(folder / "forge", bytes_of({3, 0, 2, 0, 0, 1, 0, 0, 30, 1, 4, 0, 50, 2, 1, 0, 1, 0, 0, 15, 1}));
  save(folder / "shorten", bytes_of({3, 1, 2, 3, 0, 0, 3, 0, 40, 4, 0, 20}));
  save(folder / "ask_in_turn", bytes_of({3, 0, 3, 1, 4, 0, 14, 3, 0, 3, 1, 4, 0, 14, 3, 0, 3, 0, 4, 0, 200}));
  save(folder / "withhold_and_bring_elsewhere", bytes_of({5, 0, 3, 0, 1, 3, 0, 0, 0, 4, 0, 20, 3, 0}));
  save(folder / "withhold_from_client", bytes_of({5, 2, 3, 0, 4, 0, 50, 3, 1}));
  save(folder / "move", bytes_of({6, 0, 3, 0, 4, 0, 20, 3, 0, 4, 0, 20, 6, 1, 3, 1}));
  save(folder / "newcomers", bytes_of({7, 0, 0, 7, 1, 0, 7, 2, 0, 7, 3, 0, 4, 0, 9, 3, 0}));
  save(folder / "nobody", bytes_of({7, 0, 1, 1, 3, 0, 0, 0}));
}

/// Steps of client_sequence.cpp.
void save_client_sequences(const fs::path& folder) {
  using wire_samples::bytes_of;
  save(folder / "say", bytes_of({0, 8, 0x46, 0x44, 0x53, 0x48, 2, 0, 6, 1}));
  save(folder / "repeat", bytes_of({4, 5, 30, 1, 0, 0, 0, 1, 1, 0, 0, 1, 2, 0, 0, 4, 5, 30}));
  save(folder / "forge", bytes_of({4, 5, 30, 2, 0, 1, 0, 0, 30, 1, 2, 1, 1, 0, 0, 15, 1}));
  save(folder / "shorten", bytes_of({4, 5, 30, 2, 0, 0, 3, 0, 40, 5, 20}));
  save(folder / "no_session", bytes_of({3, 1, 0, 0, 5, 50, 4}));
  save(folder / "no_session_and_lies",
       bytes_of({6, 1, 3, 1, 0, 0, 3, 1, 0, 1, 3, 1, 0, 2, 3, 7, 0, 3, 3, 1, 9, 4}));
  save(folder / "sealed", bytes_of({3, 200, 9, 5, 4, 5, 30, 3, 3, 9, 5}));
  save(folder / "withhold", bytes_of({6, 0, 4, 5, 50, 1, 0, 0, 0, 6, 1, 4, 5, 50}));
  save(folder / "silence", bytes_of({6, 1, 4, 6, 1, 4, 6, 1, 4, 6, 1, 4, 5, 255, 5, 255, 4, 5, 50}));
}

/// One capture with a server and light changes, the same cut off, one without a server, and one whose request
/// is another message.
void save_captures(const fs::path& folder) {
  using namespace record_samples;
  CapturedFrame lit = frame(1), quiet = frame(2), alone = frame(1);
  change(lit.input.settings.lights, 2, false, {});
  change(lit.input.settings.lights, 0, true, LightPose{.position = {{1, 2, 3}}});
  quiet.request.reset();
  quiet.before = std::exchange(quiet.after, {});
  Bytes whole = file_of(header(), std::vector{lit, quiet});
  save(folder / "server", whole);
  whole.erase(whole.end() - 20, whole.end());
  save(folder / "cut_off", whole);
  CaptureHeader nobody = header();
  nobody.origin = MaskOrigin::Nobody;
  alone.request.reset();
  alone.before.clear();
  alone.after.clear();
  save(folder / "nobody", file_of(nobody, std::vector{alone}));
  save(folder / "plane_slice_as_request", file_with_request(wire_samples::plane_slice()));
}

}  // namespace

/// Units in the form of video.cpp: of the size that was asked for, of a larger one, and cut.
void save_videos(const fs::path& folder) {
  if (!has_video()) return;
  const auto units = [&](Extent size) {
    const auto encoder = VideoEncoder::create({size, 2'000'000, 72, 300}).value();
    std::vector<Bytes> made;
    for (std::uint8_t frame = 0; frame < 2; ++frame) {
      Image<Rgb8> picture(size);
      for (std::uint32_t i = 0; i < size.pixels(); ++i)
        picture.pixels[i] = Rgb8(static_cast<std::uint8_t>(3 * i + 40 * frame));
      const auto unit = encoder->encode(picture, KeyFrame::IfNeeded);
      made.emplace_back(1, std::byte{frame});
      made.back().insert(made.back().end(), unit.begin(), unit.end());
    }
    return made;
  };
  const std::vector<Bytes> requested = units({64, 48}), larger = units({1024, 1024});
  save(folder / "key", requested[0]);
  save(folder / "next", requested[1]);
  save(folder / "cut", Bytes(requested[0].begin(), requested[0].begin() + 400));
  save(folder / "larger", Bytes(larger[0].begin(), larger[0].begin() + 400));
}

int main(int argc, char** argv) {
  if (argc != 2) return std::fprintf(stderr, "usage: %s CORPUS\n", argv[0]), EXIT_FAILURE;
  const fs::path corpus = argv[1];
  save(corpus / "gltf" / "triangle.glb", triangle_file().glb());
  save(corpus / "gltf" / "triangle.gltf", triangle_file().gltf());
  save(corpus / "gltf" / "rich.glb", rich_file().glb());
  save(corpus / "gltf" / "rich.gltf", rich_file().gltf());
  save(corpus / "gltf" / "triangle.parts", parts(triangle_file()));
  save(corpus / "gltf" / "rich.parts", parts(rich_file()));
  save_compressed(corpus / "gltf");
  save_envelopes(corpus / "envelope");
  save_messages(corpus / "message");
  save_handshakes(corpus / "handshake");
  save_server_sequences(corpus / "server_sequence");
  save_client_sequences(corpus / "client_sequence");
  save_captures(corpus / "capture_file");
  save_videos(corpus / "video");
  std::mt19937 random(1);
  const fs::path planes = corpus / "plane_slice";
  std::mt19937 noise(2);
  save_planes(planes, "one_value", PlaneKind::BaseColor,
              plane_of({40, 24}, 3, [](auto, auto) { return 0x8040ffu; }));
  save_planes(planes, "slope", PlaneKind::Depth,
              plane_of({33, 20}, 4, [](auto x, auto y) { return 0x3c000000u + 700 * x + 90 * y; }));
  save_planes(planes, "edge", PlaneKind::PositionX,
              plane_of({20, 18}, 3, [](auto x, auto y) { return x > y ? 0u : 70'000u + 33 * x * x; }));
  save_planes(planes, "noise", PlaneKind::Normal,
              plane_of({16, 16}, 4, [&noise](auto, auto) { return static_cast<std::uint32_t>(noise()); }));
  const fs::path slices = corpus / "slice_and_tiles";
  save_slices(slices, "none", EyeMask({16, 16}, 0));
  save_slices(slices, "small", wire_samples::small_frame().masks[0]);
  save_slices(slices, "edges", wire_samples::edge_mask({72, 40}, 11, random));
  save_slices(slices, "many", wire_samples::edge_mask({40, 24}, 70, random));
  save_slices(slices, "noise", wire_samples::noise_mask({16, 16}, 20, random));
  return EXIT_SUCCESS;
}
