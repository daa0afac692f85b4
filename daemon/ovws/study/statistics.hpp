/// Statistics over realisations.
#pragma once

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <span>
#include <vector>

namespace ovws::study {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

/// Mean of several values and its standard error.
struct Mean {
  double value = kUnknown;
  double standard_error = 0.0;
  std::size_t count = 0;
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Mean, value, standard_error, count)

inline Mean mean_of(const std::vector<double>& values) {
  Mean mean;
  mean.count = values.size();
  if (values.empty()) return mean;
  double sum = 0.0;
  double squares = 0.0;
  for (const double value : values) sum += value;
  mean.value = sum / double(values.size());
  for (const double value : values) squares += (value - mean.value) * (value - mean.value);
  if (values.size() > 1) {
    mean.standard_error = std::sqrt(squares / double(values.size() - 1) / double(values.size()));
  }
  return mean;
}

/// Root of the mean of `squares`, with propagated standard error.
inline Mean root_of(const std::vector<double>& squares) {
  Mean mean = mean_of(squares);
  mean.value = std::sqrt(mean.value);
  if (mean.value > 0.0) mean.standard_error /= 2.0 * mean.value;
  return mean;
}

inline double root_sum_square(std::span<const double> values) {
  double squares = 0.0;
  for (const double value : values) squares += value * value;
  return std::sqrt(squares);
}

/// A number as JSON; null if it is not finite.
inline nlohmann::json number_or_null(double value) {
  return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json();
}

}  // namespace ovws::study
