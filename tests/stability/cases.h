/// Cases: the extremes, as data. docs/stability.md says what the figures and bounds mean.
#pragma once

#include "tests/stability/run.h"

namespace farshade::stability {

[[nodiscard]] std::vector<Case> scene_cases();
[[nodiscard]] std::vector<Case> light_cases();
[[nodiscard]] std::vector<Case> view_cases();
[[nodiscard]] std::vector<Case> head_cases();
/// What lies outside of the domain.
[[nodiscard]] std::vector<Case> refused_cases();
/// Points of curves.
[[nodiscard]] std::vector<Case> sweep_cases();

}  // namespace farshade::stability
