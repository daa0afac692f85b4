#include "drivers/twin/pupil_field.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/complex_product.hpp"
#include "drivers/twin/in_halves.hpp"
#include "drivers/twin/turbulence.hpp"

namespace ovws::twin {
namespace {

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
  return {pixels, 0.5 * (points - 1) * step + scattered_cpp};
}

Line carrier(int count, double cpp) {
  Line phasors;
  for (int k = 0; k < count; ++k) {
    const double turns = cpp * (k - 0.5 * (count - 1));
    phasors.push_back(std::complex<float>(
        std::polar(1.0, -2.0 * std::numbers::pi * (turns - std::round(turns)))));
  }
  return phasors;
}

Line gains(const Decimator& decimator, int points, double step) {
  Line gains;
  for (int k = 0; k < points; ++k) gains.push_back(decimator.gain((k - 0.5 * (points - 1)) * step));
  return gains;
}

/// Window as seen by the values of both decimators, about the window's middle.
FarFieldWindow narrowed(const FarFieldWindow& window, const Decimator& along_x,
                        const Decimator& along_y) {
  const double step_x = along_x.bin() * window.step_cpp, step = along_y.bin() * step_y(window);
  return {window.cols,
          window.rows,
          {-0.5 * (window.cols - 1) * step_x, -0.5 * (window.rows - 1) * step},
          step_x,
          step};
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
      far_field_({along_x_.outputs(), along_y_.outputs()}, narrowed(window, along_x_, along_y_), 2),
      carrier_x_(carrier(width_, carrier_cpp_.x)),
      carrier_y_(carrier(height_, carrier_cpp_.y)),
      gain_x_(gains(along_x_, window.cols, window.step_cpp)),
      gain_y_(gains(along_y_, window.rows, step_y(window))),
      incident_(width_, height_),
      half_(along_x_.outputs(), height_),
      screened_(along_x_.outputs(), along_y_.outputs()),
      far_(window.cols, window.rows) {}

/// Columns of the SLM inside the pupil in row `y` of the square.
Columns PupilField::pupil_columns(int y) const {
  return columns_in_circle(centre_px_, diameter_px_, first_y_px_ + y, 2 * first_x_px_ + width_);
}

void PupilField::set_incident(const Image<std::complex<float>>& light) {
  in_halves(height_, [&](int first, int end, int) {
    for (int y = first; y < end; ++y) {
      const Columns pupil = pupil_columns(y);
      const std::complex<float>* const from = light.row(first_y_px_ + y) + first_x_px_;
      const std::complex<float> turn = carrier_y_[std::size_t(y)];
      for (int k = pupil.begin - first_x_px_; k < pupil.end - first_x_px_; ++k) {
        incident_.at(k, y) = product(product(from[k], turn), carrier_x_[std::size_t(k)]);
      }
    }
  });
}

void PupilField::modulate(const Image<std::uint8_t>& grey, const SlmModel::GreyPhasors& phasors,
                          Image<std::complex<float>>& light) {
  light = {along_x_.outputs(), along_y_.outputs()};
  in_halves(height_, [&](int first, int end, int) {
    Line line(carrier_x_.size());
    for (int y = first; y < end; ++y) {
      const std::uint8_t* const levels = grey.row(first_y_px_ + y) + first_x_px_;
      std::transform(incident_.row(y), incident_.row(y) + width_, levels, line.begin(),
                     [&](std::complex<float> incident, std::uint8_t level) {
                       return product(incident, phasors[level]);
                     });
      along_x_.along(line.data(), half_.row(y));
    }
  });
  in_halves(light.height, [&](int first, int end, int) {
    for (int k = first; k < end; ++k) along_y_.down(half_, k, light.row(k));
  });
}

void PupilField::add_to(Image<std::complex<float>>& far, const Image<std::complex<float>>& light,
                        const PupilScreen* screen) {
  const auto samples_behind = [&](int first, int end) {
    for (int k = first; k < end; ++k) {
      std::copy_n(light.row(k), light.width, screened_.row(k));
      screen->modulate(first_y_px_ + along_y_.position(k), first_x_px_ + along_x_.position(0),
                       along_x_.bin(), light.width, screened_.row(k));
    }
  };
  if (screen != nullptr) {
    in_halves(light.height, [&](int first, int end, int) { samples_behind(first, end); });
  }
  propagate_in_halves(far_field_, screen != nullptr ? screened_ : light, far_);
  in_halves(far.height, [&](int first, int end, int) {
    for (int r = first; r < end; ++r) {
      const std::complex<float> gain = gain_y_[std::size_t(r)];
      for (int c = 0; c < far.width; ++c) {
        far.at(c, r) += product(far_.at(c, r), product(gain, gain_x_[std::size_t(c)]));
      }
    }
  });
}

}  // namespace ovws::twin
