/// Rows of numbers in a text file, read without regard to locale; errors name file and line.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "stereo/base/expected.h"

namespace farshade::rows {

/// Where a row came from, for errors.
struct Place {
  std::string_view file;
  std::size_t line = 0;  ///< from 1
};

[[nodiscard]] tl::unexpected<Error> fail_at(Place place, Fault fault, const std::string& what);

/// Walks over lines; ends of line may be LF or CRLF, a byte order mark is skipped.
class Lines {
 public:
  Lines(std::string_view text, std::string_view file);
  /// The next line that is not blank into `line`, without blanks around it. False at the end.
  [[nodiscard]] bool next(std::string_view& line);
  [[nodiscard]] Place place() const { return place_; }

 private:
  std::string_view rest_;
  Place place_;
};

[[nodiscard]] std::string_view trimmed(std::string_view text);

/// Splits at commas or, for `separator` ' ', at runs of blanks. `fields` is reused.
void split(std::string_view line, char separator, std::vector<std::string_view>& fields);

/// A finite number that fills `field`.
[[nodiscard]] Expected<double> number(std::string_view field, Place place);

/// A decimal number of units of 10^digits nanoseconds, rounded to whole nanoseconds; exact where it is
/// written without an exponent. At most 2^62 ns from 0.
[[nodiscard]] Expected<std::int64_t> nanoseconds(std::string_view field, int digits, Place place);

}  // namespace farshade::rows
