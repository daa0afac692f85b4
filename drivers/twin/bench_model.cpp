#include "drivers/twin/bench_model.hpp"

#include <Eigen/Core>
#include <cmath>
#include <numbers>
#include <thread>

#include "core/optics/lattice.hpp"
#include "core/wavefront/slope_model.hpp"

namespace ovws::twin {
namespace {

double vortex_peak_intensity(const SensorConfig& sensor) {
  const double radius = sensor.pupil_diameter_px / sensor.subapertures_across / 2.0;
  const double peak = kVortexPeak * std::numbers::pi * radius * radius;
  return peak * peak;
}

std::complex<float> phasor(double turns) {
  const double angle = 2.0 * std::numbers::pi * std::remainder(turns, 1.0);
  return {float(std::cos(angle)), float(std::sin(angle))};
}

/// Runs work(0) and work(1) in parallel.
template <class Work>
void in_parallel(const Work& work) {
  const std::jthread helper([&] { work(1); });
  work(0);
}

}  // namespace

BenchModel::BenchModel(const Config& config)
    : config_(config), slm_(config), unit_(vortex_peak_intensity(config.sensor)) {}

void BenchModel::set_window(const Roi& window, const CameraGeometry& geometry) {
  const SlmGeometry& slm = config_.slm.geometry;
  view_.emplace(camera_map(config_, geometry), slm, window);
  const FarFieldWindow& grid = view_->grid();
  SlmGeometry upper = slm, lower = slm;
  upper.height_px = slm.height_px / 2;
  lower.height_px = slm.height_px - upper.height_px;
  halves_.clear();
  halves_.push_back({0, FarField(upper, grid), {slm.width_px, upper.height_px}, {}, {}});
  halves_.push_back(
      {upper.height_px, FarField(lower, grid), {slm.width_px, lower.height_px}, {}, {}});
  const double step_y = grid.step_y_cpp != 0.0 ? grid.step_y_cpp : grid.step_cpp;
  for (Half& half : halves_) {
    const double middle = half.first_row + (half.field.height - slm.height_px) / 2.0;
    for (int r = 0; r < grid.rows; ++r) {
      half.phase_factors.push_back(phasor(-(grid.origin_cpp.y + r * step_y) * middle));
    }
  }
  whole_ = {grid.cols, grid.rows};
  pixel_field_ = {window.width, window.height};
}

void BenchModel::propagate(const Image<std::uint8_t>& grey, Half& half) const {
  slm_.modulate(grey, half.first_row, half.field);
  half.far_field.propagate(half.field, half.far);
}

/// Adds the fields of both halves, with phases relative to the SLM's centre.
void BenchModel::collect(int first_row, int end_row) {
  const Half &upper = halves_.front(), &lower = halves_.back();
  for (int r = first_row; r < end_row; ++r) {
    const std::complex<float> a = upper.phase_factors[std::size_t(r)],
                              b = lower.phase_factors[std::size_t(r)];
    const std::complex<float>*up = upper.far.row(r), *low = lower.far.row(r);
    std::complex<float>* out = whole_.row(r);
    for (int c = 0; c < whole_.width; ++c) {
      // Written out, as in `product`.
      out[c] = {a.real() * up[c].real() - a.imag() * up[c].imag() + b.real() * low[c].real() -
                    b.imag() * low[c].imag(),
                a.real() * up[c].imag() + a.imag() * up[c].real() + b.real() * low[c].imag() +
                    b.imag() * low[c].real()};
    }
  }
}

const Image<std::complex<float>>& BenchModel::field(const Image<std::uint8_t>& grey) {
  in_parallel([&](int half) { propagate(grey, halves_[std::size_t(half)]); });
  const auto share = [](int rows, int half) { return half * rows / 2; };
  in_parallel(
      [&](int half) { collect(share(whole_.height, half), share(whole_.height, half + 1)); });
  in_parallel([&](int half) {
    view_->read(whole_, share(pixel_field_.height, half), share(pixel_field_.height, half + 1),
                pixel_field_);
  });
  return pixel_field_;
}

Image<float> BenchModel::intensity(const Image<std::uint8_t>& grey) {
  const Image<std::complex<float>>& pixel_field = field(grey);
  Image<float> intensity(pixel_field.width, pixel_field.height);
  const float scale = float(1.0 / unit_);
  for (std::size_t i = 0; i < pixel_field.pixels.size(); ++i) {
    const float re = pixel_field.pixels[i].real(), im = pixel_field.pixels[i].imag();
    intensity.pixels[i] = scale * (re * re + im * im);
  }
  return intensity;
}

std::vector<Vec2> true_spots_px(const Config& config, const Truth& truth) {
  const auto lattice = make_lattice(config.sensor, config.slm.geometry);
  if (!lattice) return {};
  std::vector<int> modes_j;
  Eigen::VectorXd waves(Eigen::Index(truth.aberration.size()));
  for (const Mode& mode : truth.aberration) {
    waves[Eigen::Index(modes_j.size())] = mode.waves;
    modes_j.push_back(mode.j);
  }
  // With a scale of 1 camera pixel per cycle, displacements are in cycles per SLM pixel.
  const Eigen::VectorXd moved_cpp =
      slope_matrix(*lattice, config.sensor, modes_j,
                   config.sensor.charge == 0 ? kGradientTilt : kVortexTilt, 1.0) *
      waves;
  const CameraMap map = camera_map(config, truth.geometry);
  std::vector<Vec2> spots;
  for (const Subaperture& s : lattice->subapertures) {
    const auto i = Eigen::Index(2 * spots.size());
    spots.push_back(map.pixel(s.frequency_cpp + Vec2{moved_cpp[i], moved_cpp[i + 1]}));
  }
  return spots;
}

}  // namespace ovws::twin
