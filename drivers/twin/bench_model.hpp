/// Optical model from SLM to camera: the intensity on each pixel of a window of the sensor.
#pragma once

#include <complex>
#include <optional>
#include <span>
#include <vector>

#include "core/base/image.hpp"
#include "core/optics/far_field.hpp"
#include "core/port/camera.hpp"
#include "drivers/twin/camera_view.hpp"
#include "drivers/twin/slm_model.hpp"
#include "drivers/twin/twin_config.hpp"

namespace ovws::twin {

/// One thread at a time.
class BenchModel {
 public:
  explicit BenchModel(const Config& config);

  void set_aberration(std::span<const Mode> modes, std::span<const Shade> shades = {}) {
    slm_.set_aberration(modes, shades);
  }
  void set_turbulence(const Turbulence* turbulence, std::int64_t t_ns) {
    slm_.set_turbulence(turbulence, t_ns);
  }
  /// Sets the camera's window, sensor pixels; it may lie anywhere.
  void set_window(const Roi& window, const CameraGeometry& geometry);

  /// |far field|^2 in the window, in units of the brightest pixel of an ideal charge-1 spot.
  /// Requires set_window before. Takes 30 to 100 ms on two threads.
  Image<float> intensity(const Image<std::uint8_t>& grey);
  /// The complex field F = sum exp(i phase) exp(-2 pi i (u x + v y)) up to its sign, valid until
  /// the next call. Requires set_window before.
  const Image<std::complex<float>>& field(const Image<std::uint8_t>& grey);

 private:
  Config config_;
  SlmModel slm_;
  double unit_;  ///< |far field|^2 in the brightest pixel of an ideal charge-1 spot
  /// One half of the SLM, upper or lower. Propagation is linear, so both run in parallel and are
  /// added.
  struct Half {
    int first_row = 0;
    FarField far_field;
    Image<std::complex<float>> field, far;
    /// From the half's centre to the SLM's, by row.
    std::vector<std::complex<float>> phase_factors;
  };
  void propagate(const Image<std::uint8_t>& grey, Half& half) const;

  void collect(int first_row, int end_row);

  std::optional<CameraView> view_;
  std::vector<Half> halves_;
  Image<std::complex<float>> whole_, pixel_field_;
};

/// Expected spot positions of the configured sensor, in pixels of the camera's sensor, for the
/// geometry and aberration of `truth`: by V-tilt for vortices, by G-tilt for bright spots. What the
/// hologram adds is not included. In the order of the lattice; empty if the configured lattice is
/// not possible.
std::vector<Vec2> true_spots_px(const Config& config, const Truth& truth);

}  // namespace ovws::twin
