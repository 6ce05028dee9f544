/// Reads head recordings from text files:
///
/// - EyeNavGS CSV: rows for left and right eye in turn, world units, milliseconds.
/// - Any table with column names, in a comment or in the first line, that name a time stamp, a position and a
///   quaternion (layout.h).
/// - Without names: EuRoC/ASL CSV (the project's own) `ns,x,y,z,qw,qx,qy,qz`, and TUM `seconds x y z qx qy qz
/// qw`.
///
/// Lines `# key: value` may state axes, units, eye distance and fov (writer.h writes them). Whatever a file
/// does not state is assumed: axes of the stage, metres, a headset as below, the unit of time that gives a
/// plausible sample rate. docs/head-recordings.md lists the programs whose files are read.
#pragma once

#include <filesystem>
#include <optional>
#include <string_view>

#include "stereo/base/expected.h"
#include "stereo/head/axes.h"
#include "stereo/head/head_recording.h"
#include "stereo/head/layout.h"

namespace farshade {

inline constexpr std::uint64_t kMaxRecordingBytes = 64u << 20;
/// A file needs at least this many samples: two would be a single straight motion.
inline constexpr std::size_t kFewestSamples = 3;
/// The length of a recorded quaternion may differ from 1 by this. It is normalised.
inline constexpr double kUnitTolerance = 1e-2;
inline constexpr double kFarthestHead_m = 1e9;

/// The fov of a file that does not state one: a Quest Pro's.
inline constexpr PerEye<EyeFov> kDefaultFov{EyeFov{-0.942, 0.698, 0.733, -0.942},
                                            EyeFov{-0.698, 0.942, 0.733, -0.942}};

/// How to read a file, where the user knows better than the file. Unset: as the file states, or assumed.
struct HeadFileOptions {
  std::optional<double> units_a_metre{};  ///< of positions
  std::optional<Axes> axes{};      ///< set: gravity is believed, too, and the recording is not levelled
  std::optional<TimeUnit> unit{};  ///< of time stamps
  std::optional<QuaternionOrder> order{};
};

/// The recording in `path`, in metres and stage axes, with strictly increasing stamps and 1 to 10,000 samples
/// a second.
///
/// Leaves out and counts: rows that are cut off, hold text that is not a finite number, a quaternion that is
/// not unit (as after lost tracking), a head beyond kFarthestHead_m, or a false tracking flag, and the fewest
/// possible rows with repeated or backward stamps. Refuses, with file and line: layouts that it does not
/// know, files of which more than half of the rows hold no pose, fewer than kFewestSamples samples,
/// other sample rates, stated axes and units other than those of the stage.
///
/// Without stated axes, heads that look around widely and are tilted on the whole (by 3 to 45 degrees) are
/// levelled: EyeNavGS has world axes of a scene that is not level. Sets `read_as` and `doubt`.
///
/// Positions are divided by `units_a_metre`. If it is unset, it is what the column names say, otherwise that
/// of the axes, or for EyeNavGS what the file name says (`eyenavgs_truck` 0.76, `eyenavgs_room` 2); an
/// EyeNavGS file with another name is refused.
[[nodiscard]] Expected<HeadRecording> load_head_recording(const std::filesystem::path& path,
                                                          const HeadFileOptions& options = {});

/// The same from text in memory. `name` is the file name, for errors and for the scale.
[[nodiscard]] Expected<HeadRecording> parse_head_recording(std::string_view text, std::string_view name,
                                                           const HeadFileOptions& options = {});

}  // namespace farshade
