/// Diffraction model of the sensor's camera image: ideal SLM, lens and camera window.
#pragma once

#include <complex>
#include <span>
#include <vector>

#include "core/base/image.hpp"
#include "core/base/result.hpp"
#include "core/optics/far_field.hpp"
#include "core/optics/geometry.hpp"
#include "core/optics/hologram.hpp"

namespace ovws {

/// Ideal diffraction model: the SLM shows the hologram's grey levels exactly, has no flatness error
/// and is illuminated uniformly. Includes light from outside the subapertures. Use from one thread.
class SensorModel {
 public:
  /// Builds the model. `cols` x `rows`: size of the camera image. Errors: those of check_straight
  /// and HologramRenderer::make.
  static Result<SensorModel> make(const SensorConfig& sensor, const SlmGeometry& slm,
                                  const OpticsConfig& optics, int cols, int rows);

  const Lattice& lattice() const { return renderer_.lattice(); }
  /// Position of each subaperture's spot for a flat wavefront, camera pixels.
  const std::vector<Vec2>& spots_px() const { return spots_px_; }
  double lambda_d_px() const { return lambda_d_px_; }
  double px_per_cycle() const { return px_per_cycle_; }

  /// Far-field intensity |F|^2 at each camera pixel, with `modes` (RMS-normalised waves) added to
  /// the hologram. About 70 ms for the default bench. Errors: those of check_sampling.
  Result<Image<float>> intensity(std::span<const Mode> modes);
  /// Peak intensity of the spots: brightest pixel within 2 lambda/d of any spot position that
  /// `modes` predict. Ignores other pixels, because the tail of the zeroth order may be brighter.
  double peak_of_spots(const Image<float>& intensity, std::span<const Mode> modes) const;

 private:
  SensorModel(HologramRenderer renderer, FarField far_field)
      : renderer_(std::move(renderer)), far_field_(std::move(far_field)) {}

  HologramRenderer renderer_;
  FarField far_field_;
  std::vector<Vec2> spots_px_;
  double pupil_radius_px_ = 0.0;
  double lambda_d_px_ = 0.0;
  double px_per_cycle_ = 0.0;
  Image<std::uint8_t> grey_;
  Image<std::complex<float>> field_;
  Image<std::complex<float>> far_;
};

/// Multiplies every pixel's intensity by `factor`.
void scale(Image<float>& intensity, double factor);
/// Total intensity: sum of all pixels.
double total(const Image<float>& intensity);

}  // namespace ovws
