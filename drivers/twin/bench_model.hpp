/// The optics between SLM and camera: which light falls on each pixel of a window of the sensor.
#pragma once

#include <complex>
#include <span>
#include <vector>

#include "core/base/image.hpp"
#include "core/optics/far_field.hpp"
#include "core/port/camera.hpp"
#include "drivers/twin/slm_model.hpp"
#include "drivers/twin/twin_config.hpp"

namespace ovws::twin {

/// One thread at a time.
class BenchModel {
 public:
  explicit BenchModel(const Config& config);

  void set_aberration(std::span<const Mode> modes) { slm_.set_aberration(modes); }
  void set_window(const Roi& window);  ///< sensor pixels; may lie anywhere

  /// |far field|^2 in the window, in units of the brightest pixel of an ideal charge-1 spot.
  /// Requires set_window before. Takes some 30 to 100 ms, of two threads.
  Image<float> intensity(const Image<std::uint8_t>& grey);

 private:
  Config config_;
  SlmModel slm_;
  double unit_;  ///< |far field|^2 of that brightest pixel
  /// The far field is linear: the upper and the lower half of the SLM, at the same time.
  struct Half {
    int first_row = 0;
    FarField far_field;
    Image<std::complex<float>> field, far;
  };
  void propagate(const Image<std::uint8_t>& grey, Half& half) const;

  std::vector<Half> halves_;
  std::vector<std::complex<float>> between_;  ///< phasor from half to half, for each camera row
};

/// Where the spots of the configured sensor fall on the sensor's pixels for this aberration, by
/// the theory of the tilts (V-tilt for a vortex, G-tilt for a bright spot); what the hologram adds
/// is not in it. In the order of the lattice; empty if the configured lattice is not possible.
std::vector<Vec2> true_spots_px(const Config& config, std::span<const Mode> aberration);

}  // namespace ovws::twin
