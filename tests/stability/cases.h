/// The stability cases: extreme scenes, lights, views and heads, as data. docs/stability.md explains the
/// figures and bounds.
#pragma once

#include "tests/stability/run.h"

namespace farshade::stability {

/// The tables one after the other.
[[nodiscard]] inline std::vector<Case> joined(std::initializer_list<std::vector<Case>> tables) {
  std::vector<Case> all;
  for (const std::vector<Case>& table : tables) all.insert(all.end(), table.begin(), table.end());
  return all;
}

[[nodiscard]] std::vector<Case> scene_cases();
[[nodiscard]] std::vector<Case> light_cases();
[[nodiscard]] std::vector<Case> view_cases();
[[nodiscard]] std::vector<Case> head_cases();
/// Settings outside the domain. The programs must refuse them.
[[nodiscard]] std::vector<Case> refused_cases();
/// Cases along a range of one parameter, for plots.
[[nodiscard]] std::vector<Case> sweep_cases();

}  // namespace farshade::stability
