#include "core/wavefront/refine_system.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace ovws {
namespace {

constexpr double kMinVariance = 0.25;  // electrons^2: lower limit, so that no weight is unbounded
constexpr int kAverageHalf = 2;  // pixels to either side; the stray light's speckles are 2 wide
constexpr Eigen::Index kChunk = 256;  // rows summed in single precision

PixelBox box_about(Vec2 at, int half, int cols, int rows) {
  const auto clipped = [](double v, int size) { return int(std::clamp(v, 0.0, double(size))); };
  const int left = clipped(std::round(at.x) - half, cols);
  const int top = clipped(std::round(at.y) - half, rows);
  return {left, top, clipped(std::round(at.x) + half + 1, cols) - left,
          clipped(std::round(at.y) + half + 1, rows) - top};
}

std::vector<float> averaged(const Image<float>& image) {
  const auto pass = [](const float* in, float* out, int count, std::ptrdiff_t stride) {
    for (int k = 0; k < count; ++k) {
      float sum = 0.0F;
      for (int d = -kAverageHalf; d <= kAverageHalf; ++d) {
        sum += in[std::clamp(k + d, 0, count - 1) * stride];
      }
      out[k * stride] = sum / float(2 * kAverageHalf + 1);
    }
  };
  std::vector<float> rows(image.pixels.size()), both(image.pixels.size());
  for (int y = 0; y < image.height; ++y) {
    pass(image.row(y), rows.data() + std::ptrdiff_t(y) * image.width, image.width, 1);
  }
  for (int x = 0; x < image.width; ++x) {
    pass(rows.data() + x, both.data() + x, image.height, image.width);
  }
  return both;
}

}  // namespace

RefineSystem::RefineSystem(SensorField field, std::vector<int> modes_j, int box_half_px)
    : field_(std::move(field)),
      moments_(field_, modes_j),
      modes_j_(std::move(modes_j)),
      box_half_px_(box_half_px),
      index_(field_.window().cols, field_.window().rows, -1) {}

void RefineSystem::set_image(const Image<float>& electrons, double read_noise_e) {
  image_ = electrons;
  noise_variance_ = std::max(kMinVariance, read_noise_e * read_noise_e);
}

std::vector<Mode> RefineSystem::modes_of(const RefineState& state) const {
  std::vector<Mode> modes;
  for (std::size_t k = 0; k < modes_j_.size(); ++k) {
    modes.push_back({modes_j_[k], state.waves(Eigen::Index(k))});
  }
  return modes;
}

void RefineSystem::propagate(const RefineState& state) {
  field_.propagate(modes_of(state), {.amplitudes = state.amplitudes});
}

void RefineSystem::model_outside() {
  field_.set_outside(true);
  stray_.clear();
}

void RefineSystem::treat_outside_as_noise(const RefineState& state) {
  field_.set_outside(true);
  propagate(state);
  const Image<std::complex<float>> all = field_.far();
  field_.set_outside(false);
  propagate(state);
  const Image<std::complex<float>>& inside = field_.far();
  Image<float> outside(all.width, all.height);
  for (std::size_t k = 0; k < all.pixels.size(); ++k) {
    outside.pixels[k] = std::norm(all.pixels[k] - inside.pixels[k]);
  }
  stray_ = averaged(outside);
}

RefineSystem::Expected RefineSystem::expected(const RefineState& state, std::size_t pixel) const {
  const double own = state.scale_e * double(std::norm(field_.far().pixels[pixel]));
  const double stray = stray_.empty() ? 0.0 : state.scale_e * double(stray_[pixel]);
  const double light = own + stray + state.background_e;
  // Variance of own + stray + 2 sqrt(own stray) cos(phase) for a random phase and an exponentially
  // distributed stray intensity (speckle).
  return {light, std::max(0.0, light) + noise_variance_ + 2.0 * own * stray + stray * stray};
}

PixelBox RefineSystem::box_of(int piece, std::span<const Mode> modes) const {
  const FarFieldWindow& w = field_.window();
  return box_about(moments_.falls_px(std::size_t(piece), modes), box_half_px_, w.cols, w.rows);
}

bool RefineSystem::has_used_pixels(const PixelBox& box) const {
  for (int y = box.y; y < box.y + box.height; ++y) {
    const int* row = index_.row(y) + box.x;
    if (std::any_of(row, row + box.width, [](int number) { return number >= 0; })) return true;
  }
  return false;
}

void RefineSystem::choose_pixels(const RefineState& state) {
  const std::vector<Mode> modes = modes_of(state);
  std::fill(index_.pixels.begin(), index_.pixels.end(), -1);
  for (int i = 0; i < field_.subapertures(); ++i) {
    const PixelBox box = box_of(i, modes);
    for (int y = box.y; y < box.y + box.height; ++y) {
      std::fill_n(index_.row(y) + box.x, box.width, 0);
    }
  }
  pixels_.clear();
  for (std::size_t k = 0; k < index_.pixels.size(); ++k) {
    if (index_.pixels[k] < 0) continue;
    index_.pixels[k] = int(pixels_.size());
    pixels_.push_back(k);
  }
}

void RefineSystem::fit_scale_and_background(RefineState& state) {
  choose_pixels(state);
  double n = 0.0, x = 0.0, y = 0.0, xx = 0.0, xy = 0.0;
  for (const std::size_t k : pixels_) {
    const double light = double(std::norm(field_.far().pixels[k])),
                 measured = double(image_.pixels[k]);
    if (std::isnan(measured)) continue;
    n += 1.0, x += light, y += measured, xx += light * light, xy += light * measured;
  }
  state.scale_e = (n * xy - x * y) / (n * xx - x * x);
  state.background_e = (y - state.scale_e * x) / n;
}

void RefineSystem::add_piece(const RefineState& state, int piece, const PixelBox& box) {
  const Eigen::MatrixXcf& moments = moments_.at(piece, box);
  piece_.resize(moments.rows(), moments.cols());
  const auto modes = Eigen::Index(modes_j_.size());
  const auto change = float(-4.0 * std::numbers::pi * state.scale_e);  // 2 Re(2 pi i conj(F) M)
  for (int y = 0; y < box.height; ++y) {
    const Eigen::Map<const Eigen::ArrayXcf> far(field_.far().row(box.y + y) + box.x, box.width);
    const Eigen::ArrayXf re = far.real(), im = far.imag();
    for (Eigen::Index k = 0; k < moments.cols(); ++k) {
      const auto m = moments.col(k).segment(Eigen::Index(y) * box.width, box.width).array();
      piece_.col(k).segment(Eigen::Index(y) * box.width, box.width) =
          change * (re * m.imag() - im * m.real());
    }
  }
  piece_modes_.noalias() = piece_ * moments_.modes_over(piece).transpose();
  const bool own = piece < int(state.amplitudes.size());
  for (int y = 0; y < box.height; ++y) {
    const int* number = index_.row(box.y + y) + box.x;
    const std::complex<float>* far = field_.far().row(box.y + y) + box.x;
    for (int x = 0; x < box.width; ++x) {
      if (number[x] < 0) continue;
      const Eigen::Index row = Eigen::Index(y) * box.width + x;
      columns_.row(number[x]).head(modes) += piece_modes_.row(row);
      if (!own) continue;
      const std::complex<float> m = moments(row, 0);
      columns_(number[x], modes + 2 + piece) =
          2.0F * float(state.scale_e) * (far[x].real() * m.real() + far[x].imag() * m.imag());
    }
  }
}

void RefineSystem::fill_columns(const RefineState& state) {
  const auto count = Eigen::Index(modes_j_.size());
  columns_.setZero(Eigen::Index(pixels_.size()), count + 2 + Eigen::Index(state.amplitudes.size()));
  const std::vector<Mode> modes = modes_of(state);
  const int last = field_.outside() ? int(field_.cells().pieces.size()) : field_.subapertures();
  for (int piece = 0; piece < last; ++piece) {
    const PixelBox box = box_of(piece, modes);
    if (!has_used_pixels(box)) continue;
    moments_.load(field_, modes, {&piece, 1});
    add_piece(state, piece, box);
  }
  for (std::size_t p = 0; p < pixels_.size(); ++p) {
    columns_(p, count) = float(state.scale_e) * std::norm(field_.far().pixels[pixels_[p]]);
    columns_(p, count + 1) = 1.0F;
  }
}

RefineSums RefineSystem::linearise(const RefineState& state) {
  choose_pixels(state);
  fill_columns(state);
  RefineSums sums;
  sums.fisher = Eigen::MatrixXd::Zero(columns_.cols(), columns_.cols());
  sums.gradient = Eigen::VectorXd::Zero(columns_.cols());
  weights_.resize(pixels_.size());
  Eigen::VectorXf residual(columns_.rows());
  for (std::size_t p = 0; p < pixels_.size(); ++p) {
    const std::size_t k = pixels_[p];
    const Expected e = expected(state, k);
    const double measured = double(image_.pixels[k]);
    const bool used = !std::isnan(measured);
    weights_[p] = used ? float(1.0 / std::sqrt(e.variance)) : 0.0F;
    residual(p) = used ? weights_[p] * float(measured - e.light) : 0.0F;
    if (!used) continue;
    sums.chi2 += double(residual(p)) * double(residual(p));
    sums.deviance += double(residual(p)) * double(residual(p)) + std::log(e.variance);
    ++sums.pixels;
  }
  Rows chunk;
  for (Eigen::Index from = 0; from < columns_.rows(); from += kChunk) {
    const Eigen::Index count = std::min(kChunk, columns_.rows() - from);
    const Eigen::Map<const Eigen::VectorXf> root(weights_.data() + from, count);
    chunk = root.asDiagonal() * columns_.middleRows(from, count);
    const Eigen::MatrixXf squares = chunk.transpose() * chunk;
    const Eigen::VectorXf gradient = chunk.transpose() * residual.segment(from, count);
    sums.fisher += squares.cast<double>();
    sums.gradient += gradient.cast<double>();
  }
  return sums;
}

double RefineSystem::brightest() const {
  float brightest_value = 0.0F;
  for (const std::size_t k : pixels_)
    brightest_value = std::max(brightest_value, std::norm(field_.far().pixels[k]));
  return double(brightest_value);
}

double RefineSystem::misfit(const RefineState& state) const {
  double sum = 0.0;
  for (std::size_t p = 0; p < pixels_.size(); ++p) {
    if (weights_[p] == 0.0F) continue;
    const std::size_t k = pixels_[p];
    const double off = double(weights_[p]) * (double(image_.pixels[k]) - expected(state, k).light);
    sum += off * off;
  }
  return sum;
}

}  // namespace ovws
