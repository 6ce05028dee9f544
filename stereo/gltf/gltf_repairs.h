/// Faults of a file that do not keep the rest of it from being drawn.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "stereo/base/expected.h"

namespace farshade::gltf {

// Remedies in several places.
/// A rule of the specification is broken that this loader does not need.
inline constexpr const char* kReadAnyway = "it is read all the same";
inline constexpr const char* kNotDrawn = "it is not drawn";

/// What was repaired. Of each remedy, the first fault is kept and the others are counted, so that a file with
/// thousands of faults makes few warnings.
class Repairs {
 public:
  /// `remedy` says what is drawn instead, such as "it is not drawn".
  void add(const char* remedy, Error fault);
  void add(const char* remedy, std::string fault) { add(remedy, Error{Fault::Malformed, std::move(fault)}); }

  /// One for each remedy: "repaired: mesh 0, primitive 0: unknown mode 9; it is not drawn (and 2 more)".
  [[nodiscard]] std::vector<std::string> sentences() const;

  /// The refusal of a file of which nothing is left to draw: with the first fault that
  /// left something out, else the first fault, else `why` alone.
  [[nodiscard]] tl::unexpected<Error> nothing_to_draw(const std::string& why) const;

 private:
  struct Kind {
    std::string remedy;
    Error first;
    std::size_t more = 0;
  };
  std::vector<Kind> kinds_;
};

/// If `checked` has no fault or a limit is exceeded (OutOfRange), returns it. Otherwise notes the fault,
/// calls `mend` and returns no fault.
template <class Mend>
[[nodiscard]] Expected<void> mended(Expected<void> checked, Repairs& repairs, const char* remedy, Mend mend) {
  if (checked || checked.error().fault == Fault::OutOfRange) return checked;
  repairs.add(remedy, std::move(checked.error()));
  mend();
  return {};
}

}  // namespace farshade::gltf
