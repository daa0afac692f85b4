#include "drivers/twin/weighted_sum.hpp"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "drivers/twin/weighted_sum.cpp"
#include <hwy/foreach_target.h>  // IWYU pragma: keep
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace ovws::twin::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::ScalableTag<float>;

/// Two vectors at a time, so that the CPU can overlap the additions.
void WeightedSum(const WeightedRow* rows, std::size_t row_count, int count, float* out) {
  const Floats f;
  const int lanes = int(hn::Lanes(f));
  int k = 0;
  for (; k + 2 * lanes <= count; k += 2 * lanes) {
    auto one = hn::Zero(f), two = hn::Zero(f);
    for (std::size_t r = 0; r < row_count; ++r) {
      const auto weight = hn::Set(f, rows[r].weight);
      one = hn::MulAdd(hn::LoadU(f, rows[r].first + k), weight, one);
      two = hn::MulAdd(hn::LoadU(f, rows[r].first + k + lanes), weight, two);
    }
    hn::StoreU(one, f, out + k);
    hn::StoreU(two, f, out + k + lanes);
  }
  for (; k < count; ++k) {
    float sum = 0.0F;
    for (std::size_t r = 0; r < row_count; ++r) sum += rows[r].first[k] * rows[r].weight;
    out[k] = sum;
  }
}

}  // namespace
}  // namespace ovws::twin::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace ovws::twin {

HWY_EXPORT(WeightedSum);

void weighted_sum(std::span<const WeightedRow> rows, int count, float* out) {
  HWY_DYNAMIC_DISPATCH(WeightedSum)(rows.data(), rows.size(), count, out);
}

}  // namespace ovws::twin

#endif  // HWY_ONCE
