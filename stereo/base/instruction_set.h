/// Instruction sets that few hot functions use where the processor has them, so that the programs run on
/// every x86-64 processor without being slower on newer ones. Embree chooses its own code in the same way.
///
/// A function that is marked FARSHADE_AVX2 or FARSHADE_AVX512 is compiled for that set, together with the
/// functions that it calls and that the compiler can see. It may be called only if best_instruction_set() is
/// that set or a later one. Its results have the same bits as without the mark: vector instructions round as
/// scalar ones do, and the option -ffp-contract=off keeps the compiler from fusing a product and a sum.
///
/// The marks are empty where the whole program is compiled for AVX2 (FARSHADE_NATIVE), because a function
/// for a smaller set cannot contain one for a larger set. They are also empty on other architectures.
#pragma once

#include <cstdint>

#if defined(__x86_64__) && !defined(__AVX2__)
#define FARSHADE_CHOOSES_INSTRUCTIONS 1
#define FARSHADE_AVX2 __attribute__((target("avx2,bmi,bmi2,popcnt"), flatten))
#define FARSHADE_AVX512 \
  __attribute__((target("avx2,bmi,bmi2,popcnt,avx512f,avx512cd,avx512bw,avx512dq,avx512vl"), flatten))
#else
#define FARSHADE_CHOOSES_INSTRUCTIONS 0
#define FARSHADE_AVX2
#define FARSHADE_AVX512
#endif

namespace farshade {

/// Each one contains those before it. Baseline: what the compiler's options allow.
enum class InstructionSet : std::uint8_t { Baseline, Avx2, Avx512 };

/// The largest set that this processor and this program have.
[[nodiscard]] InstructionSet best_instruction_set();

}  // namespace farshade
