// Planes of pixels: the cost of a G-buffer on the wire, and the precision that positions need.
//
//   plane_bench --scene S [--size N] [--poses P]
//
// For views in all directions around the scene's reference camera, prints the bytes and datagrams of each
// plane of an eye, and the times to read, pack, open and upload the planes of both eyes. For each number of
// bits per axis, it prints the share of wrong bits among pixel-lights that face their light (compared with
// the ordinary trace of the same views), the bytes of an eye's positions, and the time of the trace.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>

#include "stereo/base/check.h"
#include "stereo/base/quantile.h"
#include "stereo/codec/plane_codec.h"
#include "stereo/draw/renderer.h"
#include "stereo/frame/position_grid.h"
#include "stereo/frame/tiles.h"
#include "stereo/gltf/gltf.h"
#include "stereo/gpu/device.h"
#include "stereo/tracer/tracer.h"

namespace farshade {
namespace {

struct Options {
  std::string scene;
  std::uint32_t side_px = 512, poses = 6;
};

double median(const std::vector<double>& values) {
  return quantile(values, 0.5);
}

FrameRequest request_of(const Scene& scene, double yaw_rad, std::uint32_t side_px) {
  FrameRequest request;
  for (const Side side : kSides) {
    const Rigid<Eye, Head> camera_from_head{glm::angleAxis(yaw_rad, glm::dvec3(0, 1, 0)), glm::dvec3(0)};
    const Rigid<Head, Eye> head_from_eye{{1, 0, 0, 0}, {side == Side::Left ? -0.032 : 0.032, 0, 0}};
    request.views[index_of(side)] = {
        scene.camera.value_or(Rigid<Stage, Eye>{}) * camera_from_head * head_from_eye,
        {-0.8, 0.8, 0.8, -0.8},
        {side_px, side_px}};
  }
  return request;
}

/// The cost of packing and opening a plane of both eyes.
struct Travel {
  std::vector<double> kilobytes, datagrams;  ///< per eye
  double pack_ms = 0, open_ms = 0;           ///< both eyes

  void take(const PerEye<const PixelPlane*>& planes, PlaneKind kind, PlanePacker& packer) {
    for (const Side side : kSides) {
      const PixelPlane& plane = *planes[index_of(side)];
      std::vector<std::vector<std::byte>> messages;
      const Stopwatch packing;
      packer.start(FrameId{}, side, kind, plane);
      while (const auto slice = packer.next()) encode(ServerMessage(*slice), messages.emplace_back());
      pack_ms += ms_of(packing.elapsed());
      PixelPlane opened(plane.size, plane.word_bytes);
      ReceivedTiles known(TileGrid{plane.size}.count(), 0);
      const Stopwatch opening;
      for (const auto& message : messages)
        check(decode_plane_tiles(std::get<PlaneSlice>(*decode_server(message)), opened, known).has_value(),
              "our own slices open");
      open_ms += ms_of(opening.elapsed());
      check(opened == plane, "planes are unchanged");
      double bytes = 0;
      for (const auto& message : messages) bytes += static_cast<double>(message.size());
      kilobytes.push_back(bytes / 1e3);
      datagrams.push_back(static_cast<double>(messages.size()));
    }
  }
};

/// The lights that shine on each pixel if nothing is in between: N . L > 0 (gbuffer.frag defines the format
/// of normals).
std::vector<std::uint32_t> facing_of(const PixelPlane& normal, const PixelPlane& x, const PixelPlane& y,
                                     const PixelPlane& z, const PositionGrid& grid, const LightSet& lights) {
  std::vector<std::uint32_t> facing(normal.words.size());
  for (std::size_t i = 0; i < facing.size(); ++i) {
    if (x.words[i] == 0) continue;
    const auto half = [&](std::uint32_t shift) {
      return std::max(static_cast<std::int16_t>(normal.words[i] >> shift & 0xffff) / 32767.0, -1.0);
    };
    glm::dvec3 n(half(0), half(16), 0);
    n.z = 1 - std::abs(n.x) - std::abs(n.y);
    const double fold = std::max(-n.z, 0.0);
    n.x -= n.x < 0 ? -fold : fold, n.y -= n.y < 0 ? -fold : fold;
    const glm::dvec3 steps(x.words[i] - 1.0, y.words[i] - 1.0, z.words[i] - 1.0);
    const glm::dvec3 p = grid.low.v + steps * grid.step_m;
    for (std::size_t light = 0; light < std::min<std::size_t>(lights.lights.size(), 32); ++light) {
      const Light& of = lights.lights[light];
      const glm::dvec3 to_light = of.kind == LightKind::Directional ? -of.direction.v : of.position.v - p;
      if (of.on && glm::dot(n, to_light) > 0) facing[i] |= 1u << light;
    }
  }
  return facing;
}

struct BitsRow {
  std::uint32_t bits = 0;
  std::uint64_t facing = 0, wrong = 0, rays = 0;
  std::vector<double> kilobytes, quantise_ms, pack_ms, open_ms, trace_ms;
};

PerEye<const PixelPlane*> both(const PerEye<PixelPlane>& planes) {
  return {&planes[0], &planes[1]};
}

class Bench {
 public:
  Bench(const gpu::Device& device, const Scene& scene, const Options& options)
      : scene_(scene),
        options_(options),
        state_(state_at(scene, Time{})),
        renderer_(make_renderer(device, scene,
                                {{options.side_px, options.side_px}, {options.side_px, options.side_px}, 1})),
        tracer_(Tracer::create(scene).value()) {
    for (const std::uint32_t bits : {10u, 12u, 14u, 16u, 18u, 20u, 22u, 24u})
      rows_.emplace_back().bits = bits;
  }

  void look(double yaw_rad) {
    const FrameRequest request = request_of(scene_, yaw_rad, options_.side_px);
    const ShownFrame frame{.views = request.views, .state = state_, .masks = {}, .reprojection = {}};
    renderer_->draw(frame);
    draw_ms_.push_back(ms_of(renderer_->finish().total));
    const Stopwatch reading;
    renderer_->read_gbuffer(gbuffer_);
    read_ms_.push_back(ms_of(reading.elapsed()));
    for (std::size_t i = 0; i < kGBufferKinds.size(); ++i)
      travels_[i].take(both(planes_of(gbuffer_, kGBufferKinds[i])), kGBufferKinds[i], packer_);
    const Stopwatch receiving;
    renderer_->draw_received(gbuffer_, frame);
    renderer_->finish();
    received_ms_.push_back(ms_of(receiving.elapsed()));
    const PerEye<Image<float>> distance = renderer_->read_distance();
    const Stopwatch tracing;
    const TraceStats stats = tracer_.trace(request, truth_);
    trace_ms_.push_back(ms_of(tracing.elapsed()));
    rays_ += stats.shadow_rays;
    for (BitsRow& row : rows_) trace(request, distance, row);
  }

  void print() const {
    std::printf("%u x %u an eye, %u poses, %zu lights; medians\n", options_.side_px, options_.side_px,
                options_.poses, scene_.lights.size());
    const char* names[] = {"base colour", "normal", "depth"};
    for (std::size_t i = 0; i < travels_.size(); ++i)
      std::printf("%-12s %8.1f KB an eye %7.0f datagrams   pack both %6.2f ms   open both %6.2f ms\n",
                  names[i], median(travels_[i].kilobytes), median(travels_[i].datagrams),
                  travels_[i].pack_ms / options_.poses, travels_[i].open_ms / options_.poses);
    std::printf("draw both %.2f ms, read both %.2f ms, upload and shade both %.2f ms, trace both %.2f ms\n",
                median(draw_ms_), median(read_ms_), median(received_ms_), median(trace_ms_));
    std::printf(
        "bits  step mm  wrong %%  KB an eye  quantise ms  pack ms  open ms  trace ms  rays/ordinary\n");
    for (const BitsRow& row : rows_)
      std::printf(
          "%4u %8.4f %8.4f %10.1f %12.2f %8.2f %8.2f %9.2f %14.3f\n", row.bits, grid(row.bits).step_m * 1e3,
          100 * static_cast<double>(row.wrong) / static_cast<double>(std::max<std::uint64_t>(row.facing, 1)),
          median(row.kilobytes), median(row.quantise_ms), median(row.pack_ms), median(row.open_ms),
          median(row.trace_ms), static_cast<double>(row.rays) / static_cast<double>(rays_));
  }

 private:
  [[nodiscard]] PositionGrid grid(std::uint32_t bits) const {
    return grid_of({scene_.bounds.low}, {scene_.bounds.high}, bits);
  }

  void trace(const FrameRequest& request, const PerEye<Image<float>>& distance, BitsRow& row) {
    const Stopwatch quantising;
    for (std::size_t eye = 0; eye < kEyes; ++eye)
      positions_of(request.views[eye], distance[eye].pixels, grid(row.bits), positions_[eye]);
    row.quantise_ms.push_back(ms_of(quantising.elapsed()));
    Travel travel;
    for (std::size_t axis = 0; axis < 3; ++axis)
      travel.take({&positions_[0][axis], &positions_[1][axis]},
                  static_cast<PlaneKind>(static_cast<std::size_t>(PlaneKind::PositionX) + axis), packer_);
    double kilobytes = 0;
    for (const double plane : travel.kilobytes) kilobytes += plane / kEyes;
    row.kilobytes.push_back(kilobytes);
    row.pack_ms.push_back(travel.pack_ms), row.open_ms.push_back(travel.open_ms);
    const Stopwatch tracing;
    row.rays += tracer_.trace(request, positions_, grid(row.bits), frame_).shadow_rays;
    row.trace_ms.push_back(ms_of(tracing.elapsed()));
    for (std::size_t eye = 0; eye < kEyes; ++eye) {
      const auto& [x, y, z] = positions_[eye];
      const auto facing = facing_of(gbuffer_.normal[eye], x, y, z, grid(row.bits), state_.light_set);
      for (std::uint32_t i = 0; i < facing.size(); ++i) {
        const std::uint32_t column = i % options_.side_px, line = i / options_.side_px;
        const std::uint32_t differs =
            frame_.masks[eye].word(column, line) ^ truth_.masks[eye].word(column, line);
        row.facing += static_cast<std::uint64_t>(std::popcount(facing[i]));
        row.wrong += static_cast<std::uint64_t>(std::popcount(facing[i] & differs));
      }
    }
  }

  const Scene& scene_;
  Options options_;
  SceneState state_;
  std::unique_ptr<Renderer> renderer_;
  Tracer tracer_;
  PlanePacker packer_;
  GBufferPlanes gbuffer_;
  PerEye<PositionPlanes> positions_;
  ShadowFrame frame_, truth_;
  std::array<Travel, kGBufferKinds.size()> travels_;
  std::vector<double> draw_ms_, read_ms_, received_ms_, trace_ms_;
  std::uint64_t rays_ = 0;
  std::vector<BitsRow> rows_;
};

Expected<void> run(const Options& options) {
  const Expected<Scene> scene = load_scene(options.scene);
  if (!scene) return tl::unexpected(scene.error());
  const auto device = gpu::open_device({"", gpu::Validation::Off});
  if (!device) return tl::unexpected(device.error());
  Bench bench(*device, *scene, options);
  for (std::uint32_t pose = 0; pose < options.poses; ++pose) bench.look(6.2831853 * pose / options.poses);
  bench.print();
  return {};
}

}  // namespace
}  // namespace farshade

int main(int argc, char** argv) {
  farshade::Options options;
  CLI::App app{"Measures bytes and times of planes of pixels, and the precision that positions need."};
  app.add_option("--scene", options.scene, "glTF file")->required();
  app.add_option("--size", options.side_px, "pixels a side of each eye")->check(CLI::Range(16, 8192));
  app.add_option("--poses", options.poses, "number of directions, evenly around the camera")
      ->check(CLI::Range(1, 1000));
  CLI11_PARSE(app, argc, argv);
  const farshade::Expected<void> done = farshade::run(options);
  if (!done) std::fprintf(stderr, "plane_bench: %s\n", done.error().what.c_str());
  return done ? 0 : 1;
}
