/// Median of a list.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace ovws {

/// Standard deviation of a normal distribution over its median absolute deviation.
constexpr double kSigmaPerMedianDeviation = 1.4826;

/// The upper one of two middle values; 0 without values.
template <class T>
T median(std::vector<T> values) {
  if (values.empty()) return T(0);
  const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace ovws
