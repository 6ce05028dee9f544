/// A range check for options of the command line.
#pragma once

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <string>

namespace farshade {

/// Like CLI::Range, but refuses NaN.
inline CLI::Validator within(double low, double high) {
  const std::string range = fmt::format("{:.12g} to {:.12g}", low, high);
  return {[=](std::string& text) {
            double value = 0;
            const bool inside = CLI::detail::lexical_cast(text, value) && value >= low && value <= high;
            return inside ? std::string() : fmt::format("'{}' is not within {}", text, range);
          },
          range};
}

}  // namespace farshade
