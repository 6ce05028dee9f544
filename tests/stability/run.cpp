#include "tests/stability/run.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <numbers>
#include <sstream>

#include "stereo/base/files.h"
#include "stereo/base/quantile.h"
#include "stereo/gltf/load_lit_scene.h"
#include "stereo/head/reader.h"
#include "stereo/head/writer.h"
#include "stereo/math/rotation.h"
#include "stereo/scene/lighting.h"
#include "stereo/sealing/key_file.h"
#include "tests/integration/child_program.h"
#include "tests/stability/judge.h"

namespace farshade::stability {
namespace {

constexpr double kMostTimesOrdinary = 4;
/// Number of frames before the predictor knows the motion of the head.
constexpr std::size_t kUnsettled = 3;
constexpr double kDegrees = 180 / std::numbers::pi;

using Columns = std::map<std::string, std::vector<std::string>>;

std::vector<std::string> fields_of(const std::string& line) {
  std::vector<std::string> fields(1);
  for (const char c : line)
    if (c == ',')
      fields.emplace_back();
    else
      fields.back() += c;
  return fields;
}

Columns read_columns(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  const std::vector<std::string> names = fields_of(line);
  Columns columns;
  while (std::getline(file, line)) {
    const std::vector<std::string> row = fields_of(line);
    for (std::size_t i = 0; i < std::min(row.size(), names.size()); ++i) columns[names[i]].push_back(row[i]);
  }
  return columns;
}

/// The values of a column. Empty fields are frames without a value.
std::vector<double> numbers(const Columns& columns, const std::string& name) {
  std::vector<double> values;
  if (const auto column = columns.find(name); column != columns.end())
    for (const std::string& field : column->second)
      if (!field.empty()) values.push_back(std::strtod(field.c_str(), nullptr));
  return values;
}

/// Counts the fields of frames.csv that are not finite numbers.
double count_not_finite(const Columns& columns) {
  double count = 0;
  for (const auto& [name, fields] : columns)
    for (const std::string& field : fields) {
      if (field.empty()) continue;
      double value = 0;
      const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
      count += error != std::errc{} || end != field.data() + field.size() || !std::isfinite(value);
    }
  return count;
}

struct Files {
  std::filesystem::path scene, head, key, ring;
};

Files write(const Setting& setting, const std::filesystem::path& folder) {
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  Files files{folder / "scene.glb", folder / "head.csv", folder / "client.key", folder / "ring.keys"};
  const std::vector<std::byte> glb = setting.scene.glb();
  std::ofstream(files.scene, std::ios::binary)
      .write(reinterpret_cast<const char*>(glb.data()), static_cast<std::streamsize>(glb.size()));
  const SharedKey key = new_key("stability").value();
  if (!write_file_atomically(files.head, euroc_text(setting.head)) || !write_key(files.key, key) ||
      !append_to_ring(files.ring, key))
    throw std::runtime_error("cannot write to " + folder.string());
  return files;
}

struct Ended {
  int status = 0;
  std::string errors;
};

/// Runs the client on one setting. Each run writes its results to `out`.
class ClientRuns {
 public:
  ClientRuns(const CasePaths& paths, const Setting& setting, const Files& files, std::string server)
      : paths_(paths), setting_(setting), files_(files), server_(std::move(server)) {}

  Ended run(const std::filesystem::path& out, const std::vector<std::string>& more) const {
    std::vector<std::string> arguments{paths_.client.string(),
                                       "--scene",
                                       files_.scene.string(),
                                       "--trace",
                                       files_.head.string(),
                                       "--server",
                                       server_,
                                       "--key",
                                       files_.key.string(),
                                       "--place",
                                       "recorded",
                                       "--exposure",
                                       "1",
                                       "--pictures",
                                       "0",
                                       "--reference-every",
                                       "0",
                                       "--out",
                                       out.string(),
                                       "--size",
                                       fmt::format("{}x{}", setting_.size.width, setting_.size.height),
                                       "--frames",
                                       std::to_string(setting_.frames),
                                       "--dump",
                                       std::to_string(setting_.frames)};
    arguments.insert(arguments.end(), more.begin(), more.end());
    arguments.insert(arguments.end(), setting_.options.begin(), setting_.options.end());
    ChildProgram program(arguments);
    const std::string errors = program.errors();
    return {program.wait(), errors};
  }

 private:
  const CasePaths& paths_;
  const Setting& setting_;
  const Files& files_;
  std::string server_;
};

std::string last_line(const std::string& text) {
  std::istringstream lines(text);
  std::string line, last;
  while (std::getline(lines, line))
    if (!line.empty()) last = line;
  return last;
}

/// The number before `what` in the text; 0 if it is missing.
double number_before(const std::string& line, const std::string& what) {
  const std::size_t end = line.find(what);
  if (end == std::string::npos || end == 0) return 0;
  const std::size_t start = line.find_last_not_of("0123456789", end - 1);
  return std::strtod(line.c_str() + (start == std::string::npos ? 0 : start + 1), nullptr);
}

/// The number of messages that the server refused for their content, from its own counters. Ended sessions
/// and duplicated datagrams do not count. Infinite if the server did not report its counters.
double refused_by(ChildProgram& server) {
  server.send(SIGTERM);
  while (const auto line = server.line_after("rt_server: "))
    if (line->find(" clients, ") != std::string::npos)
      return number_before(*line, " refused") - number_before(*line, " unknown session") -
             number_before(*line, " replayed");
  return HUGE_VAL;
}

void append(std::vector<Figure>& to, std::vector<Figure> more) {
  to.insert(to.end(), more.begin(), more.end());
}

Pace pace_of(const Columns& frames) {
  return {quantile(numbers(frames, "client frame [ms]"), 0.25),
          quantile(numbers(frames, "server frame [ms]"), 0.25)};
}

/// The errors, per frame, of views held since the request and of the requested views.
void judge_head(const Case& tested, const Files& files, const Columns& frames, Verdict& verdict) {
  const Expected<HeadRecording> recording = load_head_recording(files.head);
  const std::array names{"display_time_ns", "head turned since traced view [deg]",
                         "head moved since traced view [mm]", "wire age [ms]"};
  if (!recording || !std::ranges::all_of(names, [&](const char* name) { return frames.contains(name); })) {
    verdict.broken = "frames.csv does not say how the head moved";
    return;
  }
  double held_deg = 0, most_deg = 0, most_mm = 0;
  std::size_t seen = 0;
  for (std::size_t row = 0; row < frames.at(names[0]).size(); ++row) {
    const auto field = [&](std::size_t i) { return frames.at(names[i])[row]; };
    if (field(1).empty() || field(3).empty() || ++seen <= kUnsettled) continue;
    const Time now = time_from_ns(std::strtoll(field(0).c_str(), nullptr, 10));
    const double age_ms = std::strtod(field(3).c_str(), nullptr);
    const Rigid<Recorded, Head> shown = head_at(*recording, now),
                                requested = head_at(*recording, now - duration_from_ms(age_ms));
    held_deg = std::max(held_deg, angle_between_rad(shown.rotation, requested.rotation) * kDegrees);
    most_deg = std::max(most_deg, std::strtod(field(1).c_str(), nullptr));
    most_mm = std::max(most_mm, std::strtod(field(2).c_str(), nullptr));
  }
  std::optional<double> bound;
  if (tested.head == HeadBound::NoWorseThanHeld) bound = held_deg + 0.01;
  if (tested.head == HeadBound::TwiceHeld) bound = 2 * held_deg;
  verdict.figures.push_back({"predictor turn", "deg", most_deg, bound});
  verdict.figures.push_back({"held turn", "deg", held_deg});
  verdict.figures.push_back({"predictor way", "mm", most_mm});
}

/// True if the run ended regularly; otherwise the verdict says why not.
bool ended(const Ended& run, const char* which, Verdict& verdict) {
  if (run.status == 0) return true;
  verdict.broken = fmt::format("{} run ended with {}: {}", which, run.status, last_line(run.errors));
  return false;
}

std::filesystem::path dumped(const std::filesystem::path& out, const Setting& setting) {
  return out / "dump" / fmt::format("frame_{:04}", setting.frames);
}

/// A refusal is one sentence that starts with the program's name, and a nonzero exit status.
bool is_refusal(const Ended& run, const std::string& program) {
  const std::string said = last_line(run.errors);
  return run.status > 0 && run.status < 126 && said.starts_with(program + ": ") && said.size() > 20;
}

Verdict refusal(const Case& tested, const CasePaths& paths, const Setting& setting, const Files& files) {
  Verdict verdict;
  if (tested.outcome == Outcome::BothRefuse) {
    ChildProgram server({paths.server.string(), "--scene", files.scene.string(), "--listen", "127.0.0.1:0",
                         "--keys", files.ring.string(), "--exposure", "1"});
    const bool listens = server.line_after("rt_server: listening on ").has_value();
    if (listens || !is_refusal({server.wait(), server.errors()}, "rt_server")) {
      verdict.broken = listens ? "rt_server serves it" : "rt_server ends without a sentence";
      return verdict;
    }
  }
  const Ended run = ClientRuns(paths, setting, files, "127.0.0.1:9").run(paths.folder / "out", {});
  if (!is_refusal(run, "vr_client"))
    verdict.broken = run.status == 0 ? "vr_client takes it" : "vr_client ends with: " + last_line(run.errors);
  verdict.figures.push_back({"refused in one sentence", "", 0, 0});
  return verdict;
}

}  // namespace

Ran run(const Case& tested, const CasePaths& paths) {
  const Setting setting = tested.make();
  const Files files = write(setting, paths.folder);
  if (tested.outcome != Outcome::Works) return {refusal(tested, paths, setting, files), {}};

  Ran ran;
  Verdict& verdict = ran.verdict;
  // Extreme lights are judged as they are: no exposure is chosen.
  const Expected<Scene> scene = load_lit_scene(files.scene, {.exposure = 1.0f}).map([](LitScene&& lit) {
    return std::move(lit.scene);
  });
  ChildProgram server({paths.server.string(), "--scene", files.scene.string(), "--listen", "127.0.0.1:0",
                       "--keys", files.ring.string(), "--exposure", "1"});
  const auto address = server.line_after("rt_server: listening on ");
  if (!scene || !address) {
    verdict.broken = scene ? "rt_server: " + last_line(server.errors()) : scene.error().what;
    return ran;
  }
  const ClientRuns client(paths, setting, files, *address);
  const auto still = paths.folder / "still", moving = paths.folder / "moving",
             reprojected = paths.folder / "carried";
  const std::vector<std::string> at_once{"--delay", "0", "--predictor", "hold", "--guard-band", "off"};
  std::vector<std::string> at_once_whole = at_once;
  at_once_whole.insert(at_once_whole.end(), {"--ask", "whole"});
  const std::vector<std::string> late{"--delay", fmt::format("{}", setting.delay_ms), "--ask", "whole"};
  if (!ended(client.run(still, at_once_whole), "still", verdict) ||
      !ended(client.run(moving, late), "moving", verdict) ||
      !ended(client.run(reprojected, at_once), "carried", verdict))
    return ran;

  const Expected<Dump> of_still = read_dump(dumped(still, setting)),
                       of_moving = read_dump(dumped(moving, setting)),
                       of_reprojected = read_dump(dumped(reprojected, setting));
  if (!of_still || !of_moving || !of_reprojected) {
    verdict.broken = (!of_still ? of_still : !of_moving ? of_moving : of_reprojected).error().what;
    return ran;
  }
  append(verdict.figures, judge_shown(*scene, *of_still));
  append(verdict.figures, judge_reprojected(*scene, *of_reprojected));
  append(verdict.figures, judge_traced(*scene, *of_moving));
  append(verdict.figures, judge_lookup(*scene, *of_moving));
  const Columns frames = read_columns(moving / "frames.csv");
  judge_head(tested, files, frames, verdict);
  const double not_finite = static_cast<double>(count_not_finite(*of_still) + count_not_finite(*of_moving)) +
                            count_not_finite(frames) + count_not_finite(read_columns(still / "frames.csv"));
  verdict.figures.push_back({"not finite", "numbers", not_finite, 0});
  verdict.figures.push_back({"refused by the server", "messages", refused_by(server), 0});
  ran.pace = pace_of(frames);
  return ran;
}

void judge_pace(const Pace& pace, const Pace& ordinary, Verdict& verdict) {
  if (!verdict.broken.empty()) return;
  verdict.figures.push_back({"client frame", "ms", pace.client_ms, kMostTimesOrdinary * ordinary.client_ms});
  verdict.figures.push_back({"server frame", "ms", pace.server_ms, kMostTimesOrdinary * ordinary.server_ms});
}

}  // namespace farshade::stability
