/// One subaperture's spot by itself under any wavefront, and what each local mode does to it.
#pragma once

#include <Eigen/Core>
#include <array>
#include <complex>
#include <vector>

#include "core/base/vec2.hpp"
#include "core/optics/geometry.hpp"
#include "core/optics/lattice.hpp"

namespace ovws {

/// By Fourier sums over some 450 places of the subaperture, for spots within some five waves of
/// local aberration. Pictures are squares of cells, rows along y, columns along x, of which each
/// stands for some camera pixels, along the camera's axes however it stands. Immutable: all methods
/// are thread-safe, some tenths of a millisecond each.
class SpotOptics {
 public:
  /// Local modes: Zernike j = 1 .. kLocal over the subaperture's own circle as the camera sees it,
  /// RMS-normalised.
  static constexpr int kLocal = 9;
  using Picture = Eigen::MatrixXf;

  /// A spot moves by `cells_per_cycle` for each cycle per SLM pixel of slope. Pictures are
  /// 2 `half_cells` + 1 cells a side.
  SpotOptics(const Lattice& lattice, const SensorConfig& sensor, std::vector<int> modes_j,
             const PxPerCycle& cells_per_cycle, int half_cells);

  int subapertures() const { return int(phase_.size()); }
  int half_cells() const { return half_; }
  const std::vector<int>& modes_j() const { return modes_j_; }

  /// kLocal x Z: the local modes that the modes are over this subaperture, by least squares. Of the
  /// first two, the tilts, one wave moves the spot by `cells_per_tilt`.
  const Eigen::MatrixXd& local_modes(int subaperture) const { return local_[subaperture]; }
  double cells_per_tilt() const { return cells_per_tilt_; }

  /// The light of the modes `waves` (RMS-normalised) without their mean slope, its middle `at` from
  /// the middle cell. The brightest cell of a flat spot is 1.
  Picture light(int subaperture, const Eigen::VectorXd& waves, Vec2 at) const;
  /// The same, and its derivatives by each local mode, per wave.
  struct Derived {
    Picture light;
    std::array<Picture, kLocal> per_wave;
  };
  Derived derive(int subaperture, const Eigen::VectorXd& waves, Vec2 at) const;

 private:
  using Field = Eigen::MatrixXcf;
  struct Place {
    int row = 0, column = 0;  ///< of the square of places
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
  double to_light_ = 1.0;  ///< |F|^2 to light
  std::vector<Place> places_;
  Eigen::MatrixXd plane_;               ///< 2 x places: the mean slope, by least squares
  Eigen::MatrixXd local_basis_;         ///< places x kLocal
  std::vector<Eigen::MatrixXd> phase_;  ///< of a subaperture: places x Z
  std::vector<Eigen::MatrixXd> local_;  ///< of a subaperture: kLocal x Z
};

}  // namespace ovws
