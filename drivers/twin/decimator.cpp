#include "drivers/twin/decimator.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "drivers/twin/weighted_sum.hpp"

namespace ovws::twin {
namespace {

constexpr int kMaxBin = 4;
/// Highest half band, in cycles per value. Filters get long towards 0.5.
constexpr double kMaxHalfBand = 0.3;
// Kaiser, "Nonrecursive digital filter design using the I0-sinh window function", 1974: the window
// for this attenuation, and the number of taps.
constexpr double kAttenuationDb = 84.0;
constexpr double kKaiserBeta = 0.1102 * (kAttenuationDb - 8.7);
constexpr double kKaiserTaps = (kAttenuationDb - 8.0) / (2.285 * 2.0 * std::numbers::pi);

double sinc(double x) {
  return x == 0.0 ? 1.0 : std::sin(std::numbers::pi * x) / (std::numbers::pi * x);
}

/// Low pass that lets frequencies up to `half_band` pass and stops those that decimation by `bin`
/// would move there: from 1 / bin - half_band on.
std::vector<float> low_pass(int bin, double half_band) {
  if (bin == 1) return {1.0F};
  const double transition = 1.0 / bin - 2.0 * half_band;
  const int reach = std::min(int(std::ceil(0.5 * kKaiserTaps / transition)), Decimator::kMaxReach);
  std::vector<float> taps;
  for (int t = -reach; t <= reach; ++t) {
    const double at = double(t) / reach;
    const double tap = sinc(double(t) / bin) *
                       std::cyl_bessel_i(0.0, kKaiserBeta * std::sqrt(1.0 - at * at)) /
                       std::cyl_bessel_i(0.0, kKaiserBeta);
    taps.push_back(t % bin == 0 && t != 0 ? 0.0F : float(tap));  // a sinc's zeros, not rounded
  }
  return taps;
}

/// Real and imaginary parts by turns: a real factor multiplies them alike.
const float* numbers(const std::complex<float>* values) {
  return reinterpret_cast<const float*>(values);
}
float* numbers(std::complex<float>* values) {
  return reinterpret_cast<float*>(values);
}

}  // namespace

Decimator::Decimator(int inputs, double half_band_cpp)
    : inputs_(inputs),
      bin_(std::clamp(int(kMaxHalfBand / half_band_cpp), 1, kMaxBin)),
      taps_(low_pass(bin_, half_band_cpp)),
      outputs_((inputs_ - 1 + 2 * reach()) / bin_ + 1) {}

void Decimator::along(const std::complex<float>* in, std::complex<float>* out) const {
  // One line for every bin_-th sample, from 2 reach() zeros before the first one on.
  const int length = outputs_ + int(taps_.size()) / bin_ + 1;
  std::vector<std::complex<float>> lines(std::size_t(length) * std::size_t(bin_));
  for (int x = 0; x < inputs_; ++x) {
    const int at = x + 2 * reach();
    lines[std::size_t(at % bin_) * std::size_t(length) + std::size_t(at / bin_)] = in[x];
  }
  std::vector<WeightedRow> rows;
  for (int t = 0; t < int(taps_.size()); ++t) {
    const float tap = taps_[std::size_t(t)];
    if (tap != 0.0F) rows.push_back({numbers(lines.data() + t % bin_ * length + t / bin_), tap});
  }
  weighted_sum(rows, 2 * outputs_, numbers(out));
}

void Decimator::down(const Image<std::complex<float>>& in, int k, std::complex<float>* out) const {
  const int first = position(k) - reach();
  const int begin = std::max(0, -first), end = std::min(int(taps_.size()), inputs_ - first);
  std::vector<WeightedRow> rows;
  for (int t = begin; t < end; ++t) {
    const float tap = taps_[std::size_t(t)];
    if (tap != 0.0F) rows.push_back({numbers(in.row(first + t)), tap});
  }
  weighted_sum(rows, 2 * in.width, numbers(out));
}

std::complex<float> Decimator::gain(double cpp) const {
  double passed = 0.0;
  for (int t = -reach(); t <= reach(); ++t) {
    passed += double(taps_[std::size_t(t + reach())]) * std::cos(2.0 * std::numbers::pi * cpp * t);
  }
  const double middle = 0.5 * (position(0) + position(outputs_ - 1));
  const double shift = middle - 0.5 * (inputs_ - 1);
  return std::complex<float>(std::polar(bin_ / passed, -2.0 * std::numbers::pi * cpp * shift));
}

}  // namespace ovws::twin
