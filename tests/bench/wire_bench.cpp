// The coders of masks and of requested blocks on traced masks: bytes and times of both eyes, for whole views
// and for what a client asks for of the next view. Whole masks are compared with one LZ4 block
// (mask_block.h), also in what arrives on a path that loses datagrams, and with LZ4 over the whole masks as
// they are in memory.
#include <lz4.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <bit>
#include <cstdio>
#include <memory>
#include <numeric>
#include <random>

#include "stereo/answers/assembler.h"
#include "stereo/answers/frame_packer.h"
#include "stereo/base/check.h"
#include "stereo/base/clock.h"
#include "stereo/base/quantile.h"
#include "stereo/codec/ask_coder.h"
#include "stereo/codec/decision_counts.h"
#include "stereo/codec/mask_block.h"
#include "stereo/codec/slice.h"
#include "stereo/frame/tiles.h"
#include "stereo/gltf/gltf.h"
#include "stereo/net/impairment.h"
#include "stereo/sealing/seal.h"
#include "stereo/tracer/tracer.h"

namespace {

using namespace farshade;

using Bytes = std::vector<std::byte>;

struct Options {
  std::vector<std::string> scenes;
  bool train = false;
  std::uint32_t side_px = 1024;
  std::uint32_t poses = 12;
};

struct Column {
  const char* name;
  std::vector<double> values;
};

/// Eyes at the scene's reference camera, turned by `yaw_rad`.
FrameRequest request_of(const Scene& scene, double yaw_rad, std::uint32_t side_px) {
  FrameRequest request;
  for (const Side side : kSides) {
    const Rigid<Eye, Head> camera_from_head{glm::angleAxis(yaw_rad, glm::dvec3(0, 1, 0)), glm::dvec3(0)};
    const Rigid<Head, Eye> head_from_eye{{1, 0, 0, 0}, {side == Side::Left ? -0.032 : 0.032, 0, 0}};
    View& view = request.views[index_of(side)];
    view.stage_from_eye = scene.camera.value_or(Rigid<Stage, Eye>{}) * camera_from_head * head_from_eye;
    view.fov = {-0.8, 0.8, 0.8, -0.8};
    view.size = {side_px, side_px};
  }
  return request;
}

double lz4_bytes(const Bytes& bytes) {
  std::vector<char> block(static_cast<std::size_t>(LZ4_compressBound(static_cast<int>(bytes.size()))));
  return LZ4_compress_default(reinterpret_cast<const char*>(bytes.data()), block.data(),
                              static_cast<int>(bytes.size()), static_cast<int>(block.size()));
}

/// The blocks of a view in which something is asked for.
class RequestedSet {
 public:
  RequestedSet(Extent size, std::uint32_t lights)
      : grid_{size},
        lights_(lights),
        columns_(size.width / kBlockSide_px),
        rows_(size.height / kBlockSide_px),
        tiles_(grid_.count()) {}

  /// Asks for the block of a pixel in the lights that are set in a word of a mask.
  void add_pixel(std::uint32_t x, std::uint32_t y, std::uint32_t lights) {
    RequestedTile& tile = tile_of(x, y);
    for (; lights != 0; lights &= lights - 1)
      tile.shares[static_cast<std::size_t>(std::countr_zero(lights)) % kMostShares] |=
          block_bit(x % kTileSide_px, y % kTileSide_px);
  }
  /// Asks for all lights of a block; columns and rows of blocks.
  void add_block(std::uint32_t column, std::uint32_t row) {
    const std::uint32_t x = kBlockSide_px * column, y = kBlockSide_px * row;
    if (column >= columns_ || row >= rows_) return;
    for (std::uint32_t share = 0; share < shares_of(lights_); ++share)
      tile_of(x, y).shares[share] |= block_bit(x % kTileSide_px, y % kTileSide_px);
  }
  void add_tile(std::uint32_t tile) { tiles_[tile] = all_lights_in(kAllBlocks, lights_); }

  [[nodiscard]] std::uint32_t columns() const { return columns_; }
  [[nodiscard]] std::uint32_t rows() const { return rows_; }
  [[nodiscard]] std::vector<RequestedTile> take() { return std::move(tiles_); }
  [[nodiscard]] std::uint32_t tiles() const { return grid_.count(); }

 private:
  RequestedTile& tile_of(std::uint32_t x, std::uint32_t y) {
    return tiles_[y / kTileSide_px * grid_.columns() + x / kTileSide_px];
  }

  TileGrid grid_;
  std::uint32_t lights_, columns_, rows_;
  std::vector<RequestedTile> tiles_;
};

/// The blocks of each light in which a pixel differs from one of its neighbours: those that a client cannot
/// reproject from its newest mask if the view has hardly moved.
void add_edges(const EyeMask& mask, RequestedSet& requested) {
  const auto compare = [&](std::uint32_t x, std::uint32_t y, std::uint32_t other_x, std::uint32_t other_y) {
    for (std::uint32_t plane = 0; plane < mask.layout().planes(); ++plane)
      if (const std::uint32_t differ = mask.word(x, y, plane) ^ mask.word(other_x, other_y, plane)) {
        requested.add_pixel(x, y, differ);
        requested.add_pixel(other_x, other_y, differ);
      }
  };
  for (std::uint32_t y = 0; y < mask.size().height; ++y)
    for (std::uint32_t x = 0; x < mask.size().width; ++x) {
      if (x > 0) compare(x, y, x - 1, y);
      if (y > 0) compare(x, y, x, y - 1);
    }
}

/// What a client asks for: edges light by light, and all lights in a strip along one or two sides of the
/// picture, in some disocclusions, and in the tiles whose turn it is to be refreshed.
std::vector<RequestedTile> requested_of(const EyeMask& mask, std::mt19937& random) {
  constexpr std::uint32_t kDisocclusions = 13, kDisoccluded = 5, kRefreshed_permille = 14;
  RequestedSet requested(mask.size(), mask.lights());
  add_edges(mask, requested);
  const auto up_to = [&random](std::uint32_t most) {
    return static_cast<std::uint32_t>(random()) % (most + 1);
  };
  const std::uint32_t columns = requested.columns(), rows = requested.rows();
  const std::uint32_t wide = 1 + up_to(2), high = up_to(1);
  const bool is_right = up_to(1) != 0, is_low = up_to(1) != 0;
  for (std::uint32_t i = 0; i < wide; ++i)
    for (std::uint32_t row = 0; row < rows; ++row) requested.add_block(is_right ? columns - 1 - i : i, row);
  for (std::uint32_t i = 0; i < high; ++i)
    for (std::uint32_t column = 0; column < columns; ++column)
      requested.add_block(column, is_low ? rows - 1 - i : i);
  for (std::uint32_t i = 0; i < kDisocclusions; ++i) {
    const std::uint32_t column = up_to(columns - 1), row = up_to(rows - 1);
    for (std::uint32_t down = 0; down < kDisoccluded; ++down) requested.add_block(column, row + down);
  }
  for (std::uint32_t tile = 0; tile < requested.tiles(); ++tile)
    if (up_to(999) < kRefreshed_permille) requested.add_tile(tile);
  return requested.take();
}

std::vector<RequestedTile> edges_of(const EyeMask& mask) {
  RequestedSet requested(mask.size(), mask.lights());
  add_edges(mask, requested);
  return requested.take();
}

/// The blocks that are asked for, and of how many lights each.
struct RequestedCount {
  double blocks = 0, lights = 0;

  explicit RequestedCount(const RequestedBlocks& requested) {
    for (const std::vector<RequestedTile>& eye : requested.tiles)
      for (const RequestedTile& tile : eye) {
        blocks += std::popcount(tile.any());
        for (const BlockBits share : tile.shares) lights += std::popcount(share);
      }
  }
};

double size_of(const std::vector<Bytes>& messages) {
  double bytes = 0;
  for (const Bytes& message : messages) bytes += static_cast<double>(message.size());
  return bytes;
}

std::vector<Bytes> pack(const ShadowFrame& frame, const RequestedBlocks& requested, SlicePacker& packer) {
  std::vector<Bytes> datagrams;
  for (const Side side : kSides) {
    packer.start(frame, side, requested.tiles[index_of(side)]);
    while (const auto slice = packer.next()) encode(ServerMessage(*slice), datagrams.emplace_back());
  }
  return datagrams;
}

void open(const std::vector<Bytes>& datagrams, const RequestedBlocks& requested, PerEye<EyeMask>& masks,
          PerEye<ReceivedTiles>& known) {
  for (const Bytes& datagram : datagrams) {
    const auto slice = std::get<Slice>(decode_server(datagram).value());
    const std::size_t eye = index_of(slice.eye);
    check(decode_slice_tiles(slice, requested.tiles[eye], masks[eye], known[eye]).has_value(),
          "our own slices open");
  }
}

std::vector<Bytes> pack(const ShadowFrame& frame, const RequestedBlocks& requested, AskPacker& packer) {
  std::vector<Bytes> datagrams;
  for (const Side side : kSides) {
    const std::size_t eye = index_of(side);
    packer.start(FrameId{1}, side, frame.masks[eye].size(), frame.masks[eye].lights(), requested.tiles[eye]);
    while (const auto slice = packer.next()) encode(ClientMessage(*slice), datagrams.emplace_back());
  }
  return datagrams;
}

RequestedBlocks open(const std::vector<Bytes>& datagrams, const ShadowFrame& frame) {
  RequestedBlocks requested;
  PerEye<ReceivedTiles> known;
  for (std::size_t eye = 0; eye < kEyes; ++eye) {
    requested.tiles[eye].assign(TileGrid{frame.masks[eye].size()}.count(), {});
    known[eye].assign(requested.tiles[eye].size(), 0);
  }
  for (const Bytes& datagram : datagrams) {
    const auto slice = std::get<AskSlice>(decode_client(datagram).value());
    const std::size_t eye = index_of(slice.eye);
    check(decode_ask_slice(slice, requested.tiles[eye], known[eye]).has_value(), "our own slices open");
  }
  return requested;
}

std::vector<Bytes> seal(const std::vector<Bytes>& messages, Sealer& sealer) {
  std::vector<Bytes> sealed;
  for (const Bytes& message : messages) sealer.seal(message, sealed.emplace_back());
  return sealed;
}

void unseal(const std::vector<Bytes>& datagrams, Opener& opener, Bytes& opened) {
  for (const Bytes& datagram : datagrams) {
    const auto sealed = std::get<Sealed>(open_server_envelope(datagram).value());
    check(opener.open(sealed, datagram, opened).has_value(), "what we seal opens");
  }
}

void print_columns(std::initializer_list<Column> columns) {
  for (const Column& column : columns) {
    const Spread spread = spread_of(column.values);
    const double sum = std::accumulate(column.values.begin(), column.values.end(), 0.0);
    std::printf("%-40s %8.3f %8.3f %8.3f %8.3f\n", column.name,
                sum / static_cast<double>(column.values.size()), spread.median, spread.p95, spread.p99);
  }
}

/// Figures of packing some blocks of both eyes.
struct Packing {
  Column kilobytes, datagrams, pack_ms, open_ms;

  void measure(const ShadowFrame& frame, const RequestedBlocks& requested, SlicePacker& packer) {
    PerEye<EyeMask> masks;
    PerEye<ReceivedTiles> known;
    for (std::size_t eye = 0; eye < kEyes; ++eye) {
      masks[eye] = EyeMask(frame.masks[eye].size(), frame.masks[eye].lights());
      known[eye].assign(TileGrid{masks[eye].size()}.count(), 0);
    }
    for (int repeat = 0; repeat < 20; ++repeat) {
      const Stopwatch packing;
      const std::vector<Bytes> packed = pack(frame, requested, packer);
      pack_ms.values.push_back(ms_of(packing.elapsed()));
      const Stopwatch opening;
      open(packed, requested, masks, known);
      open_ms.values.push_back(ms_of(opening.elapsed()));
      if (repeat > 0) continue;
      kilobytes.values.push_back(size_of(packed) / 1e3);
      datagrams.values.push_back(static_cast<double>(packed.size()));
    }
    if (requested.whole()) check(masks == frame.masks, "masks are unchanged");
  }
};

/// Figures of packing what is asked for of both eyes.
struct RequestFigures {
  Column share{"  blocks asked for, %", {}}, lights{"  shares of the lights in each", {}},
      bytes{"  its AskSlices, bytes", {}}, pack_ms{"    pack both eyes, ms", {}},
      open_ms{"    decode both eyes, ms", {}};

  void measure(const ShadowFrame& frame, const RequestedBlocks& requested, AskPacker& packer) {
    const double all = static_cast<double>(requested.tiles[0].size() + requested.tiles[1].size()) * 16;
    const RequestedCount count(requested);
    share.values.push_back(100 * count.blocks / all);
    if (count.blocks > 0) lights.values.push_back(count.lights / count.blocks);
    for (int repeat = 0; repeat < 20; ++repeat) {
      const Stopwatch packing;
      const std::vector<Bytes> packed = pack(frame, requested, packer);
      pack_ms.values.push_back(ms_of(packing.elapsed()));
      const Stopwatch opening;
      check(open(packed, frame) == requested, "requested blocks are unchanged");
      open_ms.values.push_back(ms_of(opening.elapsed()));
      if (repeat == 0) bytes.values.push_back(size_of(packed));
    }
  }
};

/// Times of sealing the slices of both eyes.
struct SealTimes {
  Column seal_ms{"seal both eyes, ms", {}}, unseal_ms{"unseal both eyes, ms", {}};
  Secret key{{1, 2, 3}};
  Sealer sealer{{}, key, Sealing::On};
  Opener opener{key, Sealing::On};
  Bytes opened;

  void measure(const std::vector<Bytes>& packed) {
    const Stopwatch sealing;
    const std::vector<Bytes> sealed = seal(packed, sealer);
    seal_ms.values.push_back(ms_of(sealing.elapsed()));
    const Stopwatch unsealing;
    unseal(sealed, opener, opened);
    unseal_ms.values.push_back(ms_of(unsealing.elapsed()));
  }
};

/// The messages of both masks as one LZ4 block.
std::vector<Bytes> block_parts(const ShadowFrame& frame) {
  const Bytes block = pack_mask_block(frame);
  FramePacker packer;
  packer.begin();
  packer.add(frame.frame, frame.frame, full_parts(block));
  std::vector<Bytes> messages = packer.finish({.frame = frame.frame});
  messages.pop_back();
  return messages;
}

/// Figures of both masks as one LZ4 block, and of LZ4 over the masks as they are in memory.
struct Block {
  Column masks{"LZ4 of both masks, KB", {}}, kilobytes{"whole views: one LZ4 block, KB", {}},
      datagrams{"  datagrams", {}}, pack_ms{"  pack both eyes, ms", {}},
      open_ms{"  decode both eyes, ms", {}};

  void measure(const ShadowFrame& frame) {
    double of_masks = 0;
    for (const EyeMask& mask : frame.masks)
      of_masks += lz4_bytes(Bytes(mask.bytes().begin(), mask.bytes().end())) / 1e3;
    masks.values.push_back(of_masks);
    const std::vector<Bytes> parts = block_parts(frame);
    kilobytes.values.push_back(size_of(parts) / 1e3);
    datagrams.values.push_back(static_cast<double>(parts.size()));
    for (int repeat = 0; repeat < 5; ++repeat) {
      const Stopwatch packing;
      const Bytes block = pack_mask_block(frame);
      pack_ms.values.push_back(ms_of(packing.elapsed()));
      PerEye<EyeMask> opened;
      for (std::size_t eye = 0; eye < kEyes; ++eye)
        opened[eye] = EyeMask(frame.masks[eye].size(), frame.masks[eye].lights());
      const Stopwatch opening;
      check(decode_mask_block(block, frame.light_set_revision, opened).has_value(), "our own block opens");
      open_ms.values.push_back(ms_of(opening.elapsed()));
      check(opened == frame.masks, "masks are unchanged");
    }
  }
};

/// What arrives of whole masks on a path that loses datagrams at random.
struct Arrival {
  double loss;
  Column slices{"  slices: tiles that arrive, %", {}}, whole{"  slices: whole masks, %", {}},
      block{"  one LZ4 block: whole masks, %", {}};
  std::uint64_t tried = 0;

  void measure(const FrameRequest& request, const ShadowFrame& frame, SlicePacker& packer) {
    const std::vector<Bytes> packed = pack(frame, {}, packer), parts = block_parts(frame);
    for (int repeat = 0; repeat < 50; ++repeat) {
      const double tiles = arrived(request, frame, packed);
      slices.values.push_back(100 * tiles);
      whole.values.push_back(tiles == 1 ? 100 : 0);
      FrameRequest of_block = request;
      of_block.answer.coding = Coding::Lz4;
      block.values.push_back(100 * arrived(of_block, frame, parts));
    }
  }

  /// The share of both masks' tiles that a client knows afterwards.
  double arrived(const FrameRequest& request, const ShadowFrame& frame, const std::vector<Bytes>& messages) {
    Impairment path({.loss = loss}, {}, ++tried);
    Assembler assembler;
    assembler.expect(request, {frame.masks[0].lights()}, frame.light_set_revision);
    for (const Bytes& message : messages) path.push({}, {}, message);
    for (; path.front() != nullptr; path.pop()) {
      const ServerMessage message = decode_server(path.front()->bytes()).value();
      if (const auto* slice = std::get_if<Slice>(&message)) assembler.accept(*slice);
      if (const auto* part = std::get_if<VideoPart>(&message)) assembler.accept(*part);
    }
    const RequestRecord& record = *assembler.find(request.frame);
    const double known = record.tiles_known[0] + record.tiles_known[1],
                 all = record.tiles_requested[0] + record.tiles_requested[1];
    return known / (all * frame.masks[0].layout().planes());
  }
};

Packing packing_of(const char* what) {
  return {{what, {}}, {"  datagrams", {}}, {"  pack both eyes, ms", {}}, {"  decode both eyes, ms", {}}};
}

FrameRequest request_of(const Scene& scene, const Options& options, double pose) {
  return request_of(scene, 6.2831853 * pose / options.poses, options.side_px);
}

Expected<void> run(const Options& options, const std::string& file) {
  const Expected<Scene> scene = load_scene(file);
  if (!scene) return tl::unexpected(scene.error());
  Expected<Tracer> tracer = Tracer::create(*scene);
  if (!tracer) return tl::unexpected(tracer.error());

  Column trace_ms{"trace both eyes, ms", {}};
  Packing whole = packing_of("whole views: slices, KB"), edges = packing_of("edges: slices, KB"),
          next = packing_of("next view: slices, KB");
  Block block;
  std::array<Arrival, 3> arrivals{Arrival{0}, Arrival{0.01}, Arrival{0.05}};
  RequestFigures edge_requests, next_requests;
  std::mt19937 random(1);
  SealTimes sealing;
  ShadowFrame frame;
  SlicePacker packer;
  AskPacker ask_packer;
  for (std::uint32_t pose = 0; pose < options.poses; ++pose) {
    const FrameRequest request = request_of(*scene, options, pose);
    const Stopwatch tracing;
    tracer->trace(request, frame);
    trace_ms.values.push_back(ms_of(tracing.elapsed()));
    const RequestedBlocks with_edges{{edges_of(frame.masks[0]), edges_of(frame.masks[1])}};
    const RequestedBlocks of_next{
        {requested_of(frame.masks[0], random), requested_of(frame.masks[1], random)}};
    block.measure(frame);
    for (Arrival& arrival : arrivals) arrival.measure(request, frame, packer);
    whole.measure(frame, {}, packer);
    edges.measure(frame, with_edges, packer);
    edge_requests.measure(frame, with_edges, ask_packer);
    next.measure(frame, of_next, packer);
    next_requests.measure(frame, of_next, ask_packer);
    sealing.measure(pack(frame, {}, packer));
  }
  std::printf("%s\n%u x %u an eye, %u lights, %u poses\n%-40s %8s %8s %8s %8s\n", file.c_str(),
              options.side_px, options.side_px, frame.masks[0].lights(), options.poses, "", "mean", "median",
              "p95", "p99");
  print_columns({trace_ms, block.masks, block.kilobytes, block.datagrams, block.pack_ms, block.open_ms});
  const auto print_packing = [](const Packing& packing) {
    print_columns({packing.kilobytes, packing.datagrams, packing.pack_ms, packing.open_ms});
  };
  const auto print_requests = [](const RequestFigures& asking) {
    print_columns({asking.share, asking.lights, asking.bytes, asking.pack_ms, asking.open_ms});
  };
  print_packing(whole);
  print_packing(edges);
  print_requests(edge_requests);
  print_packing(next);
  print_requests(next_requests);
  for (const Arrival& arrival : arrivals) {
    std::printf("whole views at %.0f %% loss\n", 100 * arrival.loss);
    print_columns({arrival.slices, arrival.whole, arrival.block});
  }
  print_columns({sealing.seal_ms, sealing.unseal_ms});
  const auto median = [](const Column& column) { return spread_of(column.values).median; };
  const double sealed_ms = median(sealing.seal_ms);
  std::printf("seal / (trace + pack + seal): %.4f, figure <= 0.05\n",
              sealed_ms / (median(trace_ms) + median(whole.pack_ms) + sealed_ms));
  return {};
}

// ---- initial probabilities

/// Counts the decisions of coding masks and requested blocks. A slice ends after so many tiles.
struct Training {
  static constexpr std::uint32_t kSlice_tiles = 1024;

  MaskModels mask_models{kInitialMaskModels};
  AskModels ask_models{kInitialAskModels};
  DecisionCounts::Counts counts;
  DecisionCounts counter{counts};

  void mask(const EyeMask& mask, std::span<const RequestedTile> requested) {
    const TileGrid grid{mask.size()};
    const RequestedTiles tiles(mask.size(), mask.lights(), requested);
    for (std::uint32_t plane = 0; plane < mask.layout().planes(); ++plane) {
      CodedTiles coded;
      MaskCoder coder(counter, mask_models, coded, mask.layout().lights_in(plane));
      for (std::uint32_t tile = 0; tile < grid.count(); ++tile) {
        if (tile % kSlice_tiles == 0) {
          coded.start(grid.columns(), tile);
          coder.form(false);
        }
        const RequestedTile in_tile = tiles.at(tile);
        if (in_tile.any() == kNoBlocks) {
          coded.add_nothing();
          continue;
        }
        TileBits bits;
        split_tile(mask, grid.rect(tile), plane, in_tile, bits);
        coder.tile(in_tile, bits);
      }
    }
  }

  void requested(const EyeMask& mask, std::span<const RequestedTile> requested) {
    const TileGrid grid{mask.size()};
    AskCoder coder(counter, ask_models, grid.columns(), mask.lights());
    for (std::uint32_t tile = 0; tile < grid.count(); ++tile) {
      RequestedTile in_tile = requested[tile];
      coder.tile(tile, in_tile);
    }
  }

  template <std::size_t kCount>
  void print(const char* name, ModelSet<kCount>& models) const {
    std::printf("const std::array<std::uint8_t, %zu> %s{", kCount, name);
    for (std::size_t i = 0; i < kCount; ++i) {
      const auto found = counts.find(&models.at(i));
      const auto [zeros, ones] = found == counts.end() ? std::array<std::uint64_t, 2>{} : found->second;
      const double zero = (static_cast<double>(zeros) + 0.4) / (static_cast<double>(zeros + ones) + 0.8);
      std::printf("%s0x%02x",
                  i == 0        ? ""
                  : i % 16 == 0 ? ",\n    "
                                : ", ",
                  static_cast<unsigned>(std::clamp(256 * zero, 0.0, 255.0)));
    }
    std::printf("};\n");
  }
};

/// Prints the probabilities of mask_models.cpp, from all scenes together.
Expected<void> train(const Options& options) {
  const auto training = std::make_unique<Training>();
  std::mt19937 random(2);
  for (const std::string& file : options.scenes) {
    const Expected<Scene> scene = load_scene(file);
    if (!scene) return tl::unexpected(scene.error());
    Expected<Tracer> tracer = Tracer::create(*scene);
    if (!tracer) return tl::unexpected(tracer.error());
    ShadowFrame frame;
    for (std::uint32_t pose = 0; pose < options.poses; ++pose) {
      tracer->trace(request_of(*scene, options, pose + 0.5), frame);
      for (const EyeMask& mask : frame.masks) {
        const std::vector<RequestedTile> requested = requested_of(mask, random);
        training->mask(mask, {});
        training->mask(mask, requested);
        training->requested(mask, requested);
      }
    }
  }
  training->print("kInitialMaskModels", training->mask_models);
  training->print("kInitialAskModels", training->ask_models);
  return {};
}

Expected<void> run_all(const Options& options) {
  if (options.train) return train(options);
  for (const std::string& file : options.scenes)
    if (Expected<void> done = run(options, file); !done) return done;
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app{"Measures bytes and times of packing traced masks."};
  app.add_option("--scene", options.scenes, "glTF files")->required();
  app.add_flag("--train", options.train, "print initial probabilities of the coders instead");
  app.add_option("--size", options.side_px, "pixels a side of each eye")->check(CLI::Range(1, 8192));
  app.add_option("--poses", options.poses, "number of directions, evenly around the camera")
      ->check(CLI::Range(1, 1000));
  CLI11_PARSE(app, argc, argv);
  const Expected<void> done = run_all(options);
  if (!done) std::fprintf(stderr, "wire_bench: %s\n", done.error().what.c_str());
  return done ? 0 : 1;
}
