#include "core/tracking/template_sums.hpp"

#include <array>

#include "core/base/runnable.hpp"

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

constexpr std::array kAll{plain::kKernels, avx2::kKernels, avx512::kKernels};
#else
constexpr std::array kAll{plain::kKernels};
#endif

}  // namespace

std::span<const TemplateKernels> template_kernels() {
  return std::span(kAll).first(runnable_builds());
}

}  // namespace ovws
