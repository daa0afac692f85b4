/// Run-time CPU dispatch: which SIMD builds of a loop this CPU can run.
#pragma once

#include <cstddef>

namespace ovws {

/// Number of SIMD builds that the CPU can run: 1 baseline, 2 also AVX2 with FMA, 3 also AVX-512F.
/// GCC's target_clones is not used because its resolvers run before a sanitizer is initialised.
inline std::size_t runnable_builds() {
#ifdef __x86_64__
  if (!__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("fma")) return 1;
  return __builtin_cpu_supports("avx512f") ? 3 : 2;
#else
  return 1;
#endif
}

}  // namespace ovws
