/// The file formats of load_head_recording, one function per format, and the comment lines that they share
/// with the writer.
#pragma once

#include "stereo/head/reader.h"

namespace farshade::formats {

inline constexpr std::string_view kAxesKey = "axes", kAxes = "+x right, +y up, -z ahead, right-handed";
inline constexpr std::string_view kUnitsKey = "units", kEurocUnits = "m, ns", kTumUnits = "m, s";
inline constexpr std::string_view kEyeDistanceKey = "eye distance [m]";
inline constexpr PerEye<std::string_view> kFovKeys{"fov left eye [rad] left right up down",
                                                   "fov right eye [rad] left right up down"};
inline constexpr std::string_view kEurocColumns =
    "timestamp [ns],p_RS_R_x [m],p_RS_R_y [m],p_RS_R_z [m],q_RS_w [],q_RS_x [],q_RS_y [],q_RS_z []";
inline constexpr std::string_view kTumColumns = "timestamp tx ty tz qx qy qz qw";

[[nodiscard]] Expected<HeadRecording> read_table(std::string_view text, std::string_view name,
                                                 double units_a_metre, const HeadFileOptions& options);
[[nodiscard]] Expected<HeadRecording> read_eyenavgs(std::string_view text, std::string_view name,
                                                    double units_a_metre, const HeadFileOptions& options);

}  // namespace farshade::formats
