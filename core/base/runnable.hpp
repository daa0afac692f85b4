/// Which builds of a loop this CPU can run.
#pragma once

#include <cstddef>

namespace ovws {

/// Of the builds for any CPU, for AVX2 with FMA, and for AVX-512F, in this order, those that run.
/// Asked at run time and not by target_clones, whose resolvers run before a sanitizer is ready.
inline std::size_t runnable_builds() {
#ifdef __x86_64__
  if (!__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("fma")) return 1;
  return __builtin_cpu_supports("avx512f") ? 3 : 2;
#else
  return 1;
#endif
}

}  // namespace ovws
