// Compares shadow maps with the full trace along a recorded head: their error, and the time on the device to
// draw and read them, if they are drawn in every frame and if they are kept while nothing moves.
#include <CLI/CLI.hpp>
#include <cstdio>

#include "stereo/base/quantile.h"
#include "stereo/frame/tiles.h"
#include "stereo/gpu/device.h"
#include "stereo/head/reader.h"
#include "stereo/image/codec.h"
#include "stereo/image/difference.h"
#include "stereo/scene/gltf.h"
#include "stereo/tracer/tracer.h"
#include "tests/bench/late_masks.h"
#include "vr_client/report/measure.h"

namespace {

using namespace farshade;
using namespace farshade::bench;

struct Options {
  std::string scene, trace = FARSHADE_ASSETS "/walk.csv", gpu, out;
  std::uint32_t side_px = 512, frames = 8, every = 24, pcf_radius = 1;
  std::vector<std::uint32_t> map_sides_px{512, 1024, 2048};
};

struct Figures {
  std::vector<double> mask_error, psnr_db, maps_ms, shade_ms, kept_ms, masks_ms, gbuffer_ms;
};

double ms(Duration duration) {
  return std::chrono::duration<double, std::milli>(duration).count();
}

/// One frame with masks of the full trace, and with maps.
class Comparison {
 public:
  Comparison(const gpu::Device& device, const Scene& scene, Tracer& tracer, const Options& options)
      : scene_(scene),
        tracer_(tracer),
        options_(options),
        renderer_(device, scene, plan_for(scene, {.carries_over = false, .all_lights = true}).draw,
                  {size(), size(), 1}) {}

  void compare(const FrameRequest& request, std::uint32_t map_side_px, Figures& figures) {
    tracer_.trace(request, truth_);
    const PerEye<Image<Rgb8>> reference = draw_masks(request, figures);
    ShadowMapSettings settings{map_side_px, options_.pcf_radius, Redraw::Always};
    figures.maps_ms.push_back(ms(draw_maps(request, settings).maps));
    settings.redraw = Redraw::WhenMoved;
    draw_maps(request, settings);
    const DrawTimes kept = draw_maps(request, settings);
    figures.kept_ms.push_back(ms(kept.maps));
    figures.shade_ms.push_back(ms(kept.shade));
    figures.gbuffer_ms.push_back(ms(kept.gbuffer));
    draw_maps(request, settings, PixelReport::On);
    const PerEye<Image<Rgb8>> pictures = renderer_.read_shown();
    for (const Side side : kSides) {
      const std::size_t eye = index_of(side);
      figures.mask_error.push_back(compare_masks(renderer_.report(side), truth_.masks[eye]).mask_error);
      figures.psnr_db.push_back(psnr_db(pictures[eye], reference[eye]));
    }
    if (!options_.out.empty()) {
      const std::string name =
          options_.out + "/" + std::to_string(request.frame.value) + "_" + std::to_string(map_side_px);
      (void)write_png(name + "_maps.png", pictures[0]);
      (void)write_png(name + "_truth.png", reference[0]);
      (void)write_png(name + "_difference.png", difference_x8(pictures[0], reference[0]));
    }
  }

 private:
  [[nodiscard]] Extent size() const { return {options_.side_px, options_.side_px}; }

  PerEye<Image<Rgb8>> draw_masks(const FrameRequest& request, Figures& figures) {
    const KnownTiles all(TileGrid{size()}.count(), all_planes_known(truth_.masks[0].layout()));
    const PerEye<KnownTiles> known{all, all};
    const std::vector<TracedMask> masks{{.frame = request.frame,
                                         .display_time = request.display_time,
                                         .scene_time = request.scene_time,
                                         .views = request.views,
                                         .masks = truth_.masks,
                                         .known_tiles = known,
                                         .content = request.frame.value}};
    const DrawTimes times =
        renderer_.draw({.views = request.views, .state = state_, .masks = masks, .carry_over = {}});
    figures.masks_ms.push_back(ms(times.shade));
    return renderer_.read_shown();
  }

  DrawTimes draw_maps(const FrameRequest& request, const ShadowMapSettings& settings,
                      PixelReport report = PixelReport::Off) {
    return renderer_.draw({.views = request.views,
                           .state = state_,
                           .masks = {},
                           .carry_over = {},
                           .report = report,
                           .shadow_maps = &settings});
  }

  const Scene& scene_;
  Tracer& tracer_;
  const Options& options_;
  Renderer renderer_;
  SceneState state_ = state_at(scene_, Time{});
  ShadowFrame truth_;
};

void print(std::uint32_t map_side_px, std::uint64_t bytes, const Figures& figures) {
  const auto median = [](const std::vector<double>& values) { return quantile(values, 0.5); };
  std::printf("  %5u %8.1f %10.5f %10.5f %8.2f %9.2f %9.2f %9.2f %9.2f %9.2f\n", map_side_px,
              static_cast<double>(bytes) / (1 << 20), median(figures.mask_error),
              quantile(figures.mask_error, 0.95), median(figures.psnr_db), median(figures.maps_ms),
              median(figures.kept_ms), median(figures.shade_ms), median(figures.masks_ms),
              median(figures.gbuffer_ms));
}

Expected<void> run(const Options& options) {
  const Expected<Scene> scene = load_scene(options.scene);
  if (!scene) return tl::unexpected(scene.error());
  const Expected<HeadRecording> recording = load_head_recording(options.trace);
  if (!recording) return tl::unexpected(recording.error());
  const Expected<gpu::Device> device = gpu::open_device({options.gpu, gpu::Validation::Off});
  if (!device) return tl::unexpected(device.error());
  Expected<Tracer> tracer = Tracer::create_reference(*scene);
  if (!tracer) return tl::unexpected(tracer.error());
  const Rigid<Stage, Recorded> placed =
      scene->camera ? place(*recording, *scene->camera) : Rigid<Stage, Recorded>{};
  Comparison comparison(*device, *scene, *tracer, options);
  std::printf("%s on %s, %u x %u an eye, %zu lights, pcf radius %u, %u frames of %s\n", scene->name.c_str(),
              device->name.c_str(), options.side_px, options.side_px, scene->lights.size(),
              options.pcf_radius, options.frames, options.trace.c_str());
  std::printf("  %5s %8s %10s %10s %8s %9s %9s %9s %9s %9s\n", "side", "MiB", "mask error", "p95", "PSNR dB",
              "draw ms", "kept ms", "shade ms", "by masks", "G-buffer");
  for (const std::uint32_t map_side_px : options.map_sides_px) {
    const Expected<std::uint64_t> bytes = shadow_map_bytes(*scene, {map_side_px, options.pcf_radius});
    if (!bytes) return tl::unexpected(bytes.error());
    Figures figures;
    for (std::uint32_t frame = 1; frame <= options.frames; ++frame)
      comparison.compare(shown_at(*recording, placed, frame * options.every, options.side_px), map_side_px,
                         figures);
    print(map_side_px, *bytes, figures);
  }
  return {};
}

}  // namespace

int main(int argc, char** argv) try {
  CLI::App app("Compares shadow maps with the full trace.");
  Options options;
  app.add_option("--scene", options.scene, "glTF 2.0 file")->required();
  app.add_option("--trace", options.trace, "recorded head")->capture_default_str();
  app.add_option("--size", options.side_px, "pixels of each side of an eye")->capture_default_str();
  app.add_option("--frames", options.frames, "frames compared")->capture_default_str();
  app.add_option("--every", options.every, "frames of the recording per compared frame")
      ->capture_default_str();
  app.add_option("--side", options.map_sides_px, "texels of each side of a map")->capture_default_str();
  app.add_option("--radius", options.pcf_radius, "radius of the shadow filter, texels")
      ->capture_default_str();
  app.add_option("--out", options.out, "folder for the left eye's pictures");
  app.add_option("--gpu", options.gpu, "use only a device whose name contains this");
  CLI11_PARSE(app, argc, argv);
  if (const Expected<void> done = run(options); !done) {
    std::fprintf(stderr, "shadow_map_bench: %s\n", done.error().what.c_str());
    return 1;
  }
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "shadow_map_bench: %s\n", error.what());
  return 1;
}
