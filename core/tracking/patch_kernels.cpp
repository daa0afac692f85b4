#include "core/tracking/patch_kernels.hpp"

#include <array>
#include <cstdint>
#include <limits>

#include "core/base/runnable.hpp"

namespace ovws {
namespace {

namespace plain {
#define OVWS_NAME "plain"
#define OVWS_TARGET
#define OVWS_LANES 4
#include "core/tracking/patch_kernels.inc"
#undef OVWS_LANES
#undef OVWS_TARGET
#undef OVWS_NAME
}  // namespace plain

#ifdef __x86_64__
namespace avx2 {
#define OVWS_NAME "avx2"
#define OVWS_TARGET __attribute__((target("avx2,fma")))
#define OVWS_LANES 8
#include "core/tracking/patch_kernels.inc"
#undef OVWS_LANES
#undef OVWS_TARGET
#undef OVWS_NAME
}  // namespace avx2

namespace avx512 {
#define OVWS_NAME "avx512"
#define OVWS_TARGET __attribute__((target("avx512f,fma")))
#define OVWS_LANES 16
#include "core/tracking/patch_kernels.inc"
#undef OVWS_LANES
#undef OVWS_TARGET
#undef OVWS_NAME
}  // namespace avx512

constexpr std::array kAll{plain::kKernels, avx2::kKernels, avx512::kKernels};
#else
constexpr std::array kAll{plain::kKernels};
#endif

}  // namespace

std::span<const PatchKernels> all_patch_kernels() {
  return std::span(kAll).first(runnable_builds());
}

const PatchKernels& patch_kernels() {
  static const PatchKernels& fastest = all_patch_kernels().back();
  return fastest;
}

}  // namespace ovws
