#include "vr_client/placed_head.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <functional>
#include <glm/geometric.hpp>

#include "stereo/exposure/chosen_exposure.h"
#include "stereo/exposure/picture_check.h"
#include "stereo/head/reader.h"
#include "stereo/placement/fit.h"
#include "stereo/placement/surroundings.h"

namespace farshade {
namespace {

/// Smaller things are smaller than half a degree where both eyes can look at them.
constexpr double kSmallest_m = 0.0014;

std::string where_words(const Options& options) {
  if (options.place == Place::Recorded) return "where it was recorded";
  return options.start_pose ? "where --stand says" : "at the scene's viewpoint";
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

/// At the viewpoint, or as recorded.
PlacedHead plainly_placed(const Options& options, const Scene& scene, const HeadRecording& recording) {
  if (options.place == Place::Recorded) return {recording, {}};
  return {recording, place(recording, viewpoint_of(scene, options.start_pose))};
}

/// A way to place the head.
struct Trial {
  PlacedHead placed;
  std::string where;
};

class Placing {
 public:
  Placing(const Options& options, const Scene& scene, const Surroundings& surroundings,
          const HeadRecording& recording)
      : options_(options), scene_(scene), surroundings_(surroundings), recording_(recording) {}

  [[nodiscard]] Trial plain() const {
    Trial trial{plainly_placed(options_, scene_, recording_), where_words(options_)};
    test(trial);
    return trial;
  }

  /// A camera of the file may be inside geometry, or see nothing. Then the head stands where it would without
  /// that camera.
  [[nodiscard]] Expected<Trial> fitting() const {
    if (options_.start_pose) return fitting_at(viewpoint_of(scene_, options_.start_pose), Anchors::Reference);
    Expected<Trial> fit = fitting_at(viewpoint_of(scene_), Anchors::Around);
    if (fit && !fit->placed.test.is_bad()) return fit;
    Expected<Trial> elsewhere = fitting_at(chosen_viewpoint(scene_), Anchors::Around);
    return elsewhere && (!fit || bad_poses(*elsewhere) < bad_poses(*fit)) ? elsewhere : fit;
  }

  static std::size_t bad_poses(const Trial& trial) {
    return trial.placed.test.inside + trial.placed.test.see_nothing;
  }

 private:
  static constexpr double kLeastWalk = 1e-4;

  /// Of a head that sees nothing, the walk is scaled down further, as long as that helps.
  [[nodiscard]] Expected<Trial> fitting_at(const Rigid<Stage, Eye>& reference, Anchors anchors) const {
    const Expected<Fit> fit = fit_head(surroundings_, recording_, reference, anchors);
    if (!fit) return tl::unexpected(fit.error());
    const double moved_m =
        glm::length(start_of(*fit, fit->scale).v - viewpoint_of(scene_, options_.start_pose).translation);
    Trial best = fit_trial(*fit, 1, moved_m);
    for (double less = 0.5; best.placed.test.is_bad() && less > kLeastWalk; less *= 0.5) {
      Trial smaller = fit_trial(*fit, less, moved_m);
      if (bad_poses(smaller) < bad_poses(best)) best = std::move(smaller);
    }
    return best;
  }

  /// Where the recording, scaled by `scale`, begins.
  [[nodiscard]] Point<Stage> start_of(const Fit& fit, double scale) const {
    return fit.stage_from_recorded(
        Point<Recorded>{recording_.samples.front().recorded_from_head.translation * scale});
  }

  void test(Trial& trial) const {
    trial.placed.test = test_head(surroundings_, trial.placed.recording, trial.placed.stage_from_recorded,
                                  shown_part(options_, trial.placed.recording));
  }

  /// The fitted walk, scaled by `less` about its start.
  [[nodiscard]] Trial fit_trial(const Fit& fit, double less, double moved_m) const {
    const double scale = fit.scale * less;
    PlacedHead placed{scaled(recording_, scale), fit.stage_from_recorded};
    placed.stage_from_recorded.translation += (start_of(fit, fit.scale) - start_of(fit, scale)).v;
    Trial trial{std::move(placed), fmt::format("{}, moved by {:.2f} m, its walk scaled to {:.4g} %",
                                               where_words(options_), moved_m, scale * 100)};
    test(trial);
    return trial;
  }

  const Options& options_;
  const Scene& scene_;
  const Surroundings& surroundings_;
  const HeadRecording& recording_;
};

/// What helps where the head is in a bad place: it was tried.
std::string cure_for(const Options& options, const Scene& scene, const Surroundings& surroundings,
                     const HeadRecording& recording) {
  Options tried = options;
  const auto fits = [&] {
    const Expected<Trial> fit = Placing(tried, scene, surroundings, recording).fitting();
    return fit && !fit->placed.test.is_bad();
  };
  if (fits()) return "the cure is --place fit";
  tried.start_pose.reset();
  if (options.start_pose && fits()) return "the cure is --place fit without --stand";
  const double size_m = glm::length(surroundings.bounds().high - surroundings.bounds().low);
  if (size_m < kSmallest_m)
    return fmt::format("the scene measures {:.2g} m, too little to look at: make it larger", size_m);
  return fmt::format("--stand {} may help", options.start_pose ? "with another place" : "X,Y,Z");
}

/// `why` says why the head does not stand elsewhere, `cure` what helps in a bad place.
void tell(const Trial& trial, const Scene& scene, const std::string& why,
          const std::function<std::string()>& cure) {
  const std::string still =
      scene.animation_length_s > 0 ? ", with animated things where they are at 0 s" : "";
  const std::string said =
      fmt::format("the head starts {}: {}{}{}", trial.where, in_words(trial.placed.test), still, why);
  if (trial.placed.test.is_bad())
    spdlog::warn("{}; {}", said, cure());
  else
    spdlog::info(said);
}

/// Chooses the exposure and tells what is wrong with the light of some shown pictures.
void judge_light(const Options& options, const Scene& scene, const Surroundings& surroundings,
                 PlacedHead& placed) {
  constexpr int kPoses = 4, kAcross = 16;
  const HeadRecording& recording = placed.recording;
  placed.exposure = options.lighting.exposure ? Exposure{} : chosen_exposure(surroundings, scene);
  if (const std::string words = in_words(*placed.exposure, scene.name); !words.empty()) spdlog::info(words);
  const Shown shown = shown_part(options, recording);
  std::vector<Ray> rays;
  for (int i = 0; i < kPoses; ++i) {
    const Time time = recording.start() + shown.from + (shown.until - shown.from) * i / (kPoses - 1);
    for (const Ray& ray :
         picture_rays(recording, placed.stage_from_recorded * head_at(recording, time), kAcross))
      rays.push_back(ray);
  }
  for (const PictureFinding& finding :
       check_picture(surroundings, scene, options.lighting, *placed.exposure, rays))
    spdlog::log(finding.is_bad ? spdlog::level::warn : spdlog::level::info, finding.sentence);
}

Expected<PlacedHead> placed_in(const Surroundings& surroundings, const Options& options, const Scene& scene,
                               const HeadRecording& recording) {
  const Placing placing(options, scene, surroundings, recording);
  const auto cure = [&] { return cure_for(options, scene, surroundings, recording); };
  if (options.place == Place::Fit)
    return placing.fitting().map([&](Trial&& trial) {
      tell(trial, scene, "", cure);
      return std::move(trial.placed);
    });
  Trial plain = placing.plain();
  std::string why;
  if (options.place == Place::Auto && !options.start_pose && plain.placed.test.is_bad()) {
    Expected<Trial> fit = placing.fitting();
    if (fit && Placing::bad_poses(*fit) < Placing::bad_poses(plain)) {
      why = fmt::format("; not moved, {}", in_words(plain.placed.test));
      plain = std::move(*fit);
    }
  }
  tell(plain, scene, why, cure);
  return std::move(plain.placed);
}

}  // namespace

void tell_how_read(const HeadRecording& recording) {
  if (!recording.read_as.empty()) spdlog::info(recording.read_as);
  if (!recording.doubt.empty()) spdlog::warn("head recording: {}", recording.doubt);
}

Expected<PlacedHead> place_head(const Options& options, const Scene& scene, const HeadRecording& recording) {
  tell_how_read(recording);
  const Expected<Surroundings> surroundings = Surroundings::create(scene);
  if (!surroundings && options.place == Place::Fit)
    return fail(surroundings.error().fault,
                surroundings.error().what + "; --place fit needs it: use --stand X,Y,Z instead");
  if (!surroundings) {
    spdlog::info("the head starts {}; {}", where_words(options), surroundings.error().what);
    return plainly_placed(options, scene, recording);
  }
  return placed_in(*surroundings, options, scene, recording).map([&](PlacedHead&& placed) {
    judge_light(options, scene, *surroundings, placed);
    return std::move(placed);
  });
}

std::future<Expected<PlacedHead>> place_meanwhile(const Options& options, const Scene& scene,
                                                  HeadRecording recording) {
  return std::async(std::launch::async, [&options, &scene, recording = std::move(recording)] {
    return place_head(options, scene, recording);
  });
}

std::future<void> judge_start_meanwhile(const Options& options, const Scene& scene) {
  return std::async(std::launch::async, [&options, &scene] {
    const Expected<Surroundings> surroundings = Surroundings::create(scene);
    if (!surroundings) return;
    HeadRecording still;
    still.samples = {{}, {.time = Time(std::chrono::seconds(1)), .recorded_from_head = {}}};
    still.fov = kDefaultFov;
    PlacedHead start{still, place(still, viewpoint_of(scene, options.start_pose))};
    judge_light(options, scene, *surroundings, start);
  });
}

}  // namespace farshade
