#include <fmt/format.h>

#include <cstdlib>
#include <string>

#include "firn/solver.h"
#include "solver/step/kernels.h"

namespace firn {

namespace {

const Kernels* avx2_if_supported() {
#ifdef FIRN_HAS_AVX2_KERNELS
  // What -march=x86-64-v3 lets the compiler use.
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi") &&
      __builtin_cpu_supports("bmi2") && __builtin_cpu_supports("fma") &&
      __builtin_cpu_supports("popcnt"))
    return &avx2_kernels();
#endif
  return nullptr;
}

}  // namespace

const Kernels& choose_kernels() {
  const Kernels* const avx2 = avx2_if_supported();
  const char* const wish = std::getenv("FIRN_INSTRUCTIONS");
  if (!wish || !*wish) return avx2 ? *avx2 : baseline_kernels();
  const std::string name = wish;
  if (name == baseline_kernels().name) return baseline_kernels();
  if (avx2 && name == avx2->name) return *avx2;
  throw InputError(fmt::format(
      "FIRN_INSTRUCTIONS: {} is not there on this machine or in this build; expected baseline{}",
      name, avx2 ? " or avx2" : ""));
}

std::string instruction_set() { return choose_kernels().name; }

}  // namespace firn
