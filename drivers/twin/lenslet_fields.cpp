#include "drivers/twin/lenslet_fields.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/angle.hpp"
#include "core/base/complex_product.hpp"
#include "drivers/twin/array_layout.hpp"
#include "drivers/twin/phasor_product.hpp"

namespace ovws::twin {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr int kSubsamples = 16;  // along x and y of a sample, for its share of a lenslet

int padded(int width) {
  return (width + kSplitLanes - 1) / kSplitLanes * kSplitLanes;
}

/// Side of the square, parallel to the camera's axes, that holds a lenslet.
double square_side_um(const ArrayConfig& array, const CameraMap& map) {
  switch (shape_of(array)) {
    case LensletShape::circle:
      break;
    case LensletShape::hexagon:  // from corner to corner, whatever the rotation
      return array.pitch_um * 2.0 / std::numbers::sqrt3;
    case LensletShape::square:
      return array.pitch_um * (std::abs(map.of_x.x) + std::abs(map.of_x.y));
  }
  return array.pitch_um;
}

/// Whether the lenslets are the squares themselves.
bool fill_squares(const ArrayConfig& array, const CameraMap& map) {
  return shape_of(array) == LensletShape::square && map.axis_aligned();
}

}  // namespace

LensletFields::LensletFields(const Config& config, const CameraMap& map, const Roi& window,
                             const PhaseGrid& grid, const Incident& incident,
                             const Eigen::MatrixXf& screen)
    : width_(window.width),
      height_(window.height),
      reach_(reach_px(config.array, map.scale)),
      box_stride_(padded(2 * reach_ + 1)),
      samples_(samples_across(config.array, config.optics)),
      side_um_(square_side_um(config.array, map)),
      exact_(fill_squares(config.array, map)),
      px_um_(1.0 / map.scale),
      lambda_f_(config.optics.wavelength_nm * config.optics.focal_length_mm),
      kernel_(box_stride_, samples_),
      half_(box_stride_, samples_),
      field_(width_ + 2 * box_stride_, height_ + 2 * box_stride_) {
  fill_kernel();
  const Phasors cell = cell_light(config, map);
  std::vector<Vec2> used;
  for (const Vec2 centre : lenslet_centres(config.array)) {
    const Vec2 spot = map.pixel(centre) - Vec2{double(window.x), double(window.y)};
    const bool reaches = spot.x > -reach_ - 1 && spot.x < width_ + reach_ && spot.y > -reach_ - 1 &&
                         spot.y < height_ + reach_;
    const std::size_t before = lenslets_.size();
    if (reaches) add_lenslet(map, centre, spot, cell, incident);
    if (lenslets_.size() > before) used.push_back(centre);
  }
  interpolation_.emplace(grid, used, map.frequency(map.centre_px + Vec2{map.scale, 0.0}),
                         map.frequency(map.centre_px + Vec2{0.0, map.scale}), side_um_, samples_);
  if (screen.size() > 0) dim(screen);
}

void LensletFields::dim(const Eigen::MatrixXf& screen) {
  Eigen::MatrixXf at_samples;
  for (std::size_t i = 0; i < lenslets_.size(); ++i) {
    interpolation_->at_samples(screen, i, at_samples);
    for (std::size_t s = 0; s < lenslets_[i].light.size(); ++s) {
      lenslets_[i].light[s] *= at_samples(Eigen::Index(s));
    }
  }
}

/// The light of a lenslet behind its plate, in uniform light: the mean over each sample.
LensletFields::Phasors LensletFields::cell_light(const Config& config, const CameraMap& map) const {
  const double area_um2 = kPi * config.array.pitch_um * config.array.pitch_um / 4.0;
  const double step = side_um_ / samples_, fine = step / kSubsamples;
  const double weight = fine * fine / (kVortexPeak * area_um2);
  Phasors cell(std::size_t(samples_) * samples_);
  for (int s = 0; s < samples_ * samples_; ++s) {
    std::complex<double> sum = 0.0;
    for (int k = 0; k < kSubsamples * kSubsamples; ++k) {
      const Vec2 at{(s % samples_) * step + (k % kSubsamples + 0.5) * fine - side_um_ / 2,
                    (s / samples_) * step + (k / kSubsamples + 0.5) * fine - side_um_ / 2};
      const Vec2 um = map.frequency(map.centre_px + map.scale * at);
      if (!in_lenslet(config.array, um)) continue;
      sum += std::polar(weight, plate_radians(config.array.plate, config.sensor.charge, um));
    }
    cell[std::size_t(s)] = std::complex<float>(sum);
  }
  return cell;
}

void LensletFields::fill_kernel() {
  const int across = 2 * reach_ + 1;
  kernel_by_rows_.resize(std::size_t(across) * samples_);
  for (int q = 0; q < across; ++q) {
    for (int k = 0; k < samples_; ++k) {
      const double at_um = ((k + 0.5) / samples_ - 0.5) * side_um_;
      const auto value = std::polar(1.0, -2.0 * kPi * (q - reach_) * px_um_ * at_um / lambda_f_);
      kernel_.re[std::size_t(k * box_stride_ + q)] = float(value.real());
      kernel_.im[std::size_t(k * box_stride_ + q)] = float(value.imag());
      kernel_by_rows_[std::size_t(q * samples_ + k)] = std::complex<float>(value);
    }
  }
}

/// Quadratic phase along a line through the box, and the diffraction of a sample's square: a factor
/// if the light is these squares, and a divisor if each sample is the mean of light whose edges are
/// anywhere. The spot is `offset_px` beyond the box's middle pixel.
LensletFields::Phasors LensletFields::box_factors(double offset_px) const {
  Phasors factors;
  for (int q = -reach_; q <= reach_; ++q) {
    const double um = (q - offset_px) * px_um_;
    const double square = sinc(um * side_um_ / samples_ / lambda_f_);
    factors.push_back(
        std::complex<float>(std::polar(exact_ ? square : 1.0 / square, kPi * um * um / lambda_f_)));
  }
  return factors;
}

/// Adds a lenslet, unless it is dark.
void LensletFields::add_lenslet(const CameraMap& map, Vec2 centre_um, Vec2 spot_px,
                                const Phasors& cell, const Incident& incident) {
  const Vec2 middle{std::round(spot_px.x), std::round(spot_px.y)};
  const Vec2 offset = spot_px - middle;
  Lenslet lenslet{int(middle.x) - reach_, int(middle.y) - reach_, cell, box_factors(offset.x),
                  box_factors(offset.y)};
  bool lit = false;
  for (int s = 0; s < samples_ * samples_; ++s) {
    const Vec2 at = side_um_ * Vec2{((s % samples_) + 0.5) / samples_ - 0.5,
                                    ((s / samples_) + 0.5) / samples_ - 0.5};
    const std::complex<float> light =
        incident(centre_um + map.frequency(map.centre_px + map.scale * at));
    const double tilt = 2.0 * kPi * px_um_ * (offset.x * at.x + offset.y * at.y) / lambda_f_;
    auto& value = lenslet.light[std::size_t(s)];
    lit = lit || (light != 0.0F && value != std::complex<float>{});
    value = product(product(value, light), std::complex<float>(std::polar(1.0, tilt)));
  }
  if (lit) lenslets_.push_back(std::move(lenslet));
}

void LensletFields::add_field(const Lenslet& lenslet, Phasors& light) {
  const int across = 2 * reach_ + 1;
  std::fill(half_.re.begin(), half_.re.end(), 0.0F);
  std::fill(half_.im.begin(), half_.im.end(), 0.0F);
  add_product(light.data(), samples_, samples_, kernel_.rows(), box_stride_, half_.rows());
  for (int k = 0; k < samples_; ++k) {
    for (int q = 0; q < across; ++q) {
      float &re = half_.re[std::size_t(k * box_stride_ + q)],
            &im = half_.im[std::size_t(k * box_stride_ + q)];
      const auto value = product({re, im}, lenslet.columns[std::size_t(q)]);
      re = value.real();
      im = value.imag();
    }
  }
  light.resize(std::size_t(across) * samples_);
  for (int q = 0; q < across; ++q) {
    for (int k = 0; k < samples_; ++k) {
      const auto i = std::size_t(q * samples_ + k);
      light[i] = product(kernel_by_rows_[i], lenslet.rows[std::size_t(q)]);
    }
  }
  const std::ptrdiff_t first = (lenslet.y + box_stride_) * field_.stride + lenslet.x + box_stride_;
  add_product(light.data(), across, samples_, half_.rows(), box_stride_, field_.rows(first));
}

Image<float> LensletFields::intensity(const Eigen::MatrixXf& waves) {
  std::fill(field_.re.begin(), field_.re.end(), 0.0F);
  std::fill(field_.im.begin(), field_.im.end(), 0.0F);
  Eigen::MatrixXf at_samples;
  Phasors light;
  for (std::size_t i = 0; i < lenslets_.size(); ++i) {
    light = lenslets_[i].light;
    interpolation_->at_samples(waves, i, at_samples);
    multiply_by_phasors(at_samples.data(), samples_ * samples_, light.data());
    add_field(lenslets_[i], light);
  }
  Image<float> intensity(width_, height_);
  for (int y = 0; y < height_; ++y) {
    const SplitRows row = field_.rows((y + box_stride_) * field_.stride + box_stride_);
    std::transform(row.re, row.re + width_, row.im, intensity.row(y),
                   [](float re, float im) { return re * re + im * im; });
  }
  return intensity;
}

}  // namespace ovws::twin
