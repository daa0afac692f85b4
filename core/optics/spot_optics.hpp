/// Spot model: intensity of one isolated subaperture for any wavefront, and its derivatives.
#pragma once

#include <Eigen/Core>
#include <array>
#include <complex>
#include <vector>

#include "core/base/vec2.hpp"
#include "core/optics/geometry.hpp"
#include "core/optics/lattice.hpp"

namespace ovws {

/// Fourier sums over some 450 samples of the subaperture, for up to some five waves of local
/// aberration. Images are squares of cells, rows along y, columns along x. A cell covers a number
/// of camera pixels, along the camera's axes for any registration. Immutable; all methods are
/// thread-safe and take some tenths of a millisecond.
class SpotOptics {
 public:
  /// Local modes: Zernike j = 1 .. kLocal over the subaperture's own circle as the camera sees it,
  /// RMS-normalised.
  static constexpr int kLocal = 9;
  using Picture = Eigen::MatrixXf;

  /// `cells_per_cycle`: cells that a spot moves per cycle per SLM pixel of slope. Images have
  /// 2 `half_cells` + 1 cells per side.
  SpotOptics(const Lattice& lattice, const SensorConfig& sensor, std::vector<int> modes_j,
             const PxPerCycle& cells_per_cycle, int half_cells);

  int subapertures() const { return int(phase_.size()); }
  int half_cells() const { return half_; }
  const std::vector<int>& modes_j() const { return modes_j_; }

  /// kLocal x Z: least-squares projection of the modes onto the subaperture's local modes. One wave
  /// of a local tilt (the first two) moves the spot by `cells_per_tilt`.
  const Eigen::MatrixXd& local_modes(int subaperture) const { return local_[subaperture]; }
  double cells_per_tilt() const { return cells_per_tilt_; }

  /// Intensity for the modes `waves` (RMS-normalised) without their mean slope, centred `at` cells
  /// from the middle cell. Normalised: the brightest cell for a flat wavefront is 1.
  Picture intensity(int subaperture, const Eigen::VectorXd& waves, Vec2 at) const;
  /// The same, with its derivative with respect to each local mode, per wave.
  struct Derived {
    Picture intensity;
    std::array<Picture, kLocal> per_wave;
  };
  Derived derive(int subaperture, const Eigen::VectorXd& waves, Vec2 at) const;

 private:
  using Field = Eigen::MatrixXcf;
  struct Place {
    int row = 0, column = 0;  ///< in the square grid of places
    Vec2 from_centre_px;      ///< along the camera's axes
    double vortex_turns = 0.0;
  };
  std::vector<std::complex<float>> phasors(int subaperture, const Eigen::VectorXd& waves) const;
  Field kernel(double at) const;  ///< cells x places along one axis

  std::vector<int> modes_j_;
  double cells_per_cycle_;
  double cells_per_tilt_;
  int half_;
  double spacing_px_;
  double to_light_ = 1.0;  ///< |F|^2 to normalised intensity
  std::vector<Place> places_;
  Eigen::MatrixXd plane_;               ///< 2 x places: least-squares mean slope
  Eigen::MatrixXd local_basis_;         ///< places x kLocal
  std::vector<Eigen::MatrixXd> phase_;  ///< per subaperture: places x Z
  std::vector<Eigen::MatrixXd> local_;  ///< per subaperture: kLocal x Z
};

}  // namespace ovws
