/// Phase retrieval: the wavefront over the pupil from images of its far field with known diversity.
#pragma once

#include <complex>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "core/base/image.hpp"
#include "core/base/result.hpp"
#include "core/optics/geometry.hpp"
#include "core/optics/zernike.hpp"

namespace ovws {

/// Image of the far field with known modes added to the wavefront.
struct DiverseImage {
  std::vector<Mode> modes;  ///< RMS-normalised waves over the pupil
  Image<float> intensity;   ///< without background; NaN: not known
};

/// Up to 10 patterns of defocus and astigmatism with both signs. At 3 waves RMS their images fill
/// 80 lambda/D, so that no pixel is much brighter than others and every place in the pupil has a
/// place in the image. `cells`: of the map; fewer than 100 weaken the patterns.
std::vector<std::vector<Mode>> diversity_patterns(int count, int cells);

/// Multi-image Gerchberg-Saxton iteration with Nesterov's acceleration. It is the gradient descent
/// for the misfit of amplitudes, weighted by their noise. The field of every cell is unknown, so
/// the beam's amplitude is found, too. The cells lie on the camera's axes, where one FFT gives the
/// image, also for a rotated, mirrored or stretched registration. For one thread.
class PhaseRetrieval {
 public:
  /// `cells`: over the pupil's diameter. Errors (Errc::refused, field "optics"): lambda/D has fewer
  /// than 2 camera pixels.
  static Result<PhaseRetrieval> make(const PxPerCycle& px_per_cycle, double pupil_diameter_px,
                                     int cells);

  int window_px() const { return window_; }  ///< rows and columns of the images
  double cell_px() const { return cell_px_; }

  struct Found {
    /// cells x cells over the pupil's square on the SLM, as PhaseMap; no piston, no tilts.
    Image<float> waves;
    double misfit = 0.0;  ///< weighted RMS of what is left of the amplitudes, relative
    /// A place about which the phase turns, pupil radii: the light has a branch point there, or the
    /// retrieval failed, and `waves` are wrong. None: the phase is smooth, but for dark cells.
    std::optional<Vec2> singularity;
  };
  /// `seek_vortex`: also begins with vortices, because the images of an even beam hardly differ by
  /// one, and a retrieval from a flat phase then misses it; takes four times as long. Without, it
  /// takes less than 10 s for 100 cells and 6 images. `stop` is asked before each iteration.
  /// Errc::refused: it was stopped.
  Result<Found> retrieve(const std::vector<DiverseImage>& images, bool seek_vortex,
                         const std::function<bool()>& stop) const;

 private:
  PhaseRetrieval() = default;
  struct Given;
  struct Iteration;
  std::unique_ptr<Iteration> from_a_vortex(const Given& given,
                                           const std::function<bool()>& stop) const;
  Vec2 slm_px(int column, int row) const;
  Image<float> unwrapped(const std::vector<std::complex<float>>& field,
                         double& share_of_jumps) const;
  Vec2 brightest_singularity(const std::vector<std::complex<float>>& field,
                             const Image<float>& waves) const;
  Image<float> on_slm(const Image<float>& waves) const;

  PxPerCycle map_;
  double diameter_px_ = 0.0, cell_px_ = 0.0;
  int cells_ = 0, window_ = 0;
  int side_ = 0;  ///< of the grid of cells on the camera's axes
  std::vector<float> pupil_;
};

/// Subtracts piston and tilts, by least squares over the cells that are not NaN.
void remove_tilts(Image<float>& waves);
/// RMS over the cells that are not NaN.
double rms_of(const Image<float>& waves);

/// Finest structure that two maps of the same pupil show alike: half period in units of a cell, at
/// least 1. The first ring of spatial frequencies whose correlation is below 0.5 limits it (Fourier
/// ring correlation).
double common_resolution(const Image<float>& one, const Image<float>& other);

}  // namespace ovws
