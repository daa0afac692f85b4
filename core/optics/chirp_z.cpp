#include "core/optics/chirp_z.hpp"

#include <Eigen/Core>
#include <cmath>
#include <numbers>
#include <unsupported/Eigen/FFT>

namespace ovws {
namespace {

using Line = Eigen::ArrayXcf;

std::complex<float> unit_phasor(double turns) {
  const double angle = 2.0 * std::numbers::pi * (turns - std::round(turns));
  return {static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle))};
}

/// Next 5-smooth length: the FFT has fast butterflies for the factors 2, 3 and 5.
int fast_length(int at_least) {
  for (int n = at_least;; ++n) {
    int rest = n;
    for (const int factor : {2, 3, 5}) {
      while (rest % factor == 0) rest /= factor;
    }
    if (rest == 1) return n;
  }
}

}  // namespace

struct ChirpZ::Impl {
  Eigen::FFT<float> fft;
  int length = 0;
  Line before;  ///< chirp on the inputs
  Line kernel;  ///< spectrum of the convolving chirp, 1/length included
  Line after;   ///< chirp on the outputs
  Line padded;
  Line spectrum;
};

ChirpZ::ChirpZ(const Axis& axis) : impl_(std::make_unique<Impl>()) {
  // Bluestein: k x = (k^2 + x^2 - (k - x)^2) / 2 turns the sum into a convolution with a chirp.
  Impl& d = *impl_;
  d.length = fast_length(axis.inputs + axis.outputs - 1);
  d.before.resize(axis.inputs);
  for (int x = 0; x < axis.inputs; ++x) {
    d.before[x] = unit_phasor(-axis.first * (x - axis.centre) - 0.5 * axis.step * x * x);
  }
  d.after.resize(axis.outputs);
  for (int k = 0; k < axis.outputs; ++k) {
    d.after[k] = unit_phasor(-axis.step * (0.5 * k * k - k * axis.centre));
  }
  d.padded.setZero(d.length);
  d.spectrum.resize(d.length);
  d.kernel.resize(d.length);
  const auto chirp = [&](double m) {
    return unit_phasor(0.5 * axis.step * m * m) / static_cast<float>(d.length);
  };
  for (int k = 0; k < axis.outputs; ++k) d.padded[k] = chirp(k);
  for (int x = 1; x < axis.inputs; ++x) d.padded[d.length - x] = chirp(x);
  d.fft.impl().fwd(d.kernel.data(), d.padded.data(), d.length);
  d.padded.setZero();
}

ChirpZ::~ChirpZ() = default;
ChirpZ::ChirpZ(ChirpZ&&) noexcept = default;
ChirpZ& ChirpZ::operator=(ChirpZ&&) noexcept = default;

const std::complex<float>* ChirpZ::transform(const std::complex<float>* in) {
  Impl& d = *impl_;
  const Eigen::Index inputs = d.before.size();
  d.padded.head(inputs) = Eigen::Map<const Line>(in, inputs) * d.before;
  d.padded.tail(d.length - inputs).setZero();
  d.fft.impl().fwd(d.spectrum.data(), d.padded.data(), d.length);
  d.spectrum *= d.kernel;
  d.fft.impl().inv(d.padded.data(), d.spectrum.data(), d.length);
  d.padded.head(d.after.size()) *= d.after;
  return d.padded.data();
}

}  // namespace ovws
