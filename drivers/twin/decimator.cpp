#include "drivers/twin/decimator.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/base/angle.hpp"
#include "core/optics/chirp_z.hpp"

namespace ovws::twin {
namespace {

constexpr double kMaxSpacing = 4.0;
/// Least spacing that is worth a filter.
constexpr double kMinSpacing = 1.2;
/// Highest half band, in cycles per value: 0.5 would be critical sampling. Filters get long towards
/// it, FFTs get long below it.
constexpr double kMaxHalfBand = 0.365;
// Kaiser, "Nonrecursive digital filter design using the I0-sinh window function", 1974: the window
// for this attenuation, and the number of taps.
constexpr double kAttenuationDb = 84.0;
constexpr double kKaiserBeta = 0.1102 * (kAttenuationDb - 8.7);
constexpr double kKaiserTaps = (kAttenuationDb - 8.0) / (2.285 * 2.0 * std::numbers::pi);
static_assert(0.5 * kKaiserTaps * kMaxSpacing / (1.0 - 2.0 * kMaxHalfBand) < Decimator::kMaxReach);

/// Spacing of the values, which makes 1 / (step spacing) a fast FFT length.
double spacing_for(double half_band_cpp, double step_cpp) {
  const double widest = std::min(kMaxSpacing, kMaxHalfBand / half_band_cpp);
  if (widest < kMinSpacing) return 1.0;
  const double spacing =
      1.0 / (step_cpp * fast_fft_length(int(std::ceil(1.0 / (step_cpp * widest)))));
  return spacing < kMinSpacing ? 1.0 : spacing;
}

}  // namespace

Decimator::Decimator(int inputs, double half_band_cpp, double step_cpp)
    : inputs_(inputs), spacing_(spacing_for(half_band_cpp, step_cpp)), outputs_(inputs) {
  if (spacing_ > 1.0) {
    // Passes frequencies up to the half band, and stops those that the spacing would move there:
    // from 1 / spacing - half band on.
    reach_ = 0.5 * kKaiserTaps / (1.0 / spacing_ - 2.0 * half_band_cpp);
    outputs_ = 2 * int((0.5 * (inputs_ - 1) + reach_) / spacing_) + 1;
  }
  for (int k = 0; k < outputs_; ++k) {
    const double at = position(k);
    const int first = std::max(0, int(std::ceil(at - reach_)));
    const int last = std::min(inputs_ - 1, int(std::floor(at + reach_)));
    std::vector<float> taps;
    for (int x = first; x <= last; ++x) taps.push_back(float(weight(x - at)));
    taps_.append(first, taps);
  }
}

double Decimator::weight(double from_centre) const {
  if (reach_ == 0.0) return 1.0;
  const double at = std::min(1.0, std::abs(from_centre) / reach_);
  return sinc(from_centre / spacing_) *
         std::cyl_bessel_i(0.0, kKaiserBeta * std::sqrt(1.0 - at * at)) /
         std::cyl_bessel_i(0.0, kKaiserBeta);
}

void Decimator::down(const Image<std::complex<float>>& in, std::complex<float>* out) const {
  // Real and imaginary parts by turns: a real factor multiplies them alike.
  const int length = 2 * in.width;
  taps_.apply({reinterpret_cast<const float*>(in.pixels.data()), length, length},
              reinterpret_cast<float*>(out));
}

float Decimator::gain(double cpp) const {
  double passed = 0.0;
  for (int t = -int(reach_); t <= int(reach_); ++t) {
    passed += weight(t) * std::cos(2.0 * std::numbers::pi * cpp * t);
  }
  return float(spacing_ / passed);
}

}  // namespace ovws::twin
