/// Figures: the one table of what a run measures. The printed summary, summary.csv, frames.csv, --json and
/// --explain take names, units, definitions and values from it.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "stereo/base/expected.h"
#include "vr_client/report/frame_record.h"

namespace farshade {

/// What the user reads about a figure.
struct FigureText {
  std::string group;     ///< "client", "server", "wire", "head", "eye" or "run"
  std::string name;      ///< unique in its group
  std::string unit;      ///< empty for numbers without one
  std::string meaning;   ///< one sentence: what it is
  std::string measured;  ///< one sentence: how and when it is measured
};

/// "PSNR, dB"
[[nodiscard]] std::string with_unit(const std::string& name, const std::string& unit);

/// Which values of a figure are worse. Where low values are worse, p95 and p99 are the 5 % and 1 % quantiles.
enum class Worse : std::uint8_t { High, Low };

/// A set of modes: bit i is Mode i.
using ModeSet = std::uint32_t;

/// A figure that each frame has.
struct Figure {
  FigureText text;
  std::function<std::optional<double>(const FrameRecord&)> of;
  Worse worse = Worse::High;
  ModeSet printed_in = 0;      ///< the modes whose printed summary has a row of it
  std::optional<Side> side{};  ///< the eye, in group "eye"

  /// "left eye" or "right eye", otherwise the group of its text. Columns and rows of files are named so.
  [[nodiscard]] std::string group() const;
};

/// All of them, in the order of the summary's rows and of the columns of frames.csv.
[[nodiscard]] const std::vector<Figure>& figures();

/// What a network carries.
struct PathRate {
  double down_mbit_s = 0;
  std::optional<double> up_mbit_s{};  ///< no value: unknown
};

/// What a run counts once.
struct RunTotals {
  Duration period{};  ///< of the display
  std::size_t frames = 0, start_up_frames = 0, silent_frames = 0;
  std::uint64_t missed = 0;
  Duration silent{};
  std::uint64_t memory_bytes = 0, planned_memory_bytes = 0;  ///< on the device, at peak
  Extent eye_size{};                                         ///< of the shown pictures
  bool cpu_draws = false;                                    ///< there was no GPU
  double inside_share = 0;                                   ///< of the head's poses: those inside geometry
  std::optional<PathRate> stated_path{};                     ///< by the user
  std::uint32_t reference_every = 0;  ///< every Nth frame is compared with a full trace; 0: none
};

/// A figure that a run has once.
struct RunFigure {
  FigureText text;
  double (*of)(const RunTotals&);
};
[[nodiscard]] std::span<const RunFigure> run_figures();

/// The texts of all figures, each once: both eyes have the same.
[[nodiscard]] std::vector<FigureText> figure_texts();

/// Definition, unit and way of measuring of each figure that `name` fits: "mask error", "client frame",
/// "left eye PSNR" or a column of frames.csv, in any case. An empty name gives one line for each figure.
/// Missing, with a suggestion, if there is no such figure.
[[nodiscard]] Expected<std::string> explain(const std::string& name);

}  // namespace farshade
