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

int LineFilter::end(int output) const {
  const Output& last = outputs_[std::size_t(output)];
  return last.first + int(last.weights.size());
}

void LineFilter::apply(const Lines& lines, int first, int end, float* out,
                       std::ptrdiff_t out_stride) const {
  std::vector<float> weights;
  for (int k = first; k < end; k += kSums, out += kSums * out_stride) {
    const int sums = std::min(kSums, end - k);
    const auto group = std::span(outputs_).subspan(std::size_t(k), std::size_t(sums));
    int begin_line = group.front().first, end_line = begin_line;
    for (int s = 0; s < sums; ++s) {
      begin_line = std::min(begin_line, group[std::size_t(s)].first);
      end_line = std::max(end_line, this->end(k + s));
    }
    weights.assign(std::size_t(kSums) * std::size_t(end_line - begin_line), 0.0F);
    for (int s = 0; s < sums; ++s) {
      std::size_t at = std::size_t(kSums * (group[std::size_t(s)].first - begin_line) + s);
      for (const float weight : group[std::size_t(s)].weights) {
        weights[at] = weight;
        at += kSums;
      }
    }
    HWY_DYNAMIC_DISPATCH(WeightedSums)
    ({lines.first + begin_line * lines.stride, lines.stride, lines.length, end_line - begin_line,
      weights.data()},
     {out, out_stride, sums});
  }
}

}  // namespace ovws::twin

#endif  // HWY_ONCE
