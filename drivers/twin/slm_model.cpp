#include "drivers/twin/slm_model.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "core/base/angle.hpp"
#include "core/base/complex_product.hpp"
#include "core/optics/circle_columns.hpp"
#include "core/optics/phasors.hpp"
#include "core/optics/wavefront_rows.hpp"
#include "drivers/twin/phasor_product.hpp"
#include "drivers/twin/pupil_screen.hpp"

namespace ovws::twin {

double slm_phase_waves(const SlmConfig& slm, int grey) {
  return slm.depth_waves * std::pow(grey / 256.0, slm.gamma);
}

namespace {

constexpr int kLevelOn = 128;  // the least grey level that turns a mirror on

std::complex<float> phasor(double waves) {
  const double angle = kTwoPi * (waves - std::floor(waves));
  return {float(std::cos(angle)), float(std::sin(angle))};
}

std::array<std::complex<float>, 256> make_lut(const Config& config) {
  std::array<std::complex<float>, 256> lut;
  if (config.modulator == Modulator::dmd) {
    std::fill(lut.begin(), lut.begin() + kLevelOn, 0.0F);
    std::fill(lut.begin() + kLevelOn, lut.end(), 1.0F);
    return lut;
  }
  for (std::size_t g = 0; g < lut.size(); ++g) {
    lut[g] = phasor(slm_phase_waves(config.slm, int(g)));
  }
  return lut;
}

/// Flatness error in waves: a sum of eight long cosine waves in random directions, as smooth as the
/// bend of a real SLM's glass.
Image<float> make_surface(const SlmConfig& slm) {
  constexpr int kWaves = 8;
  constexpr double kMinCycles = 0.5;
  Image<float> surface(slm.geometry.width_px, slm.geometry.height_px);
  std::mt19937_64 random{std::uint64_t(slm.flatness_seed)};
  const auto uniform = [&random] { return double(random() >> 11) * 0x1.0p-53; };
  // The sum of kWaves cosines of amplitude a has the RMS a sqrt(kWaves / 2).
  const double amplitude = slm.flatness_rms_waves * std::sqrt(2.0 / kWaves);
  for (int k = 0; k < kWaves; ++k) {
    const double direction = kTwoPi * uniform(), start = uniform();
    const double cycles =
        (kMinCycles + (slm.flatness_cycles - kMinCycles) * uniform()) / surface.height;
    const double fx = cycles * std::cos(direction), fy = cycles * std::sin(direction);
    for (int y = 0; y < surface.height; ++y) {
      float* row = surface.row(y);
      for (int x = 0; x < surface.width; ++x) {
        row[x] += float(amplitude * std::cos(kTwoPi * (fx * x + fy * y + start)));
      }
    }
  }
  return surface;
}

Image<float> make_gaussian_beam(const SlmGeometry& slm, double diameter_px) {
  Image<float> amplitude(slm.width_px, slm.height_px);
  // At half the diameter the intensity falls to 1/e^2, so the amplitude falls to 1/e.
  const double radius2 = diameter_px * diameter_px / 4.0;
  for (int y = 0; y < slm.height_px; ++y) {
    const double dy = y - (slm.height_px - 1) / 2.0;
    for (int x = 0; x < slm.width_px; ++x) {
      const double dx = x - (slm.width_px - 1) / 2.0;
      amplitude.at(x, y) = float(std::exp(-(dx * dx + dy * dy) / radius2));
    }
  }
  return amplitude;
}

void dim(Image<std::complex<float>>& field, const Shade& shade) {
  const auto amplitude = float(std::sqrt(shade.transmission));
  for (int y = 0; y < field.height; ++y) {
    const Columns behind =
        columns_in_circle(shade.centre_px, 2.0 * shade.radius_px, y, field.width);
    std::complex<float>* row = field.row(y);
    for (int x = behind.begin; x < behind.end; ++x) row[x] *= amplitude;
  }
}

/// Multiplies the field by a vortex, whose amplitude rises linearly from 0 within its core.
void twist(Image<std::complex<float>>& field, const LightVortex& vortex, double radius_px) {
  const Vec2 centre = Vec2{(field.width - 1) / 2.0, (field.height - 1) / 2.0};
  for (int y = 0; y < field.height; ++y) {
    std::complex<float>* row = field.row(y);
    for (int x = 0; x < field.width; ++x) {
      row[x] *= field_about(vortex, (1.0 / radius_px) * (Vec2{double(x), double(y)} - centre));
    }
  }
}

}  // namespace

SlmModel::SlmModel(const Config& config)
    : config_(config),
      phasor_of_grey_(make_lut(config)),
      incident_(config.slm.geometry.width_px, config.slm.geometry.height_px) {
  if (config.slm.flatness_rms_waves > 0.0) surface_waves_ = make_surface(config.slm);
  if (config.light.shape == LightShape::gaussian) {
    amplitude_ = make_gaussian_beam(config.slm.geometry, config.light.diameter_px);
  }
  const SlmGeometry& slm = config.slm.geometry;
  if (config.mirror) {
    mirror_.emplace(*config.mirror, pupil_line(slm.width_px), pupil_line(slm.height_px));
  }
  set_light(config.truth);
}

PupilLine SlmModel::pupil_line(int pixels) const {
  const double step = 2.0 / config_.sensor.pupil_diameter_px;
  return {-(pixels - 1) / 2.0 * step, step, pixels};
}

void SlmModel::set_screen(const std::optional<ScintillationConfig>& scintillation) {
  if (scintillation == scintillation_) return;
  scintillation_ = scintillation;
  screen_.resize(0, 0);
  if (!scintillation) return;
  screen_ =
      amplitude_screen(*scintillation, pupil_line(incident_.width), pupil_line(incident_.height));
}

void SlmModel::set_light(const Light& light) {
  set_screen(light.scintillation);
  const Eigen::MatrixXf mirror = mirror_ ? mirror_->waves(light.mirror_waves) : Eigen::MatrixXf();
  const int width = incident_.width, height = incident_.height;
  const Vec2 centre{(width - 1) / 2.0, (height - 1) / 2.0};
  const double diameter = config_.sensor.pupil_diameter_px;
  const WavefrontRows wavefront(light.aberration, centre, diameter);
  const std::vector<std::complex<float>>& phasors = unit_phasors();
  std::vector<double> waves(std::size_t(width), 0.0);
  for (int y = 0; y < height; ++y) {
    const Columns pupil = columns_in_circle(centre, diameter, y, width);
    std::fill(waves.begin(), waves.end(), 0.0);
    wavefront.waves(y, pupil.begin, std::span(waves).subspan(pupil.begin, pupil.end - pupil.begin));
    for (int x = pupil.begin; x < pupil.end && mirror.size() > 0; ++x) {
      waves[std::size_t(x)] += double(mirror(x, y));
    }
    std::complex<float>* row = incident_.row(y);
    for (int x = 0; x < width; ++x) {
      const double surface = surface_waves_.width > 0 ? double(surface_waves_.at(x, y)) : 0.0;
      row[x] = phasors[phase16(waves[std::size_t(x)] + surface)];
      if (amplitude_.width > 0) row[x] *= amplitude_.at(x, y);
      if (screen_.size() > 0) row[x] *= screen_(x, y);
    }
  }
  for (const Shade& shade : light.shades) dim(incident_, shade);
  for (const LightVortex& one : light.branch_points) twist(incident_, one, diameter / 2.0);
}

void SlmModel::set_turbulence(const Turbulence* turbulence, std::int64_t t_ns) {
  turbulence_waves_.resize(0, 0);
  if (turbulence == nullptr) return;
  const Vec2 centre{(incident_.width - 1) / 2.0, (incident_.height - 1) / 2.0};
  const double diameter = config_.sensor.pupil_diameter_px;
  const auto positions = [&](double middle, int& first) {
    first = std::max(0, int(std::ceil(middle - diameter / 2)));
    return PupilScreen::Positions{double(first), 1.0, int(2.0 * middle) + 1 - 2 * first};
  };
  const auto x = positions(centre.x, turbulence_x_px_), y = positions(centre.y, turbulence_y_px_);
  turbulence_waves_ = PupilScreen(*turbulence, t_ns, centre, diameter).waves(x, y).transpose();
}

void SlmModel::modulate(const Image<std::uint8_t>& grey, int first_row, int end_row,
                        Image<std::complex<float>>& field) const {
  const Vec2 centre{(field.width - 1) / 2.0, (field.height - 1) / 2.0};
  for (int y = first_row; y < end_row; ++y) {
    std::transform(incident_.row(y), incident_.row(y) + field.width, grey.row(y), field.row(y),
                   [&](std::complex<float> light, std::uint8_t level) {
                     return product(light, phasor_of_grey_[level]);
                   });
    if (turbulence_waves_.size() == 0) continue;
    const Columns pupil =
        columns_in_circle(centre, config_.sensor.pupil_diameter_px, y, field.width);
    if (pupil.begin == pupil.end) continue;
    multiply_by_phasors(&turbulence_waves_(pupil.begin - turbulence_x_px_, y - turbulence_y_px_),
                        pupil.end - pupil.begin, field.row(y) + pupil.begin);
  }
}

}  // namespace ovws::twin
