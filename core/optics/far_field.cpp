#include "core/optics/far_field.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <numbers>
#include <unsupported/Eigen/FFT>
#include <vector>

namespace ovws {
namespace {

/// SIMD scalar for Eigen's FFT: holds one number of each of kLanes lines, so that one FFT
/// transforms all lines at once.
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

/// The numbers at two places: real part, imaginary part, real part, imaginary part.
Lanes::Vector pair(const std::complex<float>* a, const std::complex<float>* b) {
  const Lanes::Vector both = {a->real(), a->imag(), b->real(), b->imag()};
  return both;
}

std::complex<Lanes> unit_phasor(double turns) {
  const double angle = 2.0 * std::numbers::pi * (turns - std::round(turns));
  return {std::cos(angle), std::sin(angle)};
}

/// Smallest 5-smooth FFT length >= `at_least`, because the FFT is fast for factors 2, 3 and 5.
int fast_length(int at_least) {
  for (int n = at_least;; ++n) {
    int rest = n;
    for (const int factor : {2, 3, 5}) {
      while (rest % factor == 0) rest /= factor;
    }
    if (rest == 1) return n;
  }
}

/// Sampling of one axis: number of input samples, and the output frequencies first + k step in
/// cycles per sample.
struct Axis {
  int inputs = 0;
  int outputs = 0;
  double first = 0.0;
  double step = 0.0;
};

/// Chirp-z transform (Bluestein): Fourier sums at any equally spaced frequencies, by two FFTs a
/// line. Transforms four lines at a time, one in each SIMD lane. Works in single precision with
/// chirps computed in double. For one thread at a time.
class ChirpZ {
 public:
  explicit ChirpZ(const Axis& axis);

  /// out[k stride + line] = sum over x of in[x] exp(-2 pi i (first + k step) (x - centre)), where
  /// centre = (axis.inputs - 1) / 2. `in`: `lines` rows of axis.inputs values.
  void transform(const std::complex<float>* in, int lines, std::complex<float>* out, int stride);

 private:
  void load(const std::complex<float>* in, int lines);
  void convolve();
  void store(int lines, std::complex<float>* out, int stride) const;

  Eigen::internal::kissfft_impl<Lanes> fft_;  ///< internal class: Eigen's public FFT rejects Lanes
  int length_;
  Values before_;  ///< chirp that multiplies the inputs
  Values kernel_;  ///< spectrum of the convolution's chirp, times 1/length
  Values after_;   ///< chirp that multiplies the outputs
  Values padded_;
  Values spectrum_;
};

ChirpZ::ChirpZ(const Axis& axis)
    : length_(fast_length(axis.inputs + axis.outputs - 1)),
      kernel_(std::size_t(length_)),
      padded_(std::size_t(length_)),
      spectrum_(std::size_t(length_)) {
  // Bluestein: k x = (k^2 + x^2 - (k - x)^2) / 2 turns the sum into a convolution with a chirp.
  const double centre = 0.5 * (axis.inputs - 1);
  for (int x = 0; x < axis.inputs; ++x) {
    before_.push_back(unit_phasor(-axis.first * (x - centre) - 0.5 * axis.step * x * x));
  }
  for (int k = 0; k < axis.outputs; ++k) {
    after_.push_back(unit_phasor(-axis.step * (0.5 * k * k - k * centre)));
  }
  const auto chirp = [&](double m) {
    return unit_phasor(0.5 * axis.step * m * m) * Lanes(1.0 / length_);
  };
  for (int k = 0; k < axis.outputs; ++k) padded_[std::size_t(k)] = chirp(k);
  for (int x = 1; x < axis.inputs; ++x) padded_[std::size_t(length_ - x)] = chirp(x);
  fft_.fwd(kernel_.data(), padded_.data(), length_);
}

void ChirpZ::load(const std::complex<float>* in, int lines) {
  const std::size_t inputs = before_.size();
  // In place of a missing line, the last one is transformed again.
  std::array<const std::complex<float>*, Lanes::kLanes> line{};
  for (int i = 0; i < Lanes::kLanes; ++i) {
    line[std::size_t(i)] = in + std::size_t(std::min(i, lines - 1)) * inputs;
  }
  for (std::size_t x = 0; x < inputs; ++x) {
    const Lanes::Vector one = pair(line[0] + x, line[1] + x), two = pair(line[2] + x, line[3] + x);
    padded_[x] = std::complex<Lanes>(__builtin_shufflevector(one, two, 0, 2, 4, 6),
                                     __builtin_shufflevector(one, two, 1, 3, 5, 7)) *
                 before_[x];
  }
  std::fill(padded_.begin() + std::ptrdiff_t(inputs), padded_.end(), std::complex<Lanes>());
}

void ChirpZ::convolve() {
  fft_.fwd(spectrum_.data(), padded_.data(), length_);
  for (std::size_t i = 0; i < spectrum_.size(); ++i) spectrum_[i] *= kernel_[i];
  fft_.inv(padded_.data(), spectrum_.data(), length_);
}

void ChirpZ::store(int lines, std::complex<float>* out, int stride) const {
  for (std::size_t k = 0; k < after_.size(); ++k) {
    const std::complex<Lanes> value = padded_[k] * after_[k];
    const Lanes::Vector real = value.real().of_line, imaginary = value.imag().of_line;
    const auto of_lines = std::bit_cast<std::array<std::complex<float>, Lanes::kLanes>>(
        std::array<Lanes::Vector, 2>{__builtin_shufflevector(real, imaginary, 0, 4, 1, 5),
                                     __builtin_shufflevector(real, imaginary, 2, 6, 3, 7)});
    std::complex<float>* to = out + k * std::size_t(stride);
    if (lines == Lanes::kLanes) {
      std::copy_n(of_lines.data(), Lanes::kLanes, to);
    } else {
      std::copy_n(of_lines.data(), lines, to);
    }
  }
}

void ChirpZ::transform(const std::complex<float>* in, int lines, std::complex<float>* out,
                       int stride) {
  for (int first = 0; first < lines; first += Lanes::kLanes) {
    const int some = std::min(Lanes::kLanes, lines - first);
    load(in + std::size_t(first) * before_.size(), some);
    convolve();
    store(some, out + first, stride);
  }
}

}  // namespace

FarFieldWindow far_field_window(const SensorConfig& sensor, const SlmGeometry& slm,
                                const OpticsConfig& optics, int image_cols, int image_rows) {
  const double step = 1.0 / camera_px_per_cycle(optics, slm);
  const Vec2 base_cpp{sensor.grooves[0] / slm.width_px, sensor.grooves[1] / slm.height_px};
  const Vec2 base_px = base_spot_px(optics, image_cols, image_rows);
  return {image_cols, image_rows, base_cpp - step * base_px, step};
}

struct FarField::Impl {
  struct Passes {
    ChirpZ along_x, along_y;
  };
  SlmGeometry slm;
  FarFieldWindow window;
  std::vector<Passes> of_worker;
  Image<std::complex<float>> columns;  ///< field after the x pass, transposed
};

FarField::FarField(SlmGeometry slm, FarFieldWindow window, int workers) {
  assert(slm.width_px > 0 && slm.height_px > 0 && window.cols > 0 && window.rows > 0);
  const double step_y = window.step_y_cpp != 0.0 ? window.step_y_cpp : window.step_cpp;
  const Impl::Passes passes{
      ChirpZ({slm.width_px, window.cols, window.origin_cpp.x, window.step_cpp}),
      ChirpZ({slm.height_px, window.rows, window.origin_cpp.y, step_y})};
  impl_ = std::make_unique<Impl>(
      Impl{slm, window, std::vector(std::size_t(workers), passes), {slm.height_px, window.cols}});
}

FarField::~FarField() = default;
FarField::FarField(FarField&&) noexcept = default;
FarField& FarField::operator=(FarField&&) noexcept = default;

void FarField::propagate(const Image<std::complex<float>>& field, Image<std::complex<float>>& out) {
  out.width = impl_->window.cols;
  out.height = impl_->window.rows;
  out.pixels.resize(std::size_t(out.width) * out.height);
  // Transform along x first: this pass needs only one transform per SLM row.
  transform_rows(field, 0, field.height, 0);
  transform_columns(0, out.width, 0, out);
}

void FarField::transform_rows(const Image<std::complex<float>>& field, int first, int end,
                              int worker) {
  Impl& d = *impl_;
  assert(field.width == d.slm.width_px && field.height == d.slm.height_px);
  d.of_worker[std::size_t(worker)].along_x.transform(
      field.row(first), end - first, d.columns.pixels.data() + first, d.columns.width);
}

void FarField::transform_columns(int first, int end, int worker, Image<std::complex<float>>& out) {
  Impl& d = *impl_;
  assert(out.width == d.window.cols && out.height == d.window.rows);
  d.of_worker[std::size_t(worker)].along_y.transform(d.columns.row(first), end - first,
                                                     out.pixels.data() + first, out.width);
}

}  // namespace ovws
