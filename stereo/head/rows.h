/// Reads rows of numbers from text, independent of the locale. Errors name file and line.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "stereo/base/expected.h"

namespace farshade::rows {

/// File and line of a row, for error messages.
struct Place {
  std::string_view file;
  std::size_t line = 0;  ///< from 1
};

[[nodiscard]] tl::unexpected<Error> fail_at(Place place, Fault fault, const std::string& what);

/// Iterates over the lines of a text. Lines end with LF, CRLF or CR; a byte order mark is skipped.
class Lines {
 public:
  Lines(std::string_view text, std::string_view file);
  /// Sets `line` to the next line that is not blank, trimmed. Returns false at the end.
  [[nodiscard]] bool next(std::string_view& line);
  [[nodiscard]] Place place() const { return place_; }

 private:
  std::string_view rest_;
  Place place_;
};

[[nodiscard]] std::string_view trimmed(std::string_view text);

/// Splits at commas or, for `separator` ' ', at runs of blanks. Reuses the memory of `fields`.
void split(std::string_view line, char separator, std::vector<std::string_view>& fields);

/// Parses the whole of `field` as a finite number.
[[nodiscard]] Expected<double> number(std::string_view field, Place place);

/// Parses a decimal number in units of 10^digits nanoseconds and rounds it to whole nanoseconds. The result
/// is exact if there is no exponent. At most 2^62 ns from 0.
[[nodiscard]] Expected<std::int64_t> nanoseconds(std::string_view field, int digits, Place place);

}  // namespace farshade::rows
