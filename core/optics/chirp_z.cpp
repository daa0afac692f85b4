#include "core/optics/chirp_z.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <unsupported/Eigen/FFT>
#include <vector>

namespace ovws {
namespace {

/// One number of each of kLanes lines: arithmetic for all lines at once, for Eigen's FFT.
struct Lanes {
  static constexpr int kLanes = 4;
  using Vector [[gnu::vector_size(kLanes * sizeof(float))]] = float;

  Vector of_line = {};

  Lanes() = default;
  Lanes(Vector of_each) : of_line(of_each) {}
  Lanes(double of_all) : of_line(Vector{} + float(of_all)) {}

  Lanes operator-() const { return -of_line; }
  Lanes& operator+=(Lanes b) { return *this = of_line + b.of_line; }
  Lanes& operator-=(Lanes b) { return *this = of_line - b.of_line; }
  Lanes& operator*=(Lanes b) { return *this = of_line * b.of_line; }
  friend Lanes operator+(Lanes a, Lanes b) { return a += b; }
  friend Lanes operator-(Lanes a, Lanes b) { return a -= b; }
  friend Lanes operator*(Lanes a, Lanes b) { return a *= b; }
};

using Values = std::vector<std::complex<Lanes>>;

std::complex<Lanes> unit_phasor(double turns) {
  const double angle = 2.0 * std::numbers::pi * (turns - std::round(turns));
  return {std::cos(angle), std::sin(angle)};
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
  Eigen::internal::kissfft_impl<Lanes> fft;  ///< Eigen's public FFT takes only built-in numbers
  int length = 0;
  Values before;  ///< chirp on the inputs
  Values kernel;  ///< spectrum of the convolving chirp, 1/length included
  Values after;   ///< chirp on the outputs
  Values padded;
  Values spectrum;

  void load(const std::complex<float>* in, int lines);
  void convolve();
  void store(int lines, std::complex<float>* out, int stride) const;
};

ChirpZ::ChirpZ(const Axis& axis) : impl_(std::make_unique<Impl>()) {
  // Bluestein: k x = (k^2 + x^2 - (k - x)^2) / 2 turns the sum into a convolution with a chirp.
  Impl& d = *impl_;
  d.length = fast_length(axis.inputs + axis.outputs - 1);
  for (int x = 0; x < axis.inputs; ++x) {
    d.before.push_back(unit_phasor(-axis.first * (x - axis.centre) - 0.5 * axis.step * x * x));
  }
  for (int k = 0; k < axis.outputs; ++k) {
    d.after.push_back(unit_phasor(-axis.step * (0.5 * k * k - k * axis.centre)));
  }
  d.padded.resize(std::size_t(d.length));
  d.spectrum.resize(std::size_t(d.length));
  d.kernel.resize(std::size_t(d.length));
  const auto chirp = [&](double m) {
    return unit_phasor(0.5 * axis.step * m * m) * Lanes(1.0 / d.length);
  };
  for (int k = 0; k < axis.outputs; ++k) d.padded[std::size_t(k)] = chirp(k);
  for (int x = 1; x < axis.inputs; ++x) d.padded[std::size_t(d.length - x)] = chirp(x);
  d.fft.fwd(d.kernel.data(), d.padded.data(), d.length);
}

ChirpZ::~ChirpZ() = default;
ChirpZ::ChirpZ(ChirpZ&&) noexcept = default;
ChirpZ& ChirpZ::operator=(ChirpZ&&) noexcept = default;

void ChirpZ::Impl::load(const std::complex<float>* in, int lines) {
  const std::size_t inputs = before.size();
  for (std::size_t x = 0; x < inputs; ++x) {
    Lanes::Vector real{}, imaginary{};
    for (int i = 0; i < lines; ++i) {
      const std::complex<float> value = in[std::size_t(i) * inputs + x];
      real[i] = value.real();
      imaginary[i] = value.imag();
    }
    padded[x] = std::complex<Lanes>(real, imaginary) * before[x];
  }
  std::fill(padded.begin() + std::ptrdiff_t(inputs), padded.end(), std::complex<Lanes>());
}

void ChirpZ::Impl::convolve() {
  fft.fwd(spectrum.data(), padded.data(), length);
  for (std::size_t i = 0; i < spectrum.size(); ++i) spectrum[i] *= kernel[i];
  fft.inv(padded.data(), spectrum.data(), length);
}

void ChirpZ::Impl::store(int lines, std::complex<float>* out, int stride) const {
  for (std::size_t k = 0; k < after.size(); ++k) {
    const std::complex<Lanes> value = padded[k] * after[k];
    for (int i = 0; i < lines; ++i) {
      out[k * std::size_t(stride) + std::size_t(i)] = {value.real().of_line[i],
                                                       value.imag().of_line[i]};
    }
  }
}

void ChirpZ::transform(const std::complex<float>* in, int lines, std::complex<float>* out) {
  for (int first = 0; first < lines; first += Lanes::kLanes) {
    const int some = std::min(Lanes::kLanes, lines - first);
    impl_->load(in + std::size_t(first) * impl_->before.size(), some);
    impl_->convolve();
    impl_->store(some, out + first, lines);
  }
}

}  // namespace ovws
