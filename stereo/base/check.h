/// Checks of this program's own invariants. They are active in every build and print both values.
#pragma once

#include <concepts>
#include <sstream>
#include <string>
#include <string_view>

namespace farshade {

/// The place of a call, as a default argument. It replaces std::source_location, which clang 14 lacks.
struct CallPlace {
  const char* file;
  unsigned line;
  static constexpr CallPlace current(const char* file = __builtin_FILE(), unsigned line = __builtin_LINE()) {
    return {file, line};
  }
};

/// Prints `file:line: check failed: what (detail)` and aborts.
[[noreturn]] void check_failed(std::string_view what, const std::string& detail, CallPlace where);

/// Aborts unless `holds`. `what` names the invariant.
inline void check(bool holds, std::string_view what, CallPlace where = CallPlace::current()) {
  if (!holds) [[unlikely]]
    check_failed(what, "", where);
}

/// Prints both values and aborts unless `actual == expected`.
template <class A, class B>
void check_eq(const A& actual, const B& expected, std::string_view what,
              CallPlace where = CallPlace::current()) {
  if (actual == expected) [[likely]]
    return;
  std::ostringstream detail;
  detail << "is " << actual << ", should be " << expected;
  check_failed(what, detail.str(), where);
}

/// Integer conversion that aborts instead of changing the value.
template <std::integral To, std::integral From>
constexpr To narrow(From value, CallPlace where = CallPlace::current()) {
  const To result = static_cast<To>(value);
  if (static_cast<From>(result) != value || (result < To{}) != (value < From{})) [[unlikely]]
    check_failed("narrowing keeps the value", std::to_string(value), where);
  return result;
}

}  // namespace farshade
