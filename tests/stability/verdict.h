/// Verdict: the figures of one case, each against its bound.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace farshade::stability {

struct Figure {
  std::string name, unit;
  double value = 0;
  std::optional<double> bound{};  ///< at most; none: told, not judged
};

/// A figure that is not finite is never within bound.
[[nodiscard]] bool holds(const Figure& figure);

struct Verdict {
  std::vector<Figure> figures;
  std::string broken{};  ///< not empty: the case did not come to figures, and why

  [[nodiscard]] bool good() const;
  /// The judged figure that is closest to its bound, or furthest beyond; null if none is judged.
  [[nodiscard]] const Figure* tightest() const;
};

/// One line: the tightest figure against its bound.
[[nodiscard]] std::string in_short(const Verdict& verdict);

}  // namespace farshade::stability
