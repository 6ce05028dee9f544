// Which mutation is on. scripts/mutate includes this in the files into which it puts mutations.
#pragma once

#include <cstdlib>
#include <type_traits>

/// The environment variable FARSHADE_MUTANT; 0 without it. Constants of a file that includes this may use it.
inline const int kFarshadeMutant = [] {
  const char* const number = std::getenv("FARSHADE_MUTANT");
  return number == nullptr ? 0 : std::atoi(number);
}();

inline bool farshade_mutant(int number) {
  return number == kFarshadeMutant;
}

/// For constexpr functions: the compiler computes constants without any mutation.
constexpr bool farshade_mutant_unless_constant(int number) {
  return !std::is_constant_evaluated() && farshade_mutant(number);
}
