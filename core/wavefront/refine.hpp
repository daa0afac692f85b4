/// Refinement: maximum-likelihood fit of the modes to every pixel of an image, by the diffraction
/// model. More accurate than any linear estimate; takes about half a second per frame.
#pragma once

#include <Eigen/Core>
#include <atomic>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "core/base/image.hpp"
#include "core/base/result.hpp"
#include "core/optics/geometry.hpp"
#include "core/optics/zernike.hpp"

namespace ovws {

/// Conversion of electrons to camera pixel values.
struct RefineCamera {
  double electrons_per_dn = 1.0;
  double read_noise_e = 5.0;  ///< RMS; below 0.5 counts as 0.5
  double black_dn = 0.0;
  double saturated_dn = std::numeric_limits<double>::infinity();  ///< ignored from here on
};

struct RefineOptions {
  double box_half = 4.0;  ///< half-width of the pixel box around each spot, units of lambda/d
  bool spot_amplitudes = false;  ///< fit each subaperture's amplitude, too (uneven illumination)
  /// Model the stray light: light from outside the subapertures, which the hologram leaves in the
  /// zeroth order. The model is kept if it explains the image better. Otherwise, or if false, stray
  /// light is treated as noise where it falls.
  bool model_outside = true;
  int max_iterations = 30;  ///< of each Levenberg-Marquardt descent
  /// Cancellation: once true, a fit ends within one iteration with Errc::refused. Must outlive the
  /// Refiner; may be null.
  const std::atomic<bool>* stop = nullptr;
};

struct Refinement {
  std::vector<Mode> modes;          ///< RMS-normalised waves
  std::vector<double> sigma_waves;  ///< standard errors, from the Fisher matrix
  Eigen::MatrixXd covariance;       ///< of the modes: the Cramer-Rao bound at the estimate, waves^2
  double peak_e = 0.0;              ///< of the model's brightest pixel above the background
  double background_e = 0.0;        ///< per pixel, above the black level
  std::vector<double> amplitudes;   ///< of each subaperture's field, RMS 1; empty: not fitted
  int iterations = 0;               ///< propagations after the first
  int pixels = 0;                   ///< number of pixels fitted
  double chi2_per_pixel = 0.0;      ///< about 1 if the model explains the image
};

/// Maximum-likelihood estimator for Gaussian noise of variance intensity + read_noise^2 (after
/// Barrett, Dainty and Lara, JOSA A 24, 391, 2007): Fisher scoring with Levenberg-Marquardt
/// damping. Takes 5 to 20 iterations of some 50 ms on the default bench. Use it from one thread at
/// a time, off the frame path. Include the rounding to whole DN in read_noise_e.
///
/// The model is the ideal sensor: positions, spot shapes and even illumination follow from the
/// geometry. To correct for the bench's own deviations, refine a reference image, too, and subtract
/// its modes.
class Refiner {
 public:
  /// `cols` x `rows`: size of the camera's image. Errors as of HologramRenderer::make, and
  /// Errc::invalid: "modes": none, piston or an unknown one; "refine.box_half": not in [1, 20].
  static Result<Refiner> make(const SensorConfig& sensor, const SlmGeometry& slm,
                              const OpticsConfig& optics, int cols, int rows,
                              std::vector<int> modes_j, const RefineOptions& options = {});
  ~Refiner();
  Refiner(Refiner&&) noexcept;
  Refiner& operator=(Refiner&&) noexcept;
  Refiner(const Refiner&) = delete;
  Refiner& operator=(const Refiner&) = delete;

  /// `dn`: camera pixel values; NaN is ignored. `start_waves`, in the order of modes_j, must be
  /// within half a wave RMS of the truth. Otherwise the fit may converge to another minimum, with a
  /// larger chi2_per_pixel. Errors: Errc::invalid ("image": wrong size; "modes": wrong number, or
  /// not finite; "camera"), Errc::refused ("image": no signal at the model's spots, no
  /// convergence, or cancelled).
  Result<Refinement> refine(const Image<float>& dn, const RefineCamera& camera,
                            std::span<const double> start_waves);
  Result<Refinement> refine(const ImageView& dn, const RefineCamera& camera,
                            std::span<const double> start_waves);

 private:
  struct Impl;
  explicit Refiner(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace ovws
