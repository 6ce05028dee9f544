/// Judge: compares a dumped frame with the double-precision oracle and records figures.
#pragma once

#include "stereo/scene/scene_state.h"
#include "tests/stability/dump.h"
#include "tests/stability/verdict.h"

namespace farshade::stability {

/// Number of mask bits that the dump holds. Higher bits are not compared.
inline constexpr std::uint32_t kJudgedLights = 16;

/// Compares the traced masks with the oracle at the traced views. Shares are of the pixel-lights of both
/// eyes. "False shadow": shadowed, but lit in the oracle; "false light": lit, but shadowed in the oracle.
/// Both count only outside the oracle's band (oracle.h), and both must be 0.
[[nodiscard]] std::vector<Figure> judge_traced(const Scene& scene, const Dump& dump);

/// Compares the shown masks and the picture, for a frame whose shown views are the traced views.
[[nodiscard]] std::vector<Figure> judge_shown(const Scene& scene, const Dump& dump);

/// Compares the shown masks of a frame whose shown views are the traced views and whose mask was composed of
/// reprojected and of requested bits (docs/partial-requests.md). A reprojected bit has the value of the true
/// mask within one pixel. "Wrong, carried": bits whose value no pixel of the 3x3 pixels around has in the
/// oracle, and none of them lies in its band.
[[nodiscard]] std::vector<Figure> judge_reprojected(const Scene& scene, const Dump& dump);

/// Compares the look-up positions in the view of the newest mask, in pixels, with those in double from the
/// same stored depth and from the oracle's surface.
[[nodiscard]] std::vector<Figure> judge_lookup(const Scene& scene, const Dump& dump);

}  // namespace farshade::stability
