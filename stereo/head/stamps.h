/// Units of time stamps: which one a file has, told by its sample rate.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

namespace farshade {

/// The value is the power of ten of its nanoseconds.
enum class TimeUnit : std::uint8_t { Nanoseconds = 0, Microseconds = 3, Milliseconds = 6, Seconds = 9 };
inline constexpr std::array kTimeUnits{TimeUnit::Seconds, TimeUnit::Milliseconds, TimeUnit::Microseconds,
                                       TimeUnit::Nanoseconds};
/// "s", "ms", "us" or "ns".
[[nodiscard]] std::string_view to_string(TimeUnit unit);

inline constexpr double kLeastRate_hz = 1, kMostRate_hz = 10'000;

/// The median sample rate of increasing stamps in this unit, Hz. 0 if no stamp is later than its predecessor.
[[nodiscard]] double rate_hz(const std::vector<double>& stamps, TimeUnit unit);
[[nodiscard]] constexpr bool is_plausible(double rate_hz) {
  return rate_hz >= kLeastRate_hz && rate_hz <= kMostRate_hz;
}

/// The unit in which the stamps have a plausible rate. If several have: the one in which the first stamp is a
/// date from 2000 to 2100, then `usual`, then the one whose rate is nearest to 100 Hz. Empty if none has.
[[nodiscard]] std::optional<TimeUnit> unit_of(const std::vector<double>& stamps, TimeUnit usual);

}  // namespace farshade
