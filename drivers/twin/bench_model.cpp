#include "drivers/twin/bench_model.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/optics/circle_columns.hpp"
#include "core/optics/lattice.hpp"
#include "core/wavefront/slope_model.hpp"
#include "drivers/twin/in_halves.hpp"

namespace ovws::twin {
namespace {

double vortex_peak_intensity(const SensorConfig& sensor) {
  const double radius = sensor.pupil_diameter_px / sensor.subapertures_across / 2.0;
  const double peak = kVortexPeak * std::numbers::pi * radius * radius;
  return peak * peak;
}

/// Calls visit(y, begin, end) for each run of pixels beside the pupil, row by row.
template <class Visit>
void beside_pupil(const Config& config, const Visit& visit) {
  const auto& [width, height, pitch_um] = config.slm.geometry;
  const Vec2 centre{(width - 1) / 2.0, (height - 1) / 2.0};
  for (int y = 0; y < height; ++y) {
    const Columns pupil = columns_in_circle(centre, config.sensor.pupil_diameter_px, y, width);
    visit(y, 0, pupil.begin);
    visit(y, pupil.end, width);
  }
}

}  // namespace

BenchModel::BenchModel(const Config& config)
    : config_(config), slm_(config), unit_(vortex_peak_intensity(config.sensor)) {}

void BenchModel::set_aberration(std::span<const Mode> modes, std::span<const Shade> shades,
                                std::span<const LightVortex> branch_points) {
  slm_.set_aberration(modes, shades, branch_points);
  lit_ = false;
  shown_ = next_ = {};
}

void BenchModel::set_turbulence(const Turbulence* turbulence, std::int64_t t_ns) {
  screen_.reset();
  if (turbulence == nullptr) return;
  const SlmGeometry& slm = config_.slm.geometry;
  screen_.emplace(*turbulence, t_ns, Vec2{(slm.width_px - 1) / 2.0, (slm.height_px - 1) / 2.0},
                  config_.sensor.pupil_diameter_px, Decimator::kMaxReach);
}

void BenchModel::set_window(const Roi& window, const CameraGeometry& geometry) {
  const SlmGeometry& slm = config_.slm.geometry;
  view_.emplace(camera_map(config_, geometry), slm, window);
  pupil_.emplace(slm, config_.sensor.pupil_diameter_px, view_->grid());
  lit_ = false;
  far_field_.emplace(slm, view_->grid(), 2);
  far_ = {view_->grid().cols, view_->grid().rows};
  pixel_field_ = {window.width, window.height};
  shown_ = next_ = {};
}

/// Writes to `shown`, which may be any but shown_, and whose memory is used again.
void BenchModel::propagate_light(const Image<std::uint8_t>& grey, Shown& shown) {
  bool same_beside = !shown_.grey.pixels.empty();
  if (same_beside) {
    beside_pupil(config_, [&](int y, int begin, int end) {
      same_beside = same_beside &&
                    std::equal(grey.row(y) + begin, grey.row(y) + end, shown_.grey.row(y) + begin);
    });
  }
  if (!lit_) pupil_->set_incident(slm_.incident());
  lit_ = true;
  shown.grey = grey;
  shown.still = {};
  pupil_->modulate(grey, slm_.phasor_of_grey(), shown.light);
  shown.beside_pupil = same_beside ? shown_.beside_pupil : propagate_beside(grey);
}

std::shared_ptr<const Image<std::complex<float>>> BenchModel::propagate_beside(
    const Image<std::uint8_t>& grey) {
  Image<std::complex<float>> all(grey.width, grey.height), beside(grey.width, grey.height);
  in_halves(all.height, [&](int first, int end, int) { slm_.modulate(grey, first, end, all); });
  beside_pupil(config_, [&](int y, int begin, int end) {
    std::copy(all.row(y) + begin, all.row(y) + end, beside.row(y) + begin);
  });
  auto far = std::make_shared<Image<std::complex<float>>>(view_->grid().cols, view_->grid().rows);
  propagate_in_halves(*far_field_, beside, *far);
  return far;
}

void BenchModel::show(const Image<std::uint8_t>& grey) {
  if (grey.pixels == shown_.grey.pixels) return;
  if (grey.pixels != next_.grey.pixels) propagate_light(grey, next_);
  std::swap(shown_, next_);
}

void BenchModel::prepare(const Image<std::uint8_t>& grey) {
  if (grey.pixels == shown_.grey.pixels || grey.pixels == next_.grey.pixels) return;
  propagate_light(grey, next_);
  if (!screen_) next_.still = intensity_of(next_);
}

void BenchModel::propagate_to_grid(const Shown& shown) {
  pupil_->propagate(shown.light, screen_ ? &*screen_ : nullptr, *shown.beside_pupil, far_);
}

/// Runs work(first, end, half) on the window's rows. Only interpolation is worth a second thread.
template <class Work>
void BenchModel::for_pixel_rows(const Work& work) const {
  if (view_->aligned()) {
    work(0, pixel_field_.height, 0);
  } else {
    in_halves(pixel_field_.height, work);
  }
}

const Image<std::complex<float>>& BenchModel::field(const Image<std::uint8_t>& grey) {
  show(grey);
  propagate_to_grid(shown_);
  for_pixel_rows([&](int first, int end, int) {
    for (int row = first; row < end; ++row) view_->read(far_, row, pixel_field_.row(row));
  });
  return pixel_field_;
}

Image<float> BenchModel::intensity_of(const Shown& shown) {
  propagate_to_grid(shown);
  Image<float> intensity(pixel_field_.width, pixel_field_.height);
  const float scale = float(1.0 / unit_);
  for_pixel_rows([&](int first, int end, int) {
    for (int row = first; row < end; ++row) {
      std::complex<float>* const field = pixel_field_.row(row);
      view_->read(far_, row, field);
      std::transform(field, field + intensity.width, intensity.row(row),
                     [&](std::complex<float> light) {
                       return scale * (light.real() * light.real() + light.imag() * light.imag());
                     });
    }
  });
  return intensity;
}

Image<float> BenchModel::intensity(const Image<std::uint8_t>& grey) {
  show(grey);
  if (!screen_ && !shown_.still.pixels.empty()) return shown_.still;
  return intensity_of(shown_);
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
  // Slope matrix at 1 camera pixel per cycle: its displacements are in cycles per SLM pixel.
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
