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

/// Assumes that the SLM shows the hologram's grey levels exactly, without flatness error, under
/// uniform illumination. Includes the light outside the subapertures. For one thread at a time.
class SensorModel {
 public:
  /// Errors as of check_straight and HologramRenderer::make. `cols` x `rows`: the camera's image.
  static Result<SensorModel> make(const SensorConfig& sensor, const SlmGeometry& slm,
                                  const OpticsConfig& optics, int cols, int rows);

  const Lattice& lattice() const { return renderer_.lattice(); }
  /// Position of each spot for a flat wavefront.
  const std::vector<Vec2>& spots_px() const { return spots_px_; }
  double lambda_d_px() const { return lambda_d_px_; }
  double px_per_cycle() const { return px_per_cycle_; }

  /// Far-field intensity |F|^2 at each camera pixel with these modes (RMS-normalised waves) in the
  /// hologram; some 70 ms for the default bench. Errors as of HologramRenderer::check_sampling.
  Result<Image<float>> intensity(std::span<const Mode> modes);
  /// Peak intensity of the spots: the brightest pixel within 2 lambda/d of where the modes move
  /// them. Excludes everything else, above all the tail of the zeroth order.
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

/// Multiplies every pixel.
void scale(Image<float>& intensity, double factor);
/// Sum of all pixels.
double total(const Image<float>& intensity);

}  // namespace ovws
