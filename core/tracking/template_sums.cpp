#include "core/tracking/template_sums.hpp"

#include <array>
#include <cstddef>

namespace ovws {
namespace {

namespace plain {
#define OVWS_TARGET
#define OVWS_LANES 4
#include "core/tracking/template_sums.inc"
#undef OVWS_LANES
#undef OVWS_TARGET
constexpr TemplateKernels kKernels{"plain", moments, residuals};
}  // namespace plain

// Chosen once at run time and not by target_clones, whose resolvers run before a sanitizer is
// ready.
#ifdef __x86_64__
namespace avx2 {
#define OVWS_TARGET __attribute__((target("avx2,fma")))
#define OVWS_LANES 8
#include "core/tracking/template_sums.inc"
#undef OVWS_LANES
#undef OVWS_TARGET
constexpr TemplateKernels kKernels{"avx2", moments, residuals};
}  // namespace avx2

namespace avx512 {
#define OVWS_TARGET __attribute__((target("avx512f,fma")))
#define OVWS_LANES 16
#include "core/tracking/template_sums.inc"
#undef OVWS_LANES
#undef OVWS_TARGET
constexpr TemplateKernels kKernels{"avx512", moments, residuals};
}  // namespace avx512

std::size_t runnable() {
  if (!__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("fma")) return 1;
  return __builtin_cpu_supports("avx512f") ? 3 : 2;
}

constexpr std::array kAll{plain::kKernels, avx2::kKernels, avx512::kKernels};
#else
std::size_t runnable() {
  return 1;
}

constexpr std::array kAll{plain::kKernels};
#endif

}  // namespace

std::span<const TemplateKernels> template_kernels() {
  return std::span(kAll).first(runnable());
}

}  // namespace ovws
