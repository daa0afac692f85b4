/// Measures the spiral phase plates of a lenslet array from one image of its spots.
#pragma once

#include <functional>
#include <span>

#include "core/base/image.hpp"
#include "core/base/result.hpp"
#include "core/optics/geometry.hpp"
#include "core/optics/piece_moments.hpp"

namespace ovws {

/// Depth and shift of the plates, which all lenslets share.
struct PlateFit {
  SpiralPlate plate{};  ///< with the steps (`levels`) of the sensor
  double depth_standard_error = 0.0;
  Vec2 shift_standard_error_px;  ///< camera pixels on the array
  double misfit = 0.0;  ///< RMS residual of the fitted spots, relative to the RMS of their light
  int spots = 0;        ///< number of spots that were fitted
};

/// Fits depth and shift to the spots near the pupil's centre by Gauss-Newton iteration, from the
/// plate of `sensor` on. Each spot has a level, a background and a phase of second degree of its
/// own, and the light a wavefront of low order, so neither the light nor the reference must be
/// known. The standard errors come from the residual, which contains the model's own errors.
///
/// `mean_dn`: mean image, not finite where saturated. `found_px`: position of each spot, NaN: lost.
/// `stopped`: whether to give up; called a few times a second. Takes some seconds. Errors
/// (Errc::refused): field "sensor.charge", the lenslets have no plates; "camera", too few spots are
/// found or not saturated; "array.plate", the fit does not converge, or the plates do not explain
/// the spots; "", stopped.
Result<PlateFit> fit_plate(const Image<float>& mean_dn, const SensorConfig& sensor,
                           const SlmGeometry& slm, const OpticsConfig& optics, const LitPixels& lit,
                           std::span<const Vec2> found_px, const std::function<bool()>& stopped);

}  // namespace ovws
