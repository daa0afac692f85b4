/// Weighted sums of rows of numbers, in vectors of the CPU's full width.
#pragma once

#include <span>

namespace ovws::twin {

struct WeightedRow {
  const float* first;
  float weight;
};

/// out[k] = sum over the rows of weight * first[k], for k = 0 .. count - 1. Agrees between CPUs
/// within rounding.
void weighted_sum(std::span<const WeightedRow> rows, int count, float* out);

}  // namespace ovws::twin
