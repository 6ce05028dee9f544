// The tile codec on traced masks: the bytes of an eye, and the times to pack and open both eyes. It is
// compared with LZ4 over the whole mask as it is in memory, and over plain bit planes. With those two, one
// lost datagram would lose the whole mask.
#include <lz4.h>

#include <CLI/CLI.hpp>
#include <cstdio>

#include "stereo/base/check.h"
#include "stereo/base/clock.h"
#include "stereo/base/quantile.h"
#include "stereo/frame/tiles.h"
#include "stereo/scene/gltf.h"
#include "stereo/tracer/tracer.h"
#include "stereo/wire/seal.h"
#include "stereo/wire/slice.h"

namespace {

using namespace farshade;

using Bytes = std::vector<std::byte>;

struct Options {
  std::string scene;
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

Bytes plain_bit_planes(const EyeMask& mask) {
  const std::size_t pixels = mask.size().pixels();
  Bytes planes((mask.lights() * pixels + 7) / 8);
  for (std::uint32_t light = 0; light < mask.lights(); ++light)
    for (std::uint32_t y = 0; y < mask.size().height; ++y)
      for (std::uint32_t x = 0; x < mask.size().width; ++x) {
        const std::size_t bit = light * pixels + std::size_t{y} * mask.size().width + x;
        if (mask.lit(x, y, light)) planes[bit / 8] |= std::byte{1} << bit % 8;
      }
  return planes;
}

std::vector<Bytes> pack(const ShadowFrame& frame, SlicePacker& packer) {
  std::vector<Bytes> datagrams;
  for (const Side side : kSides) {
    packer.start(frame, side);
    while (const auto slice = packer.next()) encode(ServerMessage(*slice), datagrams.emplace_back());
  }
  return datagrams;
}

void open(const std::vector<Bytes>& datagrams, PerEye<EyeMask>& masks, PerEye<KnownTiles>& known) {
  for (const Bytes& datagram : datagrams) {
    const auto slice = std::get<Slice>(decode_server(datagram).value());
    const std::size_t eye = index_of(slice.eye);
    check(decode_slice_tiles(slice, masks[eye], known[eye]).has_value(), "our own slices open");
  }
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
    std::printf("%-32s %8.3f %8.3f %8.3f\n", column.name, spread.median, spread.p95, spread.p99);
  }
}

Expected<void> run(const Options& options) {
  const Expected<Scene> scene = load_scene(options.scene);
  if (!scene) return tl::unexpected(scene.error());
  Expected<Tracer> tracer = Tracer::create(*scene);
  if (!tracer) return tl::unexpected(tracer.error());

  Column as_bytes{"LZ4 of the mask, KB an eye", {}}, as_planes{"LZ4 of bit planes, KB an eye", {}};
  Column as_slices{"slices, KB an eye", {}}, datagrams{"slices, datagrams an eye", {}};
  Column pack_ms{"pack both eyes, ms", {}}, open_ms{"decode both eyes, ms", {}};
  Column trace_ms{"trace both eyes, ms", {}}, seal_ms{"seal both eyes, ms", {}},
      unseal_ms{"unseal both eyes, ms", {}};
  const Secret key({1, 2, 3});
  Sealer sealer({}, key, Sealing::On);
  Opener opener(key, Sealing::On);
  Bytes opened;
  ShadowFrame frame;
  SlicePacker packer;
  for (std::uint32_t pose = 0; pose < options.poses; ++pose) {
    const Stopwatch tracing;
    tracer->trace(request_of(*scene, 6.2831853 * pose / options.poses, options.side_px), frame);
    trace_ms.values.push_back(ms_of(tracing.elapsed()));
    PerEye<EyeMask> masks;
    PerEye<KnownTiles> known;
    for (std::size_t eye = 0; eye < kEyes; ++eye) {
      const EyeMask& mask = frame.masks[eye];
      as_bytes.values.push_back(lz4_bytes(Bytes(mask.bytes().begin(), mask.bytes().end())) / 1e3);
      as_planes.values.push_back(lz4_bytes(plain_bit_planes(mask)) / 1e3);
      masks[eye] = EyeMask(mask.size(), mask.lights());
      known[eye].assign(TileGrid{mask.size()}.count(), 0);
    }
    for (int repeat = 0; repeat < 20; ++repeat) {
      const Stopwatch packing;
      const std::vector<Bytes> packed = pack(frame, packer);
      pack_ms.values.push_back(ms_of(packing.elapsed()));
      const Stopwatch sealing;
      const std::vector<Bytes> sealed = seal(packed, sealer);
      seal_ms.values.push_back(ms_of(sealing.elapsed()));
      const Stopwatch unsealing;
      unseal(sealed, opener, opened);
      unseal_ms.values.push_back(ms_of(unsealing.elapsed()));
      const Stopwatch opening;
      open(packed, masks, known);
      open_ms.values.push_back(ms_of(opening.elapsed()));
      if (repeat > 0) continue;
      double bytes = 0;
      for (const Bytes& datagram : packed) bytes += static_cast<double>(datagram.size());
      as_slices.values.push_back(bytes / 2e3);
      datagrams.values.push_back(static_cast<double>(packed.size()) / 2);
    }
    check(masks == frame.masks, "masks are unchanged");
  }
  std::printf("%u x %u an eye, %u lights, %u poses\n%-32s %8s %8s %8s\n", options.side_px, options.side_px,
              frame.masks[0].lights(), options.poses, "", "median", "p95", "p99");
  print_columns({as_bytes, as_planes, as_slices, datagrams, trace_ms, pack_ms, seal_ms, unseal_ms, open_ms});
  const auto median = [](const Column& column) { return spread_of(column.values).median; };
  std::printf("seal / (trace + pack + seal): %.4f, figure <= 0.05\n",
              median(seal_ms) / (median(trace_ms) + median(pack_ms) + median(seal_ms)));
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app{"Measures bytes and times of packing traced masks."};
  app.add_option("--scene", options.scene, "glTF file")->required();
  app.add_option("--size", options.side_px, "pixels a side of each eye")->check(CLI::Range(1, 8192));
  app.add_option("--poses", options.poses, "number of directions, evenly around the camera")
      ->check(CLI::Range(1, 1000));
  CLI11_PARSE(app, argc, argv);
  const Expected<void> done = run(options);
  if (!done) std::fprintf(stderr, "wire_bench: %s\n", done.error().what.c_str());
  return done ? 0 : 1;
}
