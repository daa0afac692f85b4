#include "core/optics/spot_optics.hpp"

#include <Eigen/QR>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/optics/zernike.hpp"

namespace ovws {
namespace {

constexpr int kPlacesAcross = 24;

std::complex<float> unit_phasor(double cycles) {
  return std::polar(1.0F, float(2.0 * std::numbers::pi * (cycles - std::round(cycles))));
}

double along(int k, double spacing_px) {
  return (k - 0.5 * (kPlacesAcross - 1)) * spacing_px;
}

}  // namespace

SpotOptics::SpotOptics(const Lattice& lattice, const SensorConfig& sensor, std::vector<int> modes_j,
                       const PxPerCycle& cells_per_cycle, int half_cells)
    : modes_j_(std::move(modes_j)),
      cells_per_cycle_(cells_per_cycle.scale()),
      // A local tilt of 1 wave RMS is 2 waves from the middle to the rim.
      cells_per_tilt_(cells_per_cycle_ * 4.0 / lattice.diameter_px),
      half_(half_cells),
      spacing_px_(lattice.diameter_px / kPlacesAcross) {
  const double radius = 0.5 * lattice.diameter_px;
  for (int row = 0; row < kPlacesAcross; ++row) {
    for (int column = 0; column < kPlacesAcross; ++column) {
      const Vec2 at{along(column, spacing_px_), along(row, spacing_px_)};
      const Vec2 on_slm = cells_per_cycle.back(at);
      const double turns =
          sensor.charge * std::atan2(on_slm.y, on_slm.x) / (2.0 * std::numbers::pi);
      if (norm(at) <= radius) places_.push_back({row, column, at, turns});
    }
  }
  const auto count = Eigen::Index(places_.size());
  Eigen::MatrixXd plane(count, 3);
  local_basis_.resize(count, kLocal);
  for (Eigen::Index p = 0; p < count; ++p) {
    const Vec2 at = places_[p].from_centre_px;
    plane.row(p) << 1.0, at.x, at.y;
    for (int k = 0; k < kLocal; ++k) local_basis_(p, k) = zernike(k + 1, (1.0 / radius) * at);
  }
  plane_ = plane.completeOrthogonalDecomposition().pseudoInverse().bottomRows(2);
  const Eigen::MatrixXd to_local = local_basis_.completeOrthogonalDecomposition().pseudoInverse();
  for (const Subaperture& s : lattice.subapertures) {
    Eigen::MatrixXd phase(count, modes_j_.size());
    for (Eigen::Index p = 0; p < count; ++p) {
      const Vec2 on_slm = cells_per_cycle.back(places_[p].from_centre_px);
      const Vec2 at = (2.0 / sensor.pupil_diameter_px) * (s.centre_px + on_slm);
      for (std::size_t k = 0; k < modes_j_.size(); ++k) phase(p, k) = zernike(modes_j_[k], at);
    }
    local_.push_back(to_local * (phase.rowwise() - phase.colwise().mean()));
    phase_.push_back(std::move(phase));
  }
  const Picture flat = intensity(0, Eigen::VectorXd::Zero(Eigen::Index(modes_j_.size())), {});
  to_light_ = 1.0 / double(flat.maxCoeff());
}

std::vector<std::complex<float>> SpotOptics::phasors(int subaperture,
                                                     const Eigen::VectorXd& waves) const {
  const Eigen::VectorXd phase = phase_[subaperture] * waves;
  const Eigen::Vector2d slope = plane_ * phase;
  std::vector<std::complex<float>> field;
  for (std::size_t p = 0; p < places_.size(); ++p) {
    const Vec2 at = places_[p].from_centre_px;
    field.push_back(unit_phasor(phase(Eigen::Index(p)) - slope.x() * at.x - slope.y() * at.y +
                                places_[p].vortex_turns));
  }
  return field;
}

SpotOptics::Field SpotOptics::kernel(double at) const {
  Field kernel(2 * half_ + 1, kPlacesAcross);
  for (int p = 0; p < kPlacesAcross; ++p) {
    const double cycles_per_cell = along(p, spacing_px_) / cells_per_cycle_;
    const std::complex<double> next = std::polar(1.0, -2.0 * std::numbers::pi * cycles_per_cell);
    std::complex<double> value =
        std::polar(1.0, 2.0 * std::numbers::pi * (half_ + at) * cycles_per_cell);
    for (Eigen::Index k = 0; k < kernel.rows(); ++k) {
      kernel(k, p) = std::complex<float>(value);
      value = {value.real() * next.real() - value.imag() * next.imag(),
               value.real() * next.imag() + value.imag() * next.real()};
    }
  }
  return kernel;
}

SpotOptics::Picture SpotOptics::intensity(int subaperture, const Eigen::VectorXd& waves,
                                          Vec2 at) const {
  const auto phasor = phasors(subaperture, waves);
  Field field = Field::Zero(kPlacesAcross, kPlacesAcross);
  for (std::size_t p = 0; p < places_.size(); ++p) {
    field(places_[p].row, places_[p].column) = phasor[p];
  }
  const Field far = kernel(at.y) * (field * kernel(at.x).transpose());
  return float(to_light_) * far.cwiseAbs2();
}

SpotOptics::Derived SpotOptics::derive(int subaperture, const Eigen::VectorXd& waves,
                                       Vec2 at) const {
  const auto phasor = phasors(subaperture, waves);
  // Horizontally concatenated: the field, and the field times each local mode.
  Field fields = Field::Zero(kPlacesAcross, kPlacesAcross * (kLocal + 1));
  for (std::size_t p = 0; p < places_.size(); ++p) {
    const Place& place = places_[p];
    fields(place.row, place.column) = phasor[p];
    for (int k = 0; k < kLocal; ++k) {
      fields(place.row, (k + 1) * kPlacesAcross + place.column) =
          float(local_basis_(Eigen::Index(p), k)) * phasor[p];
    }
  }
  const Field half = kernel(at.y) * fields;
  const Field along_x = kernel(at.x).transpose();
  const Field far = half.leftCols(kPlacesAcross) * along_x;
  Derived derived;
  derived.intensity = float(to_light_) * far.cwiseAbs2();
  const auto scale = float(-4.0 * std::numbers::pi * to_light_);  // 2 Re(2 pi i conj(F) F_k)
  for (int k = 0; k < kLocal; ++k) {
    const Field part = half.middleCols((k + 1) * kPlacesAcross, kPlacesAcross) * along_x;
    derived.per_wave[k] =
        scale * (far.real().cwiseProduct(part.imag()) - far.imag().cwiseProduct(part.real()));
  }
  return derived;
}

}  // namespace ovws
