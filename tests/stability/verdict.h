/// Verdict: the figures of one case with their bounds.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace farshade::stability {

struct Figure {
  std::string name, unit;
  double value = 0;
  std::optional<double> bound{};  ///< upper bound; none: reported only
};

/// A figure that is not finite exceeds any bound.
[[nodiscard]] bool holds(const Figure& figure);

struct Verdict {
  std::vector<Figure> figures;
  std::string broken{};  ///< if not empty: the reason why the case has no figures

  [[nodiscard]] bool good() const;
  /// The bounded figure that is closest to its bound, or furthest beyond it; null if no figure has a bound.
  [[nodiscard]] const Figure* tightest() const;
};

/// One line: the tightest figure against its bound.
[[nodiscard]] std::string in_short(const Verdict& verdict);

}  // namespace farshade::stability
