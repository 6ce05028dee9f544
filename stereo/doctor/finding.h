/// Finding: one thing that a doctor (`rt_server doctor`, `vr_client doctor`) has looked at, and what to do.
/// Checks are functions that return findings; nothing but print() writes them.
#pragma once

#include <string>
#include <vector>

#include "stereo/base/expected.h"

namespace farshade {

enum class Severity : std::uint8_t {
  Ok,
  Warn,  ///< works, but slower, or not for everything
  Fail,  ///< the program cannot do its work
};

struct Finding {
  Severity severity = Severity::Ok;
  std::string subject;  ///< what was looked at
  std::string found;    ///< never a secret
  std::string cure{};   ///< what to do; empty where nothing is wrong
  friend bool operator==(const Finding&, const Finding&) = default;
};
using Findings = std::vector<Finding>;

/// What was asked for cannot be had.
[[nodiscard]] Finding failed(std::string subject, const Error& error, std::string cure);

/// One line a finding to standard output: `FAIL  SUBJECT: FOUND; cure: CURE`.
void print(const Findings& findings);

[[nodiscard]] bool any_failed(const Findings& findings);

}  // namespace farshade
