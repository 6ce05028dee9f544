// Prints how wrong each predictor is on recorded heads.
//
//   prediction_table [--csv FILE] TRACE...
//   prediction_table --stiff
//
// The head is shown at 72 Hz as vr_client plays a recording. Each frame passes its pose to the predictor,
// which predicts the pose 20 to 200 ms later. The table contains the errors of all recordings together; the
// CSV also has the errors of each recording. A second table shows how the default predictor's error grows
// with the turning speed of the head, which is what a guard band must cover. --stiff needs no recording: it
// prints the difference of every filter from its closed form, over all time constants and steps.
#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <numbers>
#include <vector>

#include "stereo/base/quantile.h"
#include "stereo/head/prediction.h"
#include "stereo/head/reader.h"
#include "tests/unit/head/stiff_sweep.h"

namespace farshade {
namespace {

constexpr double kRefresh_hz = 72, kDegrees = 180.0 / std::numbers::pi;
constexpr int kLeads_ms[] = {20, 50, 100, 200};
/// The classes of turning speed in the second table, degrees/s: each begins at its entry and ends at the
/// next.
constexpr double kSpeeds_deg_s[] = {0, 10, 30, 60, 100, 1e9};

struct Recording {
  std::string name;
  HeadRecording head;
};

struct Errors {
  std::vector<double> turn_deg, distance_mm;
  std::vector<double> speed_deg_s;  ///< estimated by the predictor at the time of the prediction
};

HeadPose shown_at(const HeadRecording& head, Time time) {
  return Rigid<Stage, Recorded>{} *
         head_at(head, time);  // the placement of the recording does not change errors
}

/// Adds the errors at every display time for which the recording has a pose `lead` later.
void add_errors(const HeadRecording& head, PredictorKind kind, Duration lead, Errors& errors) {
  Predictor predictor(kind);
  for (std::int64_t frame = 0;; ++frame) {
    const Time shown = head.start() + Duration(std::llround(static_cast<double>(frame) * 1e9 / kRefresh_hz));
    if (shown + lead > head.end()) return;
    predictor.observe(shown, shown_at(head, shown));
    const HeadPose said = predictor.predict(shown + lead), was = shown_at(head, shown + lead);
    errors.turn_deg.push_back(angle_between_rad(said.rotation, was.rotation) * kDegrees);
    errors.speed_deg_s.push_back(glm::length(predictor.velocity().angular) * kDegrees);
    errors.distance_mm.push_back(1e3 * glm::length(said.translation - was.translation));
  }
}

Errors errors_of(const std::vector<Recording>& recordings, PredictorKind kind, int lead_ms) {
  Errors errors;
  for (const Recording& recording : recordings)
    add_errors(recording.head, kind, std::chrono::milliseconds(lead_ms), errors);
  return errors;
}

void print_table(const std::vector<Recording>& recordings) {
  std::puts("| predictor | ms ahead | degrees p50 | p95 | p99 | mm p50 | p95 | p99 |");
  std::puts("|---|---|---|---|---|---|---|---|");
  for (const PredictorKind kind : kPredictorKinds)
    for (const int lead_ms : kLeads_ms) {
      const Errors errors = errors_of(recordings, kind, lead_ms);
      const Spread turn = spread_of(errors.turn_deg), distance = spread_of(errors.distance_mm);
      std::printf("| %s%s | %d | %.2f | %.2f | %.2f | %.1f | %.1f | %.1f |\n",
                  std::string(to_string(kind)).c_str(), kind == kDefaultPredictor ? " (default)" : "",
                  lead_ms, turn.median, turn.p95, turn.p99, distance.median, distance.p95, distance.p99);
    }
}

void print_by_speed(const std::vector<Recording>& recordings) {
  std::printf(
      "\n| %s, ms ahead | degrees/s, from | frames | degrees p50 | p95 | p99 |\n|---|---|---|---|---|---|\n",
      std::string(to_string(kDefaultPredictor)).c_str());
  for (const int lead_ms : kLeads_ms) {
    const Errors errors = errors_of(recordings, kDefaultPredictor, lead_ms);
    for (std::size_t c = 0; c + 1 < std::size(kSpeeds_deg_s); ++c) {
      std::vector<double> turn_deg;
      for (std::size_t i = 0; i < errors.turn_deg.size(); ++i)
        if (errors.speed_deg_s[i] >= kSpeeds_deg_s[c] && errors.speed_deg_s[i] < kSpeeds_deg_s[c + 1])
          turn_deg.push_back(errors.turn_deg[i]);
      const Spread turn = spread_of(turn_deg);
      std::printf("| %d | %.0f | %zu | %.2f | %.2f | %.2f |\n", lead_ms, kSpeeds_deg_s[c], turn.count,
                  turn.median, turn.p95, turn.p99);
    }
  }
}

bool write_csv(const std::string& path, const std::vector<Recording>& recordings) {
  std::ofstream out(path);
  out << "recording,predictor,lead_ms,frames,turn_deg_p50,turn_deg_p95,turn_deg_p99,way_mm_p50,way_mm_p95,"
         "way_mm_p99\n";
  const auto rows = [&](const std::string& name, const std::vector<Recording>& some) {
    for (const PredictorKind kind : kPredictorKinds)
      for (const int lead_ms : kLeads_ms) {
        const Errors errors = errors_of(some, kind, lead_ms);
        const Spread turn = spread_of(errors.turn_deg), distance = spread_of(errors.distance_mm);
        out << name << ',' << to_string(kind) << ',' << lead_ms << ',' << turn.count << ',' << turn.median
            << ',' << turn.p95 << ',' << turn.p99 << ',' << distance.median << ',' << distance.p95 << ','
            << distance.p99 << '\n';
      }
  };
  for (const Recording& recording : recordings) rows(recording.name, {recording});
  rows("all", recordings);
  out.close();
  return !out.fail();
}

/// 1 if an error is beyond its bound.
int print_stiff() {
  std::puts("| filter | figure | largest error | bound | at a step of, s | time constant, s |");
  std::puts("|---|---|---|---|---|---|");
  int status = 0;
  for (const stiff::GridError& e : stiff::all_stiff_errors()) {
    std::printf("| %s | %s | %.1e | %.0e | %.2g | %.2g |\n", e.filter.c_str(), e.figure.c_str(), e.largest,
                e.bound, e.step_s, e.constant_s);
    if (!(e.largest <= e.bound)) status = 1;
  }
  return status;
}

int run(int argc, char** argv) {
  std::vector<std::string> paths;
  std::string csv;
  CLI::App app("Prints prediction errors on recorded heads.");
  CLI::Option* traces = app.add_option("TRACE", paths);
  app.add_option("--csv", csv)->needs(traces);
  const CLI::Option* stiff = app.add_flag("--stiff")->excludes(traces);
  app.require_option(1, 0);
  CLI11_PARSE(app, argc, argv);
  if (*stiff) return print_stiff();
  std::vector<Recording> recordings;
  for (const std::string& path : paths) {
    Expected<HeadRecording> head = load_head_recording(path);
    if (!head) {
      std::fprintf(stderr, "%s\n", head.error().what.c_str());
      return 1;
    }
    recordings.push_back({std::filesystem::path(path).stem().string(), std::move(*head)});
  }
  print_table(recordings);
  print_by_speed(recordings);
  if (csv.empty() || write_csv(csv, recordings)) return 0;
  std::fprintf(stderr, "%s: cannot be written\n", csv.c_str());
  return 1;
}

}  // namespace
}  // namespace farshade

int main(int argc, char** argv) {
  return farshade::run(argc, argv);
}
