#include "core/optics/chirp_z.hpp"

#include <fftw3.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <new>
#include <vector>

#include "core/base/angle.hpp"
#include "core/optics/complex_matrices.hpp"

namespace ovws {
namespace {

constexpr int kLines = 4;  // transformed at once; their results are written side by side
constexpr double kMaxDirectLength = 1 << 20;
/// Relative error of a step that still counts as 1 / length: its phase errors are below rounding.
constexpr double kMaxStepError = 1e-12;

using ComplexValues = std::vector<std::complex<float>>;

/// Length of the one FFT whose frequencies are those of the axis; 0 if there is none.
int direct_length(const ChirpAxis& axis) {
  const double exact = 1.0 / axis.step;
  if (!(exact >= std::max(axis.inputs, axis.outputs)) || exact > kMaxDirectLength) return 0;
  const int length = int(std::lround(exact));
  const bool on_grid = std::abs(length * axis.step - 1.0) < kMaxStepError;
  return on_grid && fast_fft_length(length) == length ? length : 0;
}

/// FFTW makes and destroys plans in one thread at a time.
std::mutex& planner() {
  static std::mutex mutex;
  return mutex;
}

struct Release {
  void operator()(std::complex<float>* memory) const { fftwf_free(memory); }
  void operator()(fftwf_plan_s* plan) const {
    const std::lock_guard lock(planner());
    fftwf_destroy_plan(plan);
  }
};
using Plan = std::unique_ptr<fftwf_plan_s, Release>;
/// Memory that is aligned for the FFT's vectors.
using Buffer = std::unique_ptr<std::complex<float>, Release>;

Buffer make_buffer(std::size_t count) {
  void* const memory = fftwf_malloc(count * sizeof(std::complex<float>));
  if (memory == nullptr) throw std::bad_alloc();
  Buffer buffer(static_cast<std::complex<float>*>(memory));
  std::uninitialized_fill_n(buffer.get(), count, std::complex<float>());
  return buffer;
}

/// FFT of kLines lines of `length` values.
Plan make_plan(int length, std::complex<float>* from, std::complex<float>* to, int sign) {
  const std::lock_guard lock(planner());
  return Plan(fftwf_plan_many_dft(1, &length, kLines, reinterpret_cast<fftwf_complex*>(from),
                                  nullptr, 1, length, reinterpret_cast<fftwf_complex*>(to), nullptr,
                                  1, length, sign, FFTW_ESTIMATE));
}

}  // namespace

int fast_fft_length(int at_least) {
  for (int n = (at_least + 15) / 16;; ++n) {
    int rest = n;
    for (const int factor : {2, 3, 5}) {
      while (rest % factor == 0) rest /= factor;
    }
    if (rest == 1) return 16 * n;
  }
}

struct ChirpZ::Impl {
  Impl(const ChirpAxis& axis, std::span<const float> gains);
  void make_kernel(const ChirpAxis& axis);
  void load(const std::complex<float>* in, int lines);
  void convolve();
  void store(int lines, std::complex<float>* out, int stride);

  bool direct;  ///< one FFT instead of a convolution
  int length;
  ComplexValues before;  ///< phasors that multiply the inputs
  ComplexValues kernel;  ///< spectrum of the convolution's chirp, times 1/length
  ComplexValues after;   ///< phasors that multiply the outputs
  Buffer padded;         ///< lines of `length`: inputs, then zeros
  Buffer spectra;
  Buffer found;  ///< lines of `length`: outputs, then other values
  Plan forward, backward;
};

ChirpZ::Impl::Impl(const ChirpAxis& axis, std::span<const float> gains)
    : direct(direct_length(axis) > 0),
      length(direct ? direct_length(axis) : fast_fft_length(axis.inputs + axis.outputs - 1)),
      padded(make_buffer(std::size_t(kLines) * std::size_t(length))),
      spectra(make_buffer(std::size_t(kLines) * std::size_t(length))),
      found(make_buffer(std::size_t(kLines) * std::size_t(length))),
      forward(make_plan(length, padded.get(), (direct ? found : spectra).get(), FFTW_FORWARD)),
      backward(make_plan(length, spectra.get(), found.get(), FFTW_BACKWARD)) {
  // Bluestein: k x = (k^2 + x^2 - (k - x)^2) / 2 turns the sum into a convolution with a chirp.
  const double centre = 0.5 * (axis.inputs - 1), chirp = direct ? 0.0 : 0.5 * axis.step;
  for (int x = 0; x < axis.inputs; ++x) {
    before.push_back(wrapped_phasor(-axis.first * (x - centre) - chirp * x * x));
  }
  for (int k = 0; k < axis.outputs; ++k) {
    const float gain = gains.empty() ? 1.0F : gains[std::size_t(k)];
    after.push_back(gain * wrapped_phasor(axis.step * k * centre - chirp * k * k));
  }
  if (!direct) make_kernel(axis);
}

void ChirpZ::Impl::make_kernel(const ChirpAxis& axis) {
  const auto chirp = [&](double m) {
    return wrapped_phasor(0.5 * axis.step * m * m) / float(length);
  };
  for (int k = 0; k < axis.outputs; ++k) padded.get()[k] = chirp(k);
  for (int x = 1; x < axis.inputs; ++x) padded.get()[length - x] = chirp(x);
  fftwf_execute(forward.get());
  kernel.assign(spectra.get(), spectra.get() + length);
  std::fill_n(padded.get(), length, std::complex<float>());
}

void ChirpZ::Impl::load(const std::complex<float>* in, int lines) {
  const int inputs = int(before.size());
  for (int line = 0; line < lines; ++line, in += inputs) {
    multiply_each(before.data(), in, inputs, padded.get() + std::ptrdiff_t(line) * length);
  }
}

void ChirpZ::Impl::convolve() {
  fftwf_execute(forward.get());
  if (direct) return;
  for (int line = 0; line < kLines; ++line) {
    std::complex<float>* const spectrum = spectra.get() + std::ptrdiff_t(line) * length;
    multiply_each(kernel.data(), spectrum, length, spectrum);
  }
  fftwf_execute(backward.get());
}

void ChirpZ::Impl::store(int lines, std::complex<float>* out, int stride) {
  const int outputs = int(after.size());
  for (int line = 0; line < kLines; ++line) {
    std::complex<float>* const values = found.get() + std::ptrdiff_t(line) * length;
    multiply_each(after.data(), values, outputs, values);
  }
  for (int k = 0; k < outputs; ++k, out += stride) {
    for (int line = 0; line < lines; ++line) out[line] = found.get()[line * length + k];
  }
}

ChirpZ::ChirpZ(const ChirpAxis& axis, std::span<const float> gains)
    : impl_(std::make_unique<Impl>(axis, gains)) {}
ChirpZ::~ChirpZ() = default;
ChirpZ::ChirpZ(ChirpZ&&) noexcept = default;
ChirpZ& ChirpZ::operator=(ChirpZ&&) noexcept = default;

void ChirpZ::transform(const std::complex<float>* in, int lines, std::complex<float>* out,
                       int stride) {
  for (int first = 0; first < lines; first += kLines) {
    const int some = std::min(kLines, lines - first);
    impl_->load(in + std::size_t(first) * impl_->before.size(), some);
    impl_->convolve();
    impl_->store(some, out + first, stride);
  }
}

void ChirpZ::transform_in_order(const std::complex<float>* in, int lines,
                                std::complex<float>* out) {
  const ComplexValues& after = impl_->after;
  for (int first = 0; first < lines; first += kLines) {
    const int some = std::min(kLines, lines - first);
    impl_->load(in + std::size_t(first) * impl_->before.size(), some);
    impl_->convolve();
    for (int line = 0; line < some; ++line, out += after.size()) {
      multiply_each(after.data(), impl_->found.get() + std::ptrdiff_t(line) * impl_->length,
                    int(after.size()), out);
    }
  }
}

}  // namespace ovws
