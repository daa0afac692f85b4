/// The optics between SLM and camera: which light falls on each pixel of a window of the sensor.
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
  /// Sensor pixels; may lie anywhere.
  void set_window(const Roi& window, const CameraGeometry& geometry);

  /// |far field|^2 in the window, in units of the brightest pixel of an ideal charge-1 spot.
  /// Requires set_window before. Takes some 30 to 100 ms, of two threads.
  Image<float> intensity(const Image<std::uint8_t>& grey);
  /// The field itself, F = sum exp(i phase) exp(-2 pi i (u x + v y)) up to its sign; valid until
  /// the next call. Requires as intensity.
  const Image<std::complex<float>>& field(const Image<std::uint8_t>& grey);

 private:
  Config config_;
  SlmModel slm_;
  double unit_;  ///< |far field|^2 of that brightest pixel
  /// The far field is linear: the upper and the lower half of the SLM, at the same time.
  struct Half {
    int first_row = 0;
    FarField far_field;
    Image<std::complex<float>> field, far;
    std::vector<std::complex<float>> turns;  ///< phasor from its own middle to the SLM's, by row
  };
  void propagate(const Image<std::uint8_t>& grey, Half& half) const;

  void collect(int first_row, int end_row);
  void look(int first_row, int end_row, Image<float>& intensity) const;

  std::optional<CameraView> view_;
  std::vector<Half> halves_;
  Image<std::complex<float>> whole_, seen_;
};

/// Where the spots of the configured sensor fall on the sensor's pixels for this aberration, by
/// the theory of the tilts (V-tilt for a vortex, G-tilt for a bright spot); what the hologram adds
/// is not in it. By the geometry and the aberration of `truth`. In the order of the lattice; empty
/// if the configured lattice is not possible.
std::vector<Vec2> true_spots_px(const Config& config, const Truth& truth);

}  // namespace ovws::twin
