#include "drivers/twin/pupil_field.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/angle.hpp"
#include "core/base/complex_product.hpp"
#include "core/optics/complex_matrices.hpp"
#include "drivers/twin/phasor_product.hpp"
#include "drivers/twin/turbulence.hpp"

namespace ovws::twin {
namespace {

constexpr int kLines = 16;  // transformed in the cache before they are added up
/// Columns of the pupil that are filtered together: as many as stay in the cache.
constexpr int kStripWidth = 96;

using Line = std::vector<std::complex<float>>;

/// Step along y, which FarFieldWindow may leave out.
double step_y(const FarFieldWindow& window) {
  return window.step_y_cpp != 0.0 ? window.step_y_cpp : window.step_cpp;
}

/// First pixel of the pupil's square along an axis of `size` pixels, of which it is in the middle.
int first_px(int size, double diameter_px) {
  return std::max(0, int(std::ceil((size - 1) / 2.0 - diameter_px / 2.0)));
}

/// Filter for one axis of the window, including what turbulence scatters into it.
Decimator decimator(int pixels, int points, double step, double diameter_px) {
  const double scattered_cpp = Turbulence::kMaxCycles / diameter_px;
  return {pixels, 0.5 * (points - 1) * step + scattered_cpp, step};
}

Line carrier(int count, double cpp) {
  Line phasors;
  for (int k = 0; k < count; ++k) {
    const double turns = cpp * (k - 0.5 * (count - 1));
    phasors.push_back(wrapped_phasor(-turns));
  }
  return phasors;
}

/// Transform from the values of a decimator to the window's frequencies about its middle.
ChirpZ transform(const Decimator& decimator, int points, double step) {
  std::vector<float> gains;
  const double first = -0.5 * (points - 1) * step;
  for (int k = 0; k < points; ++k) gains.push_back(decimator.gain(first + k * step));
  const double spacing = decimator.spacing();
  return ChirpZ({decimator.outputs(), points, spacing * first, spacing * step}, gains);
}

}  // namespace

PupilField::PupilField(const SlmGeometry& slm, double diameter_px, const FarFieldWindow& window)
    : centre_px_{(slm.width_px - 1) / 2.0, (slm.height_px - 1) / 2.0},
      diameter_px_(diameter_px),
      first_x_px_(first_px(slm.width_px, diameter_px)),
      first_y_px_(first_px(slm.height_px, diameter_px)),
      width_(slm.width_px - 2 * first_x_px_),
      height_(slm.height_px - 2 * first_y_px_),
      carrier_cpp_(window.origin_cpp + Vec2{0.5 * (window.cols - 1) * window.step_cpp,
                                            0.5 * (window.rows - 1) * step_y(window)}),
      along_x_(decimator(width_, window.cols, window.step_cpp, diameter_px)),
      along_y_(decimator(height_, window.rows, step_y(window), diameter_px)),
      to_x_(transform(along_x_, window.cols, window.step_cpp)),
      to_y_(transform(along_y_, window.rows, step_y(window))),
      carrier_x_(carrier(width_, carrier_cpp_.x)),
      carrier_y_(carrier(height_, carrier_cpp_.y)),
      incident_(std::size_t((width_ + kStripWidth - 1) / kStripWidth), {kStripWidth, height_}),
      modulated_(kStripWidth, height_),
      filtered_(kStripWidth, along_y_.outputs()),
      columns_(along_y_.outputs(), int(incident_.size()) * kStripWidth),
      screened_(along_y_.outputs(), along_x_.outputs()),
      rows_(along_x_.outputs(), window.rows) {}

/// Columns of the SLM inside the pupil in row `y` of the square.
Columns PupilField::pupil_columns(int y) const {
  return columns_in_circle(centre_px_, diameter_px_, first_y_px_ + y, 2 * first_x_px_ + width_);
}

void PupilField::set_incident(const Image<std::complex<float>>& light) {
  for (int y = 0; y < height_; ++y) {
    const Columns pupil = pupil_columns(y);
    const std::complex<float>* const from = light.row(first_y_px_ + y) + first_x_px_;
    const std::complex<float> turn = carrier_y_[std::size_t(y)];
    for (int k = pupil.begin - first_x_px_; k < pupil.end - first_x_px_; ++k) {
      incident_[std::size_t(k / kStripWidth)].at(k % kStripWidth, y) =
          product(product(from[k], turn), carrier_x_[std::size_t(k)]);
    }
  }
}

void PupilField::modulate_strip(const Image<std::uint8_t>& grey,
                                const SlmModel::GreyPhasors& phasors, int strip) {
  const Image<std::complex<float>>& incident = incident_[std::size_t(strip)];
  const int first = strip * kStripWidth, width = std::min(kStripWidth, width_ - first);
  for (int y = 0; y < height_; ++y) {
    const std::uint8_t* const levels = grey.row(first_y_px_ + y) + first_x_px_ + first;
    std::complex<float>* const row = modulated_.row(y);
    std::transform(levels, levels + width, row, [&](std::uint8_t level) { return phasors[level]; });
    multiply_each(incident.row(y), row, width, row);
  }
}

void PupilField::modulate(const Image<std::uint8_t>& grey, const SlmModel::GreyPhasors& phasors,
                          Image<std::complex<float>>& light) {
  for (int strip = 0; strip < int(incident_.size()); ++strip) {
    modulate_strip(grey, phasors, strip);
    along_y_.down(modulated_, filtered_.pixels.data());
    for (int x = 0; x < kStripWidth; ++x) {
      std::complex<float>* const column = columns_.row(strip * kStripWidth + x);
      for (int k = 0; k < filtered_.height; ++k) column[k] = filtered_.at(x, k);
    }
  }
  light.width = along_y_.outputs();
  light.height = along_x_.outputs();
  light.pixels.resize(std::size_t(light.width) * std::size_t(light.height));
  along_x_.down(columns_, light.pixels.data());
}

void PupilField::propagate(const Image<std::complex<float>>& light, const PupilScreen* screen,
                           const Image<std::complex<float>>& others,
                           Image<std::complex<float>>& sum) {
  if (screen != nullptr) {
    const auto positions = [](int first_px, const Decimator& along) {
      return PupilScreen::Positions{first_px + along.position(0), along.spacing(), along.outputs()};
    };
    const Eigen::MatrixXf waves =
        screen->waves(positions(first_x_px_, along_x_), positions(first_y_px_, along_y_));
    screened_ = light;
    multiply_by_phasors(waves.data(), int(waves.size()), screened_.pixels.data());
  }
  const Image<std::complex<float>>& seen = screen != nullptr ? screened_ : light;
  to_y_.transform(seen.pixels.data(), seen.height, rows_.pixels.data(), rows_.width);
  Image<std::complex<float>> lines(others.width, kLines);
  for (int first = 0; first < others.height; first += kLines) {
    const int count = std::min(kLines, others.height - first);
    to_x_.transform_in_order(rows_.row(first), count, lines.pixels.data());
    const std::ptrdiff_t values = std::ptrdiff_t(count) * others.width;
    using Values = Eigen::Map<const Eigen::ArrayXcf>;
    Eigen::Map<Eigen::ArrayXcf>(sum.row(first), values) =
        Values(lines.row(0), values) + Values(others.row(first), values);
  }
}

}  // namespace ovws::twin
