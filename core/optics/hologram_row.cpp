#include "core/optics/hologram_row.hpp"

#include <array>

#include "core/optics/hologram_row_builds.hpp"

namespace ovws {

// Dispatched at run time; the resolvers of target_clones run before a sanitizer is initialised.
std::span<const HologramRowKernels> hologram_row_kernels() {
#ifdef __x86_64__
  static const std::array all{kPlainRow, kAvx2Row, kAvx512Row};
  static const bool has_avx2 = __builtin_cpu_supports("avx2");
  static const bool has_vbmi = has_avx2 && __builtin_cpu_supports("avx512f") &&
                               __builtin_cpu_supports("avx512bw") &&
                               __builtin_cpu_supports("avx512vbmi");
  return std::span(all).first(1 + has_avx2 + has_vbmi);
#else
  return {&kPlainRow, 1};
#endif
}

}  // namespace ovws
