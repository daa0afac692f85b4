/// Optical model of a bench: from the light's ground truth to the intensity on the camera. Each
/// kind of bench implements it.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/base/image.hpp"
#include "core/port/camera.hpp"
#include "drivers/twin/judge.hpp"
#include "drivers/twin/twin_config.hpp"

namespace ovws::twin {

/// Use it in one thread at a time, except for the const functions, which any thread may call.
class OpticalModel {
 public:
  OpticalModel() = default;
  virtual ~OpticalModel() = default;
  OpticalModel(const OpticalModel&) = delete;
  OpticalModel& operator=(const OpticalModel&) = delete;

  virtual void set_light(const Light& light) = 0;
  /// `turbulence`: null if there is none. It must outlive the next call.
  virtual void set_turbulence(const Turbulence* turbulence, std::int64_t t_ns) = 0;
  /// Sets the camera's region, in sensor pixels. The region may extend beyond the sensor.
  virtual void set_window(const Roi& window, const CameraGeometry& geometry) = 0;
  /// Intensity in the window, in units of the brightest pixel of an ideal charge-1 spot of a round
  /// subaperture or lenslet. `grey`: what the SLM shows. Call set_window first.
  virtual Image<float> intensity(const Image<std::uint8_t>& grey) = 0;
  /// Prepares for the grey levels that come next. Call set_window first.
  virtual void prepare(const Image<std::uint8_t>& grey) = 0;

  /// Expected spot positions, in pixels of the camera's sensor, for the geometry and aberration of
  /// `truth`: by V-tilt for vortices, by G-tilt for bright spots. Aberrations that the shown
  /// hologram adds are not included.
  virtual std::vector<Vec2> true_spots_px(const Truth& truth) const = 0;
  /// Photons in a whole spot per photon in the brightest pixel of an ideal charge-1 spot.
  virtual double photons_per_peak_photon(const CameraGeometry& geometry) const = 0;
  /// The judge of the SLM's image; null if the bench has no SLM.
  virtual std::unique_ptr<Judge> make_judge() const = 0;

  /// Mean photons that reach the camera from one subaperture in kReferenceExposureUs.
  /// peak_electrons_for is the inverse: the peak_electrons for this number of photons.
  double photons_per_spot(const Truth& truth) const {
    return truth.peak_electrons / truth.detector.quantum_efficiency *
           photons_per_peak_photon(truth.geometry);
  }
  double peak_electrons_for(const Truth& truth, double photons) const {
    return photons * truth.detector.quantum_efficiency / photons_per_peak_photon(truth.geometry);
  }
};

/// The model of the configured bench.
std::unique_ptr<OpticalModel> make_optical_model(const Config& config);

}  // namespace ovws::twin
