/// The modes that explain every pixel of an image best, by diffraction: what no linear estimate
/// reaches, at a second a frame.
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

/// How the camera turned electrons into numbers.
struct RefineCamera {
  double electrons_per_dn = 1.0;
  double read_noise_e = 5.0;  ///< RMS; below 0.5 counts as 0.5
  double black_dn = 0.0;
  double saturated_dn = std::numeric_limits<double>::infinity();  ///< from here on not counted
};

struct RefineOptions {
  double box_half = 4.0;         ///< of the pixels about each spot that count, units of lambda/d
  bool spot_amplitudes = false;  ///< fit each subaperture's amplitude too: uneven illumination
  /// Light outside the subapertures, which the hologram leaves in the zero order: tried as part of
  /// the model, and kept if that explains the image better. Else, or false, it counts as noise
  /// where it falls.
  bool model_outside = true;
  int most_iterations = 30;  ///< of each descent
  /// Once true, a fit ends within one iteration, refused. Must outlive the Refiner; null: never.
  const std::atomic<bool>* stop = nullptr;
};

struct Refinement {
  std::vector<Mode> modes;          ///< RMS-normalised waves
  std::vector<double> sigma_waves;  ///< standard errors, from the Fisher matrix
  Eigen::MatrixXd covariance;       ///< of the modes: the Cramer-Rao bound at the estimate, waves^2
  double peak_e = 0.0;              ///< of the model's brightest pixel above the background
  double background_e = 0.0;        ///< a pixel, above the black level
  std::vector<double> amplitudes;   ///< of each subaperture's field, RMS 1; empty: not fitted
  int iterations = 0;               ///< propagations after the first
  int pixels = 0;                   ///< that counted
  double chi2_per_pixel = 0.0;      ///< about 1 if the model explains the image
};

/// Maximum likelihood with Gaussian noise of variance light + read_noise^2 (after Barrett, Dainty
/// and Lara, JOSA A 24, 391, 2007): scoring with the weights of the model, Levenberg-Marquardt.
/// About 0.1 s an iteration, 5 to 20 of them, for the default bench; for one thread at a time, off
/// the frame path. The weights know the light only, so rounding to whole DN belongs into
/// read_noise_e.
///
/// The model is the ideal sensor's: absolute places, shapes and even illumination of the bench must
/// be those of the geometry. What the bench itself adds is measured by refining a reference image,
/// and subtracted.
class Refiner {
 public:
  /// `cols` x `rows`: the camera's image. Errors as of HologramRenderer::make; Errc::invalid, field
  /// "modes": none, piston or an unknown one; "refine.box_half": not in [1, 20].
  static Result<Refiner> make(const SensorConfig& sensor, const SlmGeometry& slm,
                              const OpticsConfig& optics, int cols, int rows,
                              std::vector<int> modes_j, const RefineOptions& options = {});
  ~Refiner();
  Refiner(Refiner&&) noexcept;
  Refiner& operator=(Refiner&&) noexcept;
  Refiner(const Refiner&) = delete;
  Refiner& operator=(const Refiner&) = delete;

  /// `dn`: camera numbers; NaN does not count. `start_waves` in the order of modes_j: within half a
  /// wave RMS of the truth, else another minimum may be found, which chi2_per_pixel tells.
  /// Errors: Errc::invalid ("image": not of the size; "modes": not as many or not finite;
  /// "camera"), Errc::refused ("image": no light where the model has it, no minimum was reached, or
  /// it was told to stop).
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
