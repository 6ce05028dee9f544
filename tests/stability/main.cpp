// stability: runs every extreme case through the real rt_server and vr_client. Prints a table, writes CSV,
// and fails if a case exceeds its bounds.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <fstream>
#include <regex>

#include "stereo/base/clock.h"
#include "stereo/options/command_line.h"
#include "tests/stability/cases.h"

namespace {

using namespace farshade;
using namespace farshade::stability;

struct Options {
  std::string only = ".*";
  std::filesystem::path out = "out/stability";
  bool cases = false, sweeps = false, quick = false, list = false;
};

/// The cases that run after every change: those that found faults before, and one extreme of each kind.
constexpr const char* kQuick =
    "scale-1mm|origin-1000km|fov-170$|light-0.1mm|triangle-aspect-1e6|head-1000-deg-s|size-1x1|trace-"
    "backward|"
    "huge-floor|vertices-1000km|depth-ratio-1e7|light-overflow-in-shadow";

std::vector<Case> chosen(const Options& options) {
  std::vector<Case> all;
  const auto take = [&](std::vector<Case> cases) {
    const std::regex only(options.quick ? kQuick : options.only);
    for (Case& tested : cases)
      if (std::regex_search(tested.name, only)) all.push_back(std::move(tested));
  };
  if (!options.sweeps)
    for (const auto& cases : {scene_cases(), light_cases(), view_cases(), head_cases(), refused_cases()})
      take(cases);
  if (!options.cases && !options.quick) take(sweep_cases());
  return all;
}

/// The ordinary cases, to compare run times with. Each runs at its first use.
class Ordinary {
 public:
  explicit Ordinary(const CasePaths& paths) : paths_(paths) {}

  Pace pace(const std::string& name) {
    if (const auto known = paces_.find(name); known != paces_.end()) return known->second;
    return paces_[name] = measure(name);
  }
  /// Runs the case now, whether it ran before or not.
  [[nodiscard]] Pace measure(const std::string& name) const {
    for (const std::vector<Case>& cases : {scene_cases(), light_cases(), view_cases()})
      for (const Case& tested : cases)
        if (tested.name == name) return run(tested, paths_).pace;
    return {};
  }

 private:
  const CasePaths& paths_;
  std::map<std::string, Pace> paces_;
};

Pace faster(const Pace& a, const Pace& b) {
  return {std::min(a.client_ms, b.client_ms), std::min(a.server_ms, b.server_ms)};
}

/// The machine may be busier now than when the ordinary case ran. So if the case seems slow, both run in
/// turn, up to five times, and the fastest runs are compared.
Ran run_with_pace(const Case& tested, const CasePaths& paths, Ordinary& ordinary) {
  constexpr int kTurns = 5;
  Ran ran = run(tested, paths);
  if (tested.outcome != Outcome::Works) return ran;
  Pace best = ran.pace, like = ordinary.pace(tested.like);
  for (int turn = 0; turn < kTurns && ran.verdict.broken.empty(); ++turn) {
    Verdict timed;
    judge_pace(best, like, timed);
    if (timed.good()) break;
    const Pace ordinary_now = ordinary.measure(tested.like), now = run(tested, paths).pace;
    like = turn == 0 ? ordinary_now : faster(like, ordinary_now);
    best = turn == 0 ? now : faster(best, now);
  }
  judge_pace(best, like, ran.verdict);
  return ran;
}

void write_rows(std::ofstream& csv, const Case& tested, const Verdict& verdict) {
  const auto row = [&](const std::string& figure, const std::string& unit, const std::string& value,
                       const std::string& bound, bool good) {
    csv << fmt::format("{},\"{}\",{},{:g},{},{},{},{},{}\n", tested.name, tested.extreme, tested.sweep,
                       tested.x, figure, unit, value, bound, good ? "ok" : "BROKEN");
  };
  if (!verdict.broken.empty()) row("comes to figures", "", "0", "", false);
  for (const Figure& figure : verdict.figures)
    row(figure.name, figure.unit, fmt::format("{:.6g}", figure.value),
        figure.bound ? fmt::format("{:.6g}", *figure.bound) : "", holds(figure));
}

int run_all(const Options& options) {
  const std::vector<Case> cases = chosen(options);
  if (options.list) {
    for (const Case& tested : cases) fmt::print("{:<34} {}\n", tested.name, tested.extreme);
    return EXIT_SUCCESS;
  }
  std::filesystem::create_directories(options.out);
  const CasePaths paths{RT_SERVER, VR_CLIENT, options.out / "case"};
  std::ofstream csv(options.out / "stability.csv");
  csv << "case,extreme,sweep,x,figure,unit,value,bound,verdict\n";
  Ordinary ordinary(paths);
  const Stopwatch watch;
  std::size_t bad = 0, done = 0;
  fmt::print("{:<34} {:<46} {:<56} {}\n", "case", "what is extreme", "figure closest to its bound",
             "verdict");
  for (const Case& tested : cases) {
    const Verdict verdict = run_with_pace(tested, paths, ordinary).verdict;
    bad += !verdict.good();
    fmt::print("{:<34} {:<46} {:<56} {}\n", tested.name, tested.extreme, in_short(verdict),
               verdict.good() ? "ok" : "BROKEN");
    if (!verdict.good())
      for (const Figure& figure : verdict.figures)
        if (!holds(figure))
          fmt::print("    {} = {:.4g} {}, bound {:.4g}\n", figure.name, figure.value, figure.unit,
                     figure.bound.value_or(0));
    std::fflush(stdout);
    write_rows(csv, tested, verdict);
    csv.flush();
    ++done;
    const double left_s =
        seconds_of(watch.elapsed()) / static_cast<double>(done) * static_cast<double>(cases.size() - done);
    const bool terminal = isatty(STDERR_FILENO) != 0;
    if (terminal || done % 10 == 0)
      fmt::print(stderr, "{} of {} cases, about {:.0f} s left{}", done, cases.size(), left_s,
                 terminal ? "   \r" : "\n");
  }
  std::error_code ignored;
  std::filesystem::remove_all(paths.folder, ignored);
  fmt::print("{} cases, {} broken, {:.0f} s\n", cases.size(), bad, seconds_of(watch.elapsed()));
  return bad == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}

}  // namespace

int main(int argc, char** argv) try {
  CLI::App app(
      "Runs extreme cases through rt_server and vr_client and judges them against double precision.");
  make_readable(app);
  Options options;
  app.add_option("--only", options.only, "cases whose name this regular expression finds")
      ->capture_default_str();
  app.add_option("--out", options.out, "folder for stability.csv")->capture_default_str();
  CLI::Option* const cases = app.add_flag("--cases", options.cases, "run no sweeps");
  app.add_flag("--sweeps", options.sweeps, "run only sweeps")->excludes(cases);
  app.add_flag("--quick", options.quick, "run only the few cases that every change must pass");
  app.add_flag("--list", options.list, "only list the names of the cases");
  CLI11_PARSE(app, argc, argv);
  return run_all(options);
} catch (const std::exception& error) {
  fmt::print(stderr, "stability: {}\n", error.what());
  return EXIT_FAILURE;
}
