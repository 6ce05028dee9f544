// What an answer takes, by kind: its time, the longest stage in it that nothing interrupts, and the memory of
// the renderer that is kept for it beyond its pixels, and of the encoder. docs/link.md, answer_renderer.h and
// video.h state these figures.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include <unistd.h>

#include "rt_server/answers/answers.h"
#include "stereo/base/check.h"
#include "stereo/base/heap.h"
#include "stereo/base/quantile.h"
#include "stereo/frame/tiles.h"
#include "stereo/gltf/gltf.h"

namespace {

using namespace farshade;

constexpr double kMiB = 1 << 20;
/// So that nothing is evicted while its memory is measured.
constexpr std::size_t kAmple_bytes = std::size_t{16} << 30;

struct Options {
  std::string scene;
  std::uint32_t side_px = 512;
  std::uint32_t frames = 15;
};

/// The longest time between two calls of is_given_up. Any thread of an answer calls it.
class LongestStage {
 public:
  void begin() { last_ = clock_.now(), longest_ = {}; }
  bool ask() {
    const std::lock_guard lock(mutex_);
    const Time now = clock_.now();
    longest_ = std::max(longest_, now - std::exchange(last_, now));
    return false;
  }
  [[nodiscard]] Duration end() {
    ask();
    return longest_;
  }

 private:
  SteadyClock clock_;
  std::mutex mutex_;
  Time last_{};
  Duration longest_{};
};

class Bench {
 public:
  explicit Bench(const Scene& scene)
      : scene_(scene),
        plan_(plan_for(scene, {.all_lights = true})),
        tracer_(Tracer::create(scene, plan_.trace).value()),
        answers_(
            make_answers({.scene = scene_, .plan = plan_, .tracer = tracer_, .memory = {kAmple_bytes}})) {
    const Rigid<Stage, Eye> camera = scene.camera.value_or(Rigid<Stage, Eye>{});
    for (const Side side : kSides) {
      View& view = job_.request.views[index_of(side)];
      const Rigid<Eye, Eye> beside{{1, 0, 0, 0}, {side == Side::Left ? -0.032 : 0.032, 0, 0}};
      view = {.stage_from_eye = camera * beside, .fov = {-0.8, 0.8, 0.8, -0.8}, .size = {}};
    }
    job_.is_given_up = [this] { return stage_.ask(); };
  }

  [[nodiscard]] AnswerSet offered() const { return answers_.offered(); }

  struct Took {
    double answer_ms, longest_stage_ms;
  };
  /// Makes an answer of this kind for views of `size`, of a session of its own.
  Took answer(Answer kind, Extent size, std::uint64_t session) {
    for (View& view : job_.request.views) view.size = size;
    job_.session = {session};
    job_.request.frame = {++frame_};
    job_.request.answer = {
        .kind = kind, .bits_per_second = 30'000'000, .interval = std::chrono::milliseconds(33)};
    job_.arrived += std::chrono::seconds(1);  // so that it may rebuild
    packer_.begin();
    stage_.begin();
    const Stopwatch answering;
    answers_.answer(job_, packer_, job_.arrived);
    const Took took{ms_of(answering.elapsed()), ms_of(stage_.end())};
    check(packer_.finish({.frame = job_.request.frame}).size() > 1,
          "an answer has content beside its report");
    return took;
  }

 private:
  const Scene& scene_;
  ScenePlan plan_;
  Tracer tracer_;
  RequestHandlers answers_;
  LongestStage stage_;
  Job job_{};
  FramePacker packer_;
  std::uint32_t frame_ = 0;
};

double resident_bytes() {
  double all = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> all >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE));
}

/// Mean growth of the resident size with each of `count` calls of `make(number)`, which returns the bytes
/// that are known.
template <class Make>
double growth_MiB(int count, const Make& make) {
  const double before = resident_bytes();
  double known = 0;
  for (int i = 0; i < count; ++i) known += static_cast<double>(make(i));
  return (resident_bytes() - before - known) / count / kMiB;
}

void print_memory(Bench& bench) {
  constexpr int kSizes = 12;
  constexpr std::uint32_t kSide_px = 128;
  const auto draw = [&](int number) {
    const Extent size{kSide_px + 16 * static_cast<std::uint32_t>(number), kSide_px};
    bench.answer(Answer::GBuffer, size, 1);
    return kEyes * size.pixels() * kDrawnPixel_bytes;
  };
  draw(kSizes);  // what all share
  std::printf("a renderer beyond its pixels: %.1f MiB resident\n", growth_MiB(kSizes, draw));
  if ((bench.offered() & set_of(Answer::Video)) == 0) return;
  const auto code = [&](int number) {
    bench.answer(Answer::Video, {kSide_px, kSide_px}, 2 + static_cast<std::uint64_t>(number));
    return 0;
  };
  code(kSizes);
  std::printf("an encoder of 2 x %ux%u: %.1f MiB resident\n", kSide_px, kSide_px, growth_MiB(kSizes, code));
}

Expected<void> run(const Options& options) {
  const Expected<Scene> scene = load_scene(options.scene);
  if (!scene) return tl::unexpected(scene.error());
  Bench bench(*scene);
  std::printf("%s, %ux%u an eye\n%-12s %10s %10s %16s\n", scene->name.c_str(), options.side_px,
              options.side_px, "[ms]", "median", "p95", "longest stage");
  const Extent size{options.side_px, options.side_px};
  for (const auto& [kind, name] : {std::pair(Answer::Masks, "masks"),
                                   {Answer::GBuffer, "G-buffer"},
                                   {Answer::Video, "video"},
                                   {Answer::Difference, "difference"}}) {
    if ((bench.offered() & set_of(kind)) == 0) {
      std::printf("%-12s not offered here\n", name);
      continue;
    }
    std::vector<double> answer_ms;
    double longest_ms = 0;
    bench.answer(kind, size, 1);  // builds what is kept
    for (std::uint32_t i = 0; i < options.frames; ++i) {
      const Bench::Took took = bench.answer(kind, size, 1);
      answer_ms.push_back(took.answer_ms);
      longest_ms = std::max(longest_ms, took.longest_stage_ms);
    }
    const Spread spread = spread_of(answer_ms);
    std::printf("%-12s %10.1f %10.1f %16.1f\n", name, spread.median, spread.p95, longest_ms);
  }
  if ((bench.offered() & set_of(Answer::GBuffer)) != 0) print_memory(bench);
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  keep_freed_memory();
  CLI::App app("Prints what answers of a server take, by kind.");
  Options options;
  app.add_option("--scene", options.scene, "glTF 2.0 file")->required();
  app.add_option("--size", options.side_px, "width and height of an eye in pixels")->capture_default_str();
  app.add_option("--frames", options.frames, "answers of each kind to measure")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  const Expected<void> done = run(options);
  if (!done) std::fprintf(stderr, "answers_bench: %s\n", done.error().what.c_str());
  return done ? EXIT_SUCCESS : EXIT_FAILURE;
}
