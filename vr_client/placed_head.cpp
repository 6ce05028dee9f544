#include "vr_client/placed_head.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>

#include "stereo/placement/fit.h"
#include "stereo/placement/head_test.h"
#include "stereo/placement/surroundings.h"

namespace farshade {
namespace {

std::string where_words(const Options& options) {
  if (options.place == Place::Recorded) return "where it was recorded";
  return options.stand ? "where --stand says" : "at the scene's viewpoint";
}

/// The poses that the run shows. A preview plays the whole recording.
Shown shown_part(const Options& options, const HeadRecording& recording) {
  const Duration length = recording.end() - recording.start();
  if (options.preview) return {.from = {}, .until = length};
  const Duration from = duration_from_ms(options.skip_s * 1e3);
  if (!options.frames) return {.from = from, .until = length};
  return {
      .from = from,
      .until = std::min(length, from + duration_from_ms((*options.frames - 1) * 1e3 / options.refresh_hz))};
}

/// A camera of the file may be inside geometry. Then the head stands where it would without that camera.
Expected<Fit> fitted(const Options& options, const Scene& scene, const Surroundings& surroundings,
                     const HeadRecording& recording) {
  if (options.stand)
    return fit_head(surroundings, recording, viewpoint_of(scene, options.stand), Anchors::Reference);
  Expected<Fit> fit = fit_head(surroundings, recording, viewpoint_of(scene));
  return fit ? fit : fit_head(surroundings, recording, chosen_viewpoint(scene));
}

std::string cure_for(const Options& options) {
  const char* const stand = options.stand ? "--stand with another place" : "--stand X,Y,Z";
  return options.place == Place::Fit ? std::string(stand) : fmt::format("--place fit or {}", stand);
}

void tell(const Options& options, const std::string& where, const HeadTest& test, const Scene& scene) {
  const std::string still =
      scene.animation_length_s > 0 ? ", with animated things where they are at 0 s" : "";
  if (test.is_bad())
    spdlog::warn("the head starts {}: {}{}; the cure is {}", where, in_words(test), still, cure_for(options));
  else
    spdlog::info("the head starts {}: {}{}", where, in_words(test), still);
}

}  // namespace

Expected<PlacedHead> place_head(const Options& options, const Scene& scene, HeadRecording recording) {
  const Expected<Surroundings> surroundings = Surroundings::create(scene);
  if (!surroundings && options.place == Place::Fit)
    return fail(surroundings.error().fault,
                surroundings.error().what + "; --place fit needs it: use --stand X,Y,Z instead");
  PlacedHead placed{std::move(recording), {}};
  std::string where = where_words(options);
  if (options.place == Place::Camera)
    placed.stage_from_recorded = place(placed.recording, viewpoint_of(scene, options.stand));
  if (options.place == Place::Fit) {
    const Expected<Fit> fit = fitted(options, scene, *surroundings, placed.recording);
    if (!fit) return tl::unexpected(fit.error());
    placed.recording = scaled(std::move(placed.recording), fit->scale);
    placed.stage_from_recorded = fit->stage_from_recorded;
    where += fmt::format(", moved by {:.2f} m, its walk scaled to {:.0f} %", fit->moved_m, fit->scale * 100);
  }
  if (!surroundings)
    spdlog::info("the head starts {}; {}", where, surroundings.error().what);
  else
    tell(options, where,
         test_head(*surroundings, placed.recording, placed.stage_from_recorded,
                   shown_part(options, placed.recording)),
         scene);
  return placed;
}

std::future<Expected<PlacedHead>> place_meanwhile(const Options& options, const Scene& scene,
                                                  HeadRecording recording) {
  return std::async(std::launch::async, [&options, &scene, recording = std::move(recording)]() mutable {
    return place_head(options, scene, std::move(recording));
  });
}

}  // namespace farshade
