/// Weighted sums of lines of numbers: filters and interpolation across the lines of an image.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace ovws::twin {

/// Filter whose outputs are each a weighted sum of some consecutive lines. It computes adjacent
/// outputs together (SIMD with run-time dispatch), because they share most of their lines.
class LineFilter {
 public:
  /// Appends an output: the sum of weights[n] times line first + n.
  void append(int first, std::span<const float> weights) {
    outputs_.push_back({first, {weights.begin(), weights.end()}});
  }

  /// Lines of `length` numbers, `stride` numbers from one to the next.
  struct Lines {
    const float* first;
    std::ptrdiff_t stride;
    int length;
  };
  /// Computes all outputs of `lines`; `out` receives them one after the other, `length` numbers
  /// each. Agrees between CPUs within rounding.
  void apply(const Lines& lines, float* out) const;

 private:
  struct Output {
    int first;
    std::vector<float> weights;
  };
  std::vector<Output> outputs_;
};

}  // namespace ovws::twin
