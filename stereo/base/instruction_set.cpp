#include "stereo/base/instruction_set.h"

namespace farshade {

InstructionSet best_instruction_set() {
#if FARSHADE_CHOOSES_INSTRUCTIONS
  // The marks in the header name the same features.
  static const InstructionSet best = [] {
    const bool avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi") &&
                      __builtin_cpu_supports("bmi2") && __builtin_cpu_supports("popcnt");
    const bool avx512 = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512cd") &&
                        __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512dq") &&
                        __builtin_cpu_supports("avx512vl");
    return !avx2 ? InstructionSet::Baseline : avx512 ? InstructionSet::Avx512 : InstructionSet::Avx2;
  }();
  return best;
#else
  return InstructionSet::Baseline;
#endif
}

}  // namespace farshade
