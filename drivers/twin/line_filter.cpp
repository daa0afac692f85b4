#include "drivers/twin/line_filter.hpp"

#include <algorithm>
#include <array>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "drivers/twin/line_filter.cpp"
#include <hwy/foreach_target.h>  // IWYU pragma: keep
#include <hwy/highway.h>

#ifndef OVWS_LINE_FILTER_JOB  // once for all instruction sets
#define OVWS_LINE_FILTER_JOB

namespace ovws::twin {
namespace {

constexpr int kSums = 4;  // computed at once

struct WeightedLines {
  const float* first;
  std::ptrdiff_t stride;
  int length, count;
  const float* weights;  // kSums of each line
};

struct Sums {
  float* first;
  std::ptrdiff_t stride;
  int count;  // at most kSums; the others are not stored
};

}  // namespace
}  // namespace ovws::twin

#endif

HWY_BEFORE_NAMESPACE();
namespace ovws::twin::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::ScalableTag<float>;

/// Computes kVectors vectors of each sum, from number `at` on. Independent sums keep the CPU's
/// multipliers busy.
template <int kVectors, class F>
void SumBlock(F f, const WeightedLines& lines, int at, const Sums& out) {
  const std::size_t lanes = hn::Lanes(f);
  std::array<std::array<hn::Vec<F>, kVectors>, kSums> sum;
  for (auto& vectors : sum) vectors.fill(hn::Zero(f));
  const float *line = lines.first + at, *weights = lines.weights;
  for (int n = 0; n < lines.count; ++n, line += lines.stride, weights += kSums) {
    std::array<hn::Vec<F>, kVectors> numbers;
#pragma GCC unroll 2  // keeps the sums in registers
    for (int v = 0; v < kVectors; ++v) numbers[v] = hn::LoadU(f, line + v * lanes);
#pragma GCC unroll 4
    for (int s = 0; s < kSums; ++s) {
      const auto weight = hn::Set(f, weights[s]);
#pragma GCC unroll 2
      for (int v = 0; v < kVectors; ++v) sum[s][v] = hn::MulAdd(numbers[v], weight, sum[s][v]);
    }
  }
#pragma GCC unroll 4
  for (int s = 0; s < kSums; ++s) {
    if (s >= out.count) break;
#pragma GCC unroll 2
    for (int v = 0; v < kVectors; ++v) {
      hn::StoreU(sum[s][v], f, out.first + s * out.stride + at + v * lanes);
    }
  }
}

void WeightedSums(const WeightedLines& lines, const Sums& out) {
  const Floats f;
  const hn::CappedTag<float, 1> one;
  const int lanes = int(hn::Lanes(f)), length = lines.length;
  int k = 0;
  for (; k + 2 * lanes <= length; k += 2 * lanes) SumBlock<2>(f, lines, k, out);
  for (; k < length && length >= lanes; k += lanes) {
    k = std::min(k, length - lanes);  // the last block overlaps the previous one
    SumBlock<1>(f, lines, k, out);
  }
  for (; k < length; ++k) SumBlock<1>(one, lines, k, out);
}

}  // namespace
}  // namespace ovws::twin::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace ovws::twin {

HWY_EXPORT(WeightedSums);

void LineFilter::apply(const Lines& lines, float* out) const {
  std::vector<float> weights;
  for (std::size_t first = 0; first < outputs_.size(); first += kSums) {
    const auto group =
        std::span(outputs_).subspan(first, std::min<std::size_t>(kSums, outputs_.size() - first));
    int begin = group.front().first, end = begin;  // lines that the group depends on
    for (const Output& output : group) {
      begin = std::min(begin, output.first);
      end = std::max(end, output.first + int(output.weights.size()));
    }
    weights.assign(std::size_t(kSums) * std::size_t(end - begin), 0.0F);
    for (std::size_t s = 0; s < group.size(); ++s) {
      std::size_t at = kSums * std::size_t(group[s].first - begin) + s;
      for (const float weight : group[s].weights) {
        weights[at] = weight;
        at += kSums;
      }
    }
    HWY_DYNAMIC_DISPATCH(WeightedSums)
    ({lines.first + begin * lines.stride, lines.stride, lines.length, end - begin, weights.data()},
     {out + std::ptrdiff_t(first) * lines.length, lines.length, int(group.size())});
  }
}

}  // namespace ovws::twin

#endif  // HWY_ONCE
