#include "tests/stability/verdict.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace farshade::stability {
namespace {

/// The figure as a fraction of its bound; above 1 it exceeds the bound.
double strain(const Figure& figure) {
  if (!figure.bound) return -1;
  if (!std::isfinite(figure.value)) return std::numeric_limits<double>::infinity();
  if (*figure.bound == 0) return figure.value > 0 ? std::numeric_limits<double>::infinity() : 0;
  return figure.value / *figure.bound;
}

}  // namespace

bool holds(const Figure& figure) {
  return std::isfinite(figure.value) && (!figure.bound || figure.value <= *figure.bound);
}

bool Verdict::good() const {
  return broken.empty() && std::ranges::all_of(figures, holds);
}

const Figure* Verdict::tightest() const {
  const auto most = std::ranges::max_element(figures, {}, strain);
  return most == figures.end() || !most->bound ? nullptr : &*most;
}

std::string in_short(const Verdict& verdict) {
  if (!verdict.broken.empty()) return verdict.broken;
  const Figure* figure = verdict.tightest();
  if (figure == nullptr) return "nothing to judge";
  return fmt::format("{}: {:.3g} of {:.3g} {}", figure->name, figure->value, *figure->bound, figure->unit);
}

}  // namespace farshade::stability
