#include "core/tracking/reference_shape.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace ovws {
namespace {

constexpr double kBeta = 6.0;        // Kaiser windows: ripple about 1e-3
constexpr double kTransition = 3.9;  // transition width: this / taps, cycles per pixel
constexpr double kTapsPerLambdaD = 5.0;
constexpr int kInterpolation = 6;  // taps on either side

double bessel_i0(double x) {
  double sum = 1.0, term = 1.0;
  for (int k = 1; k < 40; ++k) {
    term *= (0.5 * x / k) * (0.5 * x / k);
    sum += term;
  }
  return sum;
}

double kaiser(double x) {
  return std::abs(x) >= 1.0 ? 0.0 : bessel_i0(kBeta * std::sqrt(1.0 - x * x)) / bessel_i0(kBeta);
}

double sinc(double x) {
  const double t = std::numbers::pi * x;
  return std::abs(t) < 1e-9 ? 1.0 : std::sin(t) / t;
}

/// Windowed-sinc low-pass filter with the pass band up to 1 / (lambda/d).
std::vector<double> low_pass_taps(double lambda_d_px) {
  const int half = std::max(4, int(std::ceil(0.5 * kTapsPerLambdaD * lambda_d_px)));
  const double edge = std::min(0.5, 1.0 / lambda_d_px + 0.5 * kTransition / (2 * half + 1));
  std::vector<double> taps;
  double sum = 0.0;
  for (int k = -half; k <= half; ++k) {
    taps.push_back(sinc(2.0 * edge * k) * kaiser(k / (half + 1.0)));
    sum += taps.back();
  }
  for (double& tap : taps) tap /= sum;
  return taps;
}

struct Taps {
  int first = 0;
  std::array<double, 2 * kInterpolation> value{}, slope{};
};

/// The windowed sinc and its derivative from -kInterpolation to kInterpolation, tabulated.
class Interpolator {
 public:
  struct Tap {
    double value = 0.0, slope = 0.0;
  };

  Interpolator() {
    const auto windowed = [](double x) { return sinc(x) * kaiser(x / kInterpolation); };
    constexpr double kStep = 1.0 / kSteps;
    for (int k = 0; k <= 2 * kInterpolation * kSteps; ++k) {
      const double x = k * kStep - kInterpolation;
      taps_.push_back({windowed(x), (windowed(x + kStep) - windowed(x - kStep)) / (2.0 * kStep)});
    }
  }

  Tap at(double x) const {
    const double steps = std::clamp((x + kInterpolation) * kSteps, 0.0, double(taps_.size()) - 2.0);
    const auto k = std::size_t(steps);
    const double f = steps - double(k);
    return {taps_[k].value + f * (taps_[k + 1].value - taps_[k].value),
            taps_[k].slope + f * (taps_[k + 1].slope - taps_[k].slope)};
  }

 private:
  static constexpr int kSteps = 512;  // per pixel
  std::vector<Tap> taps_;
};

Taps taps_at(double x) {
  static const Interpolator interpolator;
  Taps taps;
  taps.first = int(std::floor(x)) - kInterpolation + 1;
  double sum = 0.0, slopes = 0.0;
  for (std::size_t k = 0; k < taps.value.size(); ++k) {
    const Interpolator::Tap tap = interpolator.at(x - (taps.first + int(k)));
    taps.value[k] = tap.value;
    taps.slope[k] = tap.slope;
    sum += tap.value;
    slopes += tap.slope;
  }
  // Normalised so that a constant is interpolated exactly and has no slope.
  for (std::size_t k = 0; k < taps.value.size(); ++k) {
    taps.slope[k] = (taps.slope[k] - taps.value[k] * slopes / sum) / sum;
  }
  for (double& tap : taps.value) tap /= sum;
  return taps;
}

}  // namespace

ReferenceShape::ReferenceShape(const SpotModel& spots, const TemplateBank& model,
                               const Image<float>& average, Vec2 position_px)
    : position_(position_px) {
  const int reach = model.columns() / 2 + kInterpolation + 2;
  left_ = int(std::lround(position_px.x)) - reach;
  top_ = int(std::lround(position_px.y)) - reach;
  side_ = 2 * reach + 1;
  low_pass(spots, average);
  normalise(model, average);
}

void ReferenceShape::low_pass(const SpotModel& spots, const Image<float>& average) {
  const std::vector<double> taps = low_pass_taps(spots.lambda_d_px);
  const int half = int(taps.size() / 2), height = side_ + 2 * half;
  std::vector<double> rows(std::size_t(height * side_));
  for (int r = 0; r < height; ++r) {
    const float* row = average.row(std::clamp(top_ - half + r, 0, average.height - 1));
    for (int c = 0; c < side_; ++c) {
      double sum = 0.0;
      for (int k = -half; k <= half; ++k) {
        sum += taps[std::size_t(k + half)] *
               double(row[std::clamp(left_ + c + k, 0, average.width - 1)]);
      }
      rows[std::size_t(r * side_ + c)] = sum;
    }
  }
  light_.resize(std::size_t(side_ * side_));
  for (int r = 0; r < side_; ++r) {
    for (int c = 0; c < side_; ++c) {
      double sum = 0.0;
      for (int k = 0; k <= 2 * half; ++k) {
        sum += taps[std::size_t(k)] * rows[std::size_t((r + k) * side_ + c)];
      }
      light_[std::size_t(r * side_ + c)] = float(sum);
    }
  }
}

/// Background and amplitude from the model at the nearest shift; to first order its offset cancels.
void ReferenceShape::normalise(const TemplateBank& model, const Image<float>& average) {
  const TemplateBank::Place place = model.place(position_);
  const TemplateView view = model.view(place, kMiddleNoise);
  std::vector<float> window(std::size_t(view.columns * view.rows));
  const float offset = average.at(std::clamp(place.x, 0, average.width - 1),
                                  std::clamp(place.y, 0, average.height - 1));
  for (int k = 0; k < view.columns * view.rows; ++k) {
    const int x = std::clamp(place.x - view.columns / 2 + k % view.columns, 0, average.width - 1);
    const int y = std::clamp(place.y - view.rows / 2 + k / view.columns, 0, average.height - 1);
    window[std::size_t(k)] = average.at(x, y) - offset;
  }
  const TemplateMoments m = template_kernels().front().moments(view, window.data());
  const auto& c = model.solver(place, kMiddleNoise).inverse;
  const auto row = [&](std::size_t i) {
    return double(c[i] * m.one + c[i + 1] * m.value + c[i + 2] * m.cx + c[i + 3] * m.cy);
  };
  background_ = row(0) + double(offset);
  const bool whole =
      std::all_of(light_.begin(), light_.end(), [](float v) { return std::isfinite(v); });
  amplitude_ = whole && std::isfinite(row(4)) ? row(4) : 0.0;
}

ShapeSample ReferenceShape::at(Vec2 from_centre) const {
  const Taps x = taps_at(position_.x + from_centre.x - left_);
  const Taps y = taps_at(position_.y + from_centre.y - top_);
  ShapeSample s;
  for (std::size_t j = 0; j < y.value.size(); ++j) {
    const int r = std::clamp(y.first + int(j), 0, side_ - 1);
    double value = 0.0, slope = 0.0;
    for (std::size_t i = 0; i < x.value.size(); ++i) {
      const int c = std::clamp(x.first + int(i), 0, side_ - 1);
      const double light = double(light_[std::size_t(r * side_ + c)]) - background_;
      value += x.value[i] * light;
      slope += x.slope[i] * light;
    }
    s.value += y.value[j] * value;
    s.dx += y.value[j] * slope;
    s.dy += y.slope[j] * value;
  }
  return {s.value / amplitude_, s.dx / amplitude_, s.dy / amplitude_};
}

std::vector<std::shared_ptr<const TemplateBank>> reference_templates(
    const SpotModel& camera_spots, const Image<float>& camera_average,
    std::span<const Vec2> reference_px) {
  const ColourPlane& lit = camera_spots.lit.plane;
  const SpotModel spots = camera_spots.on_plane();
  const Image<float> average = on_plane(camera_average, lit);
  const ModelShape shape(spots, 1.5 * matched_window(spots.charge) + 1.0);
  const TemplateBank model(spots, shape);
  std::vector<std::shared_ptr<const TemplateBank>> banks(reference_px.size());
  for (std::size_t i = 0; i < banks.size(); ++i) {
    const Vec2 at = lit.from_image(reference_px[i]);
    const bool inside =
        at.x >= 0.0 && at.y >= 0.0 && at.x <= average.width - 1.0 && at.y <= average.height - 1.0;
    if (!inside) continue;  // also rejects NaN
    const ReferenceShape own(spots, model, average, at);
    if (!own.usable()) continue;
    auto bank = std::make_shared<TemplateBank>(spots, own);
    if (bank->regular()) banks[i] = std::move(bank);
  }
  return banks;
}

}  // namespace ovws
