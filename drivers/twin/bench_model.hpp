/// The optics between SLM and camera: which light falls on each pixel of a window of the sensor.
#pragma once

#include <complex>
#include <optional>
#include <span>

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
  /// Requires set_window before. Takes some 50 to 100 ms.
  Image<float> intensity(const Image<std::uint8_t>& grey);

 private:
  Config config_;
  SlmModel slm_;
  double unit_;  ///< |far field|^2 of that brightest pixel
  std::optional<FarField> far_field_;
  Image<std::complex<float>> field_, far_;
};

/// Where the spots of the configured sensor fall on the sensor's pixels for this aberration, by
/// the theory of the tilts (V-tilt for a vortex, G-tilt for a bright spot); what the hologram adds
/// is not in it. In the order of the lattice; empty if the configured lattice is not possible.
std::vector<Vec2> true_spots_px(const Config& config, std::span<const Mode> aberration);

}  // namespace ovws::twin
