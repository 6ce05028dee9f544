/// Judge: a dumped frame against the double-precision oracle, figure by figure.
#pragma once

#include "stereo/scene/scene_state.h"
#include "tests/stability/dump.h"
#include "tests/stability/verdict.h"

namespace farshade::stability {

/// Bits of a mask beyond the low 16 are not dumped, and not judged.
inline constexpr std::uint32_t kJudgedLights = 16;

/// Shares are of pixel-lights of both eyes. "False shadow": shadowed, but lit in truth; "false light": the
/// other way round; both outside the oracle's band (oracle.h), both bound to be 0.
/// The masks as they were traced, at the views they were traced for.
[[nodiscard]] std::vector<Figure> judge_traced(const Scene& scene, const Dump& dump);

/// The masks as they were shown, and the picture; for a frame whose shown views are the traced ones.
[[nodiscard]] std::vector<Figure> judge_shown(const Scene& scene, const Dump& dump);

/// Where points were looked up in the newest mask's view, in pixels: against double from the same stored
/// depth, and against the oracle's own surface.
[[nodiscard]] std::vector<Figure> judge_lookup(const Scene& scene, const Dump& dump);

}  // namespace farshade::stability
