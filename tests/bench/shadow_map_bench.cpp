// Compares shadow maps with the full trace along a recorded head: their error, and the time on the device to
// read them and to draw them: all of them, and only what changes while the scene's animation runs.
#include <CLI/CLI.hpp>
#include <cstdio>

#include "stereo/base/heap.h"
#include "stereo/base/quantile.h"
#include "stereo/frame/edge_sharpness.h"
#include "stereo/frame/tiles.h"
#include "stereo/gltf/gltf.h"
#include "stereo/gpu/device.h"
#include "stereo/head/reader.h"
#include "stereo/image/codec.h"
#include "stereo/image/difference.h"
#include "stereo/metrics/flip.h"
#include "stereo/metrics/pixels_per_degree.h"
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
  std::vector<float> sharpness{kEdgeSharpness};
};

struct Figures {
  std::vector<double> mask_error, psnr_db, flip, maps_ms, moved_ms, shade_ms, masks_ms, gbuffer_ms;
};

double ms(Duration duration) {
  return std::chrono::duration<double, std::milli>(duration).count();
}

/// One frame with masks of the full trace, and with maps.
class Comparison {
 public:
  Comparison(const gpu::Device& device, const Scene& scene, Tracer& tracer, const Options& options,
             const ShadowMapSettings& settings)
      : scene_(scene),
        tracer_(tracer),
        options_(options),
        settings_(settings),
        always_settings_(settings),
        renderer_(make_renderer(device, scene, plan(), {size(), size(), 1})),
        always_(make_renderer(device, scene, plan(), {size(), size(), 1})) {
    always_settings_.redraw = Redraw::Always;
  }

  void compare(const FrameMoment& request, Figures& figures) {
    tracer_.trace({request}, truth_);
    const PerEye<Image<Rgb8>> reference = draw_masks(request, figures);
    always_->draw(with_maps(request, start_, always_settings_));
    figures.maps_ms.push_back(ms(always_->finish().maps));
    renderer_->draw(with_maps(request, state_at(scene_, animated_), settings_));
    renderer_->finish();
    animated_ = animated_ + kPeriod;
    renderer_->draw(with_maps(request, state_at(scene_, animated_), settings_));
    const DrawTimes moved = renderer_->finish();
    figures.moved_ms.push_back(ms(moved.maps));
    figures.shade_ms.push_back(ms(moved.shade));
    figures.gbuffer_ms.push_back(ms(moved.gbuffer));
    ShownFrame reported = with_maps(request, start_, settings_);
    reported.report = PixelReport::On;
    renderer_->draw(reported);
    const PerEye<Image<Rgb8>> pictures = renderer_->read_shown();
    for (const Side side : kSides) {
      const std::size_t eye = index_of(side);
      figures.mask_error.push_back(compare_masks(renderer_->report(side), truth_.masks[eye]).mask_error);
      figures.psnr_db.push_back(psnr_db(pictures[eye], reference[eye]));
      const double per_degree = pixels_per_degree(request.views[eye]);
      figures.flip.push_back(mean(flip(reference[eye], pictures[eye], per_degree)));
    }
    if (!options_.out.empty()) write(request.frame, pictures[0], reference[0]);
  }

 private:
  [[nodiscard]] Extent size() const { return {options_.side_px, options_.side_px}; }
  [[nodiscard]] DrawPlan plan() const {
    return plan_for(scene_, {.reprojects = false, .all_lights = true}).draw;
  }

  void write(FrameId frame, const Image<Rgb8>& picture, const Image<Rgb8>& reference) const {
    const std::string name =
        options_.out + "/" + std::to_string(frame.value) + "_" + std::to_string(settings_.side_px);
    (void)write_png(name + "_maps.png", picture);
    (void)write_png(name + "_truth.png", reference);
    (void)write_png(name + "_difference.png", difference_x8(picture, reference));
  }

  PerEye<Image<Rgb8>> draw_masks(const FrameMoment& request, Figures& figures) {
    const ReceivedTiles all(TileGrid{size()}.count(), all_planes_received(truth_.masks[0].layout()));
    const PerEye<ReceivedTiles> known{all, all};
    const std::vector<TracedMask> masks{{.frame = request.frame,
                                         .display_time = request.display_time,
                                         .scene_time = request.scene_time,
                                         .views = request.views,
                                         .masks = truth_.masks,
                                         .received_tiles = known,
                                         .content = request.frame.value}};
    renderer_->draw({.views = request.views, .state = start_, .masks = masks, .reprojection = {}});
    figures.masks_ms.push_back(ms(renderer_->finish().shade));
    return renderer_->read_shown();
  }

  [[nodiscard]] static ShownFrame with_maps(const FrameMoment& request, const SceneState& state,
                                            const ShadowMapSettings& settings) {
    return {
        .views = request.views, .state = state, .masks = {}, .reprojection = {}, .shadow_maps = &settings};
  }

  const Scene& scene_;
  Tracer& tracer_;
  const Options& options_;
  ShadowMapSettings settings_, always_settings_;
  std::unique_ptr<Renderer> renderer_, always_;
  SceneState start_ = state_at(scene_, Time{});
  Time animated_{};
  ShadowFrame truth_;
};

void print(const ShadowMapSettings& settings, std::uint64_t bytes, const Figures& figures) {
  const auto median = [](const std::vector<double>& values) { return quantile(values, 0.5); };
  std::printf("  %5u %5.1f %8.1f %10.5f %10.5f %8.2f %8.4f %9.2f %9.2f %9.2f %9.2f %9.2f\n", settings.side_px,
              static_cast<double>(settings.sharpness), static_cast<double>(bytes) / (1 << 20),
              median(figures.mask_error), quantile(figures.mask_error, 0.95), median(figures.psnr_db),
              median(figures.flip), median(figures.maps_ms), median(figures.moved_ms),
              median(figures.shade_ms), median(figures.masks_ms), median(figures.gbuffer_ms));
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
  std::printf("%s on %s, %u x %u an eye, %zu lights, pcf radius %u, %u frames of %s\n", scene->name.c_str(),
              device->name.c_str(), options.side_px, options.side_px, scene->lights.size(),
              options.pcf_radius, options.frames, options.trace.c_str());
  std::printf("  %5s %5s %8s %10s %10s %8s %8s %9s %9s %9s %9s %9s\n", "side", "sharp", "MiB", "mask error",
              "p95", "PSNR dB", "FLIP", "draw ms", "moved ms", "shade ms", "by masks", "G-buffer");
  for (const std::uint32_t side_px : options.map_sides_px)
    for (const float sharpness : options.sharpness) {
      const ShadowMapSettings settings{side_px, options.pcf_radius, Redraw::WhenMoved, sharpness};
      const Expected<std::uint64_t> bytes = shadow_map_bytes(*scene, settings);
      if (!bytes) return tl::unexpected(bytes.error());
      Comparison comparison(*device, *scene, *tracer, options, settings);
      Figures figures;
      for (std::uint32_t frame = 1; frame <= options.frames; ++frame)
        comparison.compare(shown_at(*recording, placed, frame * options.every, options.side_px), figures);
      print(settings, *bytes, figures);
    }
  return {};
}

}  // namespace

int main(int argc, char** argv) try {
  keep_freed_memory();
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
  app.add_option("--sharpness", options.sharpness, "contrast of filtered shadow edges")
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
