/// Reads recorded heads from three kinds of text file, told apart by their first lines:
///
/// - EuRoC/ASL CSV (the project's own): `ns,x,y,z,qw,qx,qy,qz`, further columns ignored.
/// - TUM: `seconds x y z qx qy qz qw`.
/// - EyeNavGS CSV: rows for left and right eye in turn, world units, milliseconds.
///
/// Lines `# key: value` of the first two may state axes, units, eye distance and fov (writer.h writes them);
/// a file that states none is taken to be in stage axes, metres, and worn by the default headset below.
#pragma once

#include <filesystem>
#include <optional>
#include <string_view>

#include "stereo/base/expected.h"
#include "stereo/head/head_recording.h"

namespace farshade {

struct HeadRecordingOptions {
  /// World units a metre: positions are divided by it. Unset: 1, except for EyeNavGS, where the file's name
  /// tells
  /// (`eyenavgs_truck` 0.76, `eyenavgs_room` 2) or the file is refused.
  std::optional<double> scene_scale;
};

inline constexpr std::uint64_t kMaxTraceBytes = 64u << 20;
/// One straight line is no recording.
inline constexpr std::size_t kFewestSamples = 3;
/// A recorded quaternion's length may be off 1 by this; it is renormalised.
inline constexpr double kUnitTolerance = 1e-2;
inline constexpr double kFarthestHead_m = 1e9;

/// What a file that says nothing about its headset was worn with: a Quest Pro.
inline constexpr double kDefaultEyeDistance_m = 0.063;
inline constexpr PerEye<EyeFov> kDefaultFov{EyeFov{-0.942, 0.698, 0.733, -0.942},
                                            EyeFov{-0.698, 0.942, 0.733, -0.942}};

/// The trace in `path`, in metres, its stamps strictly increasing: rows whose stamps repeat another or run
/// backward are left out, as few as will do, and counted. Refuses, naming file and line: what is no number or
/// not finite, quaternions off unit, fewer than kFewestSamples samples, axes or units other than the stage's.
[[nodiscard]] Expected<HeadRecording> load_head_recording(const std::filesystem::path& path,
                                                          const HeadRecordingOptions& options = {});

/// The same from text in memory; `name` is the file name that errors speak of and that tells a scale.
[[nodiscard]] Expected<HeadRecording> parse_head_trace(std::string_view text, std::string_view name,
                                                       const HeadRecordingOptions& options = {});

}  // namespace farshade
