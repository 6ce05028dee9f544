/// Reads head recordings from three kinds of text file. The first lines identify the kind:
///
/// - EuRoC/ASL CSV (the project's own): `ns,x,y,z,qw,qx,qy,qz`, further columns ignored.
/// - TUM: `seconds x y z qx qy qz qw`.
/// - EyeNavGS CSV: rows for left and right eye in turn, world units, milliseconds.
///
/// In the first two, lines `# key: value` may state axes, units, eye distance and fov (writer.h writes them).
/// Without them, a file has stage axes, metres, and the default headset below.
#pragma once

#include <filesystem>
#include <optional>
#include <string_view>

#include "stereo/base/expected.h"
#include "stereo/head/head_recording.h"

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

/// The recording in `path`, in metres, with strictly increasing stamps. Removes the fewest possible rows with
/// repeated or backward stamps and counts them. Refuses, with file and line: text that is not a finite
/// number, quaternions that are not unit, fewer than kFewestSamples samples, axes or units other than those
/// of the stage.
/// Positions are divided by `units_a_metre`. If it is unset, it is 1, or for EyeNavGS what the file name says
/// (`eyenavgs_truck` 0.76, `eyenavgs_room` 2); an EyeNavGS file with another name is refused.
[[nodiscard]] Expected<HeadRecording> load_head_recording(const std::filesystem::path& path,
                                                          std::optional<double> units_a_metre = {});

/// The same from text in memory. `name` is the file name, for errors and for the scale.
[[nodiscard]] Expected<HeadRecording> parse_head_recording(std::string_view text, std::string_view name,
                                                           std::optional<double> units_a_metre = {});

}  // namespace farshade
