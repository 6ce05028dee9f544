#include "stereo/head/rows.h"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace farshade::rows {
namespace {

constexpr std::string_view kBlanks = " \t\r";
constexpr std::int64_t kLatest_ns = std::int64_t{1} << 62;

/// The text of a field for an error message: shortened and without control characters.
std::string quoted(std::string_view field) {
  std::string shown(field.substr(0, 40));
  std::replace_if(
      shown.begin(), shown.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
  return "'" + shown + "'";
}

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

Expected<std::int64_t> rounded(double ns, std::string_view field, Place place) {
  if (!(std::abs(ns) < static_cast<double>(kLatest_ns)))
    return fail_at(place, Fault::OutOfRange, "time stamp " + quoted(field) + " is beyond 2^62 nanoseconds");
  return std::llround(ns);
}

}  // namespace

tl::unexpected<Error> fail_at(Place place, Fault fault, const std::string& what) {
  return fail(fault, std::string(place.file) + ":" + std::to_string(place.line) + ": " + what);
}

Lines::Lines(std::string_view text, std::string_view file) : rest_(text), place_{file, 0} {
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  if (rest_.starts_with(kByteOrderMark)) rest_.remove_prefix(kByteOrderMark.size());
}

bool Lines::next(std::string_view& line) {
  while (!rest_.empty()) {
    const std::size_t end = std::min(rest_.find_first_of("\r\n"), rest_.size());
    line = trimmed(rest_.substr(0, end));
    rest_.remove_prefix(end);
    if (!rest_.empty()) rest_.remove_prefix(rest_.starts_with("\r\n") ? 2 : 1);
    ++place_.line;
    if (!line.empty()) return true;
  }
  return false;
}

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

void split(std::string_view line, char separator, std::vector<std::string_view>& fields) {
  fields.clear();
  const std::string_view separators = separator == ' ' ? kBlanks : std::string_view(&separator, 1);
  while (true) {
    const std::size_t end = line.find_first_of(separators);
    fields.push_back(trimmed(line.substr(0, end)));
    if (end == std::string_view::npos) return;
    line.remove_prefix(end + 1);
    if (separator == ' ') line = trimmed(line);
  }
}

Expected<double> number(std::string_view field, Place place) {
  const char* const end = field.data() + field.size();
  double value = 0;
  const auto [stop, error] = std::from_chars(field.data(), end, value);
  if (error != std::errc{} || stop != end)
    return fail_at(place, Fault::Malformed, quoted(field) + " is no number");
  if (!std::isfinite(value)) return fail_at(place, Fault::Malformed, quoted(field) + " is not finite");
  return value;
}

Expected<std::int64_t> nanoseconds(std::string_view field, int digits, Place place) {
  const Expected<double> value = number(field, place);
  if (!value) return tl::unexpected(value.error());
  if (field.find_first_of("eE") != std::string_view::npos)
    return rounded(*value * std::pow(10.0, digits), field, place);
  // Digit by digit: a double with seconds since 1970 is not precise to nanoseconds.
  const bool negative = field.front() == '-';
  std::int64_t ns = 0;
  int fraction = -1;  // number of digits after the point; -1 = no point yet
  const auto take = [&](int digit) {
    return ns <= (kLatest_ns - digit) / 10 && (ns = ns * 10 + digit, true);
  };
  for (const char c : field.substr(negative ? 1 : 0)) {
    if (c == '.') {
      fraction = 0;
    } else if (fraction < digits && is_digit(c)) {
      if (!take(c - '0')) return rounded(INFINITY, field, place);
      if (fraction >= 0) ++fraction;
    } else if (fraction == digits) {
      ns += c >= '5' ? 1 : 0;
      ++fraction;
    }
  }
  for (int missing = digits - std::max(fraction, 0); missing > 0; --missing)
    if (!take(0)) return rounded(INFINITY, field, place);
  if (ns > kLatest_ns) return rounded(INFINITY, field, place);  // rounded up from the latest
  return negative ? -ns : ns;
}

}  // namespace farshade::rows
