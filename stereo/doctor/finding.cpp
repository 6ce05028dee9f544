#include "stereo/doctor/finding.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>

namespace farshade {
namespace {

const char* name_of(Severity severity) {
  switch (severity) {
    case Severity::Ok:
      return "ok";
    case Severity::Warn:
      return "warn";
    case Severity::Fail:
      return "FAIL";
  }
  return "?";
}

}  // namespace

Finding failed(std::string subject, const Error& error, std::string cure) {
  return {Severity::Fail, std::move(subject), error.what, std::move(cure)};
}

void print(const Findings& findings) {
  for (const Finding& finding : findings)
    fmt::print("{:<5} {}: {}{}{}\n", name_of(finding.severity), finding.subject, finding.found,
               finding.cure.empty() ? "" : "; cure: ", finding.cure);
}

bool any_failed(const Findings& findings) {
  return std::ranges::any_of(findings, [](const Finding& f) { return f.severity == Severity::Fail; });
}

}  // namespace farshade
