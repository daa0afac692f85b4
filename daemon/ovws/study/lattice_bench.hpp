/// Light that has passed a layer of turbulent air far away, so that phase and amplitude vary over
/// the pupil; and a lattice on it: spots without neighbours, noise, tracker and reconstruction.
#pragma once

#include <complex>
#include <cstdint>
#include <memory>
#include <vector>

#include <Eigen/Core>

#include "core/base/image.hpp"
#include "core/base/vec2.hpp"
#include "core/tracking/tracker.hpp"
#include "core/wavefront/reconstructor.hpp"
#include "daemon/ovws/study/sensor.hpp"

namespace ovws::study {

constexpr int kWavePx = 512;         ///< width and height of a simulated wave, which is periodic
constexpr double kPupilPx = 256.0;   ///< diameter of the pupil in its centre
constexpr double kOuterScale = 2.0;  ///< of the turbulence, pupil diameters

/// One thin layer with von Karman's spectrum. By its distance z, light of wavelength lambda comes
/// with the Rytov variance 1.145 (sqrt(lambda z) / r0)^(5/3), the intensity's variance while weak.
struct Air {
  double pupils_per_r0 = 0.0;   ///< D / r0
  double rytov_variance = 0.0;  ///< 0: the layer is at the pupil, and changes only the phase
};

using Wave = Image<std::complex<float>>;

/// The wave at the pupil, by Fresnel propagation (angular spectrum) from the layer; its mean
/// intensity is 1. The same seed gives the same wave.
Wave scintillated_wave(const Air& air, std::uint64_t seed);
/// Variance of the intensity over the pupil, relative to the square of its mean.
double scintillation_index(const Wave& wave);

/// Every second pixel of the pupil, in each direction.
struct PupilPixel {
  int x = 0, y = 0;
  Vec2 at;  ///< pupil radii
};
std::vector<PupilPixel> pupil_pixels();

/// How spots are found, and what becomes of a dark one.
struct SpotMethod {
  const char* name;
  int charge;
  bool
      fixed_cell;  ///< centroid of a fixed cell, never lost; else `lg`, which leaves dark spots out
};

/// Modes of one frame, for each number of modes of mode_counts().
struct LatticeFrame {
  std::vector<std::vector<float>> waves;  ///< j = 1, 2, …; NaN: not determined
  int lost = 0;
};

/// A square lattice of `across` subapertures. Every spot has 6 camera pixels per lambda/d and a
/// window of 8 lambda/d. Immutable: measuring is thread-safe.
class LatticeBench {
 public:
  LatticeBench(int across, const SpotMethod& method);

  int subapertures() const { return int(cells_.size()); }
  /// Numbers of modes that the lattice determines: whole radial orders.
  const std::vector<int>& mode_counts() const { return mode_counts_; }
  /// Measures a wave whose light is `pupil_e` electrons over the pupil at mean intensity 1.
  LatticeFrame measure(const Wave& wave, double pupil_e, std::uint64_t seed) const;

 private:
  /// Pixels of the wave behind one subaperture, and their Fourier transform to its spot.
  struct Cell {
    int x = 0, y = 0;
    Eigen::MatrixXcf imprint;  ///< vortex inside the subaperture, 0 outside
    Eigen::MatrixXcf along_x, along_y;
  };
  Cell cell_of(const Subaperture& subaperture) const;
  Image<float> spots_e(const Wave& wave, double pupil_e) const;
  std::vector<SpotFix> track(const Exposure& exposure) const;
  Vec2 centre_px(std::size_t spot) const;

  SpotMethod method_;
  double diameter_px_ = 0.0;
  int columns_ = 0;  ///< windows in a row of the image
  std::vector<Cell> cells_;
  std::unique_ptr<const SpotTracker> tracker_;
  std::vector<int> mode_counts_;
  std::vector<std::unique_ptr<const Reconstructor>> reconstructors_;
};

}  // namespace ovws::study
